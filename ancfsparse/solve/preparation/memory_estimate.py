"""How much memory a run will take, estimated before it starts."""

from __future__ import annotations

import ctypes
import math
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from ancfsparse.errors import InputError, MessageTemplate, Parameter
from ancfsparse.kernels.layout import MANY_BLOCKS
from ancfsparse.nonlinear import Method
from ancfsparse.scene import Beam, Mesh, Scene
from ancfsparse.seeds import DeflatedSeed, Seed, SparseSeed
from ancfsparse.seeds.complete.sparse_seed import BLOCK_ENTRY
from ancfsparse.seeds.incomplete.constraint_border import MOST_EQUATIONS
from ancfsparse.solve.preparation.choose_solver import SPARING_PAIRS
from ancfsparse.solve.preparation.fill_in_estimate import counted_fill
from ancfsparse.system_memory import GIGABYTE, MIN_CHECKED, available_memory

# Vectors over all coordinates that a run keeps: loads, last and present state, residuals, one saved
# state, two changes in single precision, the numbering and the pivots of the factor.
VECTORS = 25
# Bytes for an entry of the matrix, value and row; and of its factor, value and its share of a row.
MATRIX_ENTRY, FACTOR_ENTRY = 12, 9
# Bytes of an incomplete factor for an entry of the matrix, and of one with coarse modes.
INCOMPLETE_ENTRY, DEFLATED_ENTRY = 20, 200
# Entries of the factor of a cube of n nodes, over those of the matrix and the third root of n: 0.8
# to 1.7 for 6 to 18 nodes a side, growing with their logarithm.
CUBE = 4.0
# Secant pairs: two terms of two vectors each.
PAIR = 4


def give_back() -> None:
    """Return to the system what set-up has freed.

    The GNU library keeps freed arrays of up to 32 MB for the next ones: 180 MB of a chain of a
    million elements.  Others have no such call, and need none.
    """
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim is not None:
        trim(0)


@dataclass(frozen=True)
class Memory:
    """Estimated bytes by what they are for.

    Attributes
    ----------
    kernels, matrix, factor, vectors, states : float
        Element arrays; matrix and its pattern; its factor, with secant pairs, or dense inverse;
        vectors of the solvers; saved states [bytes].
    exact : float
        Where the factor is an incomplete one, what the complete one might take at most [bytes].
    """

    kernels: float
    matrix: float
    factor: float
    vectors: float
    states: float
    exact: float = 0.0

    @property
    def total(self) -> float:
        """All of it [bytes]."""
        return self.kernels + self.matrix + self.factor + self.vectors + self.states


NOTHING = Memory(0.0, 0.0, 0.0, 0.0, 0.0)


def estimate(
    scene: Scene,
    rows: int,
    kept_nodes: int | None,
    to_file: bool,
    solver: Method | str,
    *,
    whole_runs: int = 0,
    matrices: int = 1,
    incomplete: bool = False,
    incomplete_entry: float = INCOMPLETE_ENTRY,
) -> Memory:
    """Estimate the memory of a run from the scene alone.

    Parameters
    ----------
    scene : Scene
        What is to move.
    rows : int
        Number of states to save.
    kept_nodes : int or None
        Number of points to keep; None keeps all coordinates.
    to_file : bool
        Whether the states go to a file.
    solver : Method or str
        A full-memory quasi-Newton method takes a dense inverse.
    whole_runs : int, optional
        Runs whose states are held with all coordinates, to be compared.
    matrices : int, optional
        Arrays of values on the pattern: `EnergyMomentum` adds one up in another.
    incomplete : bool, optional
        Whether the factor may be an incomplete one, and so is where it would fill in.
    incomplete_entry : float, optional
        Bytes that such a seed takes for an entry of the matrix.
    """
    kernels = entries = coordinates = 0.0
    n_rows = n_elements = n_nodes = 0
    width = 1
    for body in scene.bodies:
        kind = body.kind
        n, n_out, n_c = kind.n_coordinates, kind.n_out("tangent"), len(kind.node_coordinates)
        # The blocks of a long beam share their tables, see `Layout.compressed`.
        shared = isinstance(body, Beam) and body.n_elements >= MANY_BLOCKS * kind.lanes
        kernels += 16.0 * body.n_elements / kind.lanes
        kernels += 0.0 if shared else 4.0 * body.n_elements * (n + n_out)
        entries += len(body.row_nodes) * n_c * (n_c + 1) / 2 + body.n_elements * n_c**2
        coordinates += scene.dim * body.n_nodes + (n_c - scene.dim) * len(body.row_nodes)
        n_rows, n_elements = n_rows + len(body.row_nodes), n_elements + body.n_elements
        n_nodes += body.n_nodes
        width = max(width, n_c)
    columns = coordinates if kept_nodes is None else 4.0 * scene.dim * kept_nodes
    needed = Memory(
        kernels,
        (MATRIX_ENTRY + 8 * (matrices - 1)) * entries,
        0.0,
        8.0 * VECTORS * coordinates,
        24.0 * rows * (whole_runs * coordinates + (0.0 if to_file else columns)),
    )
    if not isinstance(solver, str) and solver.is_dense:
        return replace(needed, factor=8.0 * coordinates**2)
    pairs = 0 if isinstance(solver, str) else solver.pairs
    extra = 8.0 * PAIR * pairs * coordinates
    if incomplete and isinstance(solver, str):
        extra = 8.0 * PAIR * SPARING_PAIRS * coordinates
    if incomplete and _held(scene) <= MOST_EQUATIONS and _cycles(scene) > 0.1 * n_nodes:
        factor, most = incomplete_entry * entries, _cube(entries, n_nodes)
        return replace(needed, factor=factor + extra, exact=most + extra)
    return replace(needed, factor=_factor(scene, entries, n_nodes, needed.total) + extra)


def _held(scene: Scene) -> int:
    """Return how many joints surely have multipliers; clamps may have some too."""
    return sum(joint.has_multipliers for joint in scene.joints)


def _cycles(scene: Scene) -> int:
    """About how many edges a scene has beyond those of a tree."""
    cycles = sum(joint.joins for joint in scene.joints)
    return cycles + sum(m.n_elements - m.n_nodes for m in scene.beams if isinstance(m, Mesh))


def _cube(entries: float, n_nodes: int) -> float:
    """Bytes of the factor of a cube of nodes."""
    return BLOCK_ENTRY * CUBE * entries * math.cbrt(n_nodes)


def _factor(scene: Scene, entries: float, n_nodes: int, beside: float) -> float:
    """Estimate the bytes of the factor: chains and trees hardly fill in, nets and lattices do.

    Nested dissection of a square grid fills in with the logarithm of the number of nodes, that of a
    cube with its third root.  Which of them a scene is like need only be known, and is counted,
    where a cube might not fit.
    """
    if _cycles(scene) <= 0.1 * n_nodes:
        return FACTOR_ENTRY * entries
    free = available_memory()
    if free is None or beside + _cube(entries, n_nodes) <= free:
        return FACTOR_ENTRY * entries * 0.5 * math.log2(n_nodes)
    return BLOCK_ENTRY * counted_fill(scene)


def check_fits(needed: Memory) -> None:
    """Refuse a run that cannot fit.

    Raises
    ------
    InputError
        With how much would be needed, how much is there, and what to try.
    """
    free = available_memory() if needed.total > MIN_CHECKED else None
    if free is None or needed.total <= free:
        return
    parts = {
        "saved states": needed.states,
        "the incomplete factor" if needed.exact else "the factor or inverse": needed.factor,
        "the matrix": needed.matrix,
        "element arrays": needed.kernels,
        "vectors": needed.vectors,
    }
    name = max(parts, key=lambda each: parts[each])
    if name == "saved states":
        advice = MessageTemplate(
            "a larger {save_every}, save_nodes=[...], or output='run.h5', which keeps them there",
            save_every=Parameter("save_every"),
        )
    else:
        advice = MessageTemplate("fewer elements or a sparse solver such as solver='auto'")
    other = ""
    if needed.exact:
        other = f" (the factor {needed.factor / GIGABYTE:.3g} GB as an incomplete one, and as a "
        other += f"complete one up to {needed.exact / GIGABYTE:.3g} GB)"
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
def memory_for(needed: Memory) -> Iterator[None]:
    """Refuse what cannot fit, before it starts or, where the estimate was too low, when it fails.

    Raises
    ------
    InputError
        With how much is needed, how much is there, and what to try.
    """
    check_fits(needed)
    try:
        yield
    except MemoryError as full:
        raise InputError(
            f"memory ran out ({full}), although about {needed.total / GIGABYTE:.3g} GB should have "
            "been enough; try fewer elements"
        ) from None


def check_factor(needed: Memory, seed: Seed | DeflatedSeed) -> None:
    """Refuse a run whose factor, now that it is counted, cannot fit with what is yet to come.

    Parameters
    ----------
    needed : Memory
        The estimate from the scene; its element arrays and its matrix are there by now.
    seed : SparseSeed, IncompleteSeed or DeflatedSeed
        Ordered, but not yet factored.
    """
    if isinstance(seed, SparseSeed):
        here = replace(needed, factor=max(needed.factor, seed.nbytes), exact=0.0)
    else:
        here = replace(needed, factor=seed.nbytes)
    check_fits(replace(here, kernels=0.0, matrix=0.0))
