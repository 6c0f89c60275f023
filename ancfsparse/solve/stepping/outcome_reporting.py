"""Report the outcome of a run: counts, events, errors."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import (
    ConvergenceError,
    EnergyIncreaseError,
    MessageTemplate,
    Parameter,
    StepError,
)
from ancfsparse.nonlinear import Attempt, Outcome
from ancfsparse.results import Event, RunStats, Trajectory
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import NewmarkLoop
    from ancfsparse.nonlinear.loop_protocols import NonlinearLoop
    from ancfsparse.seeds import Seed

# Names of the causes of recoveries.
CAUSE_NAMES = {outcome: outcome.name.lower().replace("_", " ") for outcome in Outcome}
CAUSE_NAMES[Outcome.WOULD_GAIN] = CAUSE_NAMES[Outcome.GAINED_ENERGY]
# Outcomes after which a step may be solved in another way.
RECOVERABLE_OUTCOMES = (
    *(Outcome.TOO_MANY, Outcome.DIVERGED, Outcome.NOT_FINITE),
    *(Outcome.WOULD_GAIN, Outcome.PASSES_THROUGH),
)
LOOP_COUNTS = (
    *("iterations", "last_corrections", "residual_evaluations", "factorizations", "indefinite"),
    *("material_seeds", "rotating_seeds", "single_seeds", "shifted_seeds"),
    *("solves", "pairs", "skipped_pairs"),
)
"""Counts of the compiled loop with the same names in `RunStats`."""
HOW_TO_CONTINUE = " max_energy_gain=inf continues regardless."


def count_costs(stats: RunStats, iteration: NonlinearLoop, *seeds: Seed) -> None:
    """Copy counts and times of the compiled loop and its seeds."""
    counts = iteration.counts
    for name in LOOP_COUNTS:
        setattr(stats, name, counts[name])
    stats.sweeps, stats.products = (
        sum(x) for x in zip(*(seed.inner for seed in seeds), strict=True)
    )
    stats.pattern_changes = sum(seed.renewals for seed in seeds)
    stats.recoveries = counts["recoveries_reseed"] + counts["recoveries_newton"]
    parts = iteration.seconds
    if parts:
        stats.seconds |= parts | {"rest": stats.march_seconds - sum(parts.values())}


def recovery_events(
    recoveries: Iterable[tuple[int, int, int, float]], now: float, dt: float
) -> list[Event]:
    """Return the recoveries of steps of a length, counted from the step before the time `now`."""
    return [
        Event(
            step, now + step * dt, Attempt(attempt).description, CAUSE_NAMES[Outcome(cause)], rate
        )
        for step, attempt, cause, rate in recoveries
    ]


class FailedStep(NamedTuple):
    """Outcome of a failed step, with the properties of the compiled loops after it.

    If the step would gain energy, the gain is the one of the refused solution.
    """

    outcome: Outcome
    energy_gain: tuple[float, float]
    largest_gain: tuple[float, float, int]
    residual: tuple[Vector, Vector]
    contraction: float
    max_iterations: int

    @classmethod
    def record(
        cls, time_loop: NewmarkLoop, iteration: NonlinearLoop, outcome: Outcome
    ) -> FailedStep:
        """Return the record of the present state of both loops."""
        is_refused = outcome == Outcome.WOULD_GAIN
        return cls(
            outcome,
            time_loop.refused_gain if is_refused else time_loop.energy_gain,
            time_loop.largest_gain,
            time_loop.unbalanced,
            iteration.contraction,
            iteration.max_iterations,
        )


def step_error(
    system: System,
    failed: FailedStep,
    steps: int,
    now: float,
    dt: float,
    max_energy_gain: float,
    path: Trajectory | None,
    advice: str,
) -> StepError:
    """Return the error of a run that has stopped at a time after a number of steps.

    A run to an accuracy has no trajectory.
    """
    outcome = failed.outcome
    if outcome == Outcome.GAINED_ENERGY:
        gain, exchanged = failed.energy_gain
        advice += HOW_TO_CONTINUE
        return EnergyIncreaseError(gain, exchanged, max_energy_gain, now, steps, dt, path, advice)
    if outcome == Outcome.HAD_GAINED:
        gain, motion, when = failed.largest_gain
        advice += HOW_TO_CONTINUE
        return EnergyIncreaseError(
            gain, motion, max_energy_gain, now, steps, dt, path, advice, when
        )
    steps, now = steps + 1, now + dt
    if outcome == Outcome.WOULD_GAIN:
        gain, exchanged = failed.energy_gain
        advice += HOW_TO_CONTINUE
        return EnergyIncreaseError(gain, exchanged, max_energy_gain, now, steps, dt, path, advice)
    # Location of the largest residual of the last iterate.
    r, phi = failed.residual
    largest = int(np.argmax(np.abs(np.nan_to_num(r[: system.n_free], nan=np.inf))))
    where, size, unit = system.describe(largest), abs(float(r[largest])), system.unit(largest)
    if len(phi) and np.max(np.abs(phi)) > size:
        largest = int(np.argmax(np.abs(phi)))
        where, size, unit = system.constraints.labels[largest], abs(float(phi[largest])), "m"
    reason = f"it {outcome.message}, "
    if outcome == Outcome.TOO_MANY:
        reason = f"it did not converge in {failed.max_iterations} iterations{{parameter}}, "
    reason += (
        "however short it is"
        if path is None
        else "also with a new seed and with damped Newton, and from a start without acceleration"
    )
    if np.isfinite(failed.contraction):
        reason += f"; the residual last changed by a factor of {failed.contraction:.3g}"
    message = MessageTemplate(reason, parameter=Parameter("max_iterations", is_optional=True))
    return ConvergenceError(message, now, steps, dt, size, where, path, advice, unit)
