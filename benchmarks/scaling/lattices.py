"""Time, memory and counts of each run of nets, lattices and trusses, in a process of its own."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Annotated, Any

import typer

from ancfsparse.errors import EquilibriumError, InputError, StepError
from ancfsparse.problems import lattice
from ancfsparse.solve import simulate, solve_static
from ancfsparse.solve.preparation.choose_factorization import unknown_groups
from ancfsparse.system import System
from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.worker import Answered, Worker, peak_memory, serve
from benchmarks.scaling.lattice_jobs import Job, jobs_of

MIN_TIME = 1.0  # of a run that is not repeated [s]
MAX_ROUNDS = 3  # of a short run, whose fastest round counts
TURNS = 2  # interleaved runs on one and on more threads
MAX_FILL = 1e4  # blocks of a complete factor per block of the matrix up to which they are counted


class Row(Answered):
    """A job with its answer."""

    @property
    def inner(self) -> float:
        """Sweeps and products with the matrix per step."""
        return float(self.record["sweeps"] + self.record["products"])

    def flat(self) -> dict[str, Any]:
        """Return the entries of the CSV table."""
        line = asdict(self.job) | {"elements": self.job.elements, "note": self.note}
        if self.note:
            return line
        line |= {"microseconds": self.microseconds, "bytes_per_element": self.bytes_per_element}
        return line | {k: v for k, v in self.record.items() if not isinstance(v, dict)}


def lattices(
    largest: Annotated[
        int, typer.Option(min=2, help="Nodes along a side of the largest lattice.")
    ] = 22,
    largest_net: Annotated[
        int, typer.Option(min=2, help="Nodes along a side of the largest net.")
    ] = 100,
    largest_exact: Annotated[
        int,
        typer.Option(min=0, help="Nodes along a side of the largest lattice on complete seeds."),
    ] = 16,
    steps: Annotated[int, typer.Option(min=1, help="Time steps.")] = 20,
    threads: Annotated[
        int, typer.Option(min=1, help="Threads of a further run of the largest lattice.")
    ] = 1,
    progress: bool = False,
) -> list[Row]:
    """Measure complete and incomplete seeds on lattices and nets: time, memory and counts by size.

    Sizes are numbers of nodes along a side: before the largest come those of `jobs.LATTICES` and
    `jobs.NETS` that are smaller, and octet trusses are those of `jobs.OCTETS` with as many
    elements.  Each run has a process of its own.
    """
    jobs = jobs_of(largest, largest_net, largest_exact, steps, threads)
    rows = []
    with progress_bar(jobs, "run", progress) as bar:
        for job in bar:
            bar.set_description(f"{job.title}, {job.size}, {job.factorization}")
            rows.append(Row(job, in_process(job)))
    _again_in_turn(rows)
    return rows


def in_process(job: Job) -> dict[str, Any]:
    """Run a job in a process of its own; one that ends without an answer leaves a note."""
    with Worker(__name__) as worker:
        return worker.run(job)


def run(job: Job) -> dict[str, Any]:
    """Run a job in this process.

    Returns
    -------
    dict
        ``seconds`` of the time loop and ``set_up_seconds`` before it, the scene included [s];
        ``corrections``, ``sweeps``, ``products`` per step; ``factorizations``, ``recoveries``;
        ``peak_bytes`` and ``base_bytes`` of the process; with complete seeds ``fill``, blocks of
        the factor for each of the matrix; or ``note``, the reason without result.
    """
    simulate(lattice(2).scene, 1e-3, 1e-3, factorization="incomplete")  # loads modules on demand
    base = peak_memory()
    try:
        record = _statics(job) if job.case == "statics" else _march(job)
    except (InputError, StepError, EquilibriumError, MemoryError) as error:
        return {"note": str(error) or type(error).__name__}
    record |= {"peak_bytes": peak_memory(), "base_bytes": base}
    if job.factorization == "complete" and job.case != "statics":
        record["fill"] = _fill(job)
    return record


def _march(job: Job) -> dict[str, Any]:
    """Run the steps of a job; short ones again, and the fastest counts."""
    best: dict[str, Any] = {}
    for _ in range(MAX_ROUNDS):
        begin = time.perf_counter()
        scene = job.scene()
        built, t_end = time.perf_counter() - begin, job.steps * job.dt
        stats = simulate(
            scene,
            t_end,
            job.dt,
            factorization=job.factorization,
            save_every=job.steps,
            save_nodes=[scene.beams[0].node(0)],
            threads=job.threads,
        ).stats
        set_up = built + stats.seconds["set-up"]
        if not best or stats.march_seconds < best["seconds"]:
            best = {
                "seconds": stats.march_seconds,
                "corrections": stats.iterations_per_step,
                "sweeps": stats.sweeps / stats.steps,
                "products": stats.products / stats.steps,
                "factorizations": stats.factorizations,
                "recoveries": stats.recoveries,
                "set_up_seconds": min(set_up, best.get("set_up_seconds", set_up)),
            }
        if time.perf_counter() - begin > MIN_TIME:
            break
    return best


def _statics(job: Job) -> dict[str, Any]:
    """Find the equilibrium of a job."""
    scene, begin = job.scene(), time.perf_counter()
    stats = solve_static(scene, factorization=job.factorization).stats
    return {
        "seconds": time.perf_counter() - begin,
        "set_up_seconds": 0.0,
        "corrections": float(stats.iterations),
        "sweeps": float(stats.sweeps),
        "products": float(stats.products),
        "factorizations": stats.factorizations,
        "recoveries": 0,
    }


def _fill(job: Job) -> float:
    """Return the fill of a complete factor, blocks per block of the matrix; NaN if too large."""
    groups = unknown_groups(System(job.scene()))
    fill = groups.exact_fill(MAX_FILL)
    return math.nan if fill is None else fill.nnz / groups.nnz


def pairs(rows: Sequence[Row]) -> list[tuple[Row, Row]]:
    """Return the runs with results on both kinds of seeds, complete first."""
    by_scene: dict[tuple[str, int], dict[str, Row]] = {}
    for row in rows:
        if not row.note and row.job.threads == 1:
            by_scene.setdefault((row.job.title, row.job.size), {})[row.job.factorization] = row
    return [(both["complete"], both["incomplete"]) for both in by_scene.values() if len(both) == 2]


def threaded(rows: Sequence[Row]) -> list[tuple[Row, Row]]:
    """Return pairs of rows of the same run on one and on more threads."""

    def key(row: Row) -> Job:
        job: Job = row.job
        return replace(job, steps=0, threads=1)

    ones = {key(row): row for row in rows if row.job.threads == 1 and not row.note}
    return [
        (ones[key(row)], row)
        for row in rows
        if row.job.threads > 1 and not row.note and key(row) in ones
    ]


def _again_in_turn(rows: Sequence[Row]) -> None:
    """Repeat the runs compared by threads, in turn; the fastest counts."""
    for both in threaded(rows):
        for row in TURNS * both:
            record = in_process(row.job)
            if record.get("seconds", math.inf) < row.record["seconds"]:
                row.record = record


if __name__ == "__main__":
    serve(lambda job: run(Job(**job)))
