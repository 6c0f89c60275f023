"""Find redundant constraints of a scene by the rank of their gradients."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.checks import MAX_MAGNITUDE
from ancfsparse.errors import RedundantConstraintsWarning
from ancfsparse.seeds import SparseSeed
from ancfsparse.system import System

if TYPE_CHECKING:
    import scipy.sparse as sp


INDEPENDENT_RATIO = 1e-8  # independent part of a gradient below which its constraint is redundant
ROUNDING = 1e-14  # added to squares of unit gradients, so that a factor exists
SUSPECT_PIVOT = 1e-10  # below which a gradient may depend on others, even on many
MIN_COEFFICIENT = 1e-3  # of a linear combination whose constraints are named
MAX_DENSE_EQUATIONS = 300  # equations of a dense rank analysis
MIN_CONTRADICTION = 0.1  # relative misfit of prescribed values that is a contradiction
MAX_NAMED = 3  # constraints in a message
MAX_EXAMINED = 12  # constraints whose combinations are determined


def warn_of_redundant_constraints(system: System) -> None:
    """Warn of redundant constraints, and note them in the system.

    Their forces are not unique; a small regularization distributes them.

    Warns
    -----
    RedundantConstraintsWarning
        With the first of them, and the constraints that they depend on.
    """
    if not len(system.constraints.offset):
        return
    number, dependent = find_redundant_constraints(system, system.q0)
    system.is_redundant = number > 0
    if not number:
        return
    labels = system.constraints.labels
    parts = [
        f"the {labels[row]}, {_describe_redundancy(labels, of)}"
        for row, of in dependent[:MAX_NAMED]
    ]
    more = f" and {number - MAX_NAMED} more" if number > MAX_NAMED else ""
    warnings.warn(
        f"{number} of {len(labels)} constraints repeat others at the start: "
        f"{'; '.join(parts)}{more}.  The motion is not affected, but their forces are distributed "
        "arbitrarily: leave out a joint that repeats another, or use one with more freedom",
        RedundantConstraintsWarning,
        stacklevel=4,
    )


def describe_contradiction(system: System, q: Vector, t: float) -> str:
    """Name joints whose prescribed motions contradict each other at a time.

    A redundant equation must have the value that follows from the others; if a step changes this
    by a considerable part of the prescribed values, it has no solution.

    Parameters
    ----------
    system : System
        The moving system.
    q : (n_all,) float
        The last accepted coordinates.
    t : float
        End of the failed step [s].

    Returns
    -------
    str
        A sentence, empty if all equations are compatible.
    """
    if not system.prescribed or not np.max(np.abs(q)) < MAX_MAGNITUDE:
        return ""
    dependent = find_redundant_constraints(system, q)[1]
    if not dependent:
        return ""
    motion, displaced, zero = system.prescribed.at(t), q.copy(), np.zeros(system.n_all)
    displaced[len(q) - system.prescribed.n :] = motion.q
    amplitudes = system.loads.amplitudes(np.array([t]))[0]
    lam = np.zeros(system.n_multipliers)
    phi = system.assembly.residual(displaced, zero, zero, lam, zero, amplitudes)[1]
    phi[system.n_multipliers - system.prescribed.n_equations :] -= motion.s
    gradients = system.constraints.jacobian(q)[:, : system.n_free]
    for row, others in dependent:
        gradient, basis = gradients[[row]].toarray()[0], gradients[others].toarray()
        factors = np.linalg.lstsq(basis.T, gradient, rcond=None)[0] if others else np.zeros(0)
        parts = np.append(-factors * phi[others], phi[row])
        if abs(np.sum(parts)) > MIN_CONTRADICTION * np.max(np.abs(parts)):
            labels = system.constraints.labels
            names = dict.fromkeys(labels[other] for other in others)
            listed = " and ".join(f"the {name}" for name in list(names)[:MAX_NAMED])
            return (
                f"The joints contradict each other: the {labels[row]} depends on {listed}, and "
                "their prescribed values are incompatible; leave one out, or prescribe the same."
            )
    return ""


def _describe_redundancy(labels: list[str], others: list[int]) -> str:
    """Name the equations that an equation depends on."""
    if not others:
        return "which constrains no free coordinate"
    more = f" and {len(others) - 1} more" if len(others) > 1 else ""
    return f"which follows from the {labels[others[0]]}{more}"


def count_near_dependent(system: System, q: Vector, ratio: float) -> int:
    """Count constraints whose gradients are nearly combinations of those before them.

    Parameters
    ----------
    system : System
        The moving system.
    q : (n_all,) float
        Its coordinates.
    ratio : float
        Largest independent part of such a gradient, 0 to 1.
    """
    if not np.max(np.abs(q)) < MAX_MAGNITUDE:  # the run reports that
        return 0
    pivots = _factored(_unit_gradients(system, q)).pivots
    return int(np.sum(pivots < ratio**2))


def find_redundant_constraints(
    system: System, q: Vector
) -> tuple[int, list[tuple[int, list[int]]]]:
    """Find redundant equations, in a time that is linear in their number.

    The pivots of phi_q phi_q^T, with gradients of unit length, are the squares of the independent
    parts.  Where one is of the order of rounding, its solution is a combination that vanishes, and
    a dense rank analysis of the equations in it follows.

    Parameters
    ----------
    system : System
        The moving system.
    q : (n_all,) float
        Its coordinates.

    Returns
    -------
    int
        Number of redundant equations.
    list of (int, list of int)
        The first of them, each with the equations it depends on, largest coefficient first.
    """
    gradients = _unit_gradients(system, q)
    factor = _factored(gradients)
    suspects = np.flatnonzero(factor.pivots < SUSPECT_PIVOT)
    involved: set[int] = set()
    dependent: list[tuple[int, list[int]]] = []
    for suspect in suspects[:MAX_EXAMINED]:
        combination = np.zeros(gradients.shape[0])
        combination[suspect] = 1.0
        for _ in range(2):
            combination = factor.solve(combination)
            combination /= np.max(np.abs(combination))
        involved |= set(np.flatnonzero(np.abs(combination) > MIN_COEFFICIENT).tolist())
        if len(involved) > MAX_DENSE_EQUATIONS:
            break
    if involved:
        # Equations of rigid bodies come first, so that those of joints are found redundant.
        rows = np.array(sorted(involved))
        is_joint = np.array(system.constraints.mass)[rows] == 0.0
        rows = rows[np.argsort(is_joint, kind="stable")]
        dependent = _find_dependent_rows(gradients[rows], rows)
    is_complete = len(suspects) <= MAX_EXAMINED and len(involved) <= MAX_DENSE_EQUATIONS
    return len(dependent) if is_complete else len(suspects), dependent


def _unit_gradients(system: System, q: Vector) -> sp.csr_array:
    """Return the unit gradients of the constraints with respect to the free coordinates."""
    import scipy.sparse as sp

    phi_q = sp.csr_array(system.constraints.jacobian(q)[:, : system.n_free])
    sizes = np.sqrt(phi_q.power(2).sum(axis=1))
    return sp.csr_array(sp.diags_array(1.0 / np.where(sizes > 0.0, sizes, 1.0)) @ phi_q)


def _factored(gradients: sp.csr_array) -> SparseSeed:
    """Factor the Gram matrix of the gradients."""
    import scipy.sparse as sp

    squares = sp.csc_array(gradients @ gradients.T + ROUNDING * sp.eye_array(gradients.shape[0]))
    lower = sp.csc_array(sp.tril(squares))
    lower.sort_indices()
    seed = SparseSeed(lower.indptr, lower.indices, gradients.shape[0])
    seed.own.factor(lower.data)
    return seed


def _find_dependent_rows(
    gradients: sp.csr_array, rows: NDArray[np.intp]
) -> list[tuple[int, list[int]]]:
    """Return the rows that depend on those before them, each with these."""
    used = np.unique(gradients.indices)
    table = gradients[:, used].toarray()
    basis: list[Vector] = []
    independent: list[int] = []
    dependent = []
    for k, row in enumerate(table):
        remaining = row.copy()
        for _ in range(2):  # the second projection removes rounding
            if basis:
                known = np.array(basis)
                remaining -= known.T @ (known @ remaining)
        norm = float(np.linalg.norm(remaining))
        if norm > INDEPENDENT_RATIO:
            basis.append(remaining / norm)
            independent.append(k)
            continue
        others = np.array(independent, dtype=int)
        factors = np.abs(np.linalg.lstsq(table[others].T, row, rcond=None)[0])
        largest = others[np.argsort(-factors, kind="stable")]
        count = int(np.sum(factors > MIN_COEFFICIENT))
        dependent.append((int(rows[k]), [int(rows[j]) for j in largest[:count]]))
    return dependent
