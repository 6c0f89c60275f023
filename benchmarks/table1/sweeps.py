"""Gain of a sweep over pendulums on several processors, relative to a plain loop."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import typer

from ancfsparse.checks import check_positive
from ancfsparse.problems.benchmarks import pendulum
from ancfsparse.scene import Beam, Scene
from ancfsparse.solve import simulate
from ancfsparse.sweeps import sweep
from ancfsparse.system_memory import count_processors
from benchmarks.common import paper
from benchmarks.common.progress import bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.common.target import Target

MIN_MODULUS = 1e7  # least Young's modulus of the pendulums [Pa]
MAX_MODULUS = 1e9  # largest, with logarithmic spacing [Pa]
MIN_EFFICIENCY = 0.9  # gain over the number of processes
MAX_OVERHEAD = 0.05  # additional time of processors, over that of the loop


@dataclass(frozen=True)
class SweepSpeed:
    """Times of a loop and of a sweep over the same pendulums, least of some rounds."""

    points: int  # pendulums
    workers: int  # processes
    # time on the clock [s]
    loop_seconds: float
    sweep_seconds: float
    # time of processors; of the sweep with its workers [s]
    loop_processor: float
    sweep_processor: float
    own_processor: float  # of the sweeping process alone: its first point and the messages [s]
    equal: bool  # True if all numbers are equal bit for bit


def targets(result: SweepSpeed) -> list[Target]:
    """Return the gain on the clock and in processor time, and the overhead of calls."""
    loop, swept = result.loop_processor, result.sweep_processor
    gain = result.loop_seconds / result.sweep_seconds
    least = MIN_EFFICIENCY * result.workers
    return [
        Target("gain on the clock", gain, least),
        Target("gain by time of processors", result.workers * loop / swept, least),
        Target("overhead in time of processors", swept / loop - 1.0, MAX_OVERHEAD, at_most=True),
    ]


def times(result: SweepSpeed) -> Table:
    """Set the times of loop and sweep."""
    rows = [
        ["plain loop", result.loop_seconds, result.loop_processor, 0.0],
        ["sweep", result.sweep_seconds, result.sweep_processor, result.own_processor],
    ]
    head = ["", "clock s", "processors s", "of it in the sweeping process s"]
    return Table(head, [[str(name), *(f"{each:.3f}" for each in row)] for name, *row in rows])


def _build(youngs_modulus: float) -> tuple[Scene, Beam]:
    problem = pendulum("thin", paper.ELEMENTS, youngs_modulus=youngs_modulus)
    return problem.scene, problem.rod


def _tip(run: Any, rod: Beam) -> float:
    return float(run.position(rod.end)[-1, 1])


def sweep_speed(
    points: Annotated[int, typer.Option(min=1, help="Number of pendulums.")] = 200,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes [default: one for each processor].")
    ] = None,
    dt: Annotated[float, typer.Option(help="Time step [s].")] = paper.DT,
    rounds: Annotated[int, typer.Option(min=1, help="Rounds, of which the least counts.")] = 3,
    progress: bool = False,
) -> SweepSpeed:
    """Time a sweep over pendulums of different stiffness relative to a plain loop."""
    check_positive("dt", dt, "s")
    count = count_processors() if workers is None else workers
    moduli = np.geomspace(MIN_MODULUS, MAX_MODULUS, points).tolist()
    listed = [{"youngs_modulus": each} for each in moduli]

    def loop() -> list[float]:
        return [_tip(simulate(scene, paper.T_END, dt), rod) for scene, rod in map(_build, moduli)]

    def swept() -> list[float]:
        table = sweep(_build, listed, {"tip": _tip}, paper.T_END, workers=count, dt=dt)
        return [float(each) for each in table["tip"]]

    swept()  # loads modules on demand
    loops, sweeps, equal = [], [], True
    for _ in bar(range(rounds), "sweep", progress):
        one, values = _timed(loop)
        other, found = _timed(swept)
        loops.append(one)
        sweeps.append(other)
        equal = equal and values == found
    (clock, own, _), (swept_clock, swept_own, children) = (
        np.min(each, axis=0).tolist() for each in (loops, sweeps)
    )
    processor = swept_own + children
    return SweepSpeed(points, count, clock, swept_clock, own, processor, swept_own, equal)


def _timed(call: Callable[[], list[float]]) -> tuple[tuple[float, float, float], list[float]]:
    """Return the time on the clock, of the process and of its children that a call takes [s]."""

    def now() -> list[float]:
        each = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        return [time.perf_counter(), *(use.ru_utime + use.ru_stime for use in each)]

    begin = now()
    found = call()
    clock, own, children = (b - a for a, b in zip(begin, now(), strict=True))
    return (clock, own, children), found


STUDY = Study(
    "sweeps",
    run=sweep_speed,
    heading=lambda result: (
        f"{result.points} pendulums of {paper.ELEMENTS} elements, {result.workers} processes; "
        f"numbers {'equal bit for bit' if result.equal else 'DIFFERENT'}"
    ),
    tables=lambda result: [times(result)],
    rows=lambda result: [result],
    targets=targets,
)
