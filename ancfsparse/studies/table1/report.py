"""Table 1 as text, CSV, JSON and Markdown."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from ancfsparse.studies.common import paper, tables
from ancfsparse.studies.common.study import Study
from ancfsparse.studies.table1.cells import COLUMNS, ROWS, Cell
from ancfsparse.studies.table1.figures import figure1, figure2
from ancfsparse.studies.table1.findings import findings
from ancfsparse.studies.table1.run import Match, Table, table1


def as_text(table: Table) -> str:
    """Set the table for a terminal: one block per element, one line per method."""
    lines = []
    for row in table.rows:
        element, dim = ROWS[row].element, ROWS[row].dim
        lines += [
            "",
            f"{row} ({element}, {'planar' if dim == 2 else 'spatial'}, {paper.ELEMENTS} elements)",
            f"  {'method':<22}{'seconds':>10}{'paper':>10}{'faster by':>11}"
            f"{'iter./step':>12}{'tip error [m]':>15}{'Davidon as good':>17}",
        ]
        lines += [
            _line(table.cells[row, column], table.matches.get((row, column))) for column in COLUMNS
        ]
    lines += [
        "",
        "faster by: the paper's time over ours. tip error: largest distance from the same mesh "
        "converged in time.",
        "iter./step: corrections whose residual was looked at; Broyden, DFP, BFGS and modified "
        "Newton make one more",
        "by the residual that ends a step, which costs no residual.",
        "Davidon as good: how many times faster Davidon is with a step that makes its tip error "
        "no larger.",
        "",
        *findings(table),
    ]
    return "\n".join(lines[1:])


def _line(cell: Cell, match: Match | None) -> str:
    stands_for = paper.ODE_FUNCTIONS.get(cell.column)
    name = f"{cell.column} ({stands_for})" if stands_for else cell.column
    error = f"{cell.tip_error:.1e}" if cell.finished else ""
    as_good = "" if match is None else f"{match.ratio:.1f}" if match.found else "no step tried"
    return (
        f"  {name:<22}{_seconds(cell):>10}{_number(cell.paper_seconds, '.2f'):>10}"
        f"{_number(cell.speed_up, '.0f'):>11}{_number(cell.iterations_per_step, '.2f'):>12}"
        f"{error:>15}{as_good:>17}"
    ).rstrip()


def _seconds(cell: Cell) -> str:
    return f"{cell.seconds:.3g}" if cell.finished else cell.note


def _number(value: float, form: str) -> str:
    return "" if math.isnan(value) else format(value, form)


def as_record(table: Table) -> dict[str, Any]:
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


def as_markdown(table: Table) -> str:
    """Return the table for README: one line per method, our time and the paper's per element."""
    lines = []
    for column in COLUMNS:
        stands_for = paper.ODE_FUNCTIONS.get(column)
        name = f"{column}, for `{stands_for}`" if stands_for else column
        lines.append([name, *(_both(table.cells[row, column]) for row in table.rows)])
    davidon = [table.cells[row, "Davidon"] for row in table.rows]
    lines += [
        [
            "*Davidon: set-up before the first step*",
            *(_number(c.set_up_seconds, ".2g") for c in davidon),
        ],
        ["*Davidon: speed-up over the paper*", *(_number(c.speed_up, ".0f") for c in davidon)],
        [
            "*Davidon: iterations per step*",
            *(_number(c.iterations_per_step, ".2f") for c in davidon),
        ],
        ["*Davidon: tip error [m]*", *(_number(c.tip_error, ".1e") for c in davidon)],
    ]
    tabled = tables.table(["seconds (the paper's)", *table.rows], lines)
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


def findings_as_markdown(table: Table) -> str:
    """Return the findings as a list for a page."""
    return "\n".join(f"- {each}" for each in findings(table))


def _both(cell: Cell) -> str:
    theirs = "" if math.isnan(cell.paper_seconds) else f" ({cell.paper_seconds:g})"
    return _seconds(cell) + theirs


STUDY = Study(
    "table1",
    run=table1,
    text=as_text,
    rows=lambda table: [cell.record() for cell in table.cells.values()],
    record=as_record,
    findings=findings,
    charts={"figure1": figure1, "figure2": figure2},
    regions={"table1": as_markdown},
    gallery="docs/gallery",
)

ON_BENCHMARKS = replace(STUDY, regions={"table1-findings": findings_as_markdown}, gallery="gallery")
"""The same with its findings for a page of their own."""
