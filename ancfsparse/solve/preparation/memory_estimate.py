"""Estimate the memory of a run before it starts."""

from __future__ import annotations

import ctypes
import math
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ancfsparse.errors import InputError, MessageTemplate, Parameter
from ancfsparse.kernels.layout import MIN_SHARED_BLOCKS
from ancfsparse.nonlinear import Method, Newton
from ancfsparse.scene import Beam, Scene
from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.complete.sparse_seed import CHOLMOD_ENTRY_BYTES
from ancfsparse.seeds.interface.index_arrays import MAX_EQUATIONS
from ancfsparse.solve import preparation
from ancfsparse.solve.preparation.choose_solver import LOW_MEMORY_PAIRS
from ancfsparse.system_memory import GIGABYTE, MIN_CHECKED, available_memory

if TYPE_CHECKING:
    from ancfsparse.seeds import DeflatedSeed, Seed

# Loads, last and present state, residuals, one saved state, two changes in single precision, the
# numbering and the pivots of the factor.
N_VECTORS = 25  # vectors over all coordinates in a run
MATRIX_ENTRY_BYTES = 12  # value and row
FACTOR_ENTRY_BYTES = 9  # value and a part of a row
INCOMPLETE_ENTRY_BYTES = 20  # of an incomplete factor, per entry of the matrix
DEFLATED_ENTRY_BYTES = 200  # the same with deflation modes
# Measured 0.8 to 1.7 for cubes of 6 to 18 nodes a side, growing with their logarithm.
CUBE_FILL_IN = 4.0  # entries of the factor over those of the matrix and the third root of the nodes
NEWTON = Newton()
VECTORS_PER_PAIR = 4  # two terms of two vectors each


def release_free_memory() -> None:
    """Return memory freed by the set-up to the operating system.

    The GNU library keeps freed arrays of up to 32 MB: 180 MB of a chain of a million elements.
    Other libraries do not, and have no such call.
    """
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim is not None:
        trim(0)


@dataclass(frozen=True)
class MemoryEstimate:
    """Estimated memory by purpose.

    Attributes
    ----------
    kernels, matrix, factor, vectors, states : float
        Element arrays; matrix and its pattern; its factor, with secant pairs, or dense inverse;
        vectors of the solvers; saved states [bytes].
    complete : float
        Of an incomplete factor, the memory that the complete one may need [bytes].
    """

    kernels: float
    matrix: float
    factor: float
    vectors: float
    states: float
    complete: float = 0.0

    @property
    def total(self) -> float:
        """Sum of all parts [bytes]."""
        return self.kernels + self.matrix + self.factor + self.vectors + self.states


NO_MEMORY = MemoryEstimate(0.0, 0.0, 0.0, 0.0, 0.0)


def estimate_memory(
    scene: Scene,
    rows: int = 0,
    kept_nodes: int | None = 0,
    to_file: bool = False,
    solver: Method | str = NEWTON,
    *,
    whole_runs: int = 0,
    matrices: int = 1,
    incomplete: bool = False,
    incomplete_entry: float = INCOMPLETE_ENTRY_BYTES,
) -> MemoryEstimate:
    """Estimate the memory of a run from the scene alone.

    Parameters
    ----------
    scene : Scene
        The model.
    rows : int, optional
        Number of states to save.
    kept_nodes : int or None, optional
        Number of points to save; None saves all coordinates.
    to_file : bool, optional
        Whether the states go to a file.
    solver : Method or str, optional
        Nonlinear solver, by default Newton's method; full-memory quasi-Newton methods need a dense
        inverse.
    whole_runs : int, optional
        Number of runs that are stored with all coordinates for comparison.
    matrices : int, optional
        Number of arrays of values on the pattern; `EnergyMomentum` needs two.
    incomplete : bool, optional
        Whether an incomplete factor is allowed; it is assumed where a complete one fills in.
    incomplete_entry : float, optional
        Memory of an incomplete seed per entry of the matrix [bytes].
    """
    kernels = entries = coordinates = 0.0
    n_rows = n_elements = n_nodes = 0
    width = 1
    for body in scene.bodies:
        kind = body.kind
        n, n_out, n_c = kind.n_coordinates, kind.n_out("tangent"), len(kind.node_coordinates)
        # The blocks of a long beam share their tables, see `Layout.compressed`.
        shared = isinstance(body, Beam) and body.n_elements >= MIN_SHARED_BLOCKS * kind.lanes
        kernels += 16.0 * body.n_elements / kind.lanes
        kernels += 0.0 if shared else 4.0 * body.n_elements * (n + n_out)
        entries += len(body.row_nodes) * n_c * (n_c + 1) / 2 + body.n_elements * n_c**2
        coordinates += scene.dim * body.n_nodes + (n_c - scene.dim) * len(body.row_nodes)
        n_rows, n_elements = n_rows + len(body.row_nodes), n_elements + body.n_elements
        n_nodes += body.n_nodes
        width = max(width, n_c)
    columns = coordinates if kept_nodes is None else 4.0 * scene.dim * kept_nodes
    in_memory = 1 if to_file else rows  # a state that is written to a file meanwhile
    needed = MemoryEstimate(
        kernels,
        (MATRIX_ENTRY_BYTES + 8 * (matrices - 1)) * entries,
        0.0,
        8.0 * N_VECTORS * coordinates,
        24.0 * (rows * whole_runs * coordinates + in_memory * columns),
    )
    if not isinstance(solver, str) and solver.is_dense:
        return replace(needed, factor=8.0 * coordinates**2)
    pairs = 0 if isinstance(solver, str) else solver.pairs
    extra = 8.0 * VECTORS_PER_PAIR * pairs * coordinates
    if incomplete and isinstance(solver, str):
        extra = 8.0 * VECTORS_PER_PAIR * LOW_MEMORY_PAIRS * coordinates
    if (
        incomplete
        and _count_joints_with_multipliers(scene) <= MAX_EQUATIONS
        and _count_cycles(scene) > 0.1 * n_nodes
    ):
        factor, complete = incomplete_entry * entries, _cube_factor_bytes(entries, n_nodes)
        return replace(needed, factor=factor + extra, complete=complete + extra)
    return replace(needed, factor=_factor_bytes(scene, entries, n_nodes, needed.total) + extra)


def _count_joints_with_multipliers(scene: Scene) -> int:
    """Return the number of joints that certainly have multipliers; clamps can have some too."""
    return sum(joint.has_multipliers for joint in scene.joints)


def _count_cycles(scene: Scene) -> int:
    """Return the approximate number of edges of a scene beyond those of a tree."""
    return sum(joint.joins for joint in scene.joints) + sum(b.n_cycles for b in scene.bodies)


def _cube_factor_bytes(entries: float, n_nodes: int) -> float:
    """Return the memory of the factor of a cube of nodes [bytes]."""
    return CHOLMOD_ENTRY_BYTES * CUBE_FILL_IN * entries * math.cbrt(n_nodes)


def _factor_bytes(scene: Scene, entries: float, n_nodes: int, others: float) -> float:
    """Estimate the memory of a complete factor, given that of other arrays [bytes].

    Chains and trees hardly fill in.  Nested dissection of a square grid fills in with the logarithm
    of the number of nodes, that of a cube with its third root.  The fill-in is counted only if a
    cube might not fit.
    """
    if _count_cycles(scene) <= 0.1 * n_nodes:
        return FACTOR_ENTRY_BYTES * entries
    free = available_memory()
    if free is None or others + _cube_factor_bytes(entries, n_nodes) <= free:
        return FACTOR_ENTRY_BYTES * entries * 0.5 * math.log2(n_nodes)
    return CHOLMOD_ENTRY_BYTES * preparation.count_factor_entries(scene)


def check_memory(needed: MemoryEstimate) -> None:
    """Check that a run fits in memory.

    Raises
    ------
    InputError
        With the required and the available memory, and suggestions.
    """
    free = available_memory() if needed.total > MIN_CHECKED else None
    if free is None or needed.total <= free:
        return
    parts = {
        "saved states": needed.states,
        "the incomplete factor" if needed.complete else "the factor or inverse": needed.factor,
        "the matrix": needed.matrix,
        "element arrays": needed.kernels,
        "vectors": needed.vectors,
    }
    name = max(parts, key=lambda part: parts[part])
    if name == "saved states":
        advice = MessageTemplate(
            "a larger {save_every}, save_nodes=[...], or output='run.h5', which keeps them there",
            save_every=Parameter("save_every"),
        )
    else:
        advice = MessageTemplate("fewer elements or a sparse solver such as solver='auto'")
    other = ""
    if needed.complete:
        other = f" (the factor {needed.factor / GIGABYTE:.3g} GB as an incomplete one, and as a "
        other += f"complete one up to {needed.complete / GIGABYTE:.3g} GB)"
    raise InputError(
        "the run would need about {needed:.3g} GB, more than there is: {free:.3g} GB of memory "
        "are free, and {name} alone would take {part:.3g} GB{other}; try {advice}",
        needed=needed.total / GIGABYTE,
        free=free / GIGABYTE,
        name=name,
        part=parts[name] / GIGABYTE,
        other=other,
        advice=advice,
    )


@contextmanager
def within_memory(needed: MemoryEstimate) -> Iterator[None]:
    """Check that a run fits in memory before it starts, and report it if an allocation fails.

    Raises
    ------
    InputError
        With the required and the available memory, and suggestions.
    """
    check_memory(needed)
    try:
        yield
    except MemoryError as full:
        raise InputError(
            f"memory ran out ({full}), although about {needed.total / GIGABYTE:.3g} GB should have "
            "been enough; try fewer elements"
        ) from None


def check_factor_fits(needed: MemoryEstimate, seed: Seed | DeflatedSeed) -> None:
    """Check that the factor, whose entries are now counted, fits with the remaining arrays.

    Parameters
    ----------
    needed : MemoryEstimate
        The estimate from the scene; element arrays and the matrix are already allocated.
    seed : SparseSeed, IncompleteSeed or DeflatedSeed
        Ordered, but not yet factored.
    """
    if isinstance(seed, SparseSeed):
        remaining = replace(needed, factor=max(needed.factor, seed.nbytes), complete=0.0)
    else:
        remaining = replace(needed, factor=seed.nbytes)
    check_memory(replace(remaining, kernels=0.0, matrix=0.0))
