"""Quantities whose histories hardly approach each other as steps are halved, by a bound.

After a jump, motions have waves of all lengths, which short steps and fine meshes alone follow.  A
peak may settle long before the history does, and both do so with a low order and no regularity.  So
mesh and steps are refined together, and four motions have to show it: what is left is bounded by
their distances, of which the last may be small by chance, and by an order of 1 at most.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import PlanError
from ancfsparse.plans.discretization_error.error_model import Found
from ancfsparse.plans.discretization_error.mesh_error import (
    COARSEST,
    GROWTH,
    MeshError,
    elements_of,
    given_error,
)
from ancfsparse.plans.discretization_error.richardson import LEAST_ORDER, Estimate
from ancfsparse.plans.discretization_error.time_error import TimeError
from ancfsparse.plans.discretization_error.turning_points import swings
from ancfsparse.plans.models.model import Model, coarsest, spread
from ancfsparse.plans.trial_runs import cost_model
from ancfsparse.plans.trial_runs.trial_runs import FREE, Pilot, Pilots, distances, tolerances
from ancfsparse.scene import Scene

Array = NDArray[np.float64]

# Steps of the first motion over those of the longest kind, and by how much they grow.
FIRST, SHORTER = 4, 2
# Order in the steps that is believed at most, that is hoped for, and motions that have to show it.
MOST_ORDER, HOPED, SHOWN = 1.0, 2, 4
# Motions at most, and their work in that of free pilots.
MOST, WORTH = 12, 40.0
# Share of the error asked for that the bound may be.
ENOUGH = 0.75
# Swings that are a vibration, and saved states from turn to turn that show how long it takes.
VIBRATES, RESOLVED = 10, 3.0


def rugged(
    pilots: Pilots,
    model: Model,
    finer: Scene | None,
    fixed_steps: int | None,
    order: int,
    failure: PlanError,
) -> Found:
    """Refine mesh and steps together until bounds of all errors are small enough.

    Parameters
    ----------
    pilots, model, finer, fixed_steps
        As in `search`.
    order : int
        Order of positions in the length of the elements.
    failure : PlanError
        Why there is no other plan.

    Raises
    ------
    PlanError
        If bounds are not small enough, or would take too much work.
    """
    if fixed_steps is not None:
        raise failure
    finest, steps = coarsest(pilots.scene, COARSEST), FIRST * pilots.base
    runs: list[Pilot] = []
    apart: list[list[float]] = []
    for _ in range(MOST):
        run = pilots.run(model.with_counts(spread(pilots.scene, finest)), steps)
        finest, steps = GROWTH * finest, SHORTER * steps
        if run is None:
            runs.clear()
            apart.clear()
            continue
        runs.append(run)
        if len(runs) > 1:
            apart.append(distances(pilots.wanted, *runs[-2:]))
        if len(runs) < SHOWN:
            continue
        asked = tolerances(pilots.wanted, run)
        orders, errors = zip(*map(bound, zip(*apart[1 - SHOWN :], strict=True)), strict=True)
        excess = [e / (ENOUGH * most) for e, most in zip(errors, asked, strict=True)]
        if max(excess) <= 1.0:
            return _found(pilots, runs, asked, orders, errors, finer, order)
        # Logarithms, since an error may be asked for that no number of runs comes near.
        further = math.log(max(excess)) / math.log(SHORTER**HOPED)
        room = math.log(WORTH * FREE / run.cost.amount)
        if further * math.log(GROWTH * SHORTER) > room:
            break
    if len(runs) < SHOWN:
        raise failure
    raise _failure(pilots, runs, asked, errors)


def bound(apart: Sequence[float]) -> tuple[float, float]:
    """Return the order that three distances of four motions show, and a bound of what is left.

    Distances that fall by chance are no proof, so that before the last counts too, as far as it
    has fallen by then; where none fall, all three do.
    """
    first, second, third = apart
    seen = math.inf if third == 0.0 else 0.0
    if first > 0.0 and third > 0.0:
        seen = math.log(first / third) / (2.0 * math.log(SHORTER))
    order = min(max(seen, LEAST_ORDER), MOST_ORDER)
    fall = SHORTER**order
    most = max(third, second / fall) if seen >= LEAST_ORDER else max(apart)
    return order, most / (fall - 1.0)


def _found(
    pilots: Pilots,
    runs: Sequence[Pilot],
    asked: Sequence[float],
    orders: Sequence[float],
    errors: Sequence[float],
    finer: Scene | None,
    order: int,
) -> Found:
    """Return the last run as the choice."""
    one, last = runs[-2:]
    is_open = bool(last.model.counts)
    of_steps, of_mesh = [], []
    for p, error in zip(orders, errors, strict=True):
        half = 0.5 * error if is_open else error
        of_steps.append(Estimate(last.steps, half, p, False, SHORTER))
        of_mesh.append(Estimate(max(1, elements_of(last)), half, p, False, GROWTH))
    given = (0.0,) * len(asked)
    if finer is not None:
        given = tuple(given_error(pilots, finer, last.model, last.steps, order))
    counts = max(last.model.counts.values(), default=1)
    return Found(
        last.model,
        TimeError(tuple(of_steps), (one, last)),
        MeshError(tuple(of_mesh), (one, last)) if is_open else None,
        given,
        tuple(asked),
        cost_model.model([run.cost for run in runs]),
        None,
        chosen=(float(counts), last.steps),
        base=pilots.base,
        pair=tuple(errors) if finer is None else None,
        order=order,
        is_bound=True,
    )


def _failure(
    pilots: Pilots, runs: Sequence[Pilot], asked: Sequence[float], errors: Sequence[float]
) -> PlanError:
    """Return what is left of the quantity that misses its error most, and where it differs most."""
    i = max(range(len(asked)), key=lambda k: errors[k] / asked[k])
    quantity = pilots.wanted[i].quantity
    one, last = (np.asarray(run.histories[i]) for run in runs[-2:])
    step = math.gcd(len(one) - 1, len(last) - 1)
    pair = (each[:: max(1, (len(each) - 1) // step)] for each in (one, last))
    apart = np.linalg.norm(quantity.difference(*pair), axis=1)
    assert pilots.t_end is not None
    t = pilots.t_end * float(apart.argmax()) / max(1, len(apart) - 1)
    left = distances(pilots.wanted, *runs[-2:])[i]
    causes = _vibration(last, runs[-1].steps, pilots.t_end, asked[i], quantity.unit)
    return PlanError(quantity.name, asked[i], left, quantity.unit, len(runs), t, causes)


def _vibration(
    history: Array, steps: int, t_end: float, asked: float, unit: str
) -> tuple[str, ...]:
    """Explain how a quantity vibrates in the last motion; nothing if it does not."""
    found = (swings(values, asked) for values in history.reshape(len(history), -1).T)
    rows, sizes = max(found, key=lambda each: len(each[0]))
    if len(rows) < VIBRATES:
        return ()
    states = float(np.median(np.diff(rows)))
    period = 2.0 * t_end * states / (len(history) - 1)
    much = (
        f"about {period:.2g} s, {period * steps / t_end:.2g} steps"
        if states >= RESOLVED
        else f"{period:.2g} s or less"
    )
    return (
        f"In the last motion it vibrates by up to {sizes.max():.3g} {unit}".rstrip()
        + f" with periods of {much}: axial_damping and bending_damping of the material take "
        "vibrations away",
    )
