"""Speed on the paper's pendulum: against Exudyn in interleaved runs, and against the paper."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray

from ancfsparse.dispatch import instruction_set
from ancfsparse.problems import Problem, pendulum
from benchmarks.common import paper
from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.common.target import Target
from benchmarks.common.timing import in_turn
from benchmarks.other_codes.exudyn import Setting, load
from benchmarks.other_codes.exudyn_pendulum import SETTINGS, run_exudyn
from benchmarks.table1.cells import ROWS, repeated, simulate_paper

OUTPUT_INTERVAL = 0.5  # between compared tip positions [s]
PAPER_RUNS = 5  # of each cell of the paper's table
MIN_L2T2_RATIO = 4.0  # Exudyn's time over that of L2T2
MIN_L2T2_RATIO_V4 = 8.0  # the same on x86_64_v4
MIN_BIOT_RATIO = 5.0  # Exudyn's time over that of its own discretisation
MAX_ITERATIONS = 2.6  # per step
MIN_PAPER_RATIO = 50.0  # the paper's time over that of a cell

OURS: dict[str, dict[str, Any]] = {
    "L2T2, Davidon": {"element": "l2t2"},
    "Thin biot, Davidon": {"element": "thin", "strain": "biot"},
}
"""Runs of this package; the second has Exudyn's discretisation."""


@dataclass(frozen=True)
class Candidate:
    """One program and setting on the planar pendulum."""

    name: str
    seconds: list[float]  # wall time of each repeat [s]
    iterations_per_step: float  # corrections per time step
    tip: NDArray[np.float64]  # (k, 2), tip every half second [m]

    @property
    def median(self) -> float:
        """Median time [s]."""
        return statistics.median(self.seconds)


@dataclass(frozen=True)
class PendulumSpeed:
    """Times of all candidates, and speed-ups over the paper."""

    candidates: list[Candidate]  # this package first
    speed_ups: dict[tuple[str, str], float]  # the paper's seconds over ours, by row and column
    tip_difference: float  # largest distance of tips with the same discretisation [m]
    settings: dict[str, Any]  # of the study and the machine

    @property
    def fastest_other(self) -> Candidate:
        """The fastest candidate of Exudyn."""
        return min((c for c in self.candidates if c.name not in OURS), key=lambda c: c.median)


def pendulum_speed(
    repeats: Annotated[int, typer.Option(min=1, help="Interleaved runs of each candidate.")] = 9,
    t_end: float = paper.T_END,
    progress: bool = False,
) -> PendulumSpeed:
    """Time the paper's pendulum against Exudyn, in turn, and against the paper's own times.

    Times are those of the solvers alone: the compiled time loop, Exudyn's ``SolveDynamic``.
    """
    exudyn = load()
    problems = {
        name: pendulum(n_elements=paper.ELEMENTS, dim=2, **how) for name, how in OURS.items()
    }
    total = repeats * (len(OURS) + len(SETTINGS)) + len(paper.SECONDS) * len(paper.QUASI_NEWTON)
    with progress_bar(total, "run", progress) as bar:
        candidates = _time_candidates(problems, t_end, repeats, bar)
        speed_ups = _speed_ups(t_end, bar)
    settings = {
        "t_end_s": t_end,
        "dt_s": paper.DT,
        "elements": paper.ELEMENTS,
        "repeats": repeats,
        "instruction_set": instruction_set(),
        "exudyn": exudyn.__version__,
    }
    result = PendulumSpeed(candidates, speed_ups, np.nan, settings)
    biot = next(each for each in candidates if each.name == "Thin biot, Davidon")
    difference = np.linalg.norm(biot.tip - result.fastest_other.tip, axis=1).max()
    return replace(result, tip_difference=float(difference))


def _time_candidates(
    problems: dict[str, Problem], t_end: float, repeats: int, bar: Any
) -> list[Candidate]:
    """Run all candidates in turn."""
    mesh = next(iter(problems.values()))

    def run(candidate: str | Setting) -> Candidate:
        if isinstance(candidate, Setting):
            bar.set_description(candidate.name)
            other = run_exudyn(mesh, candidate, t_end, paper.DT, OUTPUT_INTERVAL)
            return Candidate(candidate.name, [other.seconds], other.iterations_per_step, other.tip)
        bar.set_description(candidate)
        problem, every = problems[candidate], round(OUTPUT_INTERVAL / paper.DT)
        run = simulate_paper(problem, "Davidon", t_end, paper.DT, every)
        tip = run.position(problem.rod.end)[1:]
        return Candidate(candidate, [run.stats.march_seconds], run.stats.iterations_per_step, tip)

    candidates: list[str | Setting] = [*problems, *SETTINGS]
    return [
        replace(runs[0], seconds=[seconds for each in runs for seconds in each.seconds])
        for runs in in_turn(candidates, run, repeats, bar)
    ]


def _speed_ups(t_end: float, bar: Any) -> dict[tuple[str, str], float]:
    """Return the speed-up of each quasi-Newton cell over the paper's."""
    speed_ups = {}
    every = round(OUTPUT_INTERVAL / paper.DT)
    for row, others in paper.SECONDS.items():
        problem = ROWS[row].problem()
        for column in paper.QUASI_NEWTON:
            bar.set_description(f"{row}, {column}")
            once = partial(simulate_paper, problem, column, t_end, paper.DT, every)
            runs = repeated(once, PAPER_RUNS)
            seconds = statistics.median(run.stats.march_seconds for run in runs)
            speed_ups[row, column] = others[column] * (t_end / paper.T_END) / seconds
            bar.update()
    return speed_ups


def tables(result: PendulumSpeed) -> list[Table]:
    """Set the candidates, and the speed-ups over the paper."""
    fastest, settings = result.fastest_other.median, result.settings
    columns: dict[str, Callable[[Candidate], str]] = {
        "": lambda each: each.name,
        "milliseconds": lambda each: f"{1e3 * each.median:.1f}",
        "iter./step": lambda each: f"{each.iterations_per_step:.2f}",
        "Exudyn / it": lambda each: f"{fastest / each.median:.2f}",
    }
    title = (
        f"Planar pendulum, {paper.ELEMENTS} elements, dt = {paper.DT:g} s, "
        f"{settings['t_end_s']:g} s, {settings['instruction_set']}, "
        f"medians of {settings['repeats']} interleaved runs"
    )
    ratios = [
        [row, *(f"{result.speed_ups[row, column]:.0f}" for column in paper.QUASI_NEWTON)]
        for row in paper.SECONDS
    ]
    return [
        Table.of(result.candidates, columns, title=title),
        Table(["", *paper.QUASI_NEWTON], ratios, title="Times faster than the paper's table 1"),
    ]


def targets(result: PendulumSpeed) -> list[Target]:
    """Compare speed and iterations with the targets."""
    other = result.fastest_other.median
    l2t2, biot = (c for c in result.candidates if c.name in OURS)
    least = MIN_L2T2_RATIO_V4 if instruction_set() == "x86_64_v4" else MIN_L2T2_RATIO
    (row, column), slowest = min(result.speed_ups.items(), key=lambda item: item[1])
    return [
        Target("Exudyn's best / L2T2", other / l2t2.median, least),
        Target("Exudyn's best / Thin biot", other / biot.median, MIN_BIOT_RATIO),
        Target("iterations per step, L2T2", l2t2.iterations_per_step, MAX_ITERATIONS, True),
        Target("iterations per step, Thin biot", biot.iterations_per_step, MAX_ITERATIONS, True),
        Target(f"slowest cell against the paper: {row}, {column}", slowest, MIN_PAPER_RATIO),
    ]


STUDY: Study[PendulumSpeed] = Study(
    "bench-paper",
    run=pendulum_speed,
    tables=tables,
    rows=lambda result: [asdict(each) | {"median": each.median} for each in result.candidates],
    findings=lambda result: [
        "Thin biot and Exudyn, the same discretisation, differ by "
        f"{result.tip_difference:.1e} m at the tip."
    ],
    targets=targets,
    regions={"bench-paper": lambda result: f"```\n{STUDY.text(result)}\n```"},
)
