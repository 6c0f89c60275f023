"""Memory bandwidth of the hot loops, and operations per second of the kernels.

Bandwidth is that of a triad ``a = b + c`` on arrays far larger than the caches, measured in the
same run.  Bytes are counted as the loops name them: a number read is 8, one written 8, one changed
in place 16, an index 4; fetches before overwriting are not counted.
"""

from __future__ import annotations

import timeit
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ancfsparse.dispatch import instruction_set
from ancfsparse.kernels.catalog import element_kind
from ancfsparse.problems import chain
from ancfsparse.seeds import SparseSeed
from ancfsparse.system import System
from benchmarks.common.kernel_timing import time_kernel
from benchmarks.common.tables import Table

DT = 5e-4

# In every solve: permuted in (8 + 4 + 8), down (16), up (16), permuted out (4 + 8); and 1 / D, up.
SOLVE_BYTES_PER_UNKNOWN = 64

# Elements whose data stay in the first-level cache.
IN_CACHE = 128


@dataclass(frozen=True)
class Loop:
    """A hot loop on a chain."""

    name: str  # which
    elements: int  # of the chain
    nanoseconds: float  # time per element [ns]
    # per element; 0 where they are not counted
    bytes: float = 0.0
    operations: float = 0.0

    @property
    def gigabytes_per_second(self) -> float:
        """Bytes moved [GB/s]."""
        return self.bytes / self.nanoseconds

    @property
    def gigaflops(self) -> float:
        """Operations [1e9 / s]."""
        return self.operations / self.nanoseconds


@dataclass(frozen=True)
class Roofline:
    """Bandwidth and loops."""

    triad: float  # bandwidth [GB/s]
    loops: list[Loop]  # measured in the same run

    def __str__(self) -> str:
        """Set the table for a terminal."""
        columns: dict[str, Callable[[Loop], str]] = {
            "": lambda each: each.name,
            "elements": lambda each: f"{each.elements}",
            "ns/element": lambda each: f"{each.nanoseconds:.1f}",
            "Gflop/s": lambda each: f"{each.gigaflops:.1f}" * bool(each.operations),
            "GB/s": lambda each: f"{each.gigabytes_per_second:.1f}" * bool(each.bytes),
            "of triad": lambda each: (
                f"{each.gigabytes_per_second / self.triad:.0%}" * bool(each.bytes)
            ),
        }
        title = (
            f"Roofline, chain of l2t2, {instruction_set()}: a triad on large arrays moves "
            f"{self.triad:.1f} GB/s"
        )
        return str(Table.of(self.loops, columns, title=title))


def roofline(n_elements: int = 100_000, triad_numbers: int = 16_000_000) -> Roofline:
    """Measure bandwidth, triangular solve, factorisation and kernels on a planar chain."""
    before = triad(triad_numbers)
    loops = _seed(n_elements)
    kind = element_kind("l2t2", 2)
    for kernel in ("residual", "tangent"):
        for count in (IN_CACHE, n_elements):
            nanoseconds = time_kernel(kind, kernel, n_elements=count, rounds=5)
            operations = kind.operations[kernel]
            loops.append(Loop(f"kernel {kernel}", count, nanoseconds, 0.0, operations))
    return Roofline(max(before, triad(triad_numbers)), loops)


def triad(n: int, rounds: int = 5) -> float:
    """Return the bandwidth of ``a = b + c`` on arrays of `n` numbers [GB/s]."""
    b, c, a = np.ones(n), np.ones(n), np.zeros(n)
    return 24.0 * n / (1e9 * fastest(lambda: np.add(b, c, out=a), rounds))


def _seed(n_elements: int) -> list[Loop]:
    system = System(chain(n_elements).scene)
    seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
    lam, amplitudes = np.zeros(0), np.zeros(system.loads.amplitudes(np.zeros(1)).shape[1])
    values = system.assembly.matrix(1.0, DT**2 / 4.0, system.q0, lam, amplitudes)
    r = np.ones(seed.n)
    factor = fastest(lambda: seed.factor(values), 3)
    per = 1.0 / n_elements
    loops = [Loop("factor", n_elements, 1e9 * factor * per, 0.0, seed.factor_flops * per)]

    def add_solve(name: str, size: float) -> None:
        solve = fastest(lambda: seed.solve(r), 7)
        # L is read on the way down and on the way up.
        moved = size * (2.0 * seed.nnz + seed.n) + SOLVE_BYTES_PER_UNKNOWN * seed.n
        loops.append(Loop(name, n_elements, 1e9 * solve * per, moved * per, seed.solve_flops * per))

    add_solve("solve", 8.0)
    seed.own.round_to_single()
    add_solve("solve, single", 4.0)
    return loops


def fastest(work: Callable[[], object], rounds: int) -> float:
    """Return the shortest time of several rounds after one that does not count [s]."""
    work()
    return min(timeit.repeat(work, number=1, repeat=rounds))
