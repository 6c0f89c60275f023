"""Table 1 as text, CSV, JSON and Markdown."""

from __future__ import annotations

import math
from collections.abc import Callable

from benchmarks.common import paper
from benchmarks.common.study import Study
from benchmarks.common.tables import Table, bullets
from benchmarks.common.target import verdict
from benchmarks.table1.cells import COLUMNS, ROWS, Cell
from benchmarks.table1.figures import figure1, figure2
from benchmarks.table1.table import Match, Results, table1

EXPLANATION = """\
faster by: the paper's time over ours. tip error: largest distance from the same mesh converged \
in time.
iter./step: corrections with a residual of their own; Broyden, DFP, BFGS and modified Newton make \
one more
by the residual that ends a step.
Davidon as good: ratio of times to Davidon with a step of no larger tip error.\
"""


CELLS: dict[str, Callable[[tuple[Cell, Match | None]], str]] = {
    "method": lambda each: _name(each[0].column),
    "seconds": lambda each: _seconds(each[0]),
    "paper": lambda each: _number(each[0].paper_seconds, ".2f"),
    "faster by": lambda each: _number(each[0].speed_up, ".0f"),
    "iter./step": lambda each: _number(each[0].iterations_per_step, ".2f"),
    "tip error [m]": lambda each: _number(each[0].tip_error, ".1e"),
    "Davidon as good": lambda each: _as_good(each[1]),
}
"""Columns of a cell and of Davidon at its error."""


def by_element(table: Results) -> list[Table]:
    """Set one table per element, one line per method."""
    return [
        Table.of(
            [(table.cells[row, c], table.matches.get((row, c))) for c in COLUMNS],
            CELLS,
            title=f"{row} ({ROWS[row].element}, {'planar' if ROWS[row].dim == 2 else 'spatial'}, "
            f"{paper.ELEMENTS} elements)",
        )
        for row in table.rows
    ]


def _name(column: str) -> str:
    stands_for = paper.ODE_FUNCTIONS.get(column)
    return f"{column} ({stands_for})" if stands_for else column


def _as_good(match: Match | None) -> str:
    if match is None:
        return ""
    return f"{match.ratio:.1f}" if match.found else "no step tried"


def _seconds(cell: Cell) -> str:
    return f"{cell.seconds:.3g}" if cell.finished else cell.note


def _number(value: float, form: str) -> str:
    return "" if math.isnan(value) else format(value, form)


def as_markdown(table: Results) -> str:
    """Return the table for README: one line per method, our time and the paper's per element."""
    lines = []
    for column in COLUMNS:
        stands_for = paper.ODE_FUNCTIONS.get(column)
        name = f"{column}, for `{stands_for}`" if stands_for else column
        lines.append([name, *(_both(table.cells[row, column]) for row in table.rows)])
    davidon = [table.cells[row, "Davidon"] for row in table.rows]
    lines += [
        [f"*Davidon: {what}*", *(_number(getattr(cell, name), form) for cell in davidon)]
        for what, name, form in (
            ("set-up before the first step", "set_up_seconds", ".2g"),
            ("speed-up over the paper", "speed_up", ".0f"),
            ("iterations per step", "iterations_per_step", ".2f"),
            ("tip error [m]", "tip_error", ".1e"),
        )
    ]
    tabled = Table(["seconds (the paper's)", *table.rows], lines).markdown()
    settings = table.settings
    caption = (
        f"{settings['elements']} elements, dt = {settings['dt_s']:g} s, on {settings['machine']} "
        f"with kernels for {settings['instruction_set']}. Seconds are those of the time loop, "
        "without set-up; the paper timed MATLAB on a computer it does not name. SciPy "
        f"{settings['scipy']} integrates the same compiled forces, with tolerances "
        f"{settings['ode_rtol']:g} and {settings['ode_atol']:g}. Tip error: largest distance over "
        "the whole run from the same mesh converged in time."
    )
    return "\n".join([*tabled, "", caption])


def _both(cell: Cell) -> str:
    others = "" if math.isnan(cell.paper_seconds) else f" ({cell.paper_seconds:g})"
    return _seconds(cell) + others


MIN_PAPER_RATIO = 50.0  # the paper's time over that of a quasi-Newton cell
MIN_ODE_RATIO = 10.0  # time of the best ode column over that of Davidon
ODE_TARGET = f"the target of {MIN_ODE_RATIO:.0f} times at equal or better tip error"


def findings(table: Results) -> list[str]:
    """Compare the cells with the paper and with the best ode column."""
    ours = [cell for (_, column), cell in table.cells.items() if column in paper.QUASI_NEWTON]
    sentences = []
    compared = [cell for cell in ours if not math.isnan(cell.speed_up)]
    if compared:
        slowest = min(compared, key=lambda cell: cell.speed_up)
        sentences.append(
            f"The quasi-Newton cells are at least {slowest.speed_up:.0f} times faster than the "
            f"paper's ({slowest.row}, {slowest.column}): "
            f"the target of {MIN_PAPER_RATIO:.0f} times is "
            f"{verdict(slowest.speed_up >= MIN_PAPER_RATIO)}."
        )
    sentences += [
        f"{cell.row}, {cell.column}: no result, {cell.note}." for cell in ours if not cell.finished
    ]
    return sentences + [sentence for row in table.rows for sentence in _against_ode(table, row)]


def _against_ode(table: Results, row: str) -> list[str]:
    davidon = table.cells[row, "Davidon"]
    finished = [table.cells[row, c] for c in paper.ODE_FUNCTIONS if table.cells[row, c].finished]
    if not davidon.finished:
        return []
    if not finished:
        return [f"{row}: no SciPy method finished, so there is nothing to compare with."]
    best = min(finished, key=lambda cell: cell.seconds)
    ratio = best.seconds / davidon.seconds
    as_good = davidon.tip_error <= best.tip_error
    text = (
        f"{row}: Davidon at the paper's step is {ratio:.1f} times faster than the fastest SciPy "
        f"method, {best.column}, with a tip error of {davidon.tip_error:.1e} m against "
        f"{best.tip_error:.1e} m"
    )
    if as_good:
        return [f"{text}: {_on_target(ratio >= MIN_ODE_RATIO)}"]
    match = table.matches[row, best.column]
    holds = match.ratio >= MIN_ODE_RATIO
    if match.found:
        text += (
            f". At dt = {match.dt:.3g} s its error is {match.tip_error:.1e} m and it is "
            f"{match.ratio:.1f} times faster: {_on_target(holds)}"
        )
    else:
        parts = math.sqrt(davidon.tip_error / best.tip_error)
        text += (
            f". An error that falls with the square of the step would take {parts:.0f} times the "
            f"steps: {_on_target(False)}"
        )
    return [text if holds else f"{text} {_why(best)}"]


def _why(best: Cell) -> str:
    return (
        f"The fast waves of the mesh force {best.column} into small steps, {best.evaluations} "
        f"right-hand sides, so it ends far more accurate than its tolerance of {paper.RTOL:g} asks."
    )


def _on_target(is_met: bool) -> str:
    return f"{ODE_TARGET} is {verdict(is_met)}."


STUDY = Study(
    "table1",
    run=table1,
    tables=by_element,
    rows=lambda table: [cell.record() for cell in table.cells.values()],
    findings=findings,
    notes=lambda table: [EXPLANATION],
    charts={"figure1": figure1, "figure2": figure2},
    regions={
        "table1": as_markdown,
        "table1-findings": lambda table: "\n".join(bullets(findings(table))),
    },
)
