"""Targets and findings of the scaling study."""

from __future__ import annotations

from benchmarks.common.target import Target
from benchmarks.other_codes.exudyn_scene import SETTINGS as OTHERS
from benchmarks.scaling.rows import TITLES, Row, Scaling, ratios

MAX_AUTO_RATIO = 1.2  # time of auto, which tries solvers, over that of the best fixed one
MIN_OTHER_RATIO = 5.0  # time of another code over that of auto
LARGE_CHAIN = 100_000  # elements, which fit no cache
MAX_GROWTH = 1.5  # cost per element of the longest chain over that of a large one
MAX_BYTES = 1500.0  # per element of a large chain above an idle process: a million in 1.5 GB


def group_by_subject(result: Scaling) -> dict[str, list[Target]]:
    """Return the targets of the runs that were made, by subject."""
    compared = [(name_of(group[0]), ratios(group)) for group in result.by_size()]
    autos, others = [], []
    for name, entries in compared:
        if "auto / best fixed" in entries:
            ratio, best = entries["auto / best fixed"], entries["best fixed"]
            autos.append(Target(f"auto / {best}, {name}", ratio, MAX_AUTO_RATIO, True))
        known = {p.name: entries[k] for p in OTHERS if (k := f"{p.name} / auto") in entries}
        if known:
            fastest = min(known, key=lambda each: known[each])
            others.append(Target(f"{fastest} / auto, {name}", known[fastest], MIN_OTHER_RATIO))
    growth = [
        Target(f"cost per element, {what}", value, MAX_GROWTH, True)
        for what, value in result.growth().items()
        if what.endswith(f"over {LARGE_CHAIN:,} elements")
    ]
    memory = [
        Target(f"bytes per element, {name_of(row)}", row.bytes_per_element, MAX_BYTES, True)
        for row in result.done(("chain", "rest"), "auto")
        if row.job.elements >= LARGE_CHAIN
    ]
    return {
        "`auto` over the best fixed solver of each scene and size": autos,
        "The fastest other code over `auto`, for each scene and size": others,
        "Cost per element and step of the longest chain over a shorter one": growth,
        "Bytes per element of long chains above an idle process": memory,
    }


def targets(result: Scaling) -> list[Target]:
    """Return all targets."""
    return [target for group in group_by_subject(result).values() for target in group]


def findings(result: Scaling) -> list[str]:
    """State the targets, those that are missed by name, then growth, threads and missing runs."""
    sentences = [
        each
        for subject, group in group_by_subject(result).items()
        for each in _summary(subject, group)
    ]
    sentences += [
        f"A step of {what} costs {value:.2g} times as much per element with `auto`."
        for what, value in result.growth().items()
    ]
    for group in result.by_size():
        sentences += [
            f"{name_of(group[0]).capitalize()}: {what} is {value:.2f}."
            for what, value in ratios(group).items()
            if what.startswith("gain of")
        ]
    return sentences + [f"Without result: {each}." for each in skipped(result)]


def _summary(subject: str, group: list[Target]) -> list[str]:
    """Sum up the targets of one subject, and name each that is missed."""
    if not group:
        return []
    values, missed = [t.value for t in group], [t for t in group if not t.is_met]
    span = f"{min(values):.3g}" + (f" to {max(values):.3g}" if len(values) > 1 else "")
    result = f"missed {len(missed)} of {len(group)} times" if missed else "met"
    return [
        f"{subject}: {span} (target: {group[0].side} {group[0].bound:g}, {result}).",
        *(f"Missed: {t.what}: {t.value:.3g}." for t in missed),
    ]


def skipped(result: Scaling) -> list[str]:
    """State missing results: scene, solver, first size, and the first clause of the reason."""
    sentences = []
    reported = set()
    for row in result.rows:
        if row.note and (row.scene, row.job.solver) not in reported:
            reported.add((row.scene, row.job.solver))
            why = row.note.partition(":")[0].partition(";")[0]
            sentences.append(
                f"{TITLES[row.scene]}, {row.job.solver}, from {size_of(row)} on: {why}"
            )
    return sentences


def size_of(row: Row) -> str:
    """Write a size: elements of a chain, nodes of a net."""
    size = f"{row.job.size:,}"
    return f"{size} x {size}" if row.job.case == "net" else size


def name_of(row: Row) -> str:
    """Write a scene and a size."""
    return f"{TITLES[row.scene]}, {size_of(row)}"
