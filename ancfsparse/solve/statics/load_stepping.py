"""The path to an equilibrium: load steps, and descent of the potential energy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import EquilibriumError
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState
from ancfsparse.solve.statics.newton_and_relaxation import NotFoundError, StaticResult, find, settle

Vector = NDArray[np.float64]

# Unbalanced share of the loads that is allowed in intermediate load steps.
ON_THE_WAY = 1e-3
# Number of load steps where the full load fails or ends in an unstable equilibrium, and how far
# they may be shortened.
CAREFUL, SHORTEST, SHORTEST_STABLE = 10, 1.0 / 4096.0, 1.0 / 640.0
# Factors of an easy load step, after which a shortened one is doubled.
EASY = 6
FEWER = (
    "Take fewer elements: their forces round by as much as the loads, because elements that are "
    "short compared with the scene are stiff."
)


def find_equilibrium(
    balance: EquilibriumEquations, load_steps: int, tolerance: float
) -> StaticResult:
    """Find an equilibrium by large load steps, then by descent, then by short load steps.

    An unstable equilibrium found by large steps is returned if there is no other.

    Parameters
    ----------
    balance : Balance
        The equations of the equilibrium, and their seed.
    load_steps : int
        Number of large steps.
    tolerance : float
        Unbalanced share of the loads that is allowed [-].

    Raises
    ------
    EquilibriumError
        With the largest unbalanced force.
    """
    start, stats = balance.start, balance.stats
    kept: StaticResult | None = None
    try:
        kept = _follow(balance, start, load_steps, tolerance)
        if kept.negative == 0 or not balance.conservative:
            return kept
    except NotFoundError as lost:
        if balance.lost_in_rounding():
            raise _failure(balance, lost, lost.reason, FEWER) from None
        if balance.conservative:
            try:
                return _settled(balance, balance.state(start.q, start.lam, 1.0), tolerance)
            except NotFoundError:
                pass
    taken, load_steps = stats.steps, max(CAREFUL, load_steps)
    last, reached = NotFoundError("", start, 1.0), 0.0
    for forces_first in (False, True)[: 1 + balance.driven]:
        stats.steps, balance.forces_first = 0, forces_first
        try:
            return _follow(balance, start, load_steps, tolerance, patient=True)
        except NotFoundError as failed:
            state, reached = failed.state, failed.reached
        try:
            return _settled(balance, balance.state(state.q, state.lam, 1.0), tolerance)
        except NotFoundError as failed:
            last = failed
    if kept is None:
        reason = f"{last.reason}; load steps reached {100 * reached:.3g} %"
        raise _failure(balance, last, reason)
    stats.steps = taken
    return kept


def find_from(
    balance: EquilibriumEquations, q: Vector, load_steps: int, tolerance: float
) -> StaticResult:
    """Find the equilibrium under the full load next to given coordinates, stable if possible.

    Where there is none, the load grows from the reference shape as in `find_equilibrium`.

    Parameters
    ----------
    balance : Balance
        The equations of the equilibrium, and their seed.
    q : (n_all,) float
        Where to begin.
    load_steps : int
        Number of large steps from the reference shape.
    tolerance : float
        Unbalanced share of the loads that is allowed [-].

    Raises
    ------
    EquilibriumError
        With the largest unbalanced force.
    """
    state = balance.state(q, balance.start.lam, 1.0)
    try:
        found = find(balance, state, 1.0, tolerance)
        balance.stats.steps += 1
        if found.negative == 0 or not balance.conservative:
            return found
        return _settled(balance, state, tolerance)
    except NotFoundError:
        return find_equilibrium(balance, load_steps, tolerance)


def _settled(balance: EquilibriumEquations, state: StaticState, tolerance: float) -> StaticResult:
    """Solve under the full load, which counts as one more load step."""
    found = settle(balance, state, 1.0, tolerance)
    balance.stats.steps += 1
    return found


def _follow(
    balance: EquilibriumEquations,
    state: StaticState,
    load_steps: int,
    tolerance: float,
    *,
    patient: bool = False,
) -> StaticResult:
    """Apply the load in steps.

    With `patient`, a step that fails or leaves stable equilibria is halved until it is very
    short, and doubled again where it is easy.
    """
    done, step, stable = 0.0, 1.0 / load_steps, patient and balance.conservative
    found = StaticResult(state, 0, 0.0)
    while done < 1.0:
        target = min(1.0, done + step)
        if 1.0 - target < 1e-9:
            target = 1.0
        start = balance.state(found.state.q, found.state.lam, target)
        factors = balance.stats.factorizations
        definite = stable and step > SHORTEST_STABLE
        share = tolerance if target == 1.0 else max(tolerance, ON_THE_WAY)
        try:
            new = find(balance, start, target, share, extrapolate=not patient, definite=definite)
        except NotFoundError as lost:
            if patient and step > SHORTEST:
                step *= 0.5
                continue
            raise NotFoundError(lost.reason, found.state, target, done) from None
        found, done, stable = new, target, stable and new.negative == 0
        balance.stats.steps += 1
        if balance.stats.factorizations - factors <= EASY:
            step = min(2.0 * step, 1.0 / load_steps)
    return found


def _failure(
    balance: EquilibriumEquations, last: NotFoundError, reason: str, *advice: str
) -> EquilibriumError:
    """Name the largest unbalanced force of the last state."""
    system = balance.system
    r = balance.state(last.state.q, last.state.lam, last.load).r
    worst = int(np.argmax(np.abs(np.nan_to_num(r, nan=np.inf))))
    where, unit = system.describe(worst), system.unit(worst)
    return EquilibriumError(reason, last.load, abs(float(r[worst])), where, unit, *advice)
