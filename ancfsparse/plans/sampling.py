"""How many states of a motion are saved, where each of them is exact in time."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ancfsparse.plans.models import Model
from ancfsparse.plans.pilots import Pilot, Pilots, tolerances
from ancfsparse.plans.richardson import Estimate
from ancfsparse.plans.time_error import TimeError
from ancfsparse.plans.wanted import Wanted

Array = NDArray[np.float64]

# Intervals between the saved states of the first pilot, and how often they may be halved.
FEWEST, MOST_HALVINGS = 16, 10
# What is lost between states may be so many times the error asked for, to be continued from.
FAR = 4.0


def between(pilots: Pilots, model: Model) -> TimeError:
    """Halve the time between saved states until a straight line between them is known to do.

    Quantities that are asked for at the end alone need no other states.

    Parameters
    ----------
    pilots : Pilots
        Runs by a `Way`, each of whose states is exact in time.
    model : Model
        A coarse one.

    Raises
    ------
    StepFailure
        If a run fails.
    """
    runs: list[Pilot] = []
    for _ in range(MOST_HALVINGS + 1):
        run = pilots.run(model, FEWEST << len(runs))
        if run is None:
            assert pilots.failure is not None
            raise pilots.failure
        runs.append(run)
        estimates = [_lost(*each, run.steps) for each in zip(pilots.wanted, run.histories,
                                                             strict=True)]  # fmt: skip
        asked = tolerances(pilots.wanted, run)
        if all(each.error <= FAR * most for each, most in zip(estimates, asked, strict=True)):
            break
    return TimeError(tuple(estimates), tuple(runs))


def _lost(wanted: Wanted, history: Array, steps: int) -> Estimate:
    """Estimate how far a quantity is from a straight line between two states."""
    if wanted.quantity.at == "end":
        return Estimate(steps, 0.0, 2.0, settled=True)
    coarse, fine = (_off(wanted, history[::every]) for every in (2, 1))
    # Kinks leave order 1.
    order = min(max(math.log2(coarse / fine), 1.0), 2.0) if 0.0 < fine < coarse else 1.0
    return Estimate(steps, fine / 2.0**order, order, settled=True)


def _off(wanted: Wanted, history: Array) -> float:
    """Return how far every other state is from the straight line between its neighbours."""
    line = 0.5 * (history[:-2:2] + history[2::2])
    apart = wanted.quantity.difference(line, history[1:-1:2])
    return float(np.linalg.norm(apart, axis=1).max())
