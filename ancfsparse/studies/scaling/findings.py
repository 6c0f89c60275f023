"""Findings of the scaling study, in sentences that follow from its rows."""

from __future__ import annotations

from typing import Any

from ancfsparse.studies.common.target import Target
from ancfsparse.studies.peers.exudyn_scene import SETTINGS as PEERS
from ancfsparse.studies.scaling.rows import TITLES, Row, Scaling, ratios

# Auto may cost this much more than the best solver on a scene, because it tries.
MOST_OVER_FIXED = 1.2

# A peer should take so many times as long.
LEAST_OVER_PEER = 5.0

# Cost per element of the longest chain over that of one of 100,000, which fits no cache either.
GROWTH_OVER, MOST_GROWTH = 100_000, 1.5

# Memory of a chain above an idle process [bytes per element]: a million of them in 1.5 GB.
MOST_BYTES, BYTES_FROM = 1500.0, 100_000


def aims(result: Scaling) -> dict[str, list[Target]]:
    """Compare the study with its targets, where it ran what that takes.

    Returns
    -------
    dict
        Numbers with their aims, by what they are about.
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
    return [target for about in aims(result).values() for target in about]


def findings(result: Scaling) -> list[str]:
    """State what the study shows: aims first, those that are missed by name, then what grew."""
    sentences = [each for what, about in aims(result).items() for each in _verdict(what, about)]
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
    """Sum up one kind of aim, and name each that is missed."""
    if not about:
        return []
    values, missed = [t.value for t in about], [t for t in about if not t.met]
    span = f"{min(values):.3g}" + (f" to {max(values):.3g}" if len(values) > 1 else "")
    bound = "at most" if about[0].at_most else "at least"
    met = f"missed {len(missed)} of {len(about)} times" if missed else "met"
    return [
        f"{what}: {span} (aim: {bound} {about[0].wanted:g}, {met}).",
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


def headline(result: Scaling) -> str:
    """State how the cost of the longest chain compares with that of one that fits the caches."""
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


def cost_title(result: Scaling, scene: tuple[str, str]) -> str:
    """Name the nearest rival of auto at the largest size where both have a result."""
    groups = [group for group in result.by_size() if group[0].scene == scene]
    title = TITLES[scene].capitalize()
    for names in ([peer.name for peer in PEERS], ["Newton"]):
        for group in reversed(groups):
            found = ratios(group)
            rivals = {name: found[k] for name in names if (k := f"{name} / auto") in found}
            if rivals:
                name = min(rivals, key=lambda each: rivals[each])
                return (
                    f"{title}: {name} takes {rivals[name]:.1f} times as long as auto at "
                    f"{size_of(group[0])}"
                )
    return title


def memory_title(result: Scaling) -> str:
    """State how memory grows."""
    slopes = [f"{value:.2f}" for key, value in result.slopes().items() if "memory" in key]
    text = "Memory of auto above an idle process"
    return f"{text} grows with the elements to the power {', '.join(slopes)}" if slopes else text


def split_title(rows: list[Row]) -> str:
    """Name the largest part of auto's time on the largest of the scenes."""
    if not rows:
        return "Time of auto by part"
    row = max(rows, key=lambda each: each.job.elements)
    shares = shares_of(row)
    part = max(shares, key=lambda each: shares[each])
    return f"Auto spends {shares[part]:.0f} % on {part} in the {name_of(row)}"


def shares_of(row: Row) -> dict[str, float]:
    """Return the shares of the parts of a march [%]."""
    split: dict[str, Any] = row.record["split"]
    whole = sum(split.values())
    return {part: 100.0 * seconds / whole for part, seconds in split.items()}


def count_title(rows: list[Row]) -> str:
    """State the bounds of the corrections and factorisations of auto."""
    if not rows:
        return "Corrections and factorisations of auto"
    corrections = [row.record["iterations_per_step"] for row in rows]
    each = [row.job.steps / max(row.record["factorizations"], 1) for row in rows]
    return (
        f"Auto corrects {min(corrections):.1f} to {max(corrections):.1f} times per step and "
        f"factors once in {min(each):.0f} to {max(each):.0f} steps"
    )
