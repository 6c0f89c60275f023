"""Equilibria along a path by its arc length, also where the load falls."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState
from ancfsparse.solve.statics.newton_and_relaxation import NotFoundError, solve_newton

Vector = NDArray[np.float64]

# Corrections of a point: as many as are aimed at, and the most.
WANTED, MOST_CORRECTIONS = 5, 14
# Largest turn of a slope from point to point [rad], and the share of the loads of the first step.
TURN, FIRST = 0.12, 0.02
# By how much steps may change at a time, and the shortest beside the first.
SHORTER, LONGER, SHORTEST = 0.5, 1.5, 1e-7
# Steps that place a point where the load turns, and the relative accuracy of its load.
MOST_SEARCHES, TURNED = 12, 1e-8
# Share of the last load, against it, at which a path ends that leads away from it.
REVERSED = 10.0
# Halvings that place a point where the path branches, and solutions for the buckling shape.
HALVINGS, SOLUTIONS = 14, 4
# Largest turn of a slope of the first point beside it [rad], and the smallest share of that.
BESIDE, LEAST_BESIDE = 0.05, 1.0 / 64.0


class PathPoint(NamedTuple):
    """An equilibrium on the path, and how the path goes on.

    Attributes
    ----------
    state : State
        Where.
    load : float
        Share of the loads.
    dx, dlam : (n_free,), (m,) float
        Change of coordinates and multipliers per unit of arc length.
    dload : float
        Change of the share of the loads likewise [1/m].
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
    """What has been found so far.

    Attributes
    ----------
    all : list of PathPoint
        In order.
    turns : list of int
        Those where the load turns.
    forks : list of int
        Those from which another branch was followed.
    arrived : bool
        Whether the last one is under the whole load.
    """

    all: list[PathPoint] = field(default_factory=list)
    turns: list[int] = field(default_factory=list)
    forks: list[int] = field(default_factory=list)
    arrived: bool = False


def follow(
    equations: EquilibriumEquations, to: float, most: int, tolerance: float, side: int = 0
) -> EquilibriumPath:
    """Follow the path of equilibria from the reference shape until the load reaches a share.

    Parameters
    ----------
    equations : EquilibriumEquations
        The equations.
    to : float
        Share of the loads at which the path ends, above zero.
    most : int
        Most points.
    tolerance : float
        Unbalanced share of the loads.
    side : int, optional
        1 or -1: leave the path where it first branches, to that side; 0: go straight on.

    Raises
    ------
    NotFoundError
        If no further point is found.
    """
    start = solve_newton(equations, equations.start, 0.0, tolerance)
    path = EquilibriumPath([_point(equations, start.state, 0.0, None)])
    first = path.all[0]
    step = shortest = FIRST * to / first.dload
    while len(path.all) < most:
        last = path.all[-1]
        step = min(step, TURN / max(_turn(equations, last.dx), 1e-300))
        try:
            new, corrections = _next(equations, last, step, to, tolerance)
        except NotFoundError:
            step *= SHORTER
            if step < SHORTEST * shortest:
                raise
            continue
        if new.dload * last.dload < 0.0:
            turn = _turning(equations, last, new, step, to, tolerance)
            if turn is not None:
                path.turns.append(len(path.all))
                path.all.append(turn)
        elif side and not path.forks and new.negative > last.negative:
            fork = _fork(equations, last, new, step, to, tolerance)
            path.forks.append(len(path.all))
            path.all.append(fork)
            new, step = _beside(equations, fork, side, to, tolerance)
        if new.load >= to:
            end = _at(equations, path.all[-1], new, to, tolerance)
            path.all.append(end)
            path.arrived = True
            break
        path.all.append(new)
        if new.load <= -REVERSED * to:
            break
        step *= min(LONGER, max(SHORTER, (WANTED / corrections) ** 0.5))
    return path


def _point(
    equations: EquilibriumEquations, state: StaticState, load: float, before: Vector | None
) -> PathPoint:
    """Factor at an equilibrium and go on along the path, or begin with a growing load."""
    values = equations.stiffness(state, load)
    negative = equations.factor(state, values, load)
    if negative is None:
        raise NotFoundError("the stiffness is singular", state, load)
    dx, dlam = _pull(equations, state, load)
    size = equations.distance(dx)
    ahead = before is None or (equations.mass * before) @ dx > 0.0
    scale = (1.0 if ahead else -1.0) / size
    return PathPoint(
        state, load, scale * dx, scale * dlam, scale, equations.negative_pivots(negative)
    )


def _pull(
    equations: EquilibriumEquations, state: StaticState, load: float
) -> tuple[Vector, Vector]:
    """Return the change of coordinates and multipliers per share of the loads."""
    small = equations.small_load
    there = equations.state(state.q, state.lam, load + small)
    here = equations.state(state.q, state.lam, load)
    change = StaticState(state.q, state.lam, there.r - here.r, there.phi - here.phi)
    dx, dlam = equations.correction(change)
    return dx / small, dlam / small


def _next(
    equations: EquilibriumEquations, last: PathPoint, step: float, to: float, tolerance: float
) -> tuple[PathPoint, int]:
    """Find the equilibrium on the plane across the path at a distance; count the corrections."""
    load = last.load + step * last.dload
    state = equations.moved(last.state, step * last.dx, step * last.dlam, load)
    across, target = equations.mass * last.dx, state.q[: len(last.dx)]
    for k in range(1, MOST_CORRECTIONS + 1):
        if equations.factor(state, equations.stiffness(state, load), load) is None:
            raise NotFoundError("the stiffness is singular", state, load)
        dx, dlam = equations.correction(state)
        more, mlam = _pull(equations, state, load)
        share = -float((across @ (state.q[: len(dx)] + dx - target)) / (across @ more))
        dx, dlam, load = dx + share * more, dlam + share * mlam, load + share
        size = equations.distance(dx)
        if not np.isfinite(size) or size > 2.0 * abs(step) or _turn(equations, dx) > 2.0 * TURN:
            raise NotFoundError("corrections lead away", state, load)
        state = equations.moved(state, dx, dlam, load)
        equations.stats.iterations += 1
        if not np.isfinite(state.r).all():
            raise NotFoundError("a correction left the range of numbers", state, load)
        small = size <= tolerance ** (2.0 / 3.0) * abs(step) + 1e-14 * equations.span
        if small and equations.is_balanced(state, to, tolerance):
            equations.stats.steps += 1
            return _point(equations, state, load, last.dx), k
    raise NotFoundError(f"no convergence with {MOST_CORRECTIONS} factors", state, load)


def _turning(
    equations: EquilibriumEquations,
    last: PathPoint,
    new: PathPoint,
    step: float,
    to: float,
    tolerance: float,
) -> PathPoint | None:
    """Find the point between two where the load turns, by the secant method kept between them."""
    low, high = 0.0, step
    at_low, at_high = last.dload, new.dload
    best: PathPoint | None = None
    for _ in range(MOST_SEARCHES):
        at = low + (high - low) * at_low / (at_low - at_high)
        at = min(max(at, low + 0.05 * (high - low)), high - 0.05 * (high - low))
        try:
            best = _next(equations, last, at, to, tolerance)[0]
        except NotFoundError:
            return best
        rate = best.dload
        if abs(rate * (high - low)) <= TURNED * abs(to):
            break
        if rate * at_low > 0.0:
            low, at_low = at, rate
        else:
            high, at_high = at, rate
    return best


def _fork(
    equations: EquilibriumEquations,
    last: PathPoint,
    new: PathPoint,
    step: float,
    to: float,
    tolerance: float,
) -> PathPoint:
    """Find the point between two where the path loses its stability: the last one before."""
    low, high, best = 0.0, step, last
    for _ in range(HALVINGS):
        at = 0.5 * (low + high)
        point = _next(equations, last, at, to, tolerance)[0]
        if point.negative > last.negative:
            high = at
        else:
            low, best = at, point
    return best


def _beside(
    equations: EquilibriumEquations, fork: PathPoint, side: int, to: float, tolerance: float
) -> tuple[PathPoint, float]:
    """Find an equilibrium on the other branch, in the buckling direction, and its distance.

    Its distance from the fork along that direction is held, and the load is sought.
    """
    state, load = fork.state, fork.load
    equations.factor(state, equations.stiffness(state, load), load)
    x = np.random.default_rng(3).standard_normal(len(equations.mass)) / np.sqrt(equations.mass)
    none, dlam = np.zeros_like(state.phi), np.zeros_like(state.lam)
    for _ in range(SOLUTIONS):
        x, dlam = equations.correction(StaticState(state.q, state.lam, -equations.mass * x, none))
        size = equations.distance(x)
        x, dlam = x / size, dlam / size
    first = np.argmax(np.abs(x) * np.sqrt(equations.mass))
    sign = side * np.sign(x[first])
    away = PathPoint(state, load, sign * x, sign * dlam, 0.0, fork.negative)
    step = whole = BESIDE / _turn(equations, x)
    while True:
        try:
            return _next(equations, away, step, to, tolerance)[0], step
        except NotFoundError:
            step *= SHORTER
            if step < LEAST_BESIDE * whole:
                raise


def _at(
    equations: EquilibriumEquations, last: PathPoint, new: PathPoint, to: float, tolerance: float
) -> PathPoint:
    """Find the equilibrium under a share of the loads between two points."""
    part = (to - last.load) / (new.load - last.load)
    q = last.state.q + part * (new.state.q - last.state.q)
    lam = last.state.lam + part * (new.state.lam - last.state.lam)
    found = solve_newton(equations, equations.state(q, lam, to), to, tolerance, extrapolate=False)
    return _point(equations, found.state, to, last.dx)


def _turn(equations: EquilibriumEquations, dx: Vector) -> float:
    """Return the largest change of a slope [rad]."""
    return float(np.max(np.abs(dx[equations.slopes]), initial=0.0))
