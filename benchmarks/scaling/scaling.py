"""Cost per step and element, and memory, against the size of chains and nets."""

from __future__ import annotations

import math
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.timing import in_turn
from benchmarks.common.worker import Worker
from benchmarks.other_codes.exudyn import load
from benchmarks.other_codes.exudyn_scene import SETTINGS as PEERS
from benchmarks.scaling.roofline import roofline
from benchmarks.scaling.rows import TITLES, Row, Scaling
from benchmarks.scaling.scaling_job import PROGRAM, SHORT, SOLVERS, Job, counts

DT = 5e-4
CHAINS = (10, 100, 1000, 10_000, 100_000, 1_000_000)
NETS = (10, 30, 60, 100, 200)

# A run of which only the whole is known grows with this power of the elements.
GROWTH = {"chain": 1.0, "net": 1.5}
# Where the parts are known, each grows as what it works on; the others as the elements.
GROWS_WITH = {"factor": "factor_flops", "solve": "factor_entries"}

# Rounds of short runs are repeated up to so many times, until they last this long [s].
MORE, ENOUGH = 5, 1.0

# A run that takes so many times the cap, set-up included, is ended.
PATIENCE = 5.0


def scaling(
    largest: int = 100_000,
    steps: int = 100,
    largest_net: int = 60,
    peers: bool = False,
    rounds: int = 3,
    cap: float = 60.0,
    progress: bool = False,
    threads: int = 1,
) -> Scaling:
    """Run all solvers on chains of up to `largest` elements and nets, from ten on.

    Each solver has a process of its own for each size; on one size the solvers run in turn, round
    by round, so that a busy moment of the machine hits them alike.  Short runs have up to `MORE`
    times as many rounds.  A net has up to `largest_net` nodes along a side; 0 runs none.  A run
    that is expected to take longer than `cap` seconds, from the size before, is left out, and one
    that takes `PATIENCE` times as long is ended.
    """
    settings: dict[str, Any] = {"dt_s": DT, "steps": steps, "rounds": rounds, "cap_s": cap}
    if peers:
        settings["exudyn"] = load().__version__
    names = [*SOLVERS, *(peer.name for peer in PEERS if peers)]
    plan = [
        Job(*scene[:1], size, scene[1], "", steps, DT)
        for scene in TITLES
        for size in (_chains(largest) if scene[0] == "chain" else _nets(largest_net))
    ]
    before: dict[tuple[tuple[str, str], str], Row] = {}
    rows: list[Row] = []
    table: dict[tuple[str, str, int], dict[str, Any]] = {}
    with progress_bar(plan, "scene", progress) as bar:
        for job in bar:
            bar.set_description(f"{job.case} {job.size}, {job.motion}")
            here = {"scene": TITLES[job.case, job.motion], "size": job.size}
            table[_key(job)] = here | {"elements": job.elements} | counts(job.scene())
            group = [Row(replace(job, solver=name)) for name in names]
            if threads > 1:
                group.append(Row(replace(job, solver=on_threads(threads), threads=threads)))
            for row in group:
                smaller = before.get((row.scene, row.job.solver))
                if smaller is not None:
                    sizes = table[_key(smaller.job)], table[_key(job)]
                    row.record = leave_out(row.job, smaller, *sizes, cap)
            _race([row for row in group if not row.note], rounds, PATIENCE * cap)
            before |= {(row.scene, row.job.solver): row for row in group}
            rows += group
    return Scaling(rows, list(table.values()), roofline(max(_chains(largest))), settings)


def on_threads(threads: int) -> str:
    """Name auto on several threads."""
    return f"auto, {threads} threads"


def _key(job: Job) -> tuple[str, str, int]:
    return job.case, job.motion, job.size


def _chains(largest: int) -> list[int]:
    return sorted({each for each in CHAINS if each < largest} | {largest})


def _nets(largest: int) -> list[int]:
    return sorted({each for each in NETS if each < largest} | {largest} - {0})


def leave_out(
    job: Job, before: Row, counts_before: dict[str, Any], counts_now: dict[str, Any], cap: float
) -> dict[str, Any]:
    """Return a note if a run is ruled out by that of the size before, or nothing.

    The counts of both sizes are those of `worker.counts`; the longest run, set-up included, takes
    `cap` seconds.
    """
    if before.note:
        known = before.note.startswith("from ")
        return {"note": before.note if known else f"from {before.job.size} on: {before.note}"}
    larger = job.elements / before.job.elements
    split = before.record.get("split") or {}
    if len(split) > 1:
        expected = sum(
            seconds * (counts_now[what] / counts_before[what] if what else larger)
            for part, seconds in split.items()
            for what in [GROWS_WITH.get(part)]
        )
    else:
        expected = before.fastest * larger ** GROWTH[job.case]
    expected += larger * before.record["set_up_seconds"]
    if expected <= cap:
        return {}
    return {"note": f"{expected:.0f} s expected, above the cap of {cap:g} s"}


def enough(seconds: float, rounds: int) -> int:
    """Return how many rounds to run of one that takes so long [s]."""
    wanted = math.ceil(ENOUGH / max(seconds, SHORT))
    return max(rounds, min(wanted, MORE * rounds))


def _race(rows: list[Row], rounds: int, limit: float) -> None:
    """Run all rows in turn, each in its own process; those that are short once more, and more."""

    def run(entrant: tuple[Row, Worker]) -> None:
        row, worker = entrant
        row.record = worker.run(row.job, limit)
        if not row.note:
            row.seconds.append(row.record["seconds"])

    def goes_on(entrant: tuple[Row, Worker], runs: list[None]) -> bool:
        row, done = entrant[0], len(runs)
        return not row.note and (done < rounds or done < enough(row.fastest, rounds))

    with ExitStack() as stack:
        entrants = [(row, stack.enter_context(Worker(PROGRAM))) for row in rows]
        in_turn(entrants, run, MORE * rounds, goes_on=goes_on)
