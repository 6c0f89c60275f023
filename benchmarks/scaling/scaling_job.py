"""One run of a scaling study, in a process of its own."""

from __future__ import annotations

import time
from dataclasses import dataclass
from statistics import median
from typing import Any, cast

from ancfsparse.errors import InputError, StepError
from ancfsparse.integrators import Newmark
from ancfsparse.nonlinear import Method
from ancfsparse.problems import chain, net
from ancfsparse.results import RunStats
from ancfsparse.scene import Beam, Scene
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve import simulate
from ancfsparse.system import System
from benchmarks.common import methods
from benchmarks.common.methods import chosen
from benchmarks.common.worker import peak_memory, serve
from benchmarks.other_codes.exudyn import ExudynError
from benchmarks.other_codes.exudyn_scene import SETTINGS as OTHERS, time_exudyn

SOLVERS: dict[str, Method | str] = {
    **chosen(methods.SOLVERS, "auto", "Newton", "modified Newton"),
    "Broyden, 10 pairs": methods.SOLVERS["broyden, 10 pairs"],
    "Davidon, dense": methods.SOLVERS["davidon, full"],
}
"""Solvers of this package; the last is the paper's, a full matrix."""

PROGRAM = __name__
"""Module that a `Worker` runs."""

MIN_TIME = 0.1  # of a run with its repetitions [s]


@dataclass(frozen=True)
class Job:
    """One scene, one solver."""

    case: str  # {"chain", "net"}, the scene
    size: int  # elements of the chain, or nodes along a side of the net
    motion: str  # as in `problems.chain`
    # A name in `SOLVERS`, or of a setting of Exudyn, or that of auto on several threads
    solver: str
    steps: int  # time steps
    dt: float  # their length [s]
    threads: int = 1  # threads that may share the work

    def scene(self) -> Scene:
        """Build the scene."""
        return (chain if self.case == "chain" else net)(self.size, self.motion).scene

    @property
    def elements(self) -> int:
        """Number of elements."""
        return self.size if self.case == "chain" else 2 * self.size * (self.size - 1)


def run(job: Job, base: int) -> dict[str, Any]:
    """Run a job in this process.

    Returns
    -------
    dict
        ``seconds`` of the time loop and ``set_up_seconds`` before it, from the scene on [s],
        ``iterations_per_step``, ``factorizations``, ``recoveries``, ``split`` by part [s],
        ``peak_bytes`` of the process and ``base_bytes``; or ``note``, why there is nothing to
        report.
    """
    try:
        for setting in OTHERS:
            if job.solver == setting.name:
                record: dict[str, Any] = time_exudyn(job.scene(), setting, job.dt, job.steps)
                return record | {"base_bytes": base, "peak_bytes": peak_memory()}
        return _ours(job) | {"base_bytes": base, "peak_bytes": peak_memory()}
    except (InputError, StepError, ExudynError, MemoryError) as error:
        return {"note": str(error) or type(error).__name__}


def _ours(job: Job) -> dict[str, Any]:
    runs: list[RunStats] = []
    set_ups: list[float] = []
    first = time.perf_counter()
    while not runs or time.perf_counter() - first < MIN_TIME:
        begin = time.perf_counter()
        scene = job.scene()
        end = cast(Beam, scene.beams[0]).end  # chains and nets are made of beams
        built = time.perf_counter() - begin
        stats = simulate(
            scene,
            job.steps * job.dt,
            job.dt,
            integrator=Newmark(0.0),  # as Exudyn
            solver=SOLVERS["auto" if job.threads > 1 else job.solver],
            threads=job.threads,
            save_every=job.steps,
            save_nodes=[end],
        ).stats
        runs.append(stats)
        set_ups.append(built + stats.seconds["set-up"])
    parts = [key for key in stats.seconds if key != "set-up"]
    return {
        "seconds": median(each.march_seconds for each in runs),
        "set_up_seconds": median(set_ups),
        "iterations_per_step": stats.iterations_per_step,
        "factorizations": stats.factorizations,
        "recoveries": stats.recoveries,
        "split": {key: median(each.seconds[key] for each in runs) for key in parts},
        "chosen": stats.solver,
    }


def counts(scene: Scene) -> dict[str, Any]:
    """Count what grows with a scene: unknowns, entries of the pattern and of L, operations."""
    system = System(scene)
    seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
    return {
        "unknowns": seed.n,
        "pattern_entries": system.pattern.n_values,
        "factor_entries": seed.nnz,
        "factor_flops": seed.factor_flops,
        "ordering": seed.ordering,
    }


if __name__ == "__main__":
    run(Job("chain", 2, "rest", "auto", 1, 5e-4), 0)  # whatever is loaded once only
    idle = peak_memory()
    serve(lambda job: run(Job(**job), idle))
