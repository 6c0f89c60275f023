"""Table 1 of the paper: the flexible pendulum by every method, timed and checked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field, replace
from multiprocessing import get_context
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_choice, check_count, check_positive
from ancfsparse.problems import Problem
from ancfsparse.results import Trajectory
from ancfsparse.system_memory import count_processors
from benchmarks.common import paper
from benchmarks.common.progress import bar as progress_bar
from benchmarks.other_codes.environment import environment
from benchmarks.table1.cells import COLUMNS, ROWS, Bench, Cell, march, reference

Vector = NDArray[np.float64]

# The step is divided by this at most, to reach the tip error of another method.
FINEST = 64


@dataclass(frozen=True)
class Match:
    """Davidon with a step that makes its tip error no larger than that of an ode column.

    Attributes
    ----------
    row, column : str
        The cell it is compared with.
    dt, seconds, tip_error : float
        Step [s], median time [s], tip error [m]; NaN if none down to dt / 64 was enough.
    ratio : float
        Time of the ode column over that of Davidon.
    """

    row: str
    column: str
    dt: float = math.nan
    seconds: float = math.nan
    tip_error: float = math.nan
    ratio: float = math.nan

    @property
    def found(self) -> bool:
        """Whether a step was small enough."""
        return not math.isnan(self.dt)


@dataclass(frozen=True)
class Table:
    """The table, with what figures and findings need.

    Attributes
    ----------
    t : (k,) float
        Instants at which tips are compared [s].
    cells : dict
        Cells by row and column.
    references : dict of str to (k, dim) float
        Tip on the same mesh, converged in time, by row [m].
    matches : dict
        By row and column of the finished ode cells: Davidon at equal or better tip error.
    motion : Trajectory
        A run to draw.
    problem : Problem
        Its scene and rod.
    settings : dict
        What was run, and on what.
    """

    t: Vector = field(repr=False)
    cells: dict[tuple[str, str], Cell]
    references: dict[str, Vector] = field(repr=False)
    matches: dict[tuple[str, str], Match]
    motion: Trajectory = field(repr=False)
    problem: Problem = field(repr=False)
    settings: dict[str, Any]

    @property
    def rows(self) -> list[str]:
        """Names of the rows, in order."""
        return list(self.references)


def table1(
    rows: Sequence[str] = tuple(ROWS),
    t_end: float = paper.T_END,
    dt: float = paper.DT,
    cap: float = 15.0,
    runs: int = 5,
    progress: bool = False,
) -> Table:
    """Run the table.

    Returns
    -------
    Table
        Cells, references, and Davidon's time at equal or better tip error.
    """
    for row in rows:
        check_choice("row", row, ROWS)
    check_positive("cap", cap, "s")
    check_count("runs", runs)
    problem = ROWS["Thin" if "Thin" in rows else rows[0]].problem()
    motion = march(problem, "Davidon", t_end, dt)
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
    return Table(bench.t, cells, references, matches, motion, problem, settings)


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
        while not found.found and parts <= FINEST:
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
