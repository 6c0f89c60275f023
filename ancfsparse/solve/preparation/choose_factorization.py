"""Select the seed of a run or an equilibrium: a complete factorization, or an incomplete one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ancfsparse import seeds
from ancfsparse.array_types import Indices
from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.nonlinear import Method
from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.complete.sparse_seed import LDL_ENTRY_BYTES
from ancfsparse.seeds.interface.index_arrays import MAX_EQUATIONS, leading
from ancfsparse.solve import preparation
from ancfsparse.solve.preparation.memory_estimate import MemoryEstimate, check_factor_fits
from ancfsparse.system import System
from ancfsparse.system.coordinates.nodal_vectors import vectors_of
from ancfsparse.system_memory import available_memory

if TYPE_CHECKING:
    from ancfsparse.seeds import DeflatedSeed, Groups, Seed

FACTORIZATIONS = ("auto", "complete", "incomplete")
MAX_SMALL_COORDINATES = 300  # free coordinates up to which a complete factor costs next to nothing
# Solves with a factor of this fill cost three sweeps, and incomplete seeds take half as many
# corrections again.
MAX_FILL = 3.0  # blocks of a complete factor per block of the matrix
MAX_CONSTRAINED_FILL = 6.0  # the same with multipliers, where each sweep is two
# Long steps of nets that fall on a ball take twice as many corrections on incomplete seeds, and 1.8
# to 4 times as many factors: with 4 ms, nets of 12 to 30 meshes a side (fill 3.3 to 5.5) need 1.4
# to 2.6 times the time, and those of 60 (6.9) fail; with 1 ms they need about the same time.
MAX_CONTACT_FILL = 8.0  # the same with contacts
# Static solutions on incomplete seeds take some forty sweeps each: lattices of 10 nodes a side
# (fill 12) take as long with both, those of 16 (fill 27) five times as long with complete ones.
MAX_STATIC_FILL = 16.0  # the same in statics


def check_factorization(kind: str, solver: Method | str, accuracy: float | None) -> str:
    """Return the name of a factorization after checking it with solver and accuracy.

    Raises
    ------
    InputError
        If it is not one of `FACTORIZATIONS`, or if it is incomplete and the inverse is dense or an
        accuracy is given.
    """
    check_choice("factorization", kind, FACTORIZATIONS)
    if kind == "incomplete" and not isinstance(solver, str) and solver.is_dense:
        raise InputError(
            f"factorization='incomplete' approximates a sparse factor, and {solver!r} starts from "
            "the full inverse: take solver='auto' or a number of pairs, or leave out factorization"
        )
    if kind == "incomplete" and accuracy is not None:
        raise InputError(
            f"accuracy={accuracy:g} estimates errors with a complete factor: leave out "
            "factorization='incomplete', or give dt and no accuracy"
        )
    return kind


def make_seed(
    system: System,
    kind: str,
    solver: Method | str,
    threads: int,
    needed: MemoryEstimate,
    dt: float = 0.0,
) -> tuple[Seed, Groups | None]:
    """Create the seed of a run, ordered but not yet factored.

    "auto" takes the complete factor where it hardly fills in: on trees, and up to three blocks for
    each block of the matrix, six with multipliers, or eight with contacts.  A solver that the
    caller has named gets the complete factor too, wherever it fits.

    Parameters
    ----------
    system : System
        Provides the sparsity pattern and the nodal vectors.
    kind : str
        One of `FACTORIZATIONS`.
    solver : Method or str
        Nonlinear solver.
    threads : int
        Largest number of threads for the factor.
    needed : MemoryEstimate
        Other memory of the run.
    dt : float, optional
        Time step [s]; if it is long, an incomplete seed gets modes in which cables slide.

    Returns
    -------
    seed : SparseSeed or IncompleteSeed
        The initial inverse of corrections.
    groups : Groups or None
        If "auto" has selected an incomplete seed, the groups of unknowns of a complete one.

    Raises
    ------
    InputError
        If there are too many multipliers for an incomplete seed, or if no seed fits.
    """
    indptr, indices = system.pattern.indptr, system.pattern.indices
    if kind == "incomplete" and system.n_multipliers > MAX_EQUATIONS:
        raise InputError(
            f"factorization='incomplete' takes at most {MAX_EQUATIONS} equations, and this scene "
            f"has {system.n_multipliers}, the first of the {system.constraints.labels[0]}: leave "
            "out factorization, or use joints without multipliers, such as pins"
        )
    if kind == "incomplete" or (kind == "auto" and _may_fill_in(system, solver)):
        groups = unknown_groups(system)
        if kind == "incomplete" or _fills_in(groups, solver, needed, max_fill(system)):
            incomplete = seeds.IncompleteSeed(
                indptr, indices, groups, threads, preparation.sliding_points(system, dt)
            )
            check_factor_fits(needed, incomplete)
            return incomplete, None if kind == "incomplete" else groups
        del groups
    complete = make_complete_seed(system, threads)
    check_factor_fits(needed, complete)
    return complete, None


def make_complete_seed(system: System, threads: int) -> SparseSeed:
    """Create a complete seed, with the blocks of touching elements.

    In 28 random runs with touching beams these save 60 % of the corrections with a dense inverse of
    Broyden or BFGS; most had been by Newton's method, after the inverse had failed.
    """
    pattern = system.pattern
    couplings = [pairs for each in system.contributions for pairs in each.coupled_pairs()]
    system.assembly.use_couplings(bool(couplings))
    if not couplings:
        return SparseSeed(pattern.indptr, pattern.indices, system.n_free, threads)
    return seeds.CoupledSeed(pattern.indptr, pattern.indices, system.n_free, threads, couplings)


def make_static_seed(
    system: System, indptr: Indices, indices: Indices, kind: str
) -> tuple[SparseSeed | DeflatedSeed, preparation.DeflationModes | None]:
    """Create the seed of an equilibrium, with the deflation modes of an incomplete one.

    Parameters
    ----------
    system : System
        Provides the nodal vectors.
    indptr, indices : integer arrays
        Lower triangle of the stiffness of the free coordinates.
    kind : str
        One of `FACTORIZATIONS`.
    """
    fills = kind == "incomplete"
    if fills or (kind == "auto" and _may_have_cycles(system)):
        groups = seeds.Groups.from_matrix(
            indptr, indices, *vectors_of(system.places, system.kinds, system.n_free)
        )
        if not fills:
            fills = groups.cycles > 0 and groups.exact_fill(MAX_STATIC_FILL) is None
        if fills:
            return seeds.DeflatedSeed(indptr, indices, groups), preparation.DeflationModes(system)
    return SparseSeed(indptr, indices, system.n_free), None


def unknown_groups(system: System) -> Groups:
    """Return the nodal vectors of the free coordinates, and the pairs coupled in the matrix."""
    own = leading(system.pattern.indptr, system.pattern.indices, system.n_free)
    return seeds.Groups.from_matrix(*own, *vectors_of(system.places, system.kinds, system.n_free))


def _may_fill_in(system: System, solver: Method | str) -> bool:
    """Return whether fill-in is possible and the solver does not need a complete factor."""
    if not isinstance(solver, str) and solver.is_dense:
        return False
    return system.n_multipliers <= MAX_EQUATIONS and _may_have_cycles(system)


def _may_have_cycles(system: System) -> bool:
    """Return whether beams can form cycles in a scene with more than a few coordinates."""
    scene = system.scene
    return system.n_free > MAX_SMALL_COORDINATES and (
        any(body.n_cycles for body in scene.bodies) or any(joint.joins for joint in scene.joints)
    )


def max_fill(system: System) -> float:
    """Return the largest fill at which complete factors are selected."""
    if any(each.is_contact for each in system.contributions):
        return MAX_CONTACT_FILL
    return MAX_CONSTRAINED_FILL if system.n_multipliers else MAX_FILL


def _fills_in(groups: Groups, solver: Method | str, needed: MemoryEstimate, limit: float) -> bool:
    """Return whether a complete factor costs more than an incomplete one, or does not fit."""
    if groups.cycles == 0:
        return False
    if isinstance(solver, str):
        return groups.exact_fill(limit) is None
    free = available_memory()
    if free is None:
        return False
    remaining = free - needed.vectors - needed.states
    return groups.exact_fill(remaining / (LDL_ENTRY_BYTES * groups.nnz)) is None
