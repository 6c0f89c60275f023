"""Equilibria of scenes that joints and loads hold together: pendulums, ropes, carriages."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.solve.linearization.rigid_body_modes import describe_free_motions
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState
from ancfsparse.solve.statics.newton_and_relaxation import NotFoundError, StaticResult, settle
from ancfsparse.system.rigid_motion.rigid_parts import parts_of

Vector = NDArray[np.float64]

# Share of the size of the scene by which steps move it at most, and by which it is moved out of an
# unstable balance.
LARGEST_MOVE, OUT_OF_BALANCE = 0.1, 1e-3
# Unbalanced share of the loads below which a scene that does not come to rest is in such a balance.
IN_BALANCE = 1e-2
# Solutions that leave of a random motion what is resisted least.
FILTERS = 4


def find_hanging(
    balance: EquilibriumEquations, q: Vector, tolerance: float, free: list[str]
) -> StaticResult:
    """Let a scene come to rest that its joints alone do not hold.

    Under no load its stiffness is singular, so the load cannot grow from zero: the scene creeps
    downhill under all of it, see `relax.settle`.

    Parameters
    ----------
    balance : Balance
        The equations.
    q : (n_all,) float
        Where to begin.
    tolerance : float
        Unbalanced share of the loads that is allowed [-].
    free : list of str
        The motions that joints leave free.

    Raises
    ------
    SingularSceneError
        If the loads do not restrain them either.
    """
    if not balance.pushes > 0.0:
        raise describe_free_motions(free, "no load restrains them")
    if not balance.conservative:
        raise describe_free_motions(free, "some loads have no potential that could restrain them")
    state = balance.state(q, balance.start.lam, 1.0)
    if _falls(balance, state):
        raise describe_free_motions(free, "loads move the scene as a whole")
    balance.stats.steps += 1
    farthest = LARGEST_MOVE * _size(balance, q)
    try:
        return settle(balance, state, 1.0, tolerance, farthest=farthest)
    except NotFoundError as lost:
        last = balance.state(lost.state.q, lost.state.lam, 1.0)
    try:
        if balance.size_of_forces(last.r) < IN_BALANCE * balance.pushes:
            return settle(balance, out_of_balance(balance, last), 1.0, tolerance, farthest=farthest)
    except NotFoundError:
        pass
    raise describe_free_motions(free, "the scene does not come to rest under its loads")


def _falls(balance: EquilibriumEquations, state: StaticState) -> bool:
    """Whether nothing opposes a force on the whole scene, along one of the axes."""
    system = balance.system
    for column in np.concatenate(system.vectors("r")).T:
        x = np.zeros(system.n_all)
        x[column] = 1.0
        held = [each.holds(state.q) for each in system.contributions]
        rows = [system.constraints.jacobian(state.q), *(each for each in held if each is not None)]
        if x[system.n_free :].any() or any((each @ x).any() for each in rows):
            continue
        force = x[: system.n_free] @ state.r
        if abs(force) > 1e-6 * np.abs(x[: system.n_free] * state.r).sum():
            return True
    return False


def _size(balance: EquilibriumEquations, q: Vector) -> float:
    """Return the size of the scene [m]."""
    places = np.concatenate([q[each] for each in balance.system.vectors("r")])
    sizes = [part.size for part in parts_of(balance.system)]
    return max(float(np.ptp(places, axis=0).max()), *sizes)


def out_of_balance(balance: EquilibriumEquations, state: StaticState) -> StaticState:
    """Return a state beside an unstable one, along the motions that its stiffness resists least.

    Parameters
    ----------
    balance : Balance
        The equations.
    state : State
        An equilibrium, or nearly one.

    Raises
    ------
    NotFoundError
        If no mass on the diagonal makes the stiffness definite.
    """
    way = OUT_OF_BALANCE * _size(balance, state.q)
    values, shift = balance.stiffness(state, 1.0), balance.acceleration / way
    while balance.factor(state, values, 1.0, shift) != 0:
        shift *= 4.0
        if not np.isfinite(shift):
            raise NotFoundError("the stiffness is singular", state, 1.0)
    x = np.random.default_rng(2).standard_normal(len(balance.mass)) / np.sqrt(balance.mass)
    for _ in range(FILTERS):
        x = balance.seed.solve(balance.mass * x)
        x *= way / balance.distance(x)
    return balance.moved(state, x, 0.0 * state.lam, 1.0)
