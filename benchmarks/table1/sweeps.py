"""What a sweep over pendulums gains on several processors, beside a plain loop."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ancfsparse.problems.benchmarks import pendulum
from ancfsparse.scene import Beam, Scene
from ancfsparse.solve import simulate
from ancfsparse.sweeps import sweep
from ancfsparse.system_memory import count_processors
from benchmarks.common import paper
from benchmarks.common.progress import bar
from benchmarks.common.target import Target

SOFTEST, STIFFEST = 1e7, 1e9
"""Young's moduli of the pendulums, in between spaced evenly on a logarithmic scale [Pa]."""


@dataclass(frozen=True)
class SweepBench:
    """What `python -m benchmarks bench-sweep` measures.

    Attributes
    ----------
    points, workers : int
        Number of pendulums and of processes.
    loop_seconds, sweep_seconds : float
        Time on the clock, the least of some rounds in turn [s].
    loop_processor, sweep_processor : float
        Time of processors, the least of those rounds; of the sweep with its workers [s].
    own_processor : float
        What of it the process took that sweeps: its first point and the messages [s].
    equal : bool
        Whether all numbers are equal bit for bit.
    """

    points: int
    workers: int
    loop_seconds: float
    sweep_seconds: float
    loop_processor: float
    sweep_processor: float
    own_processor: float
    equal: bool

    @property
    def targets(self) -> list[Target]:
        """The gain on two processors, and the overhead of calls."""
        overhead = self.sweep_processor / self.loop_processor - 1.0
        by_processor = self.workers * self.loop_processor / self.sweep_processor
        return [
            Target("gain on the clock", self.loop_seconds / self.sweep_seconds, 0.9 * self.workers),
            Target("gain by time of processors", by_processor, 0.9 * self.workers),
            Target("overhead in time of processors", overhead, 0.05, at_most=True),
        ]

    def __str__(self) -> str:
        """Set the numbers for a terminal."""
        lines = [
            f"{self.points} pendulums of {paper.ELEMENTS} elements, {self.workers} processes; "
            f"numbers {'equal bit for bit' if self.equal else 'DIFFERENT'}",
            f"{'':<14}{'clock s':>9}{'processors s':>14}",
            f"{'plain loop':<14}{self.loop_seconds:>9.3f}{self.loop_processor:>14.3f}",
            f"{'sweep':<14}{self.sweep_seconds:>9.3f}{self.sweep_processor:>14.3f}"
            f"   ({self.own_processor:.3f} of it in the process that sweeps)",
        ]
        return "\n".join([*lines, *map(str, self.targets)])


def _build(youngs_modulus: float) -> tuple[Scene, Beam]:
    problem = pendulum("thin", paper.ELEMENTS, youngs_modulus=youngs_modulus)
    return problem.scene, problem.rod


def _tip(run: Any, rod: Beam) -> float:
    return float(run.position(rod.end)[-1, 1])


def bench_sweep(
    points: int = 200,
    workers: int | None = None,
    dt: float = paper.DT,
    rounds: int = 3,
    progress: bool = False,
) -> SweepBench:
    """Run pendulums of different stiffness one after another, and by `sweep`.

    Parameters
    ----------
    points : int, optional
        Number of pendulums.
    workers : int, optional
        Number of processes, by default one for each processor.
    dt : float, optional
        Time step of the two seconds of each [s].
    rounds : int, optional
        Rounds, of which the least times count.
    progress : bool, optional
        Whether to draw a progress bar.
    """
    count = count_processors() if workers is None else workers
    moduli = np.geomspace(SOFTEST, STIFFEST, points).tolist()
    listed = [{"youngs_modulus": each} for each in moduli]

    def loop() -> list[float]:
        return [_tip(simulate(scene, paper.T_END, dt), rod) for scene, rod in map(_build, moduli)]

    def swept() -> list[float]:
        table = sweep(_build, listed, {"tip": _tip}, paper.T_END, workers=count, dt=dt)
        return [float(each) for each in table["tip"]]

    swept()  # loads what is loaded where it is needed
    taken: dict[str, list[tuple[float, float, float]]] = {"loop": [], "sweep": []}
    equal = True
    for _ in bar(range(rounds), "sweep", progress):
        one, values = _timed(loop)
        other, found = _timed(swept)
        taken["loop"].append(one)
        taken["sweep"].append(other)
        equal = equal and values == found
    best = {name: np.min(rows, axis=0) for name, rows in taken.items()}
    return SweepBench(
        points,
        count,
        float(best["loop"][0]),
        float(best["sweep"][0]),
        float(best["loop"][1]),
        float(best["sweep"][1] + best["sweep"][2]),
        float(best["sweep"][1]),
        equal,
    )


def _timed(call: Callable[[], list[float]]) -> tuple[tuple[float, float, float], list[float]]:
    """Return the clock, the time of the process and of its children that a call takes [s]."""

    def now() -> list[float]:
        each = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        return [time.perf_counter(), *(use.ru_utime + use.ru_stime for use in each)]

    begin = now()
    found = call()
    clock, own, children = (b - a for a, b in zip(begin, now(), strict=True))
    return (clock, own, children), found
