"""The scaling study as text, CSV and JSON, and a table for a page."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ancfsparse.dispatch import instruction_set
from benchmarks.common.charts import SMALL, new_figure, set_axes, set_empty, set_legend
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.other_codes.exudyn_scene import SETTINGS as PEERS
from benchmarks.scaling.findings import findings, name_of, size_of, targets
from benchmarks.scaling.rows import TITLES, Row, Scaling, ratios
from benchmarks.scaling.scaling import scaling
from benchmarks.scaling.scaling_job import SOLVERS

COLOURS = dict(
    zip(
        [*SOLVERS, *(peer.name for peer in PEERS)],
        ["#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#999999"],
        strict=True,
    )
)
"""One colour per solver, distinguished by colour-blind eyes too."""

STYLES = dict(zip(TITLES, ("o-", "s--", "^:"), strict=True))
"""One line and marker per scene."""

PARTS = {
    "force": "#56b4e9", "tangent": "#0072b2", "factor": "#d55e00", "solve": "#e69f00",
    "rest": "#bbbbbb",
}  # fmt: skip
"""Parts of a march, from the bottom up."""


def chart(result: Scaling) -> Figure:
    """Draw cost per element and step for each scene, memory, time by part, and counts."""
    figure = new_figure(10.5, "Cost, memory and counts against the number of elements")
    costs = figure.subplots(3, 2).ravel()
    memory, split, counted = costs[3:]
    shown: dict[str, Any] = {}
    for ax, scene in zip(costs, TITLES, strict=False):
        _costs(ax, result, scene, shown)
    autos = [row for scene in TITLES for row in result.done(scene, "auto")]
    known = [row for row in autos if row.bytes_per_element > 0]
    for scene, style in STYLES.items() if known else ():
        rows = [row for row in known if row.scene == scene]
        x, y = [r.job.elements for r in rows], [r.bytes_per_element for r in rows]
        memory.plot(x, y, style, color="black", markersize=5, label=TITLES[scene])
    if known:
        what = "Memory of auto above an idle process"
        set_axes(memory, "elements", "bytes per element", title=what)
        memory.legend(fontsize=SMALL)
    else:
        set_empty(memory, "memory of auto: above that of an idle process at no size")
    _parts(split, [row for row in autos if len(row.record.get("split", {})) > 1])
    if autos:
        _counts(counted, result)
    else:
        set_empty(counted, "corrections and factorisations of auto: no result")
    set_legend(figure, shown, 4, "crosses: no result at that size, for reasons given in the table")
    return figure


def _costs(ax: Axes, result: Scaling, scene: tuple[str, str], shown: dict[str, Any]) -> None:
    if all(row.note for row in result.rows if row.scene == scene):
        ran = any(row.scene == scene for row in result.rows)
        set_empty(ax, f"{TITLES[scene].capitalize()}: {'no result' if ran else 'not run'}")
        return
    top = ax.get_xaxis_transform()
    for k, (solver, colour) in enumerate(COLOURS.items()):
        rows = result.done(scene, solver)
        if rows:
            x, y = [r.job.elements for r in rows], [r.microseconds for r in rows]
            shown[solver] = _curve(ax, x, y, solver, colour)
        here = [r for r in result.rows if (r.scene, r.job.solver) == (scene, solver)]
        missing = [r.job.elements for r in here if r.note]
        ax.plot(missing, [0.97 - 0.035 * k] * len(missing), "x", color=colour, markersize=5,
                transform=top)  # fmt: skip
    title = TITLES[scene].capitalize()
    set_axes(ax, "elements", "us per element and step", title=title)
    low, high = ax.get_ylim()
    ax.set_ylim(low, high * (high / low) ** 0.25)  # room for crosses above the curves


def _curve(ax: Axes, x: list[int], y: list[float], solver: str, colour: str) -> Any:
    auto = solver == "auto"
    (line,) = ax.plot(
        x, y, "--" if solver not in SOLVERS else "-", color=colour, marker="o" if auto else ".",
        markerfacecolor="none", markersize=9 if auto else 6, linewidth=2.4 if auto else 1.4,
        zorder=1 if auto else 2,  # what auto chose is drawn on top of it
    )  # fmt: skip
    return line


def _parts(ax: Axes, rows: list[Row]) -> None:
    """Stack the parts of the march of auto, a bar for each scene and size."""
    floor = np.zeros(len(rows))
    for part, colour in PARTS.items():
        height = np.array([_share(row, part) for row in rows])
        ax.bar(range(len(rows)), height, 0.8, bottom=floor, color=colour, label=part)
        floor += height
    names = [f"{TITLES[row.scene].split()[0]} {_short(row)}, {row.job.motion}" for row in rows]
    ax.set_xticks(range(len(rows)), names, rotation=60, ha="right", rotation_mode="anchor",
                  fontsize=SMALL)  # fmt: skip
    ax.set_ylim(0.0, 118.0)
    ax.set_yticks(range(0, 101, 20))
    ax.set_ylabel("share of the march [%]")
    ax.legend(fontsize=SMALL, ncols=5, loc="upper center", columnspacing=0.8, handlelength=0.9)
    ax.set_title("Time of auto by part", fontsize=SMALL)


def _share(row: Row, part: str) -> float:
    """Return the share of a part of a march [%]."""
    split: dict[str, float] = row.record["split"]
    return 100.0 * split.get(part, 0.0) / sum(split.values())


def _short(row: Row) -> str:
    return f"{row.job.size:.0e}".replace("e+0", "e") if row.job.case == "chain" else size_of(row)


def _counts(ax: Axes, result: Scaling) -> None:
    """Draw corrections and factorisations per step of auto."""
    for scene, style in STYLES.items():
        rows = result.done(scene, "auto")
        x = [row.job.elements for row in rows]
        corrections = [row.record["iterations_per_step"] for row in rows]
        factors = [row.record["factorizations"] / row.job.steps for row in rows]
        ax.plot(x, corrections, style, color="black", markersize=5)
        ax.plot(x, factors, style, color="#d55e00", markersize=5)
    what = "per step; black: corrections,\norange: factorisations"
    set_axes(ax, "elements", what, title="Corrections and factorisations of auto")


def heading(result: Scaling) -> str:
    """State what is measured."""
    settings = result.settings
    return (
        f"Cost per element and step, dt = {settings['dt_s']:g} s, {settings['steps']} steps, "
        f"{instruction_set()}, the fastest of {settings['rounds']} rounds in turn, and of "
        "more where runs are short"
    )


def tables(result: Scaling) -> list[Table]:
    """Set the solvers of each scene and size, then powers and growth."""
    fits = {
        "Powers of the number of elements, from 500 on": result.slopes(),
        "Cost per element and step of auto on chains falling from rest": result.growth(),
    }
    return [
        *(_solvers(result, group) for group in result.by_size()),
        *(
            Table(["", ""], [[key, f"{value:.2f}"] for key, value in values.items()], (0,), title)
            for title, values in fits.items() if values
        ),
    ]  # fmt: skip


def _solvers(result: Scaling, group: list[Row]) -> Table:
    """Set the solvers of a scene and size, and how they compare."""
    job, title = group[0].job, TITLES[group[0].scene]
    count = next(c for c in result.counts if (c["scene"], c["size"]) == (title, job.size))
    above = (
        f"{title}, {job.size}: {job.elements} elements, {count['unknowns']} unknowns, "
        f"{count['factor_entries']} entries in L ({count['ordering']})"
    )
    compared = [f"{k} {v:.2f}" for k, v in ratios(group).items() if isinstance(v, float)]
    head = ["", "us", "it./step", "factors", "set-up s", "peak MB", "bytes/el.", "us by part"]
    return Table(head, [_line(row) for row in group], (0, 7), "\n".join([above, *compared]))


def _line(row: Row) -> list[str]:
    if row.note:
        return [row.job.solver, *[""] * 6, row.note]
    flat = row.flat()
    split = [f"{key} {value:.3f}" for key, value in flat["split_microseconds"].items()]
    return [
        row.job.solver, f"{row.microseconds:.3f}", f"{flat['iterations_per_step']:.2f}",
        f"{flat['factorizations']}", f"{flat['set_up_seconds']:.2f}",
        f"{flat['peak_megabytes']:.0f}", f"{flat['bytes_per_element']:.0f}", ", ".join(split),
    ]  # fmt: skip


def of_auto(result: Scaling) -> Table:
    """Set what auto costs and how it compares, scene by scene and size by size."""
    head = [
        "with `auto`", "elements", "us per element and step", "corrections per step",
        "factorisations", "MB at the peak", "beside best fixed", "Newton takes",
        "nearest peer takes",
    ]  # fmt: skip
    rows = []
    for group in result.by_size():
        auto = next((row for row in group if row.job.solver == "auto"), group[0])
        name = [name_of(auto), f"{auto.job.elements:,}"]
        if auto.note:
            rows.append([*name, auto.note, *[""] * 6])
            continue
        flat, compared = auto.flat(), ratios(group)
        peers = [compared[k] for peer in PEERS if (k := f"{peer.name} / auto") in compared]
        best = f"{compared['auto / best fixed']:.2f}" if "auto / best fixed" in compared else ""
        rows.append([
            *name, f"{auto.microseconds:.3g}", f"{flat['iterations_per_step']:.2f}",
            f"{flat['factorizations']} in {auto.job.steps} steps",
            f"{flat['peak_megabytes']:.0f}", best, _times(compared.get("Newton / auto")),
            _times(min(peers, default=None)),
        ])  # fmt: skip
    return Table(head, rows)


def _times(ratio: float | None) -> str:
    return "" if ratio is None else f"{ratio:.1f} times as long"


def _spread(flat: dict[str, Any]) -> dict[str, Any]:
    """Give each part of the split a column of its own."""
    split = flat.pop("split_microseconds")
    return flat | {f"{key}_microseconds": value for key, value in split.items()}


STUDY = Study(
    "scaling",
    run=scaling,
    heading=heading,
    tables=tables,
    rows=lambda result: [_spread(row.flat()) for row in result.rows],
    findings=findings,
    targets=targets,
    notes=lambda result: [str(result.roofline)],
    charts={"scaling": chart},
    regions={"scaling": of_auto},
)
