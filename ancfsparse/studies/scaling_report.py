"""The scaling study as text, CSV, JSON and a chart."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from ancfsparse.dispatch import instruction_set
from ancfsparse.studies.exudyn_scene import SETTINGS as PEERS
from ancfsparse.studies.scaling import TITLES, Row, Scaling, ratios
from ancfsparse.studies.scaling_job import SOLVERS

COLOURS = dict(
    zip(
        [*SOLVERS, *(peer.name for peer in PEERS)],
        ["#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#999999"],
        strict=True,
    )
)
"""One colour per solver, told apart by colour-blind eyes too."""


def as_text(result: Scaling) -> str:
    """Set the tables for a terminal: a block per scene, a line per size and solver."""
    settings = result.settings
    lines = [
        f"Cost per element and step, dt = {settings['dt_s']:g} s, {settings['steps']} steps, "
        f"{instruction_set()}, medians of {settings['rounds']} rounds in turn"
    ]
    for group in result.by_size():
        row = group[0]
        count = next(
            c for c in result.counts if (c["scene"], c["size"]) == (TITLES[row.scene], row.job.size)
        )
        lines += [
            "",
            f"{TITLES[row.scene]}, {row.job.size}: {row.job.elements} elements, "
            f"{count['unknowns']} unknowns, {count['factor_entries']} entries in L "
            f"({count['ordering']})",
            f"  {'':<26}{'us':>8}{'it./step':>10}{'factors':>9}{'set-up s':>10}{'peak MB':>9}"
            f"{'bytes/el.':>11}",
        ]
        lines += [_line(row) for row in group]
        compared = [
            f"{key} {value:.2f}" for key, value in ratios(group).items() if isinstance(value, float)
        ]
        if compared:
            lines.append("  " + ", ".join(compared))
    lines += ["", "Powers of the number of elements, from 500 on"]
    lines += [f"  {key:<58}{value:>6.2f}" for key, value in result.slopes().items()]
    growth = result.growth()
    if growth:
        lines += ["", "Cost per element and step of auto on chains falling from rest"]
        lines += [f"  {key:<58}{value:>6.2f}" for key, value in growth.items()]
    return "\n".join([*lines, "", str(result.roofline)])


def _line(row: Row) -> str:
    if row.note:
        return f"  {row.job.solver:<26}{row.note}"
    flat = row.flat()
    line = (
        f"  {row.job.solver:<26}{row.microseconds:>8.3f}{flat['iterations_per_step']:>10.2f}"
        f"{flat['factorizations']:>9}{flat['set_up_seconds']:>10.2f}"
        f"{flat['peak_megabytes']:>9.0f}{flat['bytes_per_element']:>11.0f}"
    )
    split = [f"{key} {value:.3f}" for key, value in flat["split_microseconds"].items()]
    return line + ("   " + ", ".join(split) if split else "")


def write(result: Scaling, folder: Path) -> list[Path]:
    """Write scaling.csv, scaling.json and scaling.png.

    Parameters
    ----------
    result : Scaling
        A finished study.
    folder : Path
        Where to; made if missing.

    Returns
    -------
    list of Path
        The files.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"scaling.{kind}" for kind in ("csv", "json", "png")]
    write_csv([_spread(row.flat()) for row in result.rows], paths[0])
    text = json.dumps(result.record(), indent=1, allow_nan=False)
    paths[1].write_text(text + "\n", encoding="utf-8")
    chart(result).savefig(paths[2], dpi=120)
    return paths


def write_csv(records: Sequence[dict[str, Any]], path: Path) -> None:
    """Write one line per record; what a record lacks is left empty."""
    names = list(dict.fromkeys(key for record in records for key in record))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(records)


def _spread(flat: dict[str, Any]) -> dict[str, Any]:
    """Give each part of the split a column of its own."""
    split = flat.pop("split_microseconds")
    return flat | {f"{key}_microseconds": value for key, value in split.items()}


def chart(result: Scaling) -> Figure:
    """Draw cost per element and step against size for each scene, and memory."""
    figure = Figure(figsize=(10.5, 8.0), layout="constrained")
    scenes = [each for each in TITLES if any(result.done(each, solver) for solver in COLOURS)]
    panels = figure.subplots(-(-(len(scenes) + 1) // 2), 2).ravel()
    costs, memory = panels[: len(scenes)], panels[len(scenes)]
    for ax in panels[len(scenes) + 1 :]:
        ax.remove()
    shown: dict[str, Any] = {}
    for ax, scene in zip(costs, scenes, strict=True):
        for solver, colour in COLOURS.items():
            rows = result.done(scene, solver)
            if rows:
                x, y = [r.job.elements for r in rows], [r.microseconds for r in rows]
                shown[solver] = _curve(ax, x, y, solver, colour)
        ax.set_ylabel("microseconds per element and step")
        ax.set_title(_finding(result, scene), fontsize="small")
    for scene, style in zip(scenes, ("o-", "s--", "^:"), strict=False):
        rows = [r for r in result.done(scene, "auto") if r.bytes_per_element > 0]
        x, y = [r.job.elements for r in rows], [r.bytes_per_element for r in rows]
        memory.plot(x, y, style, color="black", label=TITLES[scene])
    memory.set_ylabel("bytes per element above an idle process")
    memory.set_title(_memory_finding(result), fontsize="small")
    memory.legend(fontsize="small")
    for ax in (*costs, memory):
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_xlabel("elements")
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.grid(alpha=0.3, which="major")
    figure.legend(
        shown.values(), shown, loc="outside lower center", ncols=4, fontsize="small", frameon=False
    )
    figure.suptitle(_headline(result))
    return figure


def _curve(ax: Axes, x: list[int], y: list[float], solver: str, colour: str) -> Any:
    auto = solver == "auto"
    style = "--" if solver not in SOLVERS else "-"
    (line,) = ax.plot(
        x,
        y,
        style,
        color=colour,
        marker="o" if auto else ".",
        markerfacecolor="none",
        markersize=9 if auto else 6,
        linewidth=2.4 if auto else 1.4,
        label=solver,
        zorder=1 if auto else 2,  # what auto chose is drawn on top of it
    )
    return line


def _headline(result: Scaling) -> str:
    """Say how the cost of the longest chain compares with that of one that fits the caches."""
    rows = result.done(("chain", "rest"), "auto")
    if len(rows) < 2:
        return "Cost per element and step"
    first = next((r for r in rows if r.job.elements >= 1000), rows[0])
    if first is rows[-1]:
        first = rows[0]
    growth = rows[-1].microseconds / first.microseconds
    return (
        f"From {first.job.elements:,} to {rows[-1].job.elements:,} elements, a step of a chain "
        f"costs {growth:.2f} times as much per element"
    )


def _finding(result: Scaling, scene: tuple[str, str]) -> str:
    """Name the nearest rival of auto at the largest size where both have a result."""
    compared = [ratios(group) for group in result.by_size() if group[0].scene == scene]
    for names in ([peer.name for peer in PEERS], ["Newton"]):
        for found in reversed(compared):
            rivals = {name: found[k] for name in names if (k := f"{name} / auto") in found}
            if rivals:
                name = min(rivals, key=lambda each: rivals[each])
                size = f"{found['size']:,}" + (" x " + str(found["size"])) * (scene[0] == "net")
                title = TITLES[scene].capitalize()
                return f"{title}:\n{name} takes {rivals[name]:.1f} times as long as auto at {size}"
    return TITLES[scene].capitalize()


def _memory_finding(result: Scaling) -> str:
    slopes = [f"{value:.2f}" for key, value in result.slopes().items() if "memory" in key]
    return "Memory of auto grows with the elements\nto the power " + ", ".join(slopes)
