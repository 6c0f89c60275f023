"""The error of the steps in time: the same coarse mesh with half the step, until that is enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from ancfsparse.errors import PlanError
from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.plans.discretization_error.richardson import Estimate, estimate
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.trial_runs.trial_runs import (
    FREE,
    Pilot,
    Pilots,
    distances,
    farthest,
    tolerances,
)

# Steps of one pilot at most, over those of the longest kind.
MOST_HALVINGS = 14
# An error so many times the one asked for can be extrapolated from, if its order has shown: as long
# as pilots cost next to nothing, and later, or if it has shown twice.  Shorter steps follow further
# vibrations, so the order of a motion that began with a shock falls.
NEARER, FAR = 2.0, 16.0
# By how much two orders that were observed may differ from that of the method.
FIRM = 0.15
# One of this share is small enough where two runs cannot show the order, and where another has
# shown, which `confirmed` looks at again.
SMALL, NEAR = 0.4, 1.0
# Where the differences do not halve in so many halvings, the motion is too rough for an estimate.
# Before that, steps may still be too long for the slowest vibration: this share of what pilots may
# cost in any case is spent first.
STALLED, PATIENCE = 3, 0.5
# The share of both where the next mesh may be better.
HASTE = 0.5
# Solutions that differ by less than this share of their size differ by the tolerance of the solver.
SOLVER_NOISE = 1e-7
# The undamped integrator conserves vibrations that long damped steps take away.  Motions with
# both may differ by so many times the estimated error.
ALIKE = 4.0


@dataclass(frozen=True)
class TimeError:
    """What pilot runs with several steps have shown.

    Attributes
    ----------
    estimates : tuple of Estimate
        For every quantity, by the number of steps.
    runs : tuple of Pilot
        With ascending numbers of steps, each twice that of the one before.
    """

    estimates: tuple[Estimate, ...]
    runs: tuple[Pilot, ...]


def time_error(pilots: Pilots, model: Model, order: int, hasty: bool = False) -> TimeError:
    """Halve the step until the error of every quantity can be predicted.

    Parameters
    ----------
    pilots : Pilots
        Runs.
    model : Model
        A coarse one.
    order : int
        Order of the integrator.
    hasty : bool, optional
        Whether to give up as soon as differences decrease slowly: a finer mesh may be better.

    Raises
    ------
    StepError
        If no step is short enough to finish.
    PlanError
        If the motions do not approach each other as steps are halved: the motion is chaotic, or
        the quantity is not smooth.
    """
    runs: list[Pilot] = []
    failed = pilots.failed
    for halvings in range(MOST_HALVINGS + 1):
        if pilots.base << halvings <= failed:
            continue
        run = pilots.run(model, pilots.base << halvings)
        if run is None:
            runs.clear()
            continue
        runs.append(run)
        if len(runs) < 2:
            continue
        estimates = step_estimates(pilots, runs, order)
        if _enough(pilots, runs, estimates, order) and undamped_is_alike(
            pilots, model, runs, estimates
        ):
            return TimeError(estimates, tuple(runs))
        if _stalls(pilots, runs, hasty):
            break
    if pilots.failure is not None and len(runs) < 2:
        raise pilots.failure
    asked = tolerances(pilots.wanted, runs[-1])
    apart = farthest(pilots.wanted, runs[-2], runs[-1])
    i = max(range(len(asked)), key=lambda i: apart[i] / asked[i])
    quantity = pilots.wanted[i].quantity
    raise PlanError(quantity.name, asked[i], apart[i], quantity.unit, len(runs))


def no_time_error(pilots: Pilots, model: Model) -> TimeError:
    """Return what there is of an equilibrium: one run, and no error of steps."""
    run = pilots.run(model, 1)
    assert run is not None  # what fails in statics is no step
    return TimeError((Estimate(1.0, 0.0, 2.0, settled=True),) * len(pilots.wanted), (run,))


def _stalls(pilots: Pilots, runs: Sequence[Pilot], hasty: bool) -> bool:
    """Whether halving the step several times has not brought the motions nearer.

    Steps that are too long for the slowest vibration do not, so short ones are tried first.
    """
    share = HASTE if hasty else 1.0
    if len(runs) < STALLED + 2 or pilots.spent < share * PATIENCE * FREE:
        return False
    apart = [farthest(pilots.wanted, a, b) for a, b in pairwise(runs)]
    series = zip(*apart, strict=True)
    return any(each[-1] > 0.5 * share * each[-1 - STALLED] for each in series)


def step_estimates(pilots: Pilots, runs: Sequence[Pilot], order: int) -> tuple[Estimate, ...]:
    """Estimate the error of the last of some runs of one mesh for every quantity."""
    steps = [run.steps for run in runs[-3:]]
    pairs = zip(runs[-3:], runs[-2:] if len(runs) > 2 else runs[-1:], strict=False)
    apart = [distances(pilots.wanted, one, other) for one, other in pairs]
    sizes = [each.quantity.size(h) for each, h in zip(pilots.wanted, runs[-1].histories,
                                                      strict=True)]  # fmt: skip
    return tuple(
        estimate(steps, each, order, SOLVER_NOISE * size)
        for each, size in zip(zip(*apart, strict=True), sizes, strict=True)
    )


def _enough(
    pilots: Pilots, runs: Sequence[Pilot], estimates: Sequence[Estimate], order: int
) -> bool:
    """Whether errors are known well enough, and whole histories approach each other."""
    asked = tolerances(pilots.wanted, runs[-1])
    cheap = pilots.spent < FREE
    last = farthest(pilots.wanted, runs[-2], runs[-1])
    before = farthest(pilots.wanted, runs[-3], runs[-2]) if len(runs) > 2 else None
    for i, (each, most) in enumerate(zip(estimates, asked, strict=True)):
        reach = NEAR if each.seen else SMALL
        if each.settled:
            reach = NEARER if cheap and not _is_firm(pilots, runs, i, order) else FAR
        if each.careful > reach * most:
            return False
        if before is not None and last[i] > max(most, 0.5 * before[i]):
            return False
    return True


def _is_firm(pilots: Pilots, runs: Sequence[Pilot], i: int, order: int) -> bool:
    """Whether four runs have shown the order of the method twice, for a quantity."""
    if len(runs) < 4:
        return False
    apart = [distances(pilots.wanted, a, b)[i] for a, b in pairwise(runs[-4:])]
    ratio = 2.0**order
    return all(
        (1.0 - FIRM) * ratio <= first / second <= (1.0 + FIRM) * ratio
        for first, second in pairwise(apart)
        if second > 0.0
    )


def undamped_is_alike(
    pilots: Pilots, model: Model, runs: Sequence[Pilot], estimates: Sequence[Estimate]
) -> bool:
    """Whether no vibrations that matter were lost by the damping of long steps."""
    if not isinstance(pilots.integrator, GeneralizedAlpha) or pilots.integrator.rho_inf >= 1.0:
        return True
    other = pilots.with_integrator(GeneralizedAlpha(1.0))
    run = other.run(model, runs[-1].steps)
    pilots.seconds += other.seconds
    if run is None:  # the steps are too long for it, no statement about the quantity
        return True
    asked = tolerances(pilots.wanted, runs[-1])
    apart = distances(pilots.wanted, runs[-1], run)
    return all(
        far <= max(ALIKE * each.error, most)
        for far, each, most in zip(apart, estimates, asked, strict=True)
    )
