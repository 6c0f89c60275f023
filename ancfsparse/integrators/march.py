"""Configure the compiled time loop."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled
from ancfsparse.integrators.newmark import Newmark

Vector = NDArray[np.float64]


class Mechanics(Protocol):
    """What the time loop needs of a system; see ``ancf_system`` in kernels/solver_abi.h."""

    capsule: object
    q0: Vector
    v0: Vector
    dead_load: Vector


def make_march(system: Mechanics, dt: float, integrator: Newmark, a: Vector, lam: Vector) -> Any:
    """Build the compiled march from the system's initial state.

    Parameters
    ----------
    system : System
        At its initial state.
    dt : float
        Time step [s].
    integrator : Newmark
        Coefficients.
    a, lam : (n_all,) and (m,) float
        Initial accelerations [m/s2, 1/s2] and multipliers [N].
    """
    return compiled("march").March(
        system,
        dt,
        integrator.beta,
        integrator.gamma,
        system.q0,
        system.v0,
        a,
        lam,
        system.dead_load,
    )
