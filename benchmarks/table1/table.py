"""Run of table 1 of the paper: the flexible pendulum by every method, timed and checked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field, replace
from multiprocessing import get_context
from typing import Annotated, Any

import typer

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice, check_count, check_positive
from ancfsparse.problems import Problem
from ancfsparse.results import Trajectory
from ancfsparse.system_memory import count_processors
from benchmarks.common import paper
from benchmarks.common.progress import bar as progress_bar
from benchmarks.other_codes.environment import environment
from benchmarks.table1.cells import COLUMNS, ROWS, Bench, Cell, reference, simulate_paper

MAX_DIVISOR = 64  # of the step, to reach the tip error of another method


@dataclass(frozen=True)
class Match:
    """Davidon with a step that makes its tip error no larger than that of an ode column."""

    # the cell it is compared with
    row: str
    column: str
    # step [s], median time [s], tip error [m]; NaN if none down to dt / 64 was enough
    dt: float = math.nan
    seconds: float = math.nan
    tip_error: float = math.nan
    ratio: float = math.nan  # time of the ode column over that of Davidon

    @property
    def found(self) -> bool:
        """True if a step was small enough."""
        return not math.isnan(self.dt)


@dataclass(frozen=True)
class Results:
    """Cells of the table, references, and a motion to draw."""

    t: Vector = field(repr=False)  # (k,), output times [s]
    cells: dict[tuple[str, str], Cell]  # cells by row and column
    # tip on the same mesh, converged in time, by row [m]
    references: dict[str, Vector] = field(repr=False)
    # by row and column of the finished ode cells: Davidon at equal or better tip error
    matches: dict[tuple[str, str], Match]
    motion: Trajectory = field(repr=False)  # A run to draw
    problem: Problem = field(repr=False)  # its scene and rod
    settings: dict[str, Any]  # of the study and the machine

    @property
    def rows(self) -> list[str]:
        """Names of the rows, in order."""
        return list(self.references)


def table1(
    rows: Sequence[str] = tuple(ROWS),
    t_end: Annotated[float, typer.Option("--time", help="Simulated time [s].")] = paper.T_END,
    dt: Annotated[float, typer.Option("--step", help="Time step [s].")] = paper.DT,
    cap: Annotated[float, typer.Option(help="Time limit of a method of SciPy [s].")] = 15.0,
    runs: int = 5,
    progress: bool = False,
) -> Results:
    """Reproduce table 1 and figures 1 and 2 of the paper next to the paper's own numbers."""
    for row in rows:
        check_choice("row", row, ROWS)
    check_positive("cap", cap, "s")
    check_count("runs", runs)
    problem = ROWS["Thin" if "Thin" in rows else rows[0]].problem()
    motion = simulate_paper(problem, "Davidon", t_end, dt)
    cells: dict[tuple[str, str], Cell] = {}
    matches: dict[tuple[str, str], Match] = {}
    references = _references(rows, t_end, dt, progress)
    with progress_bar(len(rows) * (len(COLUMNS) + 1), "cell", progress) as bar:

        def at(time: float) -> None:
            bar.set_postfix_str(f"t = {time:.2f} s of {t_end:g} s", refresh=False)

        def begin(what: str) -> None:
            bar.set_postfix_str("", refresh=False)
            bar.set_description(what)

        for row in rows:
            bench = Bench(row, t_end, dt, references[row], cap, runs, at)
            for column in COLUMNS:
                begin(f"{row}, {column}")
                cells[row, column] = bench.run(column)
                bar.update()
            begin(f"{row}, Davidon at equal errors")
            davidon = cells[row, "Davidon"]
            finished = [cells[row, c] for c in paper.ODE_FUNCTIONS if cells[row, c].finished]
            if davidon.finished:
                matches |= {(row, m.column): m for m in _match(bench, davidon, finished)}
            bar.update()
    settings = {
        "t_end_s": t_end,
        "dt_s": dt,
        "elements": paper.ELEMENTS,
        "tolerance": "paper",
        "alpha": 0.0,
        "ode_rtol": paper.RTOL,
        "ode_atol": paper.ATOL,
        "ode_cap_s": cap,
        **environment(),
    }
    return Results(bench.t, cells, references, matches, motion, problem, settings)


def _references(rows: Sequence[str], t_end: float, dt: float, progress: bool) -> dict[str, Vector]:
    """Return the references of rows, on all processors, before anything is timed."""
    jobs = min(count_processors(), len(rows))
    with (
        ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool,
        progress_bar(len(rows), "reference", progress) as bar,
    ):
        # Those of thick beams take longest, and are the last rows.
        running = {row: pool.submit(reference, row, t_end, dt) for row in reversed(rows)}
        for _ in as_completed(running.values()):
            bar.update()
    return {row: running[row].result() for row in rows}


def _match(bench: Bench, davidon: Cell, finished: Sequence[Cell]) -> list[Match]:
    """Divide Davidon's step until it is as good as each finished ode cell."""
    runs = {1: davidon}
    matches = []
    for cell in finished:
        # The rule is of second order, so the step to try first is known.
        parts = max(1, math.ceil(math.sqrt(davidon.tip_error / cell.tip_error)))
        found = Match(cell.row, cell.column)
        while not found.found and parts <= MAX_DIVISOR:
            if parts not in runs:
                runs[parts] = bench.run("Davidon", parts)
            ours, dt = runs[parts], bench.dt / parts
            if ours.tip_error <= cell.tip_error:
                ratio = cell.seconds / ours.seconds
                found = replace(
                    found, dt=dt, seconds=ours.seconds, tip_error=ours.tip_error, ratio=ratio
                )
            parts += 1
        matches.append(found)
    return matches
