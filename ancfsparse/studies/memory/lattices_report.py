"""Secant pairs on incomplete seeds as text, table and chart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from ancfsparse.nonlinear.methods import UPDATES
from ancfsparse.studies.common.charts import SMALL, WIDTH, set_head, set_legend
from ancfsparse.studies.common.study import Study
from ancfsparse.studies.common.tables import Table
from ancfsparse.studies.memory.lattices import Row, beside, findings, lattices
from ancfsparse.studies.memory.report import COLOURS

HEAD = ("corrections", "sweeps and products", "seeds", "work beside the chord")


def _best(rows: Sequence[Row], scene: str, h_omega: float, carry: bool) -> Row | None:
    """Return the run with pairs of least work, None where all fail."""
    own = [
        row for row in rows
        if (row.scene, row.h_omega, row.carry) == (scene, h_omega, carry) and row.pairs
    ]  # fmt: skip
    return min((row for row in own if not row.failed), key=lambda row: row.work, default=None)


def _chosen(rows: Sequence[Row]) -> list[Row]:
    """Return for each scene and step the chord, auto, and the best of both kinds of pairs."""
    chosen = []
    for scene, h_omega in dict.fromkeys((row.scene, row.h_omega) for row in rows):
        for row in rows:
            if (row.scene, row.h_omega) == (scene, h_omega) and not row.pairs:
                chosen.append(row)
        best = [_best(rows, scene, h_omega, carry) for carry in (False, True)]
        chosen += [row for row in best if row is not None]
    return chosen


def _cells(rows: Sequence[Row], row: Row) -> list[str]:
    if row.failed:
        return ["fails", "", "", ""]
    ratio = beside(rows, row)
    return [
        f"{row.corrections:.2f}",
        f"{row.inner:.1f}",
        f"{row.factorizations}",
        f"{ratio:.2f}" if ratio == ratio else "",
    ]


def table(rows: Sequence[Row], shown: Sequence[Row]) -> Table:
    """Set some of the rows, beside the chord among all."""
    lines = [[row.scene, f"{row.h_omega:g}", row.name, *_cells(rows, row)] for row in shown]
    return Table(["", "h omega", "", *HEAD], lines, left=(0, 2))


def chart(rows: Sequence[Row]) -> Figure:
    """Draw the work beside the chord against the step, by scene; a gap is a run that fails."""
    scenes = list(dict.fromkeys(row.scene for row in rows))
    figure = Figure(figsize=(WIDTH, 6.4), layout="constrained")
    axes = figure.subplots(2, -(-len(scenes) // 2), sharey=True, squeeze=False)
    shown: dict[str, Any] = {}
    for ax, scene in zip(axes.ravel(), scenes, strict=False):
        _panel(ax, rows, scene, shown)
    for ax in axes[:, 0]:
        ax.set_ylabel("work beside the chord", fontsize=SMALL)
    for ax in axes[-1]:
        ax.set_xlabel("step times highest frequency of an element", fontsize=SMALL)
    set_legend(figure, shown, 3, "two pairs; the black line is auto, gaps are runs that fail")
    set_head(figure, _headline(rows))
    return figure


def _panel(ax: Axes, rows: Sequence[Row], scene: str, shown: dict[str, Any]) -> None:
    least = min(row.pairs for row in rows if row.pairs)
    own = [row for row in rows if row.scene == scene and row.pairs in (0, least)]
    steps = list(dict.fromkeys(row.h_omega for row in own))
    for update in (*UPDATES, "auto"):
        for carry in (False, True) if update != "auto" else (False,):
            line = [row for row in own if (row.update, row.carry) == (update, carry)]
            label = f"{update}, {'carried' if carry else 'this step'}"
            (shown[label if update != "auto" else "auto"],) = ax.plot(
                steps,
                [beside(rows, row) for row in line],
                "--" if carry else "-",
                color=COLOURS.get(update, "black"),
                linewidth=2.0 if update == "auto" else 1.0,
                marker=".",
            )
    ax.axhline(1.0, color="grey", linewidth=0.8)
    ax.set_xscale("log")
    ax.set_xticks(steps, [f"{each:g}" if each not in (100, 350) else "" for each in steps])
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_ylim(0.4, 3.0)
    ax.set_title(scene, fontsize=SMALL)
    ax.tick_params(labelsize=SMALL)
    ax.grid(alpha=0.3)


def _headline(rows: Sequence[Row]) -> str:
    ratios = [beside(rows, row) for row in rows if row.update == "auto"]
    known = [ratio for ratio in ratios if ratio == ratio]
    if not known:
        return "Secant pairs on incomplete seeds"
    return (
        "On incomplete seeds auto, which takes pairs where sweeps contract slowly,\n"
        f"takes {min(known):.2f} to {max(known):.2f} of the work of the chord"
    )


STUDY = Study(
    "memory-lattices",
    run=lattices,
    tables=lambda rows: [table(rows, rows)],
    rows=lambda rows: [asdict(row) for row in rows],
    record=lambda rows: {"rows": [asdict(row) for row in rows]},
    findings=findings,
    charts={"memory-lattices": chart},
    regions={"memory-lattices": lambda rows: table(rows, _chosen(rows))},
)
