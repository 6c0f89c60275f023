"""The memory-length study as text, CSV, JSON and a chart."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ancfsparse.nonlinear.methods import UPDATES
from ancfsparse.studies.memory import SAME, MemoryStudy
from ancfsparse.studies.scaling_report import write_csv

COLOURS = dict(zip(UPDATES, ["#e69f00", "#0072b2", "#009e73", "#cc79a7"], strict=True))


def as_text(result: MemoryStudy) -> str:
    """Set the tables for a terminal: a block per scene."""
    settings = result.settings
    lines = [
        f"Memory length, dt = {settings['dt_s']:g} s, {settings['steps']} steps, medians of "
        f"{settings['rounds']} rounds in turn; cost and seconds beside the chord"
    ]
    for scene in result.scenes:
        chord, *others = result.of(scene)
        lines += [
            "",
            scene,
            f"  {'':<10}{'pairs':>6}{'carried':>9}{'it./step':>10}{'seeds':>7}{'cost':>7}"
            f"{'seconds':>9}",
        ]
        for run in (chord, *others):
            lines.append(
                f"  {run.update:<10}{run.pairs:>6}{'yes' if run.carry else '':>9}"
                f"{run.iterations_per_step:>10.2f}{run.factorizations:>7}"
                f"{run.model_cost / chord.model_cost:>7.2f}{run.seconds / chord.seconds:>9.2f}"
            )
    return "\n".join([*lines, "", *result.findings()])


def write(result: MemoryStudy, folder: Path) -> list[Path]:
    """Write memory.csv, memory.json and memory.png.

    Parameters
    ----------
    result : MemoryStudy
        A finished study.
    folder : Path
        Where to; made if missing.

    Returns
    -------
    list of Path
        The files.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"memory.{kind}" for kind in ("csv", "json", "png")]
    rows = []
    for run in result.runs:
        row = asdict(run) | {"median_seconds": run.seconds}
        del row["rounds"]
        rows.append(row)
    write_csv(rows, paths[0])
    text = json.dumps(result.record(), indent=1, allow_nan=False)
    paths[1].write_text(text + "\n", encoding="utf-8")
    chart(result).savefig(paths[2], dpi=120)
    return paths


def chart(result: MemoryStudy) -> Figure:
    """Draw iterations and modelled cost against memory length, a column per scene."""
    scenes = result.scenes
    figure = Figure(figsize=(3.2 * len(scenes), 6.4), layout="constrained")
    axes = figure.subplots(2, len(scenes), sharex=True, squeeze=False)
    for top, bottom, scene in zip(*axes, scenes, strict=True):
        _panel(top, bottom, result, scene)
        top.set_title(scene, fontsize="medium")
        bottom.set_xlabel("pairs")
    axes[0, 0].set_ylabel("iterations per step")
    axes[1, 0].set_ylabel("cost by counts, beside the chord")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside lower center", ncols=4, fontsize="small", frameon=False
    )
    figure.suptitle(_headline(result))
    return figure


def _headline(result: MemoryStudy) -> str:
    """Count the scenes on which pairs are cheaper than what is simpler."""
    scenes, bound = result.scenes, 1.0 - SAME

    def paying(carry: bool) -> str:
        cheaper = [
            result.best(scene, carry).model_cost
            < bound * (result.best(scene, False) if carry else result.of(scene)[0]).model_cost
            for scene in scenes
        ]
        return f"on {sum(cheaper)} of {len(scenes)} scenes"

    return (
        f"By counts, pairs of the step alone pay beside the chord {paying(False)}, "
        f"carried ones beside them {paying(True)}"
    )


def _panel(top: Axes, bottom: Axes, result: MemoryStudy, scene: str) -> None:
    chord, *runs = result.of(scene)
    for update, colour in COLOURS.items():
        for carry in (False, True):
            chosen = [run for run in runs if run.update == update and run.carry is carry]
            x = [0, *(run.pairs for run in chosen)]
            label = f"{update}, {'carried' if carry else 'this step'}"
            style: dict[str, Any] = {"color": colour, "marker": ".", "label": label}
            line = "--" if carry else "-"
            iterations = [run.iterations_per_step for run in (chord, *chosen)]
            costs = [run.model_cost / chord.model_cost for run in (chord, *chosen)]
            top.plot(x, iterations, line, **style)
            bottom.plot(x, costs, line, **style)
    bottom.axhline(1.0, color="black", linewidth=0.8)
    for ax in (top, bottom):
        ax.set_xscale("symlog", linthresh=1.0)
        ax.set_xticks([0, 1, 2, 5, 10, 20], ["0", "1", "2", "5", "10", "20"])
        ax.minorticks_off()
        ax.grid(alpha=0.3)
