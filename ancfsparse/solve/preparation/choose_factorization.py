"""Which seed a run or an equilibrium is solved on: the complete factor, or one without fill."""

from __future__ import annotations

from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.nonlinear import Method
from ancfsparse.scene import Mesh
from ancfsparse.seeds import DeflatedSeed, Groups, IncompleteSeed, Seed, SparseSeed
from ancfsparse.seeds.complete.sparse_seed import OWN_ENTRY
from ancfsparse.seeds.incomplete.constraint_border import MOST_EQUATIONS, leading
from ancfsparse.seeds.interface.index_arrays import Indices
from ancfsparse.solve import preparation
from ancfsparse.solve.preparation.memory_estimate import Memory, check_factor
from ancfsparse.system import System
from ancfsparse.system.coordinates.nodal_vectors import vectors_of
from ancfsparse.system_memory import available_memory

FACTORIZATIONS = ("auto", "complete", "incomplete")
# Coordinates up to which a complete factor costs next to nothing.
SMALL = 300
# Blocks of a complete factor for each of the matrix up to which it is taken: its solves cost three
# sweeps, and incomplete seeds take half as many corrections again.
MOST_FILL = 3.0
# The same with equations, where each sweep is two.
MOST_HELD_FILL = 6.0
# The same in statics, whose solutions on incomplete seeds take some forty sweeps each: lattices of
# 10 nodes a side (12 blocks) take as long with both, of 16 (27) five times as long with
# complete ones.
MOST_STATIC_FILL = 16.0


def check_factorization(kind: str, solver: Method | str, accuracy: float | None) -> str:
    """Return the kind of seed; refuse an unknown one, or what incomplete seeds cannot do.

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
    needed: Memory,
    dt: float = 0.0,
) -> tuple[Seed, Groups | None]:
    """Make the seed of a run, ordered but not yet factored.

    "auto" takes the complete factor where it hardly fills in: on trees, and up to three blocks for
    each block of the matrix, or six with multipliers.  A solver that the caller has named gets the
    complete factor too, wherever it fits.

    Parameters
    ----------
    system : System
        Its pattern, and which coordinates are vectors.
    kind : str
        One of `FACTORIZATIONS`.
    solver : Method or str
        How the equations of a step are solved.
    threads : int
        Most threads for the factor.
    needed : Memory
        What else the run takes.
    dt : float, optional
        Time step [s]: for long ones an incomplete seed gets modes in which cables slide.

    Returns
    -------
    seed : SparseSeed or IncompleteSeed
        With what corrections are solved.
    groups : Groups or None
        Where an incomplete seed was chosen, of what a complete one would be made.

    Raises
    ------
    InputError
        If there are too many multipliers for an incomplete seed, or if no seed fits.
    """
    indptr, indices = system.pattern.indptr, system.pattern.indices
    if kind == "incomplete" and system.n_multipliers > MOST_EQUATIONS:
        raise InputError(
            f"factorization='incomplete' takes at most {MOST_EQUATIONS} equations, and this scene "
            f"has {system.n_multipliers}, the first of the {system.constraints.labels[0]}: leave "
            "out factorization, or use joints without multipliers, such as pins"
        )
    if kind == "incomplete" or (kind == "auto" and _may_fill_in(system, solver)):
        groups = groups_of(system)
        if kind == "incomplete" or _fills_in(groups, solver, needed, most_fill(system)):
            incomplete = IncompleteSeed(
                indptr, indices, groups, threads, preparation.slides_of(system, dt)
            )
            check_factor(needed, incomplete)
            return incomplete, None if kind == "incomplete" else groups
        del groups
    exact = SparseSeed(indptr, indices, system.n_free, threads)
    check_factor(needed, exact)
    return exact, None


def make_static_seed(
    system: System, indptr: Indices, indices: Indices, kind: str
) -> tuple[SparseSeed | DeflatedSeed, preparation.CoarseModes | None]:
    """Make the seed of an equilibrium, with the coarse modes of one that is incomplete.

    Parameters
    ----------
    system : System
        Gives the coordinates that are vectors.
    indptr, indices : integer arrays
        Lower triangle of the stiffness of the free coordinates.
    kind : str
        One of `FACTORIZATIONS`.
    """
    fills = kind == "incomplete"
    if fills or (kind == "auto" and _meshed(system)):
        groups = Groups.of(indptr, indices, *vectors_of(system.places, system.kinds, system.n_free))
        if not fills:
            fills = groups.cycles > 0 and groups.exact_fill(MOST_STATIC_FILL) is None
        if fills:
            return DeflatedSeed(indptr, indices, groups), preparation.CoarseModes(system)
    return SparseSeed(indptr, indices, system.n_free), None


def groups_of(system: System) -> Groups:
    """Return the vectors of the free coordinates, and which meet in the matrix of a step."""
    own = leading(system.pattern.indptr, system.pattern.indices, system.n_free)
    return Groups.of(*own, *vectors_of(system.places, system.kinds, system.n_free))


def _may_fill_in(system: System, solver: Method | str) -> bool:
    """Whether there may be more fill than is worth a thought, and no need of a complete factor."""
    if not isinstance(solver, str) and solver.is_dense:
        return False
    return system.n_multipliers <= MOST_EQUATIONS and _meshed(system)


def _meshed(system: System) -> bool:
    """Whether beams of a scene may cross, and it has more than a few coordinates."""
    scene = system.scene
    return system.n_free > SMALL and (
        any(isinstance(body, Mesh) for body in scene.beams)
        or any(joint.joins for joint in scene.joints)
    )


def most_fill(system: System) -> float:
    """Return the largest fill, in blocks per block of the matrix, at which complete factors pay."""
    return MOST_HELD_FILL if system.n_multipliers else MOST_FILL


def _fills_in(groups: Groups, solver: Method | str, needed: Memory, most: float) -> bool:
    """Whether a complete factor costs more than a sweep or two, or does not fit."""
    if groups.cycles == 0:
        return False
    if isinstance(solver, str):
        return groups.exact_fill(most) is None
    free = available_memory()
    if free is None:
        return False
    left = free - needed.vectors - needed.states
    return groups.exact_fill(left / (OWN_ENTRY * groups.nnz)) is None
