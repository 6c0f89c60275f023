"""The memory-length study as text, CSV, JSON and a chart."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from itertools import cycle
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ancfsparse.nonlinear.methods import UPDATES
from benchmarks.common.charts import SMALL, new_figure, set_legend
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.scaling.secant_pairs import MemoryStudy, Run, memory

COLOURS = dict(zip(UPDATES, cycle(["#e69f00", "#0072b2", "#009e73", "#cc79a7"]), strict=False))
"""Taken in turn, so that a new update has one."""


def heading(result: MemoryStudy) -> str:
    """State what is measured."""
    settings = result.settings
    return (
        f"Memory length, dt = {settings['dt_s']:g} s, {settings['steps']} steps, medians of "
        f"{settings['rounds']} rounds in turn; cost and seconds beside the chord"
    )


def best(result: MemoryStudy) -> Table:
    """Set the chord and the best of both kinds of pairs, scene by scene."""
    return _table(result, lambda scene: [result.best(scene, False), result.best(scene, True)])


def _table(result: MemoryStudy, shown: Callable[[str], Sequence[Run]]) -> Table:
    """Set the chord of each scene and the runs that are shown of it."""
    rows = []
    for scene in result.scenes:
        chord = result.of(scene)[0]
        for run in (chord, *shown(scene)):
            name = f"{run.update}, {run.pairs} pairs{' carried' * run.carry}"
            rows.append([
                scene, "chord" if run is chord else name, f"{run.iterations_per_step:.2f}",
                str(run.factorizations), f"{run.model_cost / chord.model_cost:.2f}",
                f"{run.seconds / chord.seconds:.2f}",
            ])  # fmt: skip
    head = ["", "", "corrections per step", "seeds", "cost by counts", "seconds"]
    return Table(head, rows, left=(0, 1))


def _row(run: Run) -> dict[str, Any]:
    row = asdict(run) | {"median_seconds": run.seconds}
    del row["rounds"]
    return row


ROWS: tuple[tuple[str, Callable[[Run, Run], float]], ...] = (
    ("corrections\nper step", lambda run, chord: run.iterations_per_step),
    ("seeds", lambda run, chord: run.factorizations),
    ("cost by counts\nbeside the chord", lambda run, chord: run.model_cost / chord.model_cost),
    ("seconds\nbeside the chord", lambda run, chord: run.seconds / chord.seconds),
)
"""What is drawn against memory length, from the top down."""


def chart(result: MemoryStudy) -> Figure:
    """Draw corrections, seeds, modelled cost and seconds against memory length, by scene."""
    scenes = result.scenes
    figure = new_figure(8.6, "Counts and cost of secant pairs against their number")
    axes = figure.subplots(len(ROWS), len(scenes), sharex=True, squeeze=False)
    shown: dict[str, Any] = {}
    for column, scene in zip(axes.T, scenes, strict=True):
        for ax, (_, value) in zip(column, ROWS, strict=True):
            _panel(ax, result.of(scene), value, shown)
        column[0].set_title(scene, fontsize=SMALL)
        column[-1].set_xlabel("pairs", fontsize=SMALL)
    for ax, (name, _) in zip(axes[:, 0], ROWS, strict=True):
        ax.set_ylabel(name, fontsize=SMALL)
    for ax in axes[2:].ravel():
        ax.axhline(1.0, color="black", linewidth=0.8)
    set_legend(figure, shown, 4)
    return figure


def _panel(
    ax: Axes, runs: list[Run], value: Callable[[Run, Run], float], shown: dict[str, Any]
) -> None:
    """Draw one number of a scene for each update, from no pair on."""
    chord, *others = runs
    for update, colour in COLOURS.items():
        for carry in (False, True):
            chosen = [run for run in others if run.update == update and run.carry is carry]
            x = [0, *(run.pairs for run in chosen)]
            y = [value(run, chord) for run in (chord, *chosen)]
            label = f"{update}, {'carried' if carry else 'this step'}"
            (shown[label],) = ax.plot(x, y, "--" if carry else "-", color=colour, marker=".")
    ax.set_xscale("symlog", linthresh=1.0)
    ax.set_xticks([0, 1, 2, 5, 10, 20], ["0", "1", "2", "5", "10", "20"])
    ax.minorticks_off()
    ax.tick_params(labelsize=SMALL)
    ax.grid(alpha=0.3)


STUDY = Study(
    "memory",
    run=memory,
    heading=heading,
    tables=lambda result: [_table(result, lambda scene: result.of(scene)[1:])],
    rows=lambda result: [_row(run) for run in result.runs],
    findings=MemoryStudy.findings,
    charts={"memory": chart},
    regions={"memory": best},
)
