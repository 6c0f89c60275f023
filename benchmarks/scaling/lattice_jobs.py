"""Runs of nets, lattices and trusses: scene, motion, step, factorization, threads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ancfsparse.problems import lattice, net, octet
from ancfsparse.problems.meshes import LATTICE_MATERIALS
from ancfsparse.scene import Material, Rectangle, Scene

LATTICES = (10, 16, 22, 30, 46, 64)  # nodes along a side
NETS = (5, 10, 30, 60, 100, 200)  # nodes along a side
# Further sizes for the first two of RUNS, around the change from exact to incomplete seeds.
SMALL_SIZES = ((3, 4, 5, 6, 8), (5, 6, 8))
OCTETS = {4: 10, 8: 16, 11: 22, 15: 30, 23: 46, 32: 64}
"""Cells along a side of octet trusses, and of the lattice with about as many elements."""

# Stiffness, motion, step [s], jitter, rods.
RUNS = (
    ("soft", "rest", 1e-3, 0.0, 0),
    ("soft", "rough", 1e-3, 0.0, 0),
    ("steel", "rest", 1e-3, 0.0, 0),
    ("steel", "rest", 4e-3, 0.0, 0),
    ("steel", "rest", 1e-2, 0.0, 0),
)
# Irregular lattices, whose cables buckle, and lattices tied to the ground by rods.
OTHERS = (
    ("soft", "rough", 1e-3, 0.2, 0),
    ("steel", "rest", 1e-3, 0.2, 0),
    ("steel", "rough", 1e-3, 0.2, 0),
    ("soft", "rest", 1e-3, 0.0, 32),
    ("steel", "rest", 4e-3, 0.0, 32),
)
LARGEST_OTHER = 22  # nodes along a side of irregular lattices and those on rods
LARGEST_OCTET = 22  # nodes along a side of the lattice with as many elements
LARGEST_IRREGULAR = 10  # on complete seeds, of which a step takes up to ten
NET_RUN = ("soft", "rest", 5e-4, 0.0, 0)
LARGEST_FIRST = 22  # nodes along a side of the first run on complete seeds
STATIC = 16  # nodes along a side of lattices in equilibrium
MIN_ELEMENTS = 4000  # of a run whose few steps are long enough to be timed


@dataclass(frozen=True)
class Job:
    """One run."""

    # {"lattice", "net", "octet", "statics"}, the scene; with "statics" its equilibrium under its
    # weight and a tenth of it sideways
    case: str
    size: int  # nodes along a side; of an octet truss, cells
    # A name in `LATTICE_MATERIALS`, and a motion as in `problems.lattice`
    stiff: str
    motion: str
    dt: float  # step [s]
    steps: int
    factorization: str  # {"complete", "incomplete"}, for the corrections
    jitter: float = 0.0  # of a lattice, as in `problems.lattice`
    rods: int = 0  # nodes of a lattice that are tied to the ground
    threads: int = 1  # threads that share the work

    def scene(self) -> Scene:
        """Build the scene."""
        if self.case == "net":
            return net(self.size, self.motion).scene
        if self.case == "octet":
            return octet(self.size, self.motion, *LATTICE_MATERIALS[self.stiff]).scene
        if self.case == "statics":
            return _clamped(self.size, self.stiff)
        scene, mesh = lattice(
            self.size, self.motion, *LATTICE_MATERIALS[self.stiff], jitter=self.jitter
        )
        n = self.size
        for k in range(min(self.rods, n * (n - 1))):  # of the side x = 0, from its bottom on
            node = mesh.node(n * (k % n) + k // n)
            scene.rod(node, node.position + np.array([0.05 * k, 0.1, -2.0]))
        return scene

    @property
    def elements(self) -> int:
        """Number of elements."""
        n = self.size
        if self.case == "octet":
            return 12 * n * n * (2 * n + 1)
        return 2 * n * (n - 1) if self.case == "net" else 3 * n * n * (n - 1)

    @property
    def title(self) -> str:
        """Scene, motion and step in words."""
        if self.case == "net":
            return f"net, {self.course}"
        kind = "octet truss" if self.case == "octet" else "lattice"
        kind += " on rods" if self.rods else ""
        return f"{self.stiff} {'irregular ' if self.jitter else ''}{kind}, {self.course}"

    @property
    def course(self) -> str:
        """Motion and step in words."""
        if self.case == "statics":
            return "equilibrium"
        course = f"{'at rest' if self.motion == 'rest' else self.motion}, {self.dt:g} s"
        return course + (f", {self.threads} threads" if self.threads > 1 else "")

    @property
    def side(self) -> str:
        """The size in words."""
        return f"{self.size} {'cells' if self.case == 'octet' else 'nodes'} a side"


def _clamped(n: int, stiff: str) -> Scene:
    """Clamp a lattice at its top, with a tenth of its weight sideways."""
    grid, (modulus, density) = lattice(n).mesh, LATTICE_MATERIALS[stiff]
    scene = Scene((0.0, 0.0, -9.81))
    mesh = scene.add_mesh(
        grid.positions, grid.edges, "thin", Rectangle(0.01, 0.01), Material(modulus, density)
    )
    height = mesh.positions[:, 2]
    for node in np.flatnonzero(height > height.max() - 1e-6):
        scene.clamp(mesh.node(int(node)))
    weight = mesh.stiffnesses()["mass_per_length"] * 9.81
    scene.distributed_force(mesh, (0.1 * weight, 0.0, 0.0))
    return scene


def jobs_of(
    largest: int, largest_net: int, largest_exact: int, steps: int, threads: int
) -> list[Job]:
    """Return the jobs of `lattices.lattices`, which explains the arguments."""
    sizes, entries = _sizes(LATTICES, largest), list[Job]()
    small = dict(zip(RUNS, SMALL_SIZES, strict=False))

    def add(case: str, size: int, run: tuple[str, str, float, float, int], exact: bool) -> None:
        stiff, motion, dt, jitter, rods = run
        job = Job(case, size, stiff, motion, dt, steps, "complete", jitter, rods)
        more = min(10, max(1, MIN_ELEMENTS // job.elements)) if motion == "rest" else 1
        for factorization in ("complete", "incomplete") if exact else ("incomplete",):
            entries.append(replace(job, steps=more * steps, factorization=factorization))

    for n in _sizes(NETS, largest_net):
        add("net", n, NET_RUN, True)
    for run in RUNS:
        limit = max(largest_exact, LARGEST_FIRST) if run is RUNS[0] else largest_exact
        for n in sorted({n for n in small.get(run, ()) if n < largest} | set(sizes)):
            add("lattice", n, run, n <= limit)
    for run in OTHERS:
        limit = min(LARGEST_IRREGULAR, largest_exact) if run[3] else largest_exact
        for n in sizes:
            if n <= LARGEST_OTHER:
                add("lattice", n, run, n <= limit)
    for run in RUNS:
        for cells, as_large in OCTETS.items():
            if as_large <= min(largest, LARGEST_OCTET):
                add("octet", cells, run, as_large <= largest_exact)
    if threads > 1:
        for run in (RUNS[0], *RUNS[3:]):
            stiff, motion, dt, *_ = run
            job = ("lattice", largest, stiff, motion, dt, steps, "incomplete")
            entries.append(Job(*job, threads=threads))
    if largest >= STATIC:
        entries += [
            Job("statics", STATIC, stiff, "rest", 0.0, 1, "incomplete")
            for stiff in LATTICE_MATERIALS
        ]
    return entries


def _sizes(usual: Sequence[int], largest: int) -> list[int]:
    return sorted({each for each in usual if each < largest} | {largest})
