"""Which constraints of a scene repeat others, by the rank of their gradients."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import MAX_MAGNITUDE
from ancfsparse.errors import RedundantConstraintsWarning
from ancfsparse.seeds import SparseSeed
from ancfsparse.system import System

if TYPE_CHECKING:
    import scipy.sparse as sp

Vector = NDArray[np.float64]

# Share of a gradient that must be independent of the others, or it is redundant.
INDEPENDENT_RATIO = 1e-8
# What is added to squares of gradients of length one, so that a factor exists.
ROUNDING = 1e-14
# Pivot below which a gradient is suspect: that of a combination of many is the larger.
SUSPECT_PIVOT = 1e-10
# Share of a linear combination from which a constraint is named as a part of it.
MIN_COEFFICIENT = 1e-3
# Largest number of equations that are looked at together.
MAX_DENSE_EQUATIONS = 300
# Share of prescribed changes that does not fit together where joints contradict each other.
MIN_CONTRADICTION = 0.1
# Number of constraints that are named, and of those that are looked at for it.
MAX_NAMED, MAX_EXAMINED = 3, 12


def warn_of_redundant_constraints(system: System) -> None:
    """Warn of constraints that repeat others.

    Their forces are not unique; a small regularization distributes them.

    Warns
    -----
    RedundantConstraintsWarning
        With the first of them and what they repeat.
    """
    if not len(system.constraints.offset):
        return
    number, found = find_redundant_constraints(system, system.q0)
    if not number:
        return
    labels = system.constraints.labels
    words = [
        f"the {labels[row]}, {_describe_redundancy(labels, of)}" for row, of in found[:MAX_NAMED]
    ]
    more = f" and {number - MAX_NAMED} more" if number > MAX_NAMED else ""
    warnings.warn(
        f"{number} of {len(labels)} constraints repeat others at the start: "
        f"{'; '.join(words)}{more}.  The motion is not affected, but their forces are distributed "
        "arbitrarily: leave out a joint that repeats another, or use one with more freedom",
        RedundantConstraintsWarning,
        stacklevel=4,
    )


def describe_contradiction(system: System, q: Vector, t: float) -> str:
    """Name joints that cannot hold together at a time, since their motions are prescribed.

    An equation that repeats others where the scene is must also have the values that follow from
    theirs; where a step changes these by a good share of what it prescribes, it has no solution.

    Parameters
    ----------
    system : System
        What moves.
    q : (n_all,) float
        Its last accepted coordinates.
    t : float
        End of the failed step [s].

    Returns
    -------
    str
        A sentence, empty if all equations fit together.
    """
    if not system.prescribed or not np.max(np.abs(q)) < MAX_MAGNITUDE:
        return ""
    found = find_redundant_constraints(system, q)[1]
    if not found:
        return ""
    motion, there, none = system.prescribed.at(t), q.copy(), np.zeros(system.n_all)
    there[len(q) - system.prescribed.n :] = motion.q
    amplitudes = system.loads.amplitudes(np.array([t]))[0]
    rest = np.zeros(system.n_multipliers)
    phi = system.assembly.residual(there, none, none, rest, none, amplitudes)[1]
    phi[system.n_multipliers - system.prescribed.n_equations :] -= motion.s
    gradients = system.constraints.jacobian(q)[:, : system.n_free]
    for row, others in found:
        of_row, of_others = gradients[[row]].toarray()[0], gradients[others].toarray()
        shares = np.linalg.lstsq(of_others.T, of_row, rcond=None)[0] if others else np.zeros(0)
        parts = np.append(-shares * phi[others], phi[row])
        if abs(np.sum(parts)) > MIN_CONTRADICTION * np.max(np.abs(parts)):
            labels = system.constraints.labels
            names = dict.fromkeys(labels[each] for each in others)
            listed = " and ".join(f"the {name}" for name in list(names)[:MAX_NAMED])
            return (
                f"The joints contradict each other: the {labels[row]} repeats {listed}, and what "
                "they prescribe does not fit together; leave one out, or prescribe the same."
            )
    return ""


def _describe_redundancy(labels: list[str], others: list[int]) -> str:
    """Name what an equation follows from."""
    if not others:
        return "which holds nothing that can move"
    more = f" and {len(others) - 1} more" if len(others) > 1 else ""
    return f"which follows from the {labels[others[0]]}{more}"


def count_near_dependent(system: System, q: Vector, share: float) -> int:
    """Count constraints of whose gradients less than a share is independent of those before.

    Parameters
    ----------
    system : System
        What moves.
    q : (n_all,) float
        Its coordinates.
    share : float
        From 0 to 1.
    """
    if not np.max(np.abs(q)) < MAX_MAGNITUDE:  # the motion is lost, which the run reports
        return 0
    pivots = _factored(_unit_gradients(system, q)).pivots
    return int(np.sum(pivots < share**2))


def find_redundant_constraints(
    system: System, q: Vector
) -> tuple[int, list[tuple[int, list[int]]]]:
    """Find the equations that repeat others, in a time that is linear in their number.

    The pivots of phi_q phi_q^T, of gradients of length one, are the squares of what each adds to
    those before it.  Where one is rounding, the solution for it is a combination that vanishes, and
    the equations in that are looked at by themselves.

    Parameters
    ----------
    system : System
        What moves.
    q : (n_all,) float
        Its coordinates.

    Returns
    -------
    int
        Number of equations that repeat others.
    list of (int, list of int)
        The first of them, each with those that it is made of, largest part first.
    """
    gradients = _unit_gradients(system, q)
    factor = _factored(gradients)
    suspects = np.flatnonzero(factor.pivots < SUSPECT_PIVOT)
    involved: set[int] = set()
    found: list[tuple[int, list[int]]] = []
    for suspect in suspects[:MAX_EXAMINED]:
        parts = np.zeros(gradients.shape[0])
        parts[suspect] = 1.0
        for _ in range(2):
            parts = factor.solve(parts)
            parts /= np.max(np.abs(parts))
        involved |= set(np.flatnonzero(np.abs(parts) > MIN_COEFFICIENT).tolist())
        if len(involved) > MAX_DENSE_EQUATIONS:
            break
    if involved:
        # Equations that keep bodies rigid come first, so that joints are found to repeat them.
        rows = np.array(sorted(involved))
        is_joint = np.array(system.constraints.mass)[rows] == 0.0
        rows = rows[np.argsort(is_joint, kind="stable")]
        found = _find_dependent_rows(gradients[rows], rows)
    looked_at_all = len(suspects) <= MAX_EXAMINED and len(involved) <= MAX_DENSE_EQUATIONS
    return len(found) if looked_at_all else len(suspects), found


def _unit_gradients(system: System, q: Vector) -> sp.csr_array:
    """Return the gradients of the constraints by the free coordinates, each of length one."""
    import scipy.sparse as sp

    phi_q = sp.csr_array(system.constraints.jacobian(q)[:, : system.n_free])
    sizes = np.sqrt(phi_q.power(2).sum(axis=1))
    return sp.csr_array(sp.diags_array(1.0 / np.where(sizes > 0.0, sizes, 1.0)) @ phi_q)


def _factored(gradients: sp.csr_array) -> SparseSeed:
    """Factor the products of all pairs of gradients."""
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
    """Return which rows of a few repeat those before them, and which these are."""
    used = np.unique(gradients.indices)
    table = gradients[:, used].toarray()
    basis: list[Vector] = []
    taken: list[int] = []
    found = []
    for k, row in enumerate(table):
        left = row.copy()
        for _ in range(2):  # the second time takes away what rounding left
            if basis:
                known = np.array(basis)
                left -= known.T @ (known @ left)
        rest = float(np.linalg.norm(left))
        if rest > INDEPENDENT_RATIO:
            basis.append(left / rest)
            taken.append(k)
            continue
        others = np.array(taken, dtype=int)
        shares = np.abs(np.linalg.lstsq(table[others].T, row, rcond=None)[0])
        largest = others[np.argsort(-shares, kind="stable")]
        count = int(np.sum(shares > MIN_COEFFICIENT))
        found.append((int(rows[k]), [int(rows[j]) for j in largest[:count]]))
    return found
