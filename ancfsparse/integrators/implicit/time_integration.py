"""Configuration of the compiled implicit time loop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from ancfsparse.array_types import Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.integrators.implicit.newmark_family import Implicit

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import NewmarkLoop


class Mechanics(Protocol):
    """System as the time loop uses it; see ``ancf_system`` in abi/solver_abi.h."""

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
        Coordinates [m, 1], velocities, accelerations (for an implicit integrator the part that its
        step resolves), pseudo-accelerations.
    lam : (m,) float
        Multipliers [N].
    amplitudes : (n_amplitudes,) float
        Time-dependent loads [N, N m].
    """

    q: Vector
    v: Vector
    a: Vector
    b: Vector
    lam: Vector
    amplitudes: Vector


def make_time_loop(
    system: Mechanics,
    dt: float,
    integrator: Implicit,
    start: Start,
    largest_gain: float,
    noise: float,
    rounding: float,
) -> NewmarkLoop:
    """Build the compiled time loop; only Newmark's family admits step size control.

    Parameters
    ----------
    system : System
        The system.
    dt : float
        Time step [s].
    integrator : Implicit
        Weights of the formulas.
    start : Start
        The first state.
    largest_gain : float
        Largest energy increase, relative to the energy exchanged so far [-].
    noise, rounding : float
        Energy increase by rounding [J], and root of the energy of its errors in a step [J^(1/2)].
    """
    loop: NewmarkLoop = compiled_module(integrator.loop).March(
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
        rounding,
    )
    return loop
