"""Consistent initial conditions for prescribed coordinates and constraints."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.solve import initial_conditions
from ancfsparse.system import System
from ancfsparse.system.coordinates.numbering import velocity_scales
from ancfsparse.system.coordinates.state import ROUNDING, State

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import ImplicitLoop


RESTART_TOLERANCE = 1e-6  # error of a start from another run, over the largest coordinate
START_TOLERANCE = 1e-9  # the same of other starts: rounding
MAX_VELOCITY_JUMP = 1e-3  # at the start, over the largest prescribed velocity
N_SAMPLES = 65  # times at which that is sampled
REMEDY = (
    "take start=assemble(scene), or start=solve_static(scene) for a scene that comes to rest under "
    "its loads, or let its function begin"
)


def start_prescribed_motions(
    system: System, state: State | None, step: float, t_end: float
) -> None:
    """Set prescribed coordinates and velocities in the initial state of a system.

    Parameters
    ----------
    system : System
        Its ``q0`` and ``v0`` are replaced.
    state : State or None
        Source of the initial state.
    step, t_end : float
        Length of the steps, and end of the motion [s].

    Raises
    ------
    InputError
        If a prescribed motion differs from the start in position or velocity, is not smooth, or has
        rates that are not its derivatives.
    LoadError
        If its function fails.
    """
    prescribed, n = system.prescribed, system.prescribed.n
    if not prescribed:
        return
    prescribed.resolve(step, system.t0, t_end)
    initial_conditions.check_prescribed_motions(system, t_end)
    if not n:
        return
    now, first = prescribed.at(system.t0), system.n_all - n
    system.q0, system.v0 = system.q0.copy(), system.v0.copy()
    difference = np.abs(system.q0[first:] - now.q)
    row = int(np.argmax(difference))
    allowed = (START_TOLERANCE if state is None else RESTART_TOLERANCE) * max(
        float(np.max(np.abs(system.q0))), float(np.max(np.abs(now.q)))
    )
    course = prescribed.course_of(row)
    if difference[row] > allowed and course.value.unit == "rad":
        raise InputError(
            f"{course.value.what} begins {difference[row]:.3g} rad and more from where the "
            f"motion starts: {REMEDY} there"
        )
    if difference[row] > allowed:
        raise InputError(
            f"the drive of {system.describe(first + row)} begins at {now.q[row]:.9g} m, and "
            f"the motion starts at {system.q0[first + row]:.9g} m there: {REMEDY} where the motion "
            "starts"
        )
    times = np.linspace(system.t0, t_end, N_SAMPLES)
    fastest = prescribed.fastest(times)
    allowed_v = MAX_VELOCITY_JUMP * fastest + ROUNDING * velocity_scales(
        system.scene, system.places, system.v0
    )
    allowed_v = allowed_v[first:] + prescribed.speed_errors(system.t0)
    excess = np.abs(system.v0[first:] - now.v) - allowed_v
    row = int(np.argmax(excess))
    course = prescribed.course_of(row)
    if excess[row] > 0.0 and course.value.unit == "rad":
        raise InputError(
            f"{course.value.what} begins with another angular velocity than the body has there, "
            f"by {abs(system.v0[first + row] - now.v[row]):.3g} rad/s and more: "
            "that is an impact; let the angle begin smoothly, as Ramp(..., smooth=True) does, or "
            "give the body that angular velocity"
        )
    if excess[row] > 0.0:
        raise InputError(
            f"the drive of {system.describe(first + row)} begins with {now.v[row]:.6g} m/s, "
            f"and the body moves there with {system.v0[first + row]:.6g} m/s: that is an impact; "
            "let the drive begin smoothly, as Ramp(..., smooth=True) does, or give the body that "
            "velocity"
        )
    system.q0[first:], system.v0[first:] = now.q, now.v


def inputs_at(
    system: System, times: NDArray[np.float64], rates: bool = False
) -> NDArray[np.float64]:
    """Return the time-dependent inputs at times (k,) [s], as `System.inputs` does.

    Raises
    ------
    LoadError
        If a function fails.
    """
    table, failure = system.inputs(times, rates)
    if failure is not None:
        raise failure
    return table


def prescribe_motions_of_loop(
    system: System, time_loop: ImplicitLoop, a: Vector, lam: Vector
) -> None:
    """Set prescribed motions in a time loop, and the forces that they require at the start."""
    prescribed = system.prescribed
    if not prescribed:
        return
    loads = system.loads.amplitudes(np.array([system.t0]))[0]
    r, _ = system.assembly.residual(system.q0, system.v0, a, lam, system.dead_load, loads)
    first = system.n_all - prescribed.n
    start = prescribed.at(system.t0).s
    time_loop.drive(prescribed.n, prescribed.n_equations, start, r[first:])
