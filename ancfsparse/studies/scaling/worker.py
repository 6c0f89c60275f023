"""One run of a scaling study: what is run, and a process of its own to run it in.

A process of its own because only then is its peak memory that of the run.  It reads jobs, one JSON
object per line, and answers each with the record of the run.
"""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from statistics import median
from types import TracebackType
from typing import Any, Self, cast

from ancfsparse.errors import InputError, StepFailure
from ancfsparse.integrators import Newmark
from ancfsparse.nonlinear import Method
from ancfsparse.problems import chain, net
from ancfsparse.results import RunStats
from ancfsparse.scene import Beam, Scene
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve import simulate
from ancfsparse.studies.common import methods
from ancfsparse.studies.common.methods import chosen
from ancfsparse.studies.common.process import peak_memory
from ancfsparse.studies.peers.exudyn import ExudynError
from ancfsparse.studies.peers.exudyn_scene import SETTINGS as PEERS
from ancfsparse.studies.peers.exudyn_scene import march_exudyn
from ancfsparse.system import System

SOLVERS: dict[str, Method | str] = {
    **chosen(methods.SOLVERS, "auto", "Newton", "modified Newton"),
    "Broyden, 10 pairs": methods.SOLVERS["broyden, 10 pairs"],
    "Davidon, dense": methods.SOLVERS["davidon, full"],
}
"""Ours; the last is the paper's, a full matrix."""

# A run shorter than this is repeated until this much time has gone by [s].
SHORT = 0.1


@dataclass(frozen=True)
class Job:
    """One scene, one solver.

    Attributes
    ----------
    case : {"chain", "net"}
        The scene.
    size : int
        Elements of the chain, or nodes along a side of the net.
    motion : str
        As in `problems.chain`.
    solver : str
        A name in `SOLVERS`, or of a setting of Exudyn, or that of auto on several threads.
    steps : int
        Time steps.
    dt : float
        Their length [s].
    threads : int
        How many may share the work.
    """

    case: str
    size: int
    motion: str
    solver: str
    steps: int
    dt: float
    threads: int = 1

    def scene(self) -> Scene:
        """Build the scene."""
        return (chain if self.case == "chain" else net)(self.size, self.motion).scene

    @property
    def elements(self) -> int:
        """Number of elements."""
        return self.size if self.case == "chain" else 2 * self.size * (self.size - 1)


def run(job: Job, base: int) -> dict[str, Any]:
    """Run a job in this process.

    Parameters
    ----------
    job : Job
        What to run.
    base : int
        Peak memory of this process before it was given jobs [bytes].

    Returns
    -------
    dict
        ``seconds`` of the march and ``set_up_seconds`` before it, from the scene on [s],
        ``iterations_per_step``, ``factorizations``, ``recoveries``, ``split`` by part [s],
        ``peak_bytes`` of the process and ``base_bytes``; or ``note``, why there is nothing to
        report.
    """
    try:
        for setting in PEERS:
            if job.solver == setting.name:
                record: dict[str, Any] = march_exudyn(job.scene(), setting, job.dt, job.steps)
                return record | {"base_bytes": base, "peak_bytes": peak_memory()}
        return _ours(job) | {"base_bytes": base, "peak_bytes": peak_memory()}
    except (InputError, StepFailure, ExudynError, MemoryError) as error:
        return {"note": str(error) or type(error).__name__}


def _ours(job: Job) -> dict[str, Any]:
    runs: list[RunStats] = []
    set_ups: list[float] = []
    first = time.perf_counter()
    while not runs or time.perf_counter() - first < SHORT:
        begin = time.perf_counter()
        scene = job.scene()
        end = cast(Beam, scene.beams[0]).end  # chains and nets are made of beams
        built = time.perf_counter() - begin
        stats = simulate(
            scene,
            job.steps * job.dt,
            job.dt,
            integrator=Newmark(0.0),  # as the peer
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


class Worker:
    """A process that runs jobs one by one, as a context manager."""

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        )

    def __enter__(self) -> Self:
        """Return the worker."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the process."""
        if kind is not None:
            self.process.kill()
        self.process.communicate()

    def run(self, job: Job, limit: float | None = None) -> dict[str, Any]:
        """Run a job; a process that crashes, or is ended, leaves a note in place of its record.

        Parameters
        ----------
        job : Job
            What to run.
        limit : float, optional
            After so long [s] the process is ended.
        """
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        try:
            self.process.stdin.write(json.dumps(asdict(job)) + "\n")
            self.process.stdin.flush()
            # One answer per job and none before it, so nothing waits in the buffer of the file.
            if not select.select([self.process.stdout], [], [], limit)[0]:
                self.process.kill()
                self.process.wait()
                return {"note": f"ended after {limit:g} s"}
            answer = self.process.stdout.readline()
        except BrokenPipeError:
            answer = ""
        if not answer:
            return {"note": f"the process ended with exit code {self.process.wait()}"}
        record: dict[str, Any] = json.loads(answer)
        return record


def serve() -> None:
    """Answer jobs on stdin until it ends; whatever else is printed is thrown away."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    run(Job("chain", 2, "rest", "auto", 1, 5e-4), 0)  # whatever is loaded once only
    base = peak_memory()
    for line in sys.stdin:
        answers.write(json.dumps(run(Job(**json.loads(line)), base)) + "\n")
        answers.flush()


if __name__ == "__main__":
    serve()
