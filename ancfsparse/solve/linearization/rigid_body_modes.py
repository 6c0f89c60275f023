"""Which motions without strain a scene leaves free: what makes a static problem singular."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import SingularSceneError
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.linearization.describe_motions import named
from ancfsparse.system.rigid_motion.rigid_parts import Part, parts_of
from ancfsparse.system.system import System

if TYPE_CHECKING:
    import scipy.sparse as sp

Vector = NDArray[np.float64]

# So many free motions are named at most.
MAX_FREE_MOTIONS = 24
# A part is held if every motion of one radian, or by its own size, breaks a condition by more than
# this share; rounding of positions far from the origin adds to it.
HELD = 1e-10
EPSILON = float(np.finfo(np.float64).eps)
# Weight that makes the squares of the conditions definite, beside the largest, and the number of
# times that the free motions are filtered out.
SHIFT, FILTERS = 1e-13, 4


@dataclass(frozen=True)
class Conditions:
    """Equations of rigid parts: places that they share, places that are held, constraints.

    Attributes
    ----------
    matrix : (n_conditions, n_modes) sparse
        Each row in metres, or without a unit, for the modes of all parts (see `Part`).
    units : (n_conditions, n_parts) sparse
        What a row would be for a motion of that part alone, before anything cancels.
    first : (n_parts + 1,) int
        First mode of each part, and the end.
    """

    matrix: sp.csr_array
    units: sp.csr_array
    first: NDArray[np.int64]


def free_motions(system: System) -> list[str]:
    """Name the motions in which every part stays rigid and that no joint prevents.

    Parts that the ground holds are found one after another along the graph of the scene, each
    measured by its own size; what is left are groups that can only be held together.

    Parameters
    ----------
    system : System
        Looked at in its reference shape.

    Returns
    -------
    list of str
        Such as ``"rotation about z through (0, 0) m of beam 0"``; empty if the joints hold
        everything; at most `MAX_FREE_MOTIONS`.
    """
    parts = parts_of(system)
    conditions = _conditions(system, parts)
    span = float(np.max(np.abs(system.q_ref)))
    rounding = np.array([HELD + 16.0 * EPSILON * span / part.size for part in parts])
    loose = _not_held_alone(conditions, rounding)
    if not loose.any():
        return []
    names: list[str] = []
    for group in _groups(conditions, loose):
        columns = np.concatenate([np.arange(*conditions.first[k : k + 2]) for k in group])
        free = _null_space(conditions, group, columns, float(rounding[group].max()))
        members = [parts[k] for k in group]
        names += named(system.dim, members, free)
        if len(names) >= MAX_FREE_MOTIONS:
            return names[:MAX_FREE_MOTIONS]
    return sorted(names, key=lambda name: not name.startswith("translation"))


def check_held(system: System) -> None:
    """Refuse a scene that its joints do not hold.

    Raises
    ------
    SingularSceneError
        With the number of free motions and the name of the first.
    """
    free = free_motions(system)
    if free:
        raise describe_free_motions(free)


def describe_free_motions(free: list[str], why: str = "") -> SingularSceneError:
    """Return the error that names free motions, and why loads do not restrain them."""
    count = f"{len(free)}{' or more' * (len(free) == MAX_FREE_MOTIONS)}"
    return SingularSceneError(
        f"the scene is not held: {count} rigid motion{' is' if len(free) == 1 else 's are'} free, "
        f"first the {free[0]}"
        f"{why and ', and '}{why}; add a pin or a clamp"
    )


def _conditions(system: System, parts: list[Part]) -> Conditions:
    """Write down the conditions on the modes of all parts."""
    import scipy.sparse as sp

    dim = system.dim
    count = np.array([dim + len(part.axes) for part in parts])
    first = np.concatenate([[0], np.cumsum(count)])
    uses = np.zeros(system.n_all, dtype=np.int32)
    for part in parts:
        np.add.at(uses, part.places.ravel(), 1)
    held = [each.holds(system.q_ref) for each in system.contributions]
    rows = [system.constraints.jacobian(system.q_ref), *(each for each in held if each is not None)]
    phi_q = sp.csr_array(sp.vstack(rows))
    wanted = uses > 1
    wanted[system.n_free :] = True
    wanted[np.unique(phi_q.indices)] = True
    moves = [_moves(system, part, wanted) for part in parts]
    place = np.concatenate([each[0] for each in moves])
    owner = np.repeat(np.arange(len(parts)), [len(each[0]) for each in moves])
    unit = np.concatenate([each[2] for each in moves])
    by_mode = sp.block_diag([sp.coo_array(each[1]) for each in moves], format="csr")
    by_part = sp.csr_array((unit, (np.arange(len(unit)), owner)), shape=(len(unit), len(parts)))
    # The first part at a place defines its motion: that of the others there must be the same.
    _, speaker, group = np.unique(place, return_index=True, return_inverse=True)
    other = np.flatnonzero(speaker[group] != np.arange(len(place)))
    fixed = np.flatnonzero((place >= system.n_free) & (speaker[group] == np.arange(len(place))))
    at = np.full(system.n_all, -1)
    at[place[speaker]] = speaker
    across = phi_q.tocoo()
    picked = sp.csr_array(
        (across.data, (across.coords[0], at[across.coords[1]])), shape=(phi_q.shape[0], len(place))
    )
    matrix = [by_mode[other] - by_mode[speaker[group[other]]], by_mode[fixed], picked @ by_mode]
    units = [by_part[other] + by_part[speaker[group[other]]], by_part[fixed], abs(picked) @ by_part]
    return Conditions(sp.vstack(matrix, format="csr"), sp.vstack(units, format="csr"), first)


def _moves(
    system: System, part: Part, wanted: NDArray[np.bool_]
) -> tuple[NDArray[np.int32], Vector, Vector]:
    """Return the wanted places of a part, how they move with its modes, and in what unit."""
    dim = system.dim
    row, column = np.nonzero(wanted[part.places])
    places = part.places[row, column]
    kind = part.kind
    out = np.zeros((len(row), dim + len(part.axes)))
    unit = np.ones(len(row))
    for name in kind.vectors:
        columns, directions = kind.columns(name), np.array(kind.directions(name))
        mine = np.flatnonzero((column >= columns.start) & (column < columns.stop))
        component = directions[column[mine] - columns.start]
        arm = np.zeros((len(mine), 3))
        arm[:, directions] = system.q_ref[part.places[row[mine], columns]]
        if name == "r":
            unit[mine] = out[mine, component] = part.size
            arm -= part.start
        for k, axis in enumerate(part.axes):
            turned = np.cross(axis, arm)
            out[mine, dim + k] = turned[np.arange(len(mine)), component]
    return places, out, unit


def _not_held_alone(conditions: Conditions, rounding: Vector) -> NDArray[np.bool_]:
    """Return which parts the ground and parts that are held already do not hold one by one."""
    n_parts = len(conditions.first) - 1
    matrix, units = conditions.matrix, conditions.units
    of_part = units.tocsc()
    loose = np.ones(n_parts, dtype=bool)
    # How many loose parts each condition is about.
    about = np.diff(units.indptr)
    waiting = list(range(n_parts))[::-1]
    while waiting:
        k = waiting.pop()
        if not loose[k]:
            continue
        span = slice(of_part.indptr[k], of_part.indptr[k + 1])
        rows, scale = of_part.indices[span], of_part.data[span]
        mine = about[rows] == 1
        begin, end = conditions.first[k : k + 2]
        if np.count_nonzero(mine) < end - begin:
            continue
        block = matrix[rows[mine]][:, begin:end].toarray() / scale[mine, None]
        if np.linalg.svd(block, compute_uv=False)[-1] <= rounding[k]:
            continue
        loose[k] = False
        about[rows] -= 1
        near = units[rows]
        waiting.extend(int(other) for other in np.unique(near.indices) if loose[other])
    return loose


def _groups(conditions: Conditions, loose: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """Return the loose parts that conditions bind together."""
    from scipy.sparse.csgraph import connected_components

    members = np.flatnonzero(loose)
    bound = conditions.units[:, members]
    _, label = connected_components(bound.T @ bound, directed=False)
    order = np.argsort(label, kind="stable")
    return np.split(members[order], np.flatnonzero(np.diff(label[order])) + 1)


def _null_space(
    conditions: Conditions, group: NDArray[np.int64], columns: NDArray[np.int64], held: float
) -> Vector:
    """Return at most `MAX_FREE_MOTIONS` independent motions without restraint, (k, n_columns).

    Powers of the inverse of the squared conditions filter them out, closely enough to identify them
    by their residual in the conditions.
    """
    import scipy.sparse as sp

    matrix, units = conditions.matrix[:, columns], conditions.units[:, group]
    rows = np.flatnonzero(np.diff(units.indptr))
    largest = np.maximum.reduceat(units.data, units.indptr[rows]) if len(rows) else np.ones(0)
    matrix = sp.diags_array(1.0 / largest) @ matrix[rows]
    n = len(columns)
    found = (
        np.eye(n)
        if n <= MAX_FREE_MOTIONS
        else np.random.default_rng(0).standard_normal((n, MAX_FREE_MOTIONS))
    )
    if n > MAX_FREE_MOTIONS:
        squares = sp.csc_array(matrix.T @ matrix)
        shift = SHIFT * float(squares.diagonal().max())
        lower = sp.csc_array(sp.tril(squares + shift * sp.eye_array(n, format="csc")))
        lower.sort_indices()
        seed = SparseSeed(lower.indptr, lower.indices, n)
        seed.factor(lower.data)
        for _ in range(FILTERS):
            found = np.linalg.qr(found)[0]
            found = np.stack([seed.solve(column) for column in found.T.copy()], axis=1)
        found = np.linalg.qr(found)[0]
    # Reduced to a small matrix with the same singular values.
    _, sizes, mixes = np.linalg.svd(np.linalg.qr(matrix @ found)[1], full_matrices=True)
    sizes = np.append(sizes, np.zeros(len(mixes) - len(sizes)))
    return np.asarray((found @ mixes[sizes <= held].T).T)
