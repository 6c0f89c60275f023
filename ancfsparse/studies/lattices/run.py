"""Exact and incomplete seeds on nets, lattices and trusses: time, memory and counts by size."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from ancfsparse.errors import InputError, StepFailure
from ancfsparse.problems import lattice, net, octet
from ancfsparse.problems.meshes import STIFF
from ancfsparse.scene import Scene
from ancfsparse.solve import simulate
from ancfsparse.studies.common.process import peak_memory
from ancfsparse.studies.common.progress import bar as progress_bar

LATTICES, NETS = (10, 16, 22, 30, 46, 64), (30, 60, 100, 200)
OCTETS = {4: 10, 8: 16, 11: 22, 15: 30, 23: 46, 32: 64}
"""Cells along a side of octet trusses, and of the lattice with about as many elements."""

# What is run of each lattice and truss: stiffness, motion, step [s].
RUNS = (
    ("soft", "rest", 1e-3),
    ("soft", "rough", 1e-3),
    ("steel", "rest", 1e-3),
    ("steel", "rest", 4e-3),
    ("steel", "rest", 1e-2),
)
# Nets as in the study of scaling: their own cable, at rest.
NET_RUN = ("soft", "rest", 5e-4)


@dataclass(frozen=True)
class Job:
    """One run.

    Attributes
    ----------
    case : {"lattice", "net", "octet"}
        The scene.
    size : int
        Nodes along a side; of an octet truss, cells.
    stiff, motion : str
        A name in `STIFF`, and a motion as in `problems.lattice`.
    dt : float
        Step [s].
    steps : int
        How many.
    seed : {"exact", "incomplete"}
        What corrections are solved with.
    """

    case: str
    size: int
    stiff: str
    motion: str
    dt: float
    steps: int
    seed: str

    def scene(self) -> Scene:
        """Build the scene."""
        if self.case == "net":
            return net(self.size, self.motion).scene
        make = octet if self.case == "octet" else lattice
        return make(self.size, self.motion, *STIFF[self.stiff]).scene

    @property
    def elements(self) -> int:
        """Number of elements."""
        n = self.size
        if self.case == "octet":
            return 12 * n * n * (2 * n + 1)
        return 2 * n * (n - 1) if self.case == "net" else 3 * n * n * (n - 1)

    @property
    def title(self) -> str:
        """What is run, without size and seed."""
        names = {"net": "net", "lattice": "soft lattice", "octet": "soft octet truss"}
        return f"{names[self.case].replace('soft', self.stiff)}, {self.course}"

    @property
    def course(self) -> str:
        """Motion and step in words."""
        return f"{'at rest' if self.motion == 'rest' else self.motion}, {self.dt:g} s"

    @property
    def side(self) -> str:
        """The size in words."""
        return f"{self.size} {'cells' if self.case == 'octet' else 'nodes'} a side"


@dataclass
class Row:
    """What a job gave.

    Attributes
    ----------
    job : Job
        What was run.
    record : dict
        As `run` returns it.
    """

    job: Job
    record: dict[str, Any] = field(default_factory=dict)

    @property
    def note(self) -> str:
        """Why there is no result, or nothing."""
        return str(self.record.get("note", ""))

    @property
    def microseconds(self) -> float:
        """Time of a step for each element [microseconds]."""
        return 1e6 * float(self.record["seconds"]) / (self.job.steps * self.job.elements)

    @property
    def bytes_per_element(self) -> float:
        """Peak memory above that of an idle process [bytes]."""
        return float(self.record["peak_bytes"] - self.record["base_bytes"]) / self.job.elements

    def flat(self) -> dict[str, Any]:
        """Return one line of the table."""
        line = asdict(self.job) | {"elements": self.job.elements, "note": self.note}
        if self.note:
            return line
        line |= {"microseconds": self.microseconds, "bytes_per_element": self.bytes_per_element}
        return line | {k: v for k, v in self.record.items() if not isinstance(v, dict)}


def lattices(
    largest: int = 22,
    largest_net: int = 100,
    largest_exact: int = 16,
    steps: int = 20,
    progress: bool = False,
) -> list[Row]:
    """Run nets, lattices and trusses on both kinds of seeds, each in a process of its own.

    Parameters
    ----------
    largest, largest_net : int, optional
        Nodes along a side of the largest lattice and net; before it come those of `LATTICES` and
        `NETS` that are smaller.  Octet trusses are those of `OCTETS` with as many elements.
    largest_exact : int, optional
        Nodes along a side of the largest lattice on exact seeds, and of the truss as large.
    steps : int, optional
        Time steps of each run.
    progress : bool, optional
        Whether to draw a progress bar.
    """
    scenes = [("net", n, *NET_RUN) for n in _sizes(NETS, largest_net)]
    scenes += [("lattice", n, *run) for run in RUNS for n in _sizes(LATTICES, largest)]
    trusses = [cells for cells, as_large in OCTETS.items() if as_large <= largest]
    scenes += [("octet", n, *run) for run in RUNS for n in trusses]
    jobs = [
        Job(*scene, steps, seed)
        for scene in scenes
        for seed in ("exact", "incomplete")
        if seed == "incomplete" or _exact_too(scene[0], scene[1], largest_exact)
    ]
    rows = []
    with progress_bar(jobs, "run", progress) as bar:
        for job in bar:
            bar.set_description(f"{job.title}, {job.size}, {job.seed}")
            rows.append(Row(job, in_process(job)))
    return rows


def _exact_too(case: str, size: int, largest_exact: int) -> bool:
    return case == "net" or (OCTETS[size] if case == "octet" else size) <= largest_exact


def _sizes(usual: Sequence[int], largest: int) -> list[int]:
    return sorted({each for each in usual if each < largest} | {largest})


def in_process(job: Job) -> dict[str, Any]:
    """Run a job in a process of its own; one that ends without an answer leaves a note."""
    done = subprocess.run(
        [sys.executable, "-m", __name__, json.dumps(asdict(job))],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
    )
    if done.returncode:
        return {"note": f"the process ended with exit code {done.returncode}"}
    record: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return record


def run(job: Job) -> dict[str, Any]:
    """Run a job in this process.

    Returns
    -------
    dict
        ``seconds`` of the march and ``set_up_seconds`` before it, the scene included [s];
        ``corrections``, ``sweeps``, ``products`` per step; ``factorizations``, ``recoveries``;
        ``peak_bytes`` and ``base_bytes`` of the process; or ``note``, why there is no result.
    """
    simulate(lattice(2).scene, 1e-3, 1e-3, seed="incomplete")  # whatever is loaded once only
    base, begin = peak_memory(), time.perf_counter()
    scene = job.scene()
    built, t_end = time.perf_counter() - begin, job.steps * job.dt
    try:
        stats = simulate(
            scene,
            t_end,
            job.dt,
            seed=job.seed,
            save_every=job.steps,
            save_nodes=[scene.beams[0].node(0)],
        ).stats
    except (InputError, StepFailure, MemoryError) as error:
        return {"note": str(error) or type(error).__name__}
    return {
        "seconds": stats.march_seconds,
        "set_up_seconds": built + stats.seconds["set-up"],
        "corrections": stats.iterations_per_step,
        "sweeps": stats.sweeps / stats.steps,
        "products": stats.products / stats.steps,
        "factorizations": stats.factorizations,
        "recoveries": stats.recoveries,
        "peak_bytes": peak_memory(),
        "base_bytes": base,
    }


def pairs(rows: Sequence[Row]) -> list[tuple[Row, Row]]:
    """Return the runs with results on both kinds of seeds, exact first."""
    by_scene: dict[tuple[str, int], dict[str, Row]] = {}
    for row in rows:
        if not row.note:
            by_scene.setdefault((row.job.title, row.job.size), {})[row.job.seed] = row
    return [(both["exact"], both["incomplete"]) for both in by_scene.values() if len(both) == 2]


if __name__ == "__main__":
    print(json.dumps(run(Job(**json.loads(sys.argv[1])))))
