"""Cost per step and element, and memory, against the size of chains and nets."""

from __future__ import annotations

import math
from contextlib import ExitStack
from dataclasses import replace
from typing import Annotated, Any

import typer

from ancfsparse.checks import check_positive
from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.timing import in_turn
from benchmarks.common.worker import Worker
from benchmarks.other_codes.exudyn import load
from benchmarks.other_codes.exudyn_scene import SETTINGS as OTHERS
from benchmarks.scaling.roofline import roofline
from benchmarks.scaling.rows import TITLES, Row, Scaling
from benchmarks.scaling.scaling_job import MIN_TIME, PROGRAM, SOLVERS, Job, counts

DT = 5e-4  # time step [s]
CHAINS = (10, 100, 1000, 10_000, 100_000, 1_000_000)
NETS = (10, 30, 60, 100, 200)

GROWTH = {"chain": 1.0, "net": 1.5}  # exponents of the elements in the time of a run
# Counts to which the time of a part is proportional; other parts grow as the elements.
GROWS_WITH = {"factor": "factor_flops", "solve": "factor_entries"}

MAX_REPEATS = 5  # of the rounds of short runs
MIN_TOTAL_TIME = 1.0  # of the rounds of a run [s]
LIMIT_RATIO = 5.0  # time at which a run is ended, over the cap


def scaling(
    largest: Annotated[int, typer.Option(min=1, help="Elements of the longest chain.")] = 100_000,
    steps: Annotated[int, typer.Option(min=1, help=f"Time steps of {DT:g} s.")] = 100,
    largest_net: Annotated[
        int, typer.Option(min=2, help="Nodes along a side of the largest net.")
    ] = 60,
    nets: Annotated[bool, typer.Option(help="Run nets.")] = True,
    peers: Annotated[bool, typer.Option("--peers", help="Run Exudyn too.")] = False,
    rounds: Annotated[int, typer.Option(min=1, help="Interleaved rounds of each solver.")] = 3,
    cap: Annotated[float, typer.Option(help="Omit runs expected to take longer [s].")] = 60.0,
    threads: Annotated[
        int, typer.Option(min=1, help="If more than 1, auto on this number of threads too.")
    ] = 1,
    progress: bool = False,
) -> Scaling:
    """Measure cost per element and step, and memory, against size, and the roofline.

    Each solver has a process of its own for each size; on one size the solvers run in turn, round
    by round, so that a busy moment of the machine hits them alike.  Short runs have up to
    `MAX_REPEATS` times as many rounds.  A run that is expected to take longer than `cap` seconds,
    from the next smaller size, is omitted, and one that takes `LIMIT_RATIO` times as long is ended.
    """
    check_positive("cap", cap, "s")
    settings: dict[str, Any] = {"dt_s": DT, "steps": steps, "rounds": rounds, "cap_s": cap}
    if peers:
        settings["exudyn"] = load().__version__
    names = [*SOLVERS, *(other.name for other in OTHERS if peers)]
    plan = [
        Job(*scene[:1], size, scene[1], "", steps, DT)
        for scene in TITLES
        for size in (_chains(largest) if scene[0] == "chain" else _nets(largest_net if nets else 0))
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
            _run_in_turn([row for row in group if not row.note], rounds, LIMIT_RATIO * cap)
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


def rounds_of(seconds: float, rounds: int) -> int:
    """Return the number of rounds of a run that takes this time [s]."""
    wanted = math.ceil(MIN_TOTAL_TIME / max(seconds, MIN_TIME))
    return max(rounds, min(wanted, MAX_REPEATS * rounds))


def _run_in_turn(rows: list[Row], rounds: int, limit: float) -> None:
    """Run all rows in turn, each in its own process; short ones more often."""

    def run(candidate: tuple[Row, Worker]) -> None:
        row, worker = candidate
        row.record = worker.run(row.job, limit)
        if not row.note:
            row.seconds.append(row.record["seconds"])

    def goes_on(candidate: tuple[Row, Worker], runs: list[None]) -> bool:
        row, done = candidate[0], len(runs)
        return not row.note and (done < rounds or done < rounds_of(row.fastest, rounds))

    with ExitStack() as stack:
        candidates = [(row, stack.enter_context(Worker(PROGRAM))) for row in rows]
        in_turn(candidates, run, MAX_REPEATS * rounds, goes_on=goes_on)
