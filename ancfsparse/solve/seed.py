"""Which seed a run is solved on: the exact factor of its matrix, or one without fill."""

from __future__ import annotations

from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.nonlinear import Method, QuasiNewton
from ancfsparse.seeds import IncompleteSeed, Seed, SparseSeed
from ancfsparse.system import System
from ancfsparse.system.vectors import vectors_of

SEEDS = ("auto", "exact", "incomplete")


def check_seed(kind: str, solver: Method | str, accuracy: float | None) -> str:
    """Return the kind of seed; refuse what is none, or what incomplete seeds cannot do.

    Raises
    ------
    InputError
        If it is not one of `SEEDS`, or if it is incomplete beside a dense inverse or an accuracy.
    """
    check_choice("seed", kind, SEEDS)
    if kind == "incomplete" and isinstance(solver, QuasiNewton) and solver.memory == "full":
        raise InputError(
            f"seed='incomplete' approximates a sparse factor, and {solver!r} starts from the whole "
            "inverse: take solver='auto' or a number of pairs, or leave out seed"
        )
    if kind == "incomplete" and accuracy is not None:
        raise InputError(
            f"accuracy={accuracy:g} estimates errors with an exact factor: leave out "
            "seed='incomplete', or give dt and no accuracy"
        )
    return kind


def make_seed(system: System, kind: str, solver: Method | str, threads: int) -> Seed:
    """Make the seed of a run, ordered but not yet factored.

    Parameters
    ----------
    system : System
        Its pattern, and which coordinates are vectors.
    kind : str
        One of `SEEDS`.
    solver : Method or str
        How the equations of a step are solved.
    threads : int
        Most threads for an exact factor.

    Raises
    ------
    InputError
        If an incomplete seed is asked for where there are multipliers.
    """
    pattern = system.pattern
    if kind == "incomplete":
        if system.n_multipliers:
            raise InputError(
                "seed='incomplete' needs a positive definite matrix, which multipliers prevent: "
                f"the {system.constraints.labels[0]} has one ({system.n_multipliers} in all); "
                "leave out seed, or use joints without multipliers, such as pins"
            )
        vectors, node = vectors_of(system.places, system.dim, system.n_free)
        return IncompleteSeed(pattern.indptr, pattern.indices, vectors, node)
    return SparseSeed(pattern.indptr, pattern.indices, system.n_free, threads)
