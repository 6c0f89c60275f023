"""Table 1 as text, CSV, JSON and Markdown."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

from ancfsparse.studies.common import paper
from ancfsparse.studies.common.files import fill_text
from ancfsparse.studies.table1.cells import COLUMNS, ROWS, Cell
from ancfsparse.studies.table1.findings import findings
from ancfsparse.studies.table1.run import Match, Table

MARKERS = "table1"
"""Name of the markers of the table on a page."""

FINDINGS = "table1-findings"
"""Name of the markers of its findings on a page."""


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
        "findings": findings(table),
    }


def write(table: Table, folder: Path) -> list[Path]:
    """Write table1.csv and table1.json.

    Parameters
    ----------
    table : Table
        A finished table.
    folder : Path
        Where to; made if missing.

    Returns
    -------
    list of Path
        The files.
    """
    folder.mkdir(parents=True, exist_ok=True)
    records = [cell.record() for cell in table.cells.values()]
    with (folder / "table1.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(records[0]))
        writer.writeheader()
        writer.writerows(records)
    text = json.dumps(as_record(table), indent=1, allow_nan=False)
    (folder / "table1.json").write_text(text + "\n", encoding="utf-8")
    return [folder / "table1.csv", folder / "table1.json"]


def as_markdown(table: Table) -> str:
    """Return the table for README: one line per method, our time and the paper's per element."""
    heads = table.rows
    lines = [
        "| seconds (the paper's) | " + " | ".join(heads) + " |",
        "|---|" + "---:|" * len(heads),
    ]
    for column in COLUMNS:
        stands_for = paper.ODE_FUNCTIONS.get(column)
        name = f"{column}, for `{stands_for}`" if stands_for else column
        cells = [table.cells[row, column] for row in table.rows]
        lines.append(f"| {name} | " + " | ".join(_both(cell) for cell in cells) + " |")
    davidon = [table.cells[row, "Davidon"] for row in table.rows]
    lines += [
        "| *Davidon: set-up before the first step* | "
        + " | ".join(_number(c.set_up_seconds, ".2g") for c in davidon) + " |",
        "| *Davidon: speed-up over the paper* | "
        + " | ".join(_number(c.speed_up, ".0f") for c in davidon) + " |",
        "| *Davidon: iterations per step* | "
        + " | ".join(_number(c.iterations_per_step, ".2f") for c in davidon) + " |",
        "| *Davidon: tip error [m]* | "
        + " | ".join(_number(c.tip_error, ".1e") for c in davidon) + " |",
    ]  # fmt: skip
    settings = table.settings
    caption = (
        f"{settings['elements']} elements, dt = {settings['dt_s']:g} s, on {settings['machine']} "
        f"with kernels for {settings['instruction_set']}. Seconds are those of the time loop, "
        "without set-up; the paper timed MATLAB on a computer it does not name. SciPy "
        f"{settings['scipy']} integrates the same compiled forces, with tolerances "
        f"{settings['ode_rtol']:g} and {settings['ode_atol']:g}. Tip error: largest distance over "
        "the whole run from the same mesh converged in time."
    )
    return "\n".join([*lines, "", caption])


def findings_as_markdown(table: Table) -> str:
    """Return the findings as a list for a page."""
    return "\n".join(f"- {each}" for each in findings(table))


def _both(cell: Cell) -> str:
    theirs = "" if math.isnan(cell.paper_seconds) else f" ({cell.paper_seconds:g})"
    return _seconds(cell) + theirs


def fill_readme(table: Table, readme: Path) -> None:
    """Put the table between its two markers.

    Parameters
    ----------
    table : Table
        A finished table.
    readme : Path
        A page with both markers.

    Raises
    ------
    InputError
        If a marker is missing; nothing is written.
    """
    fill_text(readme, MARKERS, as_markdown(table))


def fill_page(table: Table, page: Path) -> None:
    """Put the findings between their two markers, as `fill_readme` does with the table."""
    fill_text(page, FINDINGS, findings_as_markdown(table))
