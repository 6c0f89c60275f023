"""Reference motions with their uncertainty."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ancfsparse.integrators import Newmark
from ancfsparse.nonlinear import ModifiedNewton
from ancfsparse.results.data.interpolation import interpolate
from ancfsparse.solve import simulate
from ancfsparse.system import System
from benchmarks.accuracy.models import MODELS, OUTPUTS, Tips, distance, output_times
from benchmarks.common.first_order import FirstOrder, integrate

# Much tighter tolerances of DOP853 meet the rounding of the forces.
RTOL, ATOL = 1e-10, 1e-11  # relative, absolute
TOLERANCE = 1e-7  # residual of the steps below [m/s2]


@dataclass(frozen=True)
class Reference:
    """The tip of a reference motion."""

    tip: Tips  # (4, 2), at the output times [m]
    uncertainty: float  # [m]
    how: str  # where both numbers come from


def converged_in_time(model: str, elements: int, t_end: float, dt: float) -> Reference:
    """Solve a mesh exactly in time, twice: by DOP853 and by the trapezoidal rule, extrapolated.

    The two share the forces and nothing else.  The tip is that by DOP853, its uncertainty the
    distance between the two; `dt` is the largest of the three steps that are extrapolated [s].
    """
    problem = MODELS[model].problem(elements)
    system = System(problem.scene)
    t = np.concatenate([[0.0], output_times(t_end)])
    precise = integrate(FirstOrder(system), "DOP853", t, RTOL, ATOL)
    tip = interpolate(system.point(problem.rod.end), precise.q)[1:]
    other, _ = extrapolate([trapezoidal_tip(model, elements, t_end, dt / 2**k) for k in range(3)])
    return Reference(
        tip,
        distance(tip, other),
        f"DOP853 with rtol {RTOL:g}; uncertainty: distance from the trapezoidal rule with steps of "
        f"{dt:.3g}, {dt / 2:.3g} and {dt / 4:.3g} s, extrapolated",
    )


def converged(model: str, elements: int, t_end: float, dt: float) -> Reference:
    """Solve a model exactly in time and space, by extrapolation.

    `elements`, an even number, is that of the finer of two meshes, and `dt` the largest of the
    three steps on it [s].  The uncertainty is the size of the last corrections in time and in
    space.
    """
    fine, last = extrapolate([trapezoidal_tip(model, elements, t_end, dt / 2**k) for k in range(3)])
    coarse, _ = extrapolate(
        [trapezoidal_tip(model, elements // 2, t_end, dt / 2**k) for k in range(3)]
    )
    tip = fine + (fine - coarse) / (2.0 ** MODELS[model].order - 1.0)
    return Reference(
        tip,
        last + distance(tip, fine),
        f"extrapolated from {elements // 2} and {elements} elements and steps of {dt:.3g}, "
        f"{dt / 2:.3g} and {dt / 4:.3g} s; uncertainty: the last corrections in time and space",
    )


def extrapolate(tips: list[Tips]) -> tuple[Tips, float]:
    """Remove the even powers of the step from tips found with h, h/2, h/4 ...

    Returns
    -------
    tip : (k, 2) float
        Richardson's extrapolation [m].
    last : float
        The distance between the last two columns of the scheme, that is the size of the last
        correction [m].
    """
    columns = [tips]
    while len(columns[-1]) > 1:
        power = 4.0 ** len(columns)
        columns.append([(power * b - a) / (power - 1.0) for a, b in pairwise(columns[-1])])
    tip = columns[-1][-1]
    return tip, distance(tip, columns[-2][-1])


def trapezoidal_tip(model: str, elements: int, t_end: float, dt: float) -> Tips:
    """Return the tip (4, 2) by the trapezoidal rule, its equations solved tightly [m]."""
    scene, rod = MODELS[model].problem(elements)
    run = simulate(
        scene,
        t_end,
        dt,
        integrator=Newmark(0.0),
        solver=ModifiedNewton(),
        tolerance=TOLERANCE,
        save_every=round(t_end / OUTPUTS / dt),
        save_nodes=[rod.end],
    )
    return run.position(rod.end)[1:]
