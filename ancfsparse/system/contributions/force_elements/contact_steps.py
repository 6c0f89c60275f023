"""Steps of explicit integrators that resolve the stiffness of a contact."""

from __future__ import annotations

import numpy as np

from ancfsparse.errors import InputError


def check_contact_step(
    what: str, stiffness: float, impact_time: float, dt: float, phase: float
) -> None:
    """Refuse a step at which the vibration of a line on a contact is not stable.

    Parameters
    ----------
    what : str
        The contact, in messages.
    stiffness : float
        Stiffness [N/m2].
    impact_time : float
        Half a period of this vibration [s].
    dt : float
        Step [s].
    phase : float
        Product of a step and a frequency up to which the integrator is stable.
    """
    longest = phase * float(impact_time) / np.pi
    if dt > longest:
        raise InputError(
            f"dt of {dt:.3g} s does not resolve {what}: with the stiffness of {stiffness:.3g} N/m2 "
            f"this integrator needs a dt of at most {longest:.3g} s; take that, a smaller "
            "stiffness, or an implicit integrator such as EnergyMomentum()"
        )
