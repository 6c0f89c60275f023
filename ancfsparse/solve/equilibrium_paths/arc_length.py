"""Equilibrium paths by arc-length continuation, past limit points and bifurcations."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState
from ancfsparse.solve.statics.newton_and_relaxation import (
    NotFoundError,
    check_passage,
    solve_newton,
)

TARGET_CORRECTIONS = 5  # corrections of a point that the step length aims at
MAX_CORRECTIONS = 14  # corrections of a point
MAX_ROTATION = 0.12  # change of a slope from point to point [rad]
FIRST_LOAD_STEP = 0.02  # of the final load
MIN_STEP_RATIO = 0.5  # of the last step
MAX_STEP_RATIO = 1.5  # of the last step
# Of the first step, as its rotation limits it: tangents of straight ropes have hundreds of metres.
MIN_STEP = 1e-7
MAX_SECANT_STEPS = 12  # secant steps for a limit point
LIMIT_TOLERANCE = 1e-8  # relative error of its load
MAX_REVERSE_LOAD = 10.0  # opposite load over the final one at which a path ends
N_BISECTIONS = 14  # for a bifurcation point
N_INVERSE_ITERATIONS = 4  # for the buckling shape
BRANCH_ROTATION = 0.05  # change of a slope to the first point of another branch [rad]
MIN_BRANCH_RATIO = 1.0 / 64.0  # part of it that is tried


class PathPoint(NamedTuple):
    """An equilibrium on the path, with the tangent of the path.

    Attributes
    ----------
    state : StaticState
        The state.
    load : float
        Load factor.
    dx, dlam : (n_free,), (m,) float
        Change of coordinates and multipliers per unit of arc length.
    dload : float
        Change of the load factor per unit of arc length [1/m].
    negative : int
        Negative pivots of the stiffness.
    """

    state: StaticState
    load: float
    dx: Vector
    dlam: Vector
    dload: float
    negative: int


@dataclass
class EquilibriumPath:
    """The points of a path.

    Attributes
    ----------
    points : list of PathPoint
        In order.
    limit_points : list of int
        Indices of limit points.
    bifurcations : list of int
        Indices of points at which another branch was followed.
    is_complete : bool
        Whether the last point is under the final load.
    """

    points: list[PathPoint] = field(default_factory=list)
    limit_points: list[int] = field(default_factory=list)
    bifurcations: list[int] = field(default_factory=list)
    is_complete: bool = False

    def append(self, equations: EquilibriumEquations, point: PathPoint) -> None:
        """Add the next point, which the history of forces follows."""
        equations.system.accept_equilibrium(point.state.q)
        self.points.append(point)


def follow_path(
    equations: EquilibriumEquations, to: float, max_points: int, tolerance: float, side: int = 0
) -> EquilibriumPath:
    """Follow the equilibrium path from the reference shape to a load factor.

    Parameters
    ----------
    equations : EquilibriumEquations
        The equations.
    to : float
        Final load factor, positive.
    max_points : int
        Largest number of points.
    tolerance : float
        Largest residual over the loads [-].
    side : int, optional
        1 or -1: follow the other branch to that side from the first bifurcation; 0: go straight on.

    Raises
    ------
    NotFoundError
        If no further point is found.
    """
    start = solve_newton(equations, equations.start, 0.0, tolerance)
    tracer = _PathTracer(equations, to, tolerance)
    path = EquilibriumPath()
    path.append(equations, _path_point(equations, start.state, 0.0, None))
    first = path.points[0]
    step = FIRST_LOAD_STEP * to / first.dload
    first_step = min(step, _longest_step(equations, first))
    while len(path.points) < max_points:
        last = path.points[-1]
        step = min(step, _longest_step(equations, last))
        try:
            new, corrections = tracer.next_point(last, step)
        except NotFoundError:
            step *= MIN_STEP_RATIO
            if step < MIN_STEP * first_step:
                raise
            continue
        if new.dload * last.dload < 0.0:
            limit = tracer.limit_point(last, new, step)
            if limit is not None:
                path.limit_points.append(len(path.points))
                path.append(equations, limit)
        elif side and not path.bifurcations and new.negative > last.negative:
            bifurcation = tracer.bifurcation_point(last, step)
            path.bifurcations.append(len(path.points))
            path.append(equations, bifurcation)
            new, step = tracer.branch_point(bifurcation, side)
        if new.load >= to:
            path.append(equations, tracer.final_point(path.points[-1], new))
            path.is_complete = True
            break
        path.append(equations, new)
        if new.load <= -MAX_REVERSE_LOAD * to:
            break
        step *= min(MAX_STEP_RATIO, max(MIN_STEP_RATIO, (TARGET_CORRECTIONS / corrections) ** 0.5))
    return path


def _path_point(
    equations: EquilibriumEquations, state: StaticState, load: float, before: Vector | None
) -> PathPoint:
    """Return a point with its tangent, in the direction `before` or of growing load."""
    values = equations.stiffness(state, load)
    negative = equations.factor(state, values, load)
    if negative is None:
        raise NotFoundError("the stiffness is singular", state, load)
    dx, dlam = _tangent_direction(equations, state, load)
    size = equations.distance(dx)
    is_ahead = before is None or (equations.mass * before) @ dx > 0.0
    scale = (1.0 if is_ahead else -1.0) / size
    return PathPoint(
        state, load, scale * dx, scale * dlam, scale, equations.negative_pivots(negative)
    )


def _tangent_direction(
    equations: EquilibriumEquations, state: StaticState, load: float
) -> tuple[Vector, Vector]:
    """Return the change of coordinates and multipliers per unit of the load factor."""
    small = equations.imposed.small_factor
    loaded = equations.state(state.q, state.lam, load + small)
    now = equations.state(state.q, state.lam, load)
    change = StaticState(state.q, state.lam, loaded.r - now.r, loaded.phi - now.phi)
    dx, dlam = equations.correction(change)
    return dx / small, dlam / small


class _PathTracer:
    """Finds points of a path; equations, load factor and tolerance are those of `follow_path`."""

    def __init__(self, equations: EquilibriumEquations, to: float, tolerance: float) -> None:
        self._equations, self._to, self._tolerance = equations, to, tolerance

    def next_point(self, last: PathPoint, step: float) -> tuple[PathPoint, int]:
        """Find the equilibrium on the plane across the path at a distance, and its corrections."""
        equations, load = self._equations, last.load + step * last.dload
        state = equations.moved(last.state, step * last.dx, step * last.dlam, load)
        across, target = equations.mass * last.dx, state.q[: len(last.dx)]
        for k in range(1, MAX_CORRECTIONS + 1):
            if equations.factor(state, equations.stiffness(state, load), load) is None:
                raise NotFoundError("the stiffness is singular", state, load)
            dx, dlam = equations.correction(state)
            pulled, pulled_lam = _tangent_direction(equations, state, load)
            dload = -float((across @ (state.q[: len(dx)] + dx - target)) / (across @ pulled))
            dx, dlam, load = dx + dload * pulled, dlam + dload * pulled_lam, load + dload
            size = equations.distance(dx)
            if (
                not np.isfinite(size)
                or size > 2.0 * abs(step)
                or _largest_rotation(equations, dx) > 2.0 * MAX_ROTATION
            ):
                raise NotFoundError("corrections diverge from the path", state, load)
            state = equations.moved(state, dx, dlam, load)
            equations.stats.iterations += 1
            if not np.isfinite(state.r).all():
                raise NotFoundError("a correction left the range of numbers", state, load)
            is_small = size <= self._tolerance ** (2.0 / 3.0) * abs(step) + 1e-14 * equations.span
            if is_small and equations.is_balanced(state, self._to, self._tolerance):
                check_passage(equations, last.state.q, state, load)
                equations.stats.steps += 1
                return _path_point(equations, state, load, last.dx), k
        raise NotFoundError(f"no convergence with {MAX_CORRECTIONS} factors", state, load)

    def limit_point(self, last: PathPoint, new: PathPoint, step: float) -> PathPoint | None:
        """Find the limit point between two points by a bracketed secant method."""
        low, high = 0.0, step
        low_rate, high_rate = last.dload, new.dload
        best: PathPoint | None = None
        for _ in range(MAX_SECANT_STEPS):
            at = low + (high - low) * low_rate / (low_rate - high_rate)
            at = min(max(at, low + 0.05 * (high - low)), high - 0.05 * (high - low))
            try:
                best = self.next_point(last, at)[0]
            except NotFoundError:
                return best
            rate = best.dload
            if abs(rate * (high - low)) <= LIMIT_TOLERANCE * abs(self._to):
                break
            if rate * low_rate > 0.0:
                low, low_rate = at, rate
            else:
                high, high_rate = at, rate
        return best

    def bifurcation_point(self, last: PathPoint, step: float) -> PathPoint:
        """Return the last stable point before a bifurcation between two points, by bisection."""
        low, high, best = 0.0, step, last
        for _ in range(N_BISECTIONS):
            at = 0.5 * (low + high)
            point = self.next_point(last, at)[0]
            if point.negative > last.negative:
                high = at
            else:
                low, best = at, point
        return best

    def branch_point(self, origin: PathPoint, side: int) -> tuple[PathPoint, float]:
        """Find an equilibrium on the other branch, in the buckling direction, and its distance.

        The distance from the bifurcation in that direction is fixed, and the load is unknown.
        """
        equations, state, load = self._equations, origin.state, origin.load
        equations.factor(state, equations.stiffness(state, load), load)
        x = np.random.default_rng(3).standard_normal(len(equations.mass)) / np.sqrt(equations.mass)
        no_violation, dlam = np.zeros_like(state.phi), np.zeros_like(state.lam)
        for _ in range(N_INVERSE_ITERATIONS):
            r = -equations.mass * x
            x, dlam = equations.correction(StaticState(state.q, state.lam, r, no_violation))
            size = equations.distance(x)
            x, dlam = x / size, dlam / size
        first = np.argmax(np.abs(x) * np.sqrt(equations.mass))
        sign = side * np.sign(x[first])
        tangent = PathPoint(state, load, sign * x, sign * dlam, 0.0, origin.negative)
        step = first_step = BRANCH_ROTATION / _largest_rotation(equations, x)
        while True:
            try:
                return self.next_point(tangent, step)[0], step
            except NotFoundError:
                step *= MIN_STEP_RATIO
                if step < MIN_BRANCH_RATIO * first_step:
                    raise

    def final_point(self, last: PathPoint, new: PathPoint) -> PathPoint:
        """Find the equilibrium at the final load factor between two points."""
        equations, to = self._equations, self._to
        fraction = (to - last.load) / (new.load - last.load)
        q = last.state.q + fraction * (new.state.q - last.state.q)
        lam = last.state.lam + fraction * (new.state.lam - last.state.lam)
        state = equations.state(q, lam, to)
        check_passage(equations, last.state.q, state, to)
        result = solve_newton(equations, state, to, self._tolerance, extrapolate=False)
        return _path_point(equations, result.state, to, last.dx)


def _longest_step(equations: EquilibriumEquations, last: PathPoint) -> float:
    """Return the step length from a point with the largest rotation."""
    return MAX_ROTATION / max(_largest_rotation(equations, last.dx), 1e-300)


def _largest_rotation(equations: EquilibriumEquations, dx: Vector) -> float:
    """Return the largest change of a slope [rad]."""
    return float(np.max(np.abs(dx[equations.slopes]), initial=0.0))
