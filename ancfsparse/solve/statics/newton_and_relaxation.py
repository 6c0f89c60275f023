"""Newton's method for equilibria of slender bodies, with relaxation as its fallback."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState
from ancfsparse.solve.statics.extrapolated_tangent import ExtrapolatedTangent
from ancfsparse.system.contributions.interface import limit_length

MAX_FACTORS = 40  # for one equilibrium
MIN_FACTORS = 12  # factors after which corrections must have decreased
MAX_ROTATION = 0.5  # change of a slope in a correction [rad]: larger ones exceed the linear range
MAX_CONTRACTION = 0.25  # of corrections, below which the last factor is used again
# The forces must decrease by more, or corrections have stretched slender bodies.
MAX_FORCE_CONTRACTION = 0.03
MAX_BROYDEN_STEPS = 12  # corrections by the last factor
MAX_RELAXATION_FACTORS = 60  # factors of a relaxation
NEWTON_ROTATION = 0.05  # rotation in a step below which Newton's method is tried [rad]
NEWTON_SHIFT_RATIO = 0.1  # force by the shift over the residual, below which it is tried
# The same with contact, after load steps have failed: points touch one after the other.  Of 32
# ropes above obstacles 23 came to rest with 60, 25 with 200 and 29 with 600.
MAX_CONTACT_FACTORS = 600  # factors of a relaxation
MAX_FREE_FACTORS = 800  # factors with free rigid motions, which go farther: up to 736 in 850 scenes
NEUTRAL_SHIFT_RATIO = 1e-5  # remaining part of the first shift, for motions without stiffness
BLOCKED = "bodies would pass through each other"
UNSTABLE = "the equilibrium is unstable"


class NotFoundError(Exception):
    """No equilibrium was found from a state.

    Parameters
    ----------
    reason : str
        Description of the failure.
    state : StaticState
        The last state.
    load : float
        Its load factor.
    reached : float, optional
        Largest load factor with an equilibrium.
    """

    def __init__(self, reason: str, state: StaticState, load: float, reached: float = 0.0) -> None:
        super().__init__(reason)
        self.reason, self.state, self.load, self.reached = reason, state, load, reached


class StaticResult(NamedTuple):
    """An equilibrium.

    Attributes
    ----------
    state : StaticState
        The state.
    negative : int
        Negative pivots of its stiffness: none if it is stable.
    error : float
        The last correction of a body, or the displacement by rounding if larger [m].
    """

    state: StaticState
    negative: int
    error: float


def solve_newton(
    equations: EquilibriumEquations,
    state: StaticState,
    load: float,
    tolerance: float,
    *,
    extrapolate: bool = True,
    definite: bool = False,
    shift: float = 0.0,
    intermediate: bool = False,
) -> StaticResult:
    """Solve for the equilibrium near a state by Newton's method.

    Tangents extrapolate the stress, the rotation in a correction is bounded, and no bodies pass
    through each other.  Where corrections
    contract well, the last factor is used again with Broyden's update.  The last factor is that of
    the equilibrium.

    Parameters
    ----------
    equations : EquilibriumEquations
        The equations.
    state : StaticState
        Initial state.
    load : float
        Load factor.
    tolerance : float
        Largest residual over the loads [-].
    extrapolate : bool, optional
        Whether to extrapolate the stress; otherwise the tangent is exact.
    definite : bool, optional
        Whether to fail if the stiffness is not positive definite.
    shift : float, optional
        Factor of the mass that is added to the stiffness [1/s2], for motions without stiffness.
    intermediate : bool, optional
        Whether further load steps follow, see `EquilibriumEquations.is_balanced`.

    Raises
    ------
    NotFoundError
        If corrections do not converge.
    """

    def is_balanced(state: StaticState) -> bool:
        return equations.is_balanced(state, load, tolerance, intermediate=intermediate)

    tangent, closing = ExtrapolatedTangent(equations), False
    sizes: list[float] = []
    for k in range(MAX_FACTORS):
        exact = closing or not extrapolate
        values = (tangent.exact if exact else tangent.extrapolated)(state, load)
        negative = equations.factor(state, values, load, shift)
        dx, dlam = equations.correction(state)
        size = equations.distance(dx)
        if negative is None or not math.isfinite(size):
            raise NotFoundError("the stiffness is singular", state, load)
        if definite and negative:
            raise NotFoundError("the stiffness is not definite", state, load)
        length = _step_length(equations, state, dx)
        if length == 0.0:
            raise NotFoundError(BLOCKED, state, load)
        is_last = (exact or k == 0) and length == 1.0 and _is_small(equations, state, dx, tolerance)
        error = equations.distances(dx)
        # Coordinates cannot change by less.
        is_rounding = length == 1.0 and bool(np.all(error <= EPSILON * equations.span))
        if closing and not is_last:
            noise = equations.noise(state, load)
            is_last, error = bool(np.all(error <= noise)), noise
        state = equations.moved(state, length * dx, length * dlam, load)
        equations.stats.iterations += 1
        if not np.isfinite(state.r).all():
            raise NotFoundError("a correction left the range of numbers", state, load)
        if is_last and (is_rounding or is_balanced(state)):
            return StaticResult(state, equations.negative_pivots(negative), float(error.max()))
        sizes.append(size)
        if len(sizes) > MIN_FACTORS and size > 0.9 * min(sizes[: -MIN_FACTORS // 2]):
            raise NotFoundError("corrections do not become smaller", state, load)
        if length == 1.0 and (len(sizes) == 1 or size < MAX_CONTRACTION * sizes[-2]):
            state = _broyden_corrections(equations, state, dx, load, is_balanced)
        closing = is_rounding or is_balanced(state)
    raise NotFoundError(f"no convergence with {MAX_FACTORS} factors", state, load)


def check_passage(
    equations: EquilibriumEquations, q: Vector, state: StaticState, load: float
) -> None:
    """Raise if bodies pass through each other in a straight motion from coordinates to a state.

    Raises
    ------
    NotFoundError
        With that state.
    """
    if not equations.system.admits(q, state.q):
        raise NotFoundError(BLOCKED, state, load)


def _step_length(equations: EquilibriumEquations, state: StaticState, dx: Vector) -> float:
    """Return the largest step length up to 1 without large rotations and passages of bodies.

    It is 0 if bodies would pass through each other with any length.
    """
    dq = np.append(dx, np.zeros(equations.system.n_all - len(dx)))
    length = MAX_ROTATION / max(MAX_ROTATION, _largest_rotation(equations, dx))
    return limit_length(equations.system.contributions, state.q, dq, length)


def _largest_rotation(equations: EquilibriumEquations, dx: Vector) -> float:
    """Return the largest change of a slope, or of the direction of a string [rad]."""
    turn = float(np.max(np.abs(dx[equations.slopes]), initial=0.0))
    if equations.strings is None:
        return turn
    ends, lengths = equations.strings
    moved = np.append(dx, np.zeros(equations.system.n_all - len(dx)))[ends]
    return max(turn, float(np.max(np.abs(moved[:, 1] - moved[:, 0]) / lengths[:, None])))


def _is_small(
    equations: EquilibriumEquations, state: StaticState, dx: Vector, tolerance: float
) -> bool:
    """Return whether the square of a correction over the displacement is below the tolerance."""
    system = equations.system
    moved = equations.distances(state.q[: system.n_free] - system.q_ref[: system.n_free])
    rounding = 64.0 * EPSILON * equations.span
    return bool(np.all(equations.distances(dx) <= tolerance ** (2.0 / 3.0) * moved + rounding))


def _broyden_corrections(
    equations: EquilibriumEquations,
    state: StaticState,
    dx: Vector,
    load: float,
    is_balanced: Callable[[StaticState], bool],
) -> StaticState:
    """Correct by the last factor with Broyden's updates while that converges well."""
    steps, last = [dx], equations.distance(dx)
    for _ in range(MAX_BROYDEN_STEPS):
        if is_balanced(state):
            break
        s, dlam = equations.correction(state)
        for one, following in itertools.pairwise(steps):
            s = s + (equations.mass * one) @ s / ((equations.mass * one) @ one) * following
        latest = equations.mass * steps[-1]
        factor = 1.0 - latest @ s / (latest @ steps[-1])
        if factor == 0.0:  # the residual did not change, and the update is singular
            break
        s = s / factor
        size = equations.distance(s)
        if not size <= MAX_CONTRACTION * last:
            break
        new = equations.moved(state, s, dlam, load)
        if not equations.system.admits(state.q, new.q):
            break
        equations.stats.iterations += 1
        if not equations.force_norm(new.r) <= MAX_FORCE_CONTRACTION * equations.force_norm(state.r):
            break
        state, last = new, size
        steps.append(s)
    return state


def relax(
    equations: EquilibriumEquations,
    state: StaticState,
    load: float,
    tolerance: float,
    *,
    farthest: float = math.inf,
    patient: bool = False,
) -> StaticResult:
    """Relax a scene to a state of rest, and find the equilibrium there.

    Implicit steps of ``M dq/dt = -r`` without inertia, each by one correction with the mass over
    the step on the diagonal, as much as makes the stiffness definite.

    Parameters
    ----------
    equations, state, load, tolerance
        As in `solve_newton`.
    farthest : float, optional
        Approximate bound of the displacement in a step if rigid motions are free [m].
    patient : bool, optional
        Whether to take more steps in scenes with contact.

    Raises
    ------
    NotFoundError
        If it does not come to rest or, with free rigid motions, reaches an unstable equilibrium.
    """
    tangent = ExtrapolatedTangent(equations)
    moves = math.isfinite(farthest)
    touches = patient and any(term.is_contact for term in equations.system.contributions)
    factors = equations.stats.factorizations + (
        MAX_FREE_FACTORS if moves else MAX_CONTACT_FACTORS if touches else MAX_RELAXATION_FACTORS
    )
    shift = equations.acceleration_scale(state) / farthest
    neutral = NEUTRAL_SHIFT_RATIO * shift
    before: Vector | None = None
    while equations.stats.factorizations < factors:
        values = tangent.extrapolated(state, load)
        norm = equations.distance(state.r / equations.mass)  # an acceleration [m/s2]
        while True:
            definite = equations.factor(state, values, load, shift) == 0
            dx, dlam = equations.correction(state) if definite else (state.r, state.phi)
            length = _step_length(equations, state, dx)
            if moves and not definite and equations.is_balanced(state, load, tolerance):
                raise NotFoundError(UNSTABLE, state, load)
            if definite and length > 0.25 and equations.distance(dx) <= 2.0 * farthest:
                break
            shift = 4.0 * shift if shift > 0.0 else 1e-3 * norm / equations.span
            if equations.stats.factorizations >= factors or not math.isfinite(shift):
                raise NotFoundError("the scene does not come to rest", state, load)
        state = equations.moved(state, length * dx, length * dlam, load)
        equations.system.assembly.accept(state.q)
        equations.stats.iterations += 1
        rotation = _largest_rotation(equations, dx)
        if (
            rotation <= NEWTON_ROTATION
            and shift * equations.distance(dx) <= NEWTON_SHIFT_RATIO * norm
        ):
            try:
                return solve_newton(equations, state, load, tolerance, definite=True, shift=neutral)
            except NotFoundError:
                pass
        # Steps that reverse are too long for the curvature of constraints.
        reverses = before is not None and (equations.mass * dx) @ before < 0.0
        shift *= 4.0 if reverses else 0.5 if rotation > 0.2 * MAX_ROTATION else 0.25
        before = dx if moves else None
    raise NotFoundError("the scene does not come to rest", state, load)
