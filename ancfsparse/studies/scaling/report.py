"""The scaling study as text, CSV and JSON, and a table for a page."""

from __future__ import annotations

from typing import Any

from ancfsparse.dispatch import instruction_set
from ancfsparse.studies.common.study import Study
from ancfsparse.studies.common.tables import Table
from ancfsparse.studies.peers.exudyn_scene import SETTINGS as PEERS
from ancfsparse.studies.scaling.charts import chart
from ancfsparse.studies.scaling.findings import findings, name_of, targets
from ancfsparse.studies.scaling.rows import TITLES, Row, Scaling, ratios
from ancfsparse.studies.scaling.run import scaling


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
    record=Scaling.record,
    findings=findings,
    targets=targets,
    notes=lambda result: [str(result.roofline)],
    charts={"scaling": chart},
    regions={"scaling": of_auto},
)
