"""Find the rigid-body modes that the joints of a scene leave free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.errors import SingularSceneError
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.linearization.describe_motions import name_motions
from ancfsparse.system.rigid_motion.rigid_parts import RigidPart, find_rigid_parts
from ancfsparse.system.system import System

if TYPE_CHECKING:
    import scipy.sparse as sp


MAX_FREE_MOTIONS = 24  # that are named
# Rounding of positions far from the origin adds to it.
RESTRAINT_TOLERANCE = 1e-10  # violation by a motion of one radian or of the size of a part
EPSILON = float(np.finfo(np.float64).eps)
SHIFT_RATIO = 1e-13  # added to the squared conditions, over the largest, for a definite matrix
N_FILTERS = 4  # powers of its inverse


@dataclass(frozen=True)
class Conditions:
    """Conditions on the motions of rigid parts: shared and fixed coordinates, constraints.

    Attributes
    ----------
    matrix : (n_conditions, n_modes) sparse
        Each row in metres, or without a unit, for the modes of all parts (see `RigidPart`).
    units : (n_conditions, n_parts) sparse
        Size of a row for a motion of one part alone, without cancellation.
    first : (n_parts + 1,) int
        First mode of each part, and the end.
    """

    matrix: sp.csr_array
    units: sp.csr_array
    first: NDArray[np.int64]


def free_motions(system: System) -> list[str]:
    """Name the motions of rigid parts that no joint prevents.

    Parts that are connected to the ground are found one after another along the graph of the scene,
    each measured by its own size; groups that can only be restrained together remain.

    Parameters
    ----------
    system : System
        In its reference shape.

    Returns
    -------
    list of str
        Such as ``"rotation about z through (0, 0) m of beam 0"``, at most `MAX_FREE_MOTIONS`; empty
        if the joints restrain all motions.
    """
    parts = find_rigid_parts(system)
    conditions = _assemble_conditions(system, parts)
    span = float(np.max(np.abs(system.q_ref)))
    rounding = np.array([RESTRAINT_TOLERANCE + 16.0 * EPSILON * span / part.size for part in parts])
    is_free = _find_unrestrained(conditions, rounding)
    if not is_free.any():
        return []
    names: list[str] = []
    for group in _connected_groups(conditions, is_free):
        columns = np.concatenate([np.arange(*conditions.first[k : k + 2]) for k in group])
        free = _null_space(conditions, group, columns, float(rounding[group].max()))
        members = [parts[k] for k in group]
        names += name_motions(system.dim, members, free)
        if len(names) >= MAX_FREE_MOTIONS:
            return names[:MAX_FREE_MOTIONS]
    return sorted(names, key=lambda name: not name.startswith("translation"))


def check_restrained(system: System) -> None:
    """Check that the joints of a scene restrain all rigid motions.

    Raises
    ------
    SingularSceneError
        With the number of free motions and the name of the first.
    """
    free = free_motions(system)
    if free:
        raise describe_free_motions(free)


def describe_free_motions(free: list[str], why: str = "") -> SingularSceneError:
    """Return the error that names free motions, and the reason why loads do not restrain them."""
    count = f"{len(free)}{' or more' * (len(free) == MAX_FREE_MOTIONS)}"
    return SingularSceneError(
        f"the scene is not held: {count} rigid motion{' is' if len(free) == 1 else 's are'} free, "
        f"first the {free[0]}"
        f"{why and ', and '}{why}; add a pin or a clamp"
    )


def _assemble_conditions(system: System, parts: list[RigidPart]) -> Conditions:
    """Assemble the conditions on the modes of all parts."""
    import scipy.sparse as sp

    dim = system.dim
    count = np.array([dim + len(part.axes) for part in parts])
    first = np.concatenate([[0], np.cumsum(count)])
    uses = np.zeros(system.n_all, dtype=np.int32)
    for part in parts:
        np.add.at(uses, part.places.ravel(), 1)
    terms = [term.resisted_motions(system.q_ref) for term in system.contributions]
    rows = [system.constraints.jacobian(system.q_ref), *(x for x in terms if x is not None)]
    phi_q = sp.csr_array(sp.vstack(rows))
    is_used = uses > 1
    is_used[system.n_free :] = True
    is_used[np.unique(phi_q.indices)] = True
    moves = [_displacements(system, part, is_used) for part in parts]
    index = np.concatenate([move[0] for move in moves])
    owner = np.repeat(np.arange(len(parts)), [len(move[0]) for move in moves])
    unit = np.concatenate([move[2] for move in moves])
    by_mode = sp.block_diag([sp.coo_array(move[1]) for move in moves], format="csr")
    by_part = sp.csr_array((unit, (np.arange(len(unit)), owner)), shape=(len(unit), len(parts)))
    # The first part with a coordinate defines its motion; other parts must have the same.
    _, leader, group = np.unique(index, return_index=True, return_inverse=True)
    other = np.flatnonzero(leader[group] != np.arange(len(index)))
    fixed = np.flatnonzero((index >= system.n_free) & (leader[group] == np.arange(len(index))))
    row_of = np.full(system.n_all, -1)
    row_of[index[leader]] = leader
    entries = phi_q.tocoo()
    picked = sp.csr_array(
        (entries.data, (entries.coords[0], row_of[entries.coords[1]])),
        shape=(phi_q.shape[0], len(index)),
    )
    matrix = [by_mode[other] - by_mode[leader[group[other]]], by_mode[fixed], picked @ by_mode]
    units = [by_part[other] + by_part[leader[group[other]]], by_part[fixed], abs(picked) @ by_part]
    return Conditions(sp.vstack(matrix, format="csr"), sp.vstack(units, format="csr"), first)


def _displacements(
    system: System, part: RigidPart, is_used: NDArray[np.bool_]
) -> tuple[NDArray[np.int32], Vector, Vector]:
    """Return the used coordinates of a part, their displacements in its modes, and their units."""
    dim = system.dim
    row, column = np.nonzero(is_used[part.places])
    indices = part.places[row, column]
    kind = part.kind
    out = np.zeros((len(row), dim + len(part.axes)))
    unit = np.ones(len(row))
    for name in kind.vectors:
        columns, directions = kind.columns(name), np.array(kind.directions(name))
        chosen = np.flatnonzero((column >= columns.start) & (column < columns.stop))
        component = directions[column[chosen] - columns.start]
        arm = np.zeros((len(chosen), 3))
        arm[:, directions] = system.q_ref[part.places[row[chosen], columns]]
        if name == "r":
            unit[chosen] = out[chosen, component] = part.size
            arm -= part.start
        for k, axis in enumerate(part.axes):
            rotated = np.cross(axis, arm)
            out[chosen, dim + k] = rotated[np.arange(len(chosen)), component]
    return indices, out, unit


def _find_unrestrained(conditions: Conditions, rounding: Vector) -> NDArray[np.bool_]:
    """Return the parts that neither the ground nor restrained parts hold one by one."""
    n_parts = len(conditions.first) - 1
    matrix, units = conditions.matrix, conditions.units
    of_part = units.tocsc()
    is_free = np.ones(n_parts, dtype=bool)
    # Number of free parts in each condition.
    n_free = np.diff(units.indptr)
    queue = list(range(n_parts))[::-1]
    while queue:
        k = queue.pop()
        if not is_free[k]:
            continue
        span = slice(of_part.indptr[k], of_part.indptr[k + 1])
        rows, scale = of_part.indices[span], of_part.data[span]
        alone = n_free[rows] == 1
        begin, end = conditions.first[k : k + 2]
        if np.count_nonzero(alone) < end - begin:
            continue
        block = matrix[rows[alone]][:, begin:end].toarray() / scale[alone, None]
        if np.linalg.svd(block, compute_uv=False)[-1] <= rounding[k]:
            continue
        is_free[k] = False
        n_free[rows] -= 1
        neighbours = np.unique(units[rows].indices)
        queue.extend(int(other) for other in neighbours if is_free[other])
    return is_free


def _connected_groups(
    conditions: Conditions, is_free: NDArray[np.bool_]
) -> list[NDArray[np.int64]]:
    """Return the free parts in groups that conditions connect."""
    from scipy.sparse.csgraph import connected_components

    members = np.flatnonzero(is_free)
    units = conditions.units[:, members]
    _, label = connected_components(units.T @ units, directed=False)
    order = np.argsort(label, kind="stable")
    return np.split(members[order], np.flatnonzero(np.diff(label[order])) + 1)


def _null_space(
    conditions: Conditions, group: NDArray[np.int64], columns: NDArray[np.int64], rounding: float
) -> Vector:
    """Return at most `MAX_FREE_MOTIONS` independent motions without restraint, (k, n_columns).

    Inverse iteration with the squared conditions, until their residuals identify them.
    """
    import scipy.sparse as sp

    matrix, units = conditions.matrix[:, columns], conditions.units[:, group]
    rows = np.flatnonzero(np.diff(units.indptr))
    largest = np.maximum.reduceat(units.data, units.indptr[rows]) if len(rows) else np.ones(0)
    matrix = sp.diags_array(1.0 / largest) @ matrix[rows]
    n = len(columns)
    if n <= MAX_FREE_MOTIONS:
        basis = np.eye(n)
    else:
        squares = sp.csc_array(matrix.T @ matrix)
        shift = SHIFT_RATIO * float(squares.diagonal().max())
        lower = sp.csc_array(sp.tril(squares + shift * sp.eye_array(n, format="csc")))
        lower.sort_indices()
        seed = SparseSeed(lower.indptr, lower.indices, n)
        seed.factor(lower.data)
        basis = np.random.default_rng(0).standard_normal((n, MAX_FREE_MOTIONS))
        for _ in range(N_FILTERS):
            basis = np.linalg.qr(basis)[0]
            basis = np.stack([seed.solve(column) for column in basis.T.copy()], axis=1)
        basis = np.linalg.qr(basis)[0]
    # A small matrix with the same singular values.
    _, sizes, mixes = np.linalg.svd(np.linalg.qr(matrix @ basis)[1], full_matrices=True)
    sizes = np.append(sizes, np.zeros(len(mixes) - len(sizes)))
    return np.asarray((basis @ mixes[sizes <= rounding].T).T)
