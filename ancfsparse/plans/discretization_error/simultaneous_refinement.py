"""The shortest way to the errors of mesh and steps: both are refined together.

Two pilots differ by the error of the first, but for a quarter.  Where that is about what was asked
for, the second is exact enough, and nothing else need be known.  Otherwise one more, of the mesh of
the first with the steps of the second, divides their distance into what is of the mesh and what is
of the steps; the choice that follows is run, and `confirmed` by its distance from the second.

The first pilot has no numerical damping: what long damped steps take away is part of the distance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.plans.discretization_error.mesh_error import (
    GROWTH,
    SOLVER_NOISE,
    MeshError,
    elements_of,
)
from ancfsparse.plans.discretization_error.richardson import LEAST_ORDER, Estimate, estimate
from ancfsparse.plans.discretization_error.time_error import (
    MOST_HALVINGS,
    TimeError,
    step_estimates,
    undamped_is_alike,
)
from ancfsparse.plans.discretization_error.turning_points import swings
from ancfsparse.plans.models.model import Model, spread
from ancfsparse.plans.trial_runs.trial_runs import (
    FREE,
    SHARE,
    Pilot,
    Pilots,
    distances,
    farthest,
    tolerances,
)

# By how much steps grow from one pilot to the next; meshes grow by as much where elements are of
# low order.
SHORTER = 2
LOW_ORDER = 2
# Two runs show no order: errors are taken to fall with this share of it, or with that which three
# show, if it is at least the next; they may make up the last share of what was asked for.
UNSEEN, LEAST, ENOUGH = 0.75, 0.4, 0.75
# Where errors are at most so many times that, both are refined once more, which takes no more than
# to divide them.
FEW = 2.0
# Errors are continued to so many times the steps of pilots that have shown no order, or that of the
# method; this share of what pilots may cost in any case shows it.
REACH_UNSEEN, REACH, WORTH = 1.5, 16.0, 0.5
# Vibrations by this share of the error asked for matter, and may be delayed by so much [rad].
SEEN, ASTRAY = 0.5, 1.0
# Motions that differ by less than this share of the quantity approach each other with the orders of
# the method; before that, both are refined so many times if that makes distances this share or
# less.
CLOSE, MOST, FALLING = 0.1, 5, 0.5
# Runs without numerical damping that may fail.
TRIED = 2


@dataclass(frozen=True)
class Ladder:
    """What pilots refined together have shown.

    Attributes
    ----------
    time : TimeError
        Of the steps.
    mesh : MeshError
        Of the open meshes.
    pair : tuple of float, or None
        The error of the last run, of mesh and steps together, for every quantity [its unit], where
        it is small enough; then `time` and `mesh` have half of it each.
    runs : tuple of Pilot
        All runs.
    """

    time: TimeError
    mesh: MeshError
    pair: tuple[float, ...] | None
    runs: tuple[Pilot, ...]


def ladder(pilots: Pilots, model: Model, order: int, order_of_steps: int) -> Ladder | None:
    """Refine mesh and steps together until the errors of both are known, or small enough.

    Parameters
    ----------
    pilots : Pilots
        Runs of a motion by an integrator.
    model : Model
        Its elements.
    order, order_of_steps : int
        Orders of positions in the length of the elements, and of the integrator.

    Returns
    -------
    Ladder or None
        None where a run fails, or motions do not approach each other: then each is to be refined
        for itself.
    """
    growth = GROWTH if order > LOW_ORDER else float(SHORTER)
    runs: list[Pilot] = []
    before: list[float] = []
    last = [0.0] * len(pilots.wanted)
    for own, finest, steps in _rungs(pilots, growth, runs):
        finer = _on(pilots, model, finest)
        if _count(pilots, finer) != sum(finer.counts.values()):
            return None  # places on beams set the mesh, whose error falls by leaps
        run = own.run(finer, steps)
        if run is None:
            runs.clear()
            continue
        runs.append(run)
        if len(runs) < 2:
            continue
        one, other = runs[-2:]
        far = farthest(pilots.wanted, one, other)
        apart = distances(pilots.wanted, one, other)
        if _is_close(pilots, other, far) and is_followed(pilots, other):
            ratios = _slowest(pilots, order, order_of_steps, growth)
            errors = [_left(a, b, r) for a, b, r in zip(apart, last, ratios, strict=True)]
            asked = tolerances(pilots.wanted, other)
            worst = max(e / (ENOUGH * most) for e, most in zip(errors, asked, strict=True))
            found = None
            if worst <= 1.0:
                found = _pair(pilots, runs, errors, order, order_of_steps)
            elif worst > FEW:
                found = _divided(pilots, runs, order, order_of_steps)
            if found is not None:
                time = found.time
                is_alike = runs[0].integrator != pilots.integrator or undamped_is_alike(
                    pilots, time.runs[-1].model, time.runs, time.estimates)  # fmt: skip
                return found if is_alike else None
            if worst > FEW:
                return None
        if before and any(b > FALLING * a for a, b in zip(before, far, strict=True)):
            return None
        before, last = far, apart
    return None


def _rungs(
    pilots: Pilots, growth: float, runs: Sequence[Pilot]
) -> Iterator[tuple[Pilots, float, int]]:
    """Give by which integrator, with how many elements and in how many steps pilots are run.

    Where two without numerical damping have failed, they begin again with it, and with steps that
    are halved until one does not fail.
    """
    first, steps = pilots.first
    undamped = _undamped(pilots)
    finest, failures = first, 0
    if undamped is not pilots:
        for _ in range(TRIED):
            yield undamped, finest, steps
            finest, steps = growth * finest, SHORTER * steps
            if runs:
                break
        else:
            finest, steps = first, steps // SHORTER
    done = len(runs)
    while done < MOST and failures < MOST_HALVINGS:
        yield pilots, finest, steps
        steps *= SHORTER
        if runs:
            done, finest = done + 1, growth * finest
        else:
            failures += 1


def _slowest(pilots: Pilots, order: int, order_of_steps: int, growth: float) -> list[float]:
    """Return by how many times the error falls from one run to the next, the lesser of both."""
    return [min(growth**own, float(SHORTER**order_of_steps)) for own in _orders(pilots, order)]


def _left(apart: float, before: float, ratio: float) -> float:
    """Return the error of the last run by its distance from the one before.

    Errors fall by `ratio`, to a lower power if the distances of three runs show one; two show none.
    """
    power = UNSEEN
    if before > 0.0 and apart > 0.0:
        power = min(1.0, max(LEAST, math.log(before / apart) / math.log(ratio)))
    return apart / float(ratio**power - 1.0)


def beside(
    pilots: Pilots, model: Model, order: int, time: TimeError, judge: Pilot
) -> Ladder | None:
    """Find the error of the mesh of other elements, whose steps err as those of known ones do.

    Parameters
    ----------
    pilots, model, order
        As in `ladder`.
    time : TimeError
        Of the steps, with other elements.
    judge : Pilot
        The run of other elements on the finest mesh.

    Returns
    -------
    Ladder or None
        None where a run fails, or the two meshes are one.
    """
    finest, steps = float(max(judge.model.counts.values())), judge.steps
    growth = GROWTH if order > LOW_ORDER else float(SHORTER)
    if any(rung.element == "string" for rung in model.rungs.values()):
        finest /= growth  # to take less work than the others
    coarse, fine = (_on(pilots, model, each) for each in (finest, growth * finest))
    if any(_count(pilots, each) != sum(each.counts.values()) for each in (coarse, fine)):
        return None
    one, other = pilots.run(coarse, steps), pilots.run(fine, steps)
    if one is None or other is None:
        return None
    far = farthest(pilots.wanted, one, other)
    if not (_is_close(pilots, other, far) and is_followed(pilots, other)):
        return None
    of_mesh = _of_mesh(pilots, one, other, order)
    asked = tolerances(pilots.wanted, other)
    errors = [m.careful + t.at(steps) for m, t in zip(of_mesh, time.estimates, strict=True)]
    is_enough = all(e <= ENOUGH * most for e, most in zip(errors, asked, strict=True))
    mesh = MeshError(of_mesh, (one, other))
    return Ladder(time, mesh, tuple(errors) if is_enough else None, (one, other))


def _of_mesh(pilots: Pilots, one: Pilot, other: Pilot, order: int) -> tuple[Estimate, ...]:
    """Estimate the error of the mesh of the second of two runs with the same steps."""
    counts = [elements_of(one), elements_of(other)]
    each = zip(distances(pilots.wanted, one, other), _orders(pilots, order), pilots.wanted,
               other.histories, strict=True)  # fmt: skip
    return tuple(
        estimate(counts, [far], own, SOLVER_NOISE * wanted.quantity.size(history))
        for far, own, wanted, history in each
    )


def _count(pilots: Pilots, model: Model) -> int:
    """Return the number of elements of the beams whose mesh is open; places on them are nodes."""
    scene = pilots.built(model)
    return sum(scene.body(name).n_elements for name in model.counts)


def _on(pilots: Pilots, model: Model, finest: float) -> Model:
    return model.with_counts(spread(pilots.scene, finest))


def _undamped(pilots: Pilots) -> Pilots:
    """Return runs by the same integrator without numerical damping, if it can have none."""
    own = pilots.integrator
    if not isinstance(own, GeneralizedAlpha) or own.rho_inf >= 1.0:
        return pilots
    return pilots.with_integrator(GeneralizedAlpha(1.0))


def _orders(pilots: Pilots, order: int) -> list[int]:
    """Return the order of every quantity in the length of the elements."""
    return [each.quantity.order(order) for each in pilots.wanted]


def _is_close(pilots: Pilots, other: Pilot, far: Sequence[float]) -> bool:
    sizes = [w.quantity.size(h) for w, h in zip(pilots.wanted, other.histories, strict=True)]
    return all(each <= CLOSE * size for each, size in zip(far, sizes, strict=True))


def is_followed(pilots: Pilots, run: Pilot) -> bool:
    """Whether steps are short enough to follow the vibrations that a quantity shows.

    A method of order 2 delays a vibration by a twelfth of the square of its phase in a step, in
    each step.  Those that turn so often that this comes to `ASTRAY` in all are unlike the true
    ones, and two runs with them may be alike by chance.
    """
    asked = tolerances(pilots.wanted, run)
    for history, most in zip(run.histories, asked, strict=True):
        for values in history.T:
            phase = np.pi * len(swings(values, SEEN * most)[0])
            if phase**3 > 12.0 * ASTRAY * run.steps**2:
                return False
    return True


def _pair(
    pilots: Pilots, runs: Sequence[Pilot], errors: Sequence[float], order: int, order_of_steps: int
) -> Ladder:
    """Return two runs of which the second is exact enough: what is of mesh and steps is open."""
    one, other = runs[-2:]
    of_steps, of_mesh = [], []
    for error, own in zip(errors, _orders(pilots, order), strict=True):
        ratio = elements_of(other) / elements_of(one)
        half = 0.5 * error
        of_steps.append(Estimate(other.steps, half, order_of_steps, False, SHORTER, seen=False))
        of_mesh.append(Estimate(elements_of(other), half, own, False, ratio, seen=False))
    pair = (one, other)
    return Ladder(
        TimeError(tuple(of_steps), pair), MeshError(tuple(of_mesh), pair),
        tuple(errors), tuple(runs),
    )  # fmt: skip


def _divided(pilots: Pilots, runs: list[Pilot], order: int, order_of_steps: int) -> Ladder | None:
    """Return the errors of mesh and steps, by a run between the last two.

    Errors that have to fall far are not continued by an order that has not shown: then steps on the
    coarse mesh are halved until it has.
    """
    one, other = runs[-2:]
    asked = tolerances(pilots.wanted, other)
    halved = [one]
    for k in range(MOST):
        run = pilots.run(one.model, other.steps << k)
        if run is None:
            return None
        halved.append(run)
        of_steps = step_estimates(pilots, halved, order_of_steps)
        if any(each.seen and each.order <= LEAST_ORDER for each in of_steps):
            return None  # shorter steps do not approach a motion
        needed = [each.needed(0.5 * most) for each, most in zip(of_steps, asked, strict=True)]
        far = [n / run.steps / _reach(e) for n, e in zip(needed, of_steps, strict=True)]
        if max(far) <= 1.0:
            break
        planned = run.cost.amount * max(needed) / run.steps
        is_dear = pilots.spent > WORTH * FREE and run.cost.amount > SHARE * planned
        if is_dear and all(each.seen for each in of_steps):
            break
    mesh = MeshError(_of_mesh(pilots, halved[1], other, order), (halved[1], other))
    return Ladder(TimeError(of_steps, tuple(halved)), mesh, None, (*runs, *halved[1:]))


def _reach(known: Estimate) -> float:
    """Return by how many times as many steps an error may be continued."""
    if not known.seen:
        return REACH_UNSEEN
    return REACH if known.settled else 1.0
