"""The scaling study as text, CSV and JSON, and a table for a page."""

from __future__ import annotations

from typing import Any

from ancfsparse.dispatch import instruction_set
from ancfsparse.studies.common.study import Study
from ancfsparse.studies.common.tables import table, with_findings
from ancfsparse.studies.peers.exudyn_scene import SETTINGS as PEERS
from ancfsparse.studies.scaling.charts import chart
from ancfsparse.studies.scaling.findings import findings, name_of, targets
from ancfsparse.studies.scaling.rows import TITLES, Row, Scaling, ratios
from ancfsparse.studies.scaling.run import scaling


def as_text(result: Scaling) -> str:
    """Set the tables for a terminal: a block per scene, a line per size and solver."""
    settings = result.settings
    lines = [
        f"Cost per element and step, dt = {settings['dt_s']:g} s, {settings['steps']} steps, "
        f"{instruction_set()}, the fastest of {settings['rounds']} rounds in turn, and of "
        "more where runs are short"
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
    lines += ["", *map(str, targets(result))]
    return "\n".join([*lines, "", *findings(result), "", str(result.roofline)])


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


def as_markdown(result: Scaling) -> str:
    """Set what auto costs and how it compares, scene by scene and size by size, for a page."""
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
    return with_findings(table(head, rows), findings(result))


def _times(ratio: float | None) -> str:
    return "" if ratio is None else f"{ratio:.1f} times as long"


def _spread(flat: dict[str, Any]) -> dict[str, Any]:
    """Give each part of the split a column of its own."""
    split = flat.pop("split_microseconds")
    return flat | {f"{key}_microseconds": value for key, value in split.items()}


STUDY = Study(
    "scaling",
    run=scaling,
    text=as_text,
    rows=lambda result: [_spread(row.flat()) for row in result.rows],
    record=Scaling.record,
    findings=findings,
    targets=targets,
    charts={"scaling": chart},
    regions={"scaling": as_markdown},
)
