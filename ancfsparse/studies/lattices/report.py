"""The study of lattices as text, CSV, JSON and a chart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ancfsparse.studies.common.charts import SMALL, WIDTH, set_axes, set_empty, set_head, set_legend
from ancfsparse.studies.common.study import Study
from ancfsparse.studies.common.tables import Table
from ancfsparse.studies.lattices.findings import findings, targets
from ancfsparse.studies.lattices.run import Row, lattices, pairs

COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#000000")
HEAD = (
    "seeds", "elements", "fill", "us per element and step", "set-up s", "kB per element",
    "corrections", "sweeps and products", "factorisations",
)  # fmt: skip


def _cells(row: Row) -> list[str]:
    job, record = row.job, row.record
    if row.note:
        return [job.seed, f"{job.elements:,}", "", row.note.partition(":")[0], "", "", "", "", ""]
    inner = record["sweeps"] + record["products"]
    return [
        job.seed,
        f"{job.elements:,}",
        f"{record['fill']:.3g}" if "fill" in record else "",
        f"{row.microseconds:.3g}",
        f"{record['set_up_seconds']:.2g}",
        f"{row.bytes_per_element / 1e3:.2g}",
        f"{record['corrections']:.2f}",
        f"{inner:.1f}" if inner else "",
        f"{record['factorizations']} in {job.steps} steps",
    ]


def runs(rows: Sequence[Row]) -> Table:
    """Set a line for each run."""
    lines = [[row.job.title, row.job.side, *_cells(row)] for row in rows]
    return Table(["", "size", *HEAD], lines, left=(0, 2))


def chart(rows: Sequence[Row]) -> Figure:
    """Draw time and memory per element against the number of elements, by kind of scene."""
    rows = [row for row in rows if row.job.case != "statics" and row.job.threads == 1]
    kinds = {
        "nets and lattices": [
            row for row in rows if row.job.case != "octet" and not (row.job.jitter or row.job.rods)
        ],
        "irregular or on rods": [row for row in rows if row.job.jitter or row.job.rods],
        "octet trusses": [row for row in rows if row.job.case == "octet"],
    }
    kinds = {name: own for name, own in kinds.items() if own}
    figure = Figure(figsize=(WIDTH, 1.0 + 3.4 * len(kinds)), layout="constrained")
    colours = dict(zip(dict.fromkeys(map(_label, rows)), COLOURS, strict=False))
    shown: dict[str, Any] = {}
    for (left, right), (name, own) in zip(
        figure.subplots(len(kinds), 2, squeeze=False), kinds.items(), strict=True
    ):
        shown |= _panels(left, right, name, own, colours)
    if shown:
        set_legend(figure, shown, 3, "solid: incomplete seeds, dashed: exact ones")
        set_head(figure, _headline(rows))
    return figure


def _panels(
    left: Axes, right: Axes, name: str, rows: Sequence[Row], colours: dict[str, str]
) -> dict[str, Any]:
    """Draw a line for each stiffness, motion and step; return those of incomplete seeds."""
    shown: dict[str, Any] = {}
    if all(row.note for row in rows):
        for ax in (left, right):
            set_empty(ax, "no run has a result")
        return shown
    for label, colour in colours.items():
        for seed, line in (("exact", "--"), ("incomplete", "-")):
            own = [r for r in rows if (_label(r), r.job.seed) == (label, seed) and not r.note]
            x = [row.job.elements for row in own]
            left.plot(x, [row.microseconds for row in own], line, color=colour, marker=".")
            y = [row.bytes_per_element / 1e3 for row in own]
            (drawn,) = right.plot(x, y, line, color=colour, marker=".")
            if seed == "incomplete" and own:
                shown[label] = drawn
    for ax, what in ((left, "microseconds per element and step"), (right, "kB per element")):
        ax.set_title(name, fontsize=SMALL)
        set_axes(ax, "elements", what, "x")
        ax.tick_params(labelsize=SMALL)
    left.set_yscale("log")
    right.set_ylim(bottom=0.0)
    return shown


def _label(row: Row) -> str:
    job = row.job
    return f"{'net' if job.case == 'net' else job.stiff}, {job.course}"


def _headline(rows: Sequence[Row]) -> str:
    both = [pair for pair in pairs(rows) if pair[0].job.case != "net"]
    if not both:
        return "Exact and incomplete seeds"
    exact, incomplete = max(both, key=lambda pair: pair[0].microseconds / pair[1].microseconds)
    return (
        f"The exact seed takes up to {exact.microseconds / incomplete.microseconds:.2g} times as "
        f"long as the incomplete one ({exact.job.title}, {exact.job.side})"
    )


STUDY = Study(
    "lattices",
    run=lattices,
    tables=lambda rows: [runs(rows)],
    rows=lambda rows: [row.flat() for row in rows],
    record=lambda rows: {"rows": [row.flat() for row in rows]},
    findings=findings,
    targets=targets,
    charts={"lattices": chart},
    regions={"lattices": runs},
)
