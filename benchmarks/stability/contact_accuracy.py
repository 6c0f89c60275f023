"""Runs to an accuracy with contact: errors and cost for the scenes of the stability map."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ancfsparse.errors import AccuracyError
from ancfsparse.integrators import EnergyMomentum
from ancfsparse.results import Trajectory
from ancfsparse.solve import simulate
from benchmarks.common.progress import bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.common.target import Target
from benchmarks.stability.contact_scenes import SHAPES, ContactCase, add_contact

END = 0.12  # [s]
INTERVAL = 1e-3  # of the compared states [s]
ACCURACIES = (1e-3, 1e-4)  # [m]
REFERENCE_STEPS = (1e-6, 2e-6)  # of the reference, and of the run which states its error [s]
CASES = [
    (shape, friction)
    for shape, friction in itertools.product(SHAPES, ("no friction", "bristles"))
    if (shape, friction) != ("level fall", "bristles")  # it does not slide
]


@dataclass(frozen=True)
class AccurateRun:
    """A run to an accuracy beside its reference."""

    scene: str
    friction: str
    accuracy: float  # [m]
    is_reached: bool
    estimate: float  # [m]
    error: float  # largest difference from the reference [m]
    reference_error: float  # largest difference of both references [m]
    steps: int  # of all runs
    seconds: float  # processor time [s]


def contact_accuracy(progress: bool = False) -> list[AccurateRun]:
    """Compare runs to an accuracy with contact with runs in steps of 1 us."""
    out = []
    for shape, friction in bar(CASES, "scene", progress):
        reference, other = (
            simulate(
                _case(shape, friction).scene,
                END,
                dt,
                integrator=EnergyMomentum(),
                save_every=round(INTERVAL / dt),
            )
            for dt in REFERENCE_STEPS
        )
        for accuracy in ACCURACIES:
            start = time.process_time()
            try:
                run, is_reached = _run_to_accuracy(shape, friction, accuracy), True
                estimate = run.stats.error
            except AccuracyError as error:
                run, is_reached, estimate = error.trajectory, False, error.error
            seconds = time.process_time() - start
            out.append(
                AccurateRun(
                    *(shape, friction, accuracy, is_reached, estimate),
                    _distance(run, reference),
                    _distance(other, reference),
                    run.stats.steps,
                    seconds,
                )
            )
    return out


def _case(shape: str, friction: str) -> ContactCase:
    return add_contact(shape, friction, stiffness=None)


def _run_to_accuracy(shape: str, friction: str, accuracy: float) -> Trajectory:
    return simulate(_case(shape, friction).scene, END, INTERVAL, accuracy=accuracy)


def _distance(run: Trajectory, reference: Trajectory) -> float:
    """Return the largest difference of a coordinate of a node at equal times [m]."""
    if not np.allclose(run.t, reference.t):
        return math.nan
    nodes = np.unique(reference.system.positions)
    return float(np.abs(run.q[:, nodes] - reference.q[:, nodes]).max())


def run_table(result: list[AccurateRun]) -> Table:
    """Set all runs."""
    columns: dict[str, Callable[[AccurateRun], str]] = {
        "scene": lambda run: run.scene,
        "friction": lambda run: run.friction,
        "accuracy [m]": lambda run: f"{run.accuracy:g}",
        "reached": lambda run: "yes" if run.is_reached else "no",
        "estimate [m]": lambda run: f"{run.estimate:.2g}",
        "error [m]": lambda run: f"{run.error:.2g}",
        "error of the reference [m]": lambda run: f"{run.reference_error:.1g}",
        "steps of all runs": lambda run: f"{run.steps:,}".replace(",", " "),
        "processor time [s]": lambda run: f"{run.seconds:.2g}",
    }
    return Table.of(result, columns, left=(0, 1), title=f"Runs of {END:g} s to an accuracy")


def targets(result: list[AccurateRun]) -> list[Target]:
    """Return the largest error of the runs that reach their accuracy."""
    reached = [run for run in result if run.is_reached]
    worst = max((run.error / run.accuracy for run in reached), default=math.nan)
    name = f"largest error over the accuracy of {len(reached)} of {len(result)} runs"
    return [Target(name, worst, 1.0, at_most=True)]


STUDY = Study(
    "contact-accuracy",
    run=contact_accuracy,
    tables=lambda result: [run_table(result)],
    rows=lambda result: result,
    targets=targets,
    regions={"contact-accuracy": run_table},
)
