"""Steps that resolve the stiffness of a contact, and its impacts with a restitution."""

from __future__ import annotations

import math

from ancfsparse.errors import InputError
from ancfsparse.scene.loads.attachment import ContactLaw

# Damping ratio of the mass of the body on bristles with a static friction.  Without damping a body
# that comes to rest swings on them and slides again at the kinetic friction; .3 and 1 do alike.
BRISTLE_DAMPING = 1.0
# Steps times the restitution that an impact needs.  The speed of a level rebound is then within 1 %
# in all phases, for .25 to .9; with 8 it is off by up to 2 %, with 6 steps and .25 by 50 %.
RESTITUTION_STEPS = 12.0
# Speed below which an impact is damped less, near its deepest point, over the restitution and the
# speed of an undamped impact as deep: with .25 the rebound is .4 % faster.  With half of it steps
# are repeated, and with a constant small speed some do not converge.
SLOW_RATIO = 0.05
# Steps of an impact that implicit integrators resolve: 6 damp 15 % of its energy, and 2 all of it.
IMPACT_STEPS = 6.0
SAME_STEP = 1e-6  # relative difference of steps that are equal


def find_resolving_step(
    law: ContactLaw, impact_time: float, keeps_energy: bool
) -> tuple[float, str]:
    """Return the step that resolves an impact of a duration [s], see `Contribution.resolving_step`.

    Friction depends on the motion during an impact, also if its energy is conserved.
    """
    if keeps_energy and not law.friction and not law.restitution:
        return math.inf, law.what
    return _longest_step(impact_time, law.restitution), law.what


def find_longest_step(restitution: float, impact_time: float, phase: float) -> float:
    """Return the longest step that `check_contact_step` and `check_impact_step` admit [s]."""
    stable = _stable_step(impact_time, phase)
    return min(stable, _longest_step(impact_time, restitution)) if restitution else stable


def _stable_step(impact_time: float, phase: float) -> float:
    """Return the longest step at which the vibration of a line on a contact is stable [s]."""
    return phase * impact_time / math.pi


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
    longest = _stable_step(impact_time, phase)
    if dt > longest:
        raise InputError(
            f"dt of {dt:.3g} s does not resolve {what}: with the stiffness of {stiffness:.3g} N/m2 "
            f"this integrator needs a dt of at most {longest:.3g} s; take that, a smaller "
            "stiffness, or an implicit integrator such as EnergyMomentum()"
        )


def check_impact_step(
    what: str, stiffness: float, impact_time: float, dt: float, restitution: float
) -> None:
    """Refuse a step that does not resolve impacts with a coefficient of restitution, 0 for none."""
    longest = _longest_step(impact_time, restitution)
    if restitution and dt > (1.0 + SAME_STEP) * longest:
        raise InputError(
            f"dt of {dt:.3g} s does not resolve the impacts of {what}, of {impact_time:.3g} s with "
            f"the stiffness of {stiffness:.3g} N/m2: a restitution of {restitution:.3g} needs a dt "
            f"of at most {longest:.3g} s, accuracy= in place of dt, or a smaller stiffness"
        )


def _longest_step(impact_time: float, restitution: float) -> float:
    """Return the longest step that resolves an impact [s]."""
    steps = RESTITUTION_STEPS / restitution if restitution else IMPACT_STEPS
    return impact_time / steps
