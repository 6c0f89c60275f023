"""Table 1 as text, CSV, JSON and Markdown."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from ancfsparse.studies.common import paper
from ancfsparse.studies.common.study import Study
from ancfsparse.studies.common.tables import Table, bullets
from ancfsparse.studies.table1.cells import COLUMNS, ROWS, Cell
from ancfsparse.studies.table1.figures import figure1, figure2
from ancfsparse.studies.table1.findings import findings
from ancfsparse.studies.table1.run import Match, table1
from ancfsparse.studies.table1.run import Table as Results

EXPLANATION = """\
faster by: the paper's time over ours. tip error: largest distance from the same mesh converged \
in time.
iter./step: corrections whose residual was looked at; Broyden, DFP, BFGS and modified Newton make \
one more
by the residual that ends a step, which costs no residual.
Davidon as good: how many times faster Davidon is with a step that makes its tip error no larger.\
"""


def by_element(table: Results) -> list[Table]:
    """Set one table per element, one line per method."""
    head = [
        "method", "seconds", "paper", "faster by", "iter./step", "tip error [m]", "Davidon as good"
    ]  # fmt: skip
    return [
        Table(
            head,
            [_line(table.cells[row, c], table.matches.get((row, c))) for c in COLUMNS],
            title=f"{row} ({ROWS[row].element}, {'planar' if ROWS[row].dim == 2 else 'spatial'}, "
            f"{paper.ELEMENTS} elements)",
        )
        for row in table.rows
    ]


def _line(cell: Cell, match: Match | None) -> list[str]:
    stands_for = paper.ODE_FUNCTIONS.get(cell.column)
    as_good = "" if match is None else f"{match.ratio:.1f}" if match.found else "no step tried"
    return [
        f"{cell.column} ({stands_for})" if stands_for else cell.column,
        _seconds(cell),
        _number(cell.paper_seconds, ".2f"),
        _number(cell.speed_up, ".0f"),
        _number(cell.iterations_per_step, ".2f"),
        f"{cell.tip_error:.1e}" if cell.finished else "",
        as_good,
    ]


def _seconds(cell: Cell) -> str:
    return f"{cell.seconds:.3g}" if cell.finished else cell.note


def _number(value: float, form: str) -> str:
    return "" if math.isnan(value) else format(value, form)


def as_record(table: Results) -> dict[str, Any]:
    """Return the table as one JSON object."""
    return {
        "settings": table.settings,
        "cells": [cell.record() for cell in table.cells.values()],
        "davidon_at_equal_or_better_tip_error": [
            {
                "element": match.row,
                "method": match.column,
                "dt_s": match.dt,
                "seconds": match.seconds,
                "tip_error_m": match.tip_error,
                "ratio": match.ratio,
            }
            if match.found
            else {"element": match.row, "method": match.column}
            for match in table.matches.values()
        ],
    }


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
    theirs = "" if math.isnan(cell.paper_seconds) else f" ({cell.paper_seconds:g})"
    return _seconds(cell) + theirs


STUDY = Study(
    "table1",
    run=table1,
    tables=by_element,
    rows=lambda table: [cell.record() for cell in table.cells.values()],
    record=as_record,
    findings=findings,
    notes=lambda table: [EXPLANATION],
    charts={"figure1": figure1, "figure2": figure2},
    regions={"table1": as_markdown},
    gallery="docs/gallery",
)

ON_BENCHMARKS = replace(
    STUDY,
    regions={"table1-findings": lambda table: "\n".join(bullets(findings(table)))},
    gallery="gallery",
)
"""The same with its findings for a page of their own."""
