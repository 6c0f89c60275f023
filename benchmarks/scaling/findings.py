"""Findings of the scaling study, in sentences that follow from its rows."""

from __future__ import annotations

from benchmarks.common.target import Target
from benchmarks.other_codes.exudyn_scene import SETTINGS as PEERS
from benchmarks.scaling.rows import TITLES, Row, Scaling, ratios

# Auto may cost this much more than the best solver on a scene, because it tries.
MOST_OVER_FIXED = 1.2

# A peer should take so many times as long.
LEAST_OVER_PEER = 5.0

# Cost per element of the longest chain over that of one of 100,000, which fits no cache either.
GROWTH_OVER, MOST_GROWTH = 100_000, 1.5

# Memory of a chain above an idle process [bytes per element]: a million of them in 1.5 GB.
MOST_BYTES, BYTES_FROM = 1500.0, 100_000


def by_subject(result: Scaling) -> dict[str, list[Target]]:
    """Compare the study with its targets, where it ran what that takes.

    Returns
    -------
    dict
        Numbers with their targets, by what they are about.
    """
    compared = [(name_of(group[0]), ratios(group)) for group in result.by_size()]
    beside, rivals = [], []
    for name, found in compared:
        if "auto / best fixed" in found:
            ratio, best = found["auto / best fixed"], found["best fixed"]
            beside.append(Target(f"auto / {best}, {name}", ratio, MOST_OVER_FIXED, True))
        peers = {peer.name: found[k] for peer in PEERS if (k := f"{peer.name} / auto") in found}
        if peers:
            nearest = min(peers, key=lambda each: peers[each])
            rivals.append(Target(f"{nearest} / auto, {name}", peers[nearest], LEAST_OVER_PEER))
    growth = [
        Target(f"cost per element, {what}", value, MOST_GROWTH, True)
        for what, value in result.growth().items()
        if what.endswith(f"over {GROWTH_OVER:,} elements")
    ]
    memory = [
        Target(f"bytes per element, {name_of(row)}", row.bytes_per_element, MOST_BYTES, True)
        for row in result.done(("chain", "rest"), "auto")
        if row.job.elements >= BYTES_FROM
    ]
    return {
        "`auto` beside the best fixed solver of each scene and size": beside,
        "The nearest peer beside `auto`, for each scene and size": rivals,
        "Cost per element and step of the longest chain beside a shorter one": growth,
        "Bytes per element of long chains above an idle process": memory,
    }


def targets(result: Scaling) -> list[Target]:
    """Return all targets."""
    return [target for about in by_subject(result).values() for target in about]


def findings(result: Scaling) -> list[str]:
    """State what the study shows: targets first, those that are missed by name, then what grew."""
    sentences = [
        each for what, about in by_subject(result).items() for each in _verdict(what, about)
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


def _verdict(what: str, about: list[Target]) -> list[str]:
    """Sum up one kind of target, and name each that is missed."""
    if not about:
        return []
    values, missed = [t.value for t in about], [t for t in about if not t.met]
    span = f"{min(values):.3g}" + (f" to {max(values):.3g}" if len(values) > 1 else "")
    bound = "at most" if about[0].at_most else "at least"
    met = f"missed {len(missed)} of {len(about)} times" if missed else "met"
    return [
        f"{what}: {span} (target: {bound} {about[0].wanted:g}, {met}).",
        *(f"Missed: {t.what}: {t.value:.3g}." for t in missed),
    ]


def skipped(result: Scaling) -> list[str]:
    """State what has no result: scene, solver, first size, and the first clause of why."""
    sentences = []
    seen = set()
    for row in result.rows:
        if row.note and (row.scene, row.job.solver) not in seen:
            seen.add((row.scene, row.job.solver))
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
