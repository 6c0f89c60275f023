"""Newton's method for equilibria of slender bodies, and its fallback: motion without inertia."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState
from ancfsparse.solve.statics.extrapolated_tangent import Tangent

Vector = NDArray[np.float64]

# Most factors for one equilibrium, and those after which corrections must have become smaller.
MOST_FACTORS, PATIENCE = 40, 12
# Largest change of a slope in a correction: beyond half a radian a tangent is of little use.
LARGEST_TURN = 0.5
# Corrections by an old factor must shrink by this, and forces by more, or they have stretched what
# is slender; they are tried where Newton's shrink too.  Most of them.
CONTRACTION, FORCE_CONTRACTION, MOST_CHORDS = 0.25, 0.03, 12
# Factors of a settling, and the share of the shift below which Newton takes over.
MOST_SETTLING, SMALL_TURN, SHIFT_SHARE = 60, 0.05, 0.1
# Factors where rigid motions are free, which go farther.
MOST_MOVING = 240
# Share of the first shift that stays on the diagonal there, for motions that take no force.
NEUTRAL = 1e-5


class NotFoundError(Exception):
    """No equilibrium from here.

    Parameters
    ----------
    reason : str
        Why.
    state : State
        The last one.
    load : float
        Share of the loads.
    reached : float, optional
        Share under which load steps have found one.
    """

    def __init__(self, reason: str, state: StaticState, load: float, reached: float = 0.0) -> None:
        super().__init__(reason)
        self.reason, self.state, self.load, self.reached = reason, state, load, reached


class StaticResult(NamedTuple):
    """An equilibrium.

    Attributes
    ----------
    state : State
        Where.
    negative : int
        Negative pivots of its stiffness: none if it is stable.
    error : float
        The last correction of a body, or how far rounding may move it if that is more [m].
    """

    state: StaticState
    negative: int
    error: float


def find(
    balance: EquilibriumEquations,
    state: StaticState,
    load: float,
    tolerance: float,
    *,
    extrapolate: bool = True,
    definite: bool = False,
    shift: float = 0.0,
) -> StaticResult:
    """Solve for the equilibrium near a state.

    Newton's, with tangents that extrapolate the stress and corrections that turn no slope too far.
    Between factors, where corrections shrink well, the last one is used again with Broyden's
    update.  The last factor is that of the equilibrium.

    Parameters
    ----------
    balance : Balance
        The equations.
    state : State
        Where to begin.
    load : float
        Share of the loads.
    tolerance : float
        Share of the loads that may stay unbalanced.
    extrapolate : bool, optional
        Whether to extrapolate the stress; without it the tangent is exact.
    definite : bool, optional
        Whether to give up where the stiffness is not definite.
    shift : float, optional
        Added to it times the mass [1/s2], where some motion may take no force.

    Raises
    ------
    NotFoundError
        If corrections do not become small.
    """
    tangent, closing = Tangent(balance), False
    sizes: list[float] = []
    for k in range(MOST_FACTORS):
        exact = closing or not extrapolate
        values = (tangent.exact if exact else tangent.extrapolated)(state, load)
        negative = balance.factor(state, values, load, shift)
        dx, dlam = balance.correction(state)
        size = balance.distance(dx)
        if negative is None or not math.isfinite(size):
            raise NotFoundError("the stiffness is singular", state, load)
        if definite and negative:
            raise NotFoundError("the stiffness is not definite", state, load)
        share = _share(balance, dx)
        arrived = (exact or k == 0) and share == 1.0 and _is_small(balance, state, dx, tolerance)
        error = balance.distances(dx)
        # Coordinates cannot take any less.
        least = share == 1.0 and bool(np.all(error <= EPSILON * balance.span))
        if closing and not arrived:
            noise = balance.noise(state, load)
            arrived, error = bool(np.all(error <= noise)), noise
        state = balance.moved(state, share * dx, share * dlam, load)
        balance.stats.iterations += 1
        if not np.isfinite(state.r).all():
            raise NotFoundError("a correction left the range of numbers", state, load)
        if arrived and (least or balance.is_balanced(state, load, tolerance)):
            return StaticResult(state, balance.negative_pivots(negative), float(error.max()))
        sizes.append(size)
        if len(sizes) > PATIENCE and size > 0.9 * min(sizes[: -PATIENCE // 2]):
            raise NotFoundError("corrections do not become smaller", state, load)
        if share == 1.0 and (len(sizes) == 1 or size < CONTRACTION * sizes[-2]):
            state = _chords(balance, state, dx, load, tolerance)
        closing = least or balance.is_balanced(state, load, tolerance)
    raise NotFoundError(f"no convergence with {MOST_FACTORS} factors", state, load)


def _share(balance: EquilibriumEquations, dx: Vector) -> float:
    """Return the share of a correction that turns no slope too far."""
    return LARGEST_TURN / max(LARGEST_TURN, _turn(balance, dx))


def _turn(balance: EquilibriumEquations, dx: Vector) -> float:
    """Return the largest change of a slope, or of the direction of a string [rad]."""
    turn = float(np.max(np.abs(dx[balance.slopes]), initial=0.0))
    if balance.strings is None:
        return turn
    ends, lengths = balance.strings
    moved = np.append(dx, np.zeros(balance.system.n_all - len(dx)))[ends]
    return max(turn, float(np.max(np.abs(moved[:, 1] - moved[:, 0]) / lengths[:, None])))


def _is_small(
    balance: EquilibriumEquations, state: StaticState, dx: Vector, tolerance: float
) -> bool:
    """Whether a correction is small beside what each body has moved: its square is left."""
    system = balance.system
    moved = balance.distances(state.q[: system.n_free] - system.q_ref[: system.n_free])
    rounding = 64.0 * EPSILON * balance.span
    return bool(np.all(balance.distances(dx) <= tolerance ** (2.0 / 3.0) * moved + rounding))


def _chords(
    balance: EquilibriumEquations, state: StaticState, dx: Vector, load: float, tolerance: float
) -> StaticState:
    """Correct by the last factor with Broyden's update, for as long as that converges well."""
    steps, last = [dx], balance.distance(dx)
    for _ in range(MOST_CHORDS):
        if balance.is_balanced(state, load, tolerance):
            break
        s, dlam = balance.correction(state)
        for one, following in itertools.pairwise(steps):
            s = s + (balance.mass * one) @ s / ((balance.mass * one) @ one) * following
        latest = balance.mass * steps[-1]
        changed = 1.0 - latest @ s / (latest @ steps[-1])
        if changed == 0.0:  # the residual did not change, which the update would divide by
            break
        s = s / changed
        size = balance.distance(s)
        if not size <= CONTRACTION * last:
            break
        new = balance.moved(state, s, dlam, load)
        balance.stats.iterations += 1
        if not balance.size_of_forces(new.r) <= FORCE_CONTRACTION * balance.size_of_forces(state.r):
            break
        state, last = new, size
        steps.append(s)
    return state


def settle(
    balance: EquilibriumEquations,
    state: StaticState,
    load: float,
    tolerance: float,
    *,
    farthest: float = math.inf,
) -> StaticResult:
    """Let the scene creep downhill until it comes to rest, and find the equilibrium there.

    Implicit steps of ``M dq/dt = -r`` without inertia, each solved by one correction with mass
    over the step on the diagonal: as much as the stiffness needs to be definite.

    Parameters
    ----------
    balance, state, load, tolerance
        As in `find`.
    farthest : float, optional
        Displacement that no step goes far beyond, where rigid motions are free [m].

    Raises
    ------
    NotFoundError
        If it does not come to rest.
    """
    tangent = Tangent(balance)
    moves = math.isfinite(farthest)
    factors = balance.stats.factorizations + (MOST_MOVING if moves else MOST_SETTLING)
    shift = balance.acceleration / farthest
    least = NEUTRAL * shift
    before: Vector | None = None
    while balance.stats.factorizations < factors:
        values = tangent.extrapolated(state, load)
        push = balance.distance(state.r / balance.mass)  # an acceleration [m/s2]
        while True:
            definite = balance.factor(state, values, load, shift) == 0
            dx, dlam = balance.correction(state) if definite else (state.r, state.phi)
            share = _share(balance, dx)
            if definite and share > 0.25 and balance.distance(dx) <= 2.0 * farthest:
                break
            shift = 4.0 * shift if shift > 0.0 else 1e-3 * push / balance.span
            if balance.stats.factorizations >= factors or not math.isfinite(shift):
                raise NotFoundError("the scene does not come to rest", state, load)
        state = balance.moved(state, share * dx, share * dlam, load)
        balance.system.assembly.accept(state.q)
        balance.stats.iterations += 1
        turn = _turn(balance, dx)
        if turn <= SMALL_TURN and shift * balance.distance(dx) <= SHIFT_SHARE * push:
            try:
                return find(balance, state, load, tolerance, definite=True, shift=least)
            except NotFoundError:
                pass
        # Steps to and fro are too long for how constraints curve.
        back = before is not None and (balance.mass * dx) @ before < 0.0
        shift *= 4.0 if back else 0.5 if turn > 0.2 * LARGEST_TURN else 0.25
        before = dx if moves else None
    raise NotFoundError("the scene does not come to rest", state, load)
