"""Configure the compiled time loop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled_module
from ancfsparse.integrators.implicit.newmark_family import Implicit

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import ControlledLoop

Vector = NDArray[np.float64]


class Mechanics(Protocol):
    """What the time loop needs of a system; see ``ancf_system`` in abi/solver_abi.h."""

    capsule: object
    parts: Any
    constraints: Any
    prescribed: Any

    @property
    def dead_load(self) -> Vector:
        """Constant applied force, (n_all,) [N, N m]."""
        ...


@dataclass(frozen=True)
class Start:
    """Start of a motion, made consistent for an integrator (see `solve.initial_conditions`).

    Attributes
    ----------
    q, v, a, b : (n_all,) float
        Coordinates [m, 1], velocities, accelerations (of an implicit integrator what its step can
        follow of them), the integrator's own accelerations.
    lam : (m,) float
        Multipliers [N].
    amplitudes : (n_amplitudes,) float
        Changing loads [N, N m].
    """

    q: Vector
    v: Vector
    a: Vector
    b: Vector
    lam: Vector
    amplitudes: Vector


def make_march(
    system: Mechanics,
    dt: float,
    integrator: Implicit,
    start: Start,
    largest_gain: float,
    noise: float,
) -> ControlledLoop:
    """Build the compiled march; only those of Newmark's family can be controlled.

    Parameters
    ----------
    system : System
        What moves.
    dt : float
        Time step [s].
    integrator : Implicit
        Weights of the formulas.
    start : Start
        The first state.
    largest_gain : float
        Share of the energy exchanged so far by which the energy may exceed what was given.
    noise : float
        Energy that rounding makes [J].
    """
    march: ControlledLoop = compiled_module(integrator.loop).March(
        system,
        dt,
        integrator,
        start.q,
        start.v,
        start.a,
        start.b,
        start.lam,
        system.dead_load,
        start.amplitudes,
        largest_gain,
        noise,
    )
    return march
