"""Speed on the paper's pendulum: against Exudyn in the same run, and against the paper."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import instruction_set
from ancfsparse.problems import Problem, pendulum
from benchmarks.common import paper
from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.tables import Table
from benchmarks.common.target import Target
from benchmarks.common.timing import in_turn
from benchmarks.other_codes.exudyn import Setting, load
from benchmarks.other_codes.exudyn_pendulum import SETTINGS, run_exudyn
from benchmarks.table1.cells import ROWS, march, repeated

# Tips are compared this often [s].
INTERVAL = 0.5

OURS: dict[str, dict[str, Any]] = {
    "L2T2, Davidon": {"element": "l2t2"},
    "Thin biot, Davidon": {"element": "thin", "strain": "biot"},
}
"""What runs against Exudyn; the second has Exudyn's discretisation."""


@dataclass(frozen=True)
class Contestant:
    """One program and setting on the planar pendulum.

    Attributes
    ----------
    name : str
        For the table.
    seconds : list of float
        Wall time of each repeat [s].
    iterations_per_step : float
        Corrections per time step.
    tip : (k, 2) float
        Tip every half second [m].
    """

    name: str
    seconds: list[float]
    iterations_per_step: float
    tip: NDArray[np.float64]

    @property
    def median(self) -> float:
        """Median time [s]."""
        return statistics.median(self.seconds)


@dataclass(frozen=True)
class PaperBench:
    """Everything `python -m benchmarks bench-paper` measures.

    Attributes
    ----------
    contestants : list of Contestant
        Ours first.
    speed_ups : dict
        The paper's seconds over ours, by row and column of its table.
    targets : list of Target
        The target.
    tip_difference : float
        Largest distance between our tip and Exudyn's with the same discretisation [m].
    settings : dict
        What was run, and on what.
    """

    contestants: list[Contestant]
    speed_ups: dict[tuple[str, str], float]
    targets: list[Target]
    tip_difference: float
    settings: dict[str, Any]

    def __str__(self) -> str:
        """Set the tables for a terminal."""
        fastest = _fastest_peer(self.contestants).median
        columns: dict[str, Callable[[Contestant], str]] = {
            "": lambda each: each.name,
            "milliseconds": lambda each: f"{1e3 * each.median:.1f}",
            "iter./step": lambda each: f"{each.iterations_per_step:.2f}",
            "Exudyn / it": lambda each: f"{fastest / each.median:.2f}",
        }
        title = (
            f"Planar pendulum, {paper.ELEMENTS} elements, dt = {paper.DT:g} s, "
            f"{self.settings['t_end_s']:g} s, {self.settings['instruction_set']}, "
            f"medians of {self.settings['repeats']} interleaved runs"
        )
        against = [
            [row, *(f"{self.speed_ups[row, c]:.0f}" for c in paper.QUASI_NEWTON)]
            for row in paper.SECONDS
        ]
        parts = [
            Table.of(self.contestants, columns, title=title),
            "Thin biot and Exudyn, the same discretisation, differ by "
            f"{self.tip_difference:.1e} m at the tip.",
            Table(
                ["", *paper.QUASI_NEWTON], against, title="Times faster than the paper's table 1"
            ),
            "\n".join(map(str, self.targets)),
        ]
        return "\n\n".join(map(str, parts))


def bench_paper(t_end: float = paper.T_END, repeats: int = 9, progress: bool = False) -> PaperBench:
    """Time the pendulum with Exudyn beside it, run by run in turn.

    Times are those of the solvers alone: our compiled march, Exudyn's ``SolveDynamic``.
    """
    exudyn = load()
    problems = {
        name: pendulum(n_elements=paper.ELEMENTS, dim=2, **how) for name, how in OURS.items()
    }
    total = repeats * (len(OURS) + len(SETTINGS)) + len(paper.SECONDS) * len(paper.QUASI_NEWTON)
    with progress_bar(total, "run", progress) as bar:
        contestants = _race(problems, t_end, repeats, bar)
        speed_ups = _against_paper(t_end, bar)
    biot = next(each for each in contestants if each.name == "Thin biot, Davidon")
    difference = np.linalg.norm(biot.tip - _fastest_peer(contestants).tip, axis=1).max()
    settings = {
        "t_end_s": t_end,
        "dt_s": paper.DT,
        "elements": paper.ELEMENTS,
        "repeats": repeats,
        "instruction_set": instruction_set(),
        "exudyn": exudyn.__version__,
    }
    targets = _targets(contestants, speed_ups)
    return PaperBench(contestants, speed_ups, targets, float(difference), settings)


def _race(problems: dict[str, Problem], t_end: float, repeats: int, bar: Any) -> list[Contestant]:
    """Run all contestants in turn."""
    mesh = next(iter(problems.values()))

    def run(entrant: str | Setting) -> Contestant:
        if isinstance(entrant, Setting):
            bar.set_description(entrant.name)
            peer = run_exudyn(mesh, entrant, t_end, paper.DT, INTERVAL)
            return Contestant(entrant.name, [peer.seconds], peer.iterations_per_step, peer.tip)
        bar.set_description(entrant)
        run = march(problems[entrant], "Davidon", t_end, paper.DT, round(INTERVAL / paper.DT))
        tip = run.position(problems[entrant].rod.end)[1:]
        return Contestant(entrant, [run.stats.march_seconds], run.stats.iterations_per_step, tip)

    entrants: list[str | Setting] = [*problems, *SETTINGS]
    return [
        replace(runs[0], seconds=[seconds for each in runs for seconds in each.seconds])
        for runs in in_turn(entrants, run, repeats, bar)
    ]


def _against_paper(t_end: float, bar: Any) -> dict[tuple[str, str], float]:
    """Return by how much the quasi-Newton cells are faster than the paper's."""
    speed_ups = {}
    for row, theirs in paper.SECONDS.items():
        problem = ROWS[row].problem()
        for column in paper.QUASI_NEWTON:
            bar.set_description(f"{row}, {column}")
            once = partial(march, problem, column, t_end, paper.DT, round(INTERVAL / paper.DT))
            seconds = statistics.median(run.stats.march_seconds for run in repeated(once, 5))
            speed_ups[row, column] = theirs[column] * (t_end / paper.T_END) / seconds
            bar.update()
    return speed_ups


def _fastest_peer(contestants: list[Contestant]) -> Contestant:
    return min((c for c in contestants if c.name not in OURS), key=lambda c: c.median)


def _targets(
    contestants: list[Contestant], speed_ups: dict[tuple[str, str], float]
) -> list[Target]:
    peer = _fastest_peer(contestants).median
    l2t2, biot = (c for c in contestants if c.name in OURS)
    wanted = 8.0 if instruction_set() == "x86_64_v4" else 4.0
    (row, column), slowest = min(speed_ups.items(), key=lambda item: item[1])
    return [
        Target("Exudyn's best / L2T2", peer / l2t2.median, wanted),
        Target("Exudyn's best / Thin biot", peer / biot.median, 5.0),
        Target("iterations per step, L2T2", l2t2.iterations_per_step, 2.6, at_most=True),
        Target("iterations per step, Thin biot", biot.iterations_per_step, 2.6, at_most=True),
        Target(f"slowest cell against the paper: {row}, {column}", slowest, 50.0),
    ]
