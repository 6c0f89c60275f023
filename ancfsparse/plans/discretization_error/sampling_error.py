"""How many states of a motion are saved, where each of them is exact in time."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ancfsparse.plans.discretization_error.richardson import Estimate
from ancfsparse.plans.discretization_error.time_error import TimeError
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.quantities.tolerances import Wanted
from ancfsparse.plans.trial_runs.solution_methods import Way
from ancfsparse.plans.trial_runs.trial_runs import FREE, Pilot, Pilots, distances, tolerances

Array = NDArray[np.float64]

# How often the intervals between the saved states of the first pilot may be halved.
MOST_HALVINGS = 10
# What is lost between states may be so many times the error asked for, to be continued from.
FAR = 4.0
# Work of all these pilots, over that of free ones, at which it is not halved further.
DEAR = 2.0
# Loads, and what is between equilibria, are lines from one saved state to the next.
ORDER_OF_LOADS = 2


def between(pilots: Pilots, model: Model) -> TimeError:
    """Halve the time between saved states until what is between them is known well enough.

    It is a straight line between equilibria, a cubic between states of vibrations.  Loads may be
    taken as linear between them too, which the last two runs show.  Quantities that are asked for
    at the end alone need no other states.

    Parameters
    ----------
    pilots : Pilots
        Runs by a `Way`, each of whose states is exact in time.
    model : Model
        A coarse one.

    Raises
    ------
    StepError
        If a run fails.
    """
    way = pilots.integrator
    assert isinstance(way, Way)
    runs: list[Pilot] = []
    for _ in range(MOST_HALVINGS + 1):
        run = pilots.run(model, way.fewest << len(runs))
        if run is None:
            assert pilots.failure is not None
            raise pilots.failure
        runs.append(run)
        if way.order > ORDER_OF_LOADS and len(runs) < 2:
            continue
        by_loads = distances(pilots.wanted, *runs[-2:]) if len(runs) > 1 else [0.0] * 64
        estimates = [
            _lost(each, history, run.steps, way.order, far / (2.0**ORDER_OF_LOADS - 1.0))
            for each, history, far in zip(pilots.wanted, run.histories, by_loads, strict=False)
        ]
        asked = tolerances(pilots.wanted, run)
        enough = all(each.error <= FAR * most for each, most in zip(estimates, asked, strict=True))
        # Where an equilibrium is lost, no state is near the one before.
        if enough or pilots.spent > DEAR * FREE or run.run.stats.recoveries:
            break
    return TimeError(tuple(estimates), tuple(runs))


def _lost(wanted: Wanted, history: Array, steps: int, order: int, by_loads: float) -> Estimate:
    """Estimate how far a quantity is from what is interpolated between states."""
    fine = 0.0 if wanted.quantity.at == "end" else _off(wanted, history, order)
    coarse = _off(wanted, history[::2], order)
    # Kinks leave order 1.
    seen = min(max(math.log2(coarse / fine), 1.0), float(order)) if 0.0 < fine < coarse else 1.0
    lost = fine / 2.0**seen
    if by_loads > lost:
        return Estimate(steps, by_loads, float(ORDER_OF_LOADS), settled=True)
    return Estimate(steps, lost, seen, settled=True)


def _off(wanted: Wanted, history: Array, order: int) -> float:
    """Return how far every other state is from a line, or a cubic, between its neighbours."""
    known, left = history[::2], history[1::2]
    if order == ORDER_OF_LOADS:
        between = 0.5 * (known[:-1] + known[1:])
    else:
        inner = 9.0 * (known[1:-2] + known[2:-1])
        between, left = (inner - known[:-3] - known[3:]) / 16.0, left[1:-1]
    apart = wanted.quantity.difference(between, left)
    return float(np.linalg.norm(apart, axis=1).max())
