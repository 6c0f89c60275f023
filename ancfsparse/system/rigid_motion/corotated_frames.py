"""Corotated frames of seeds: rotation of vectors with nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Integers
from ancfsparse.dispatch import compiled_module
from ancfsparse.scene.kinematics.linear_forms import LINEAR
from ancfsparse.system.system import System

if TYPE_CHECKING:
    from ancfsparse.abi.nodal_frames import Frame


def make_corotated_frame(system: System) -> Frame:
    """Return the compiled rotations of a system's nodes, see ``ancf_frame`` in solver_abi.h.

    Positions and slopes rotate with their row; a position of several rows, as at the crossings of a
    net, rotates with their average.  A vector is not rotated if one of its components is fixed or
    is part of a linear constraint, because these directions do not rotate with the body.

    Parameters
    ----------
    system : System
        The system.
    """
    dim, n_free = system.dim, system.n_free
    rotates = np.zeros(system.n_all, dtype=bool)
    rotates[:n_free] = True
    rotates[_in_linear_constraints(system)] = False

    n_rows = sum(len(places) for places in system.places)
    axes = np.full((n_rows, dim if dim == 2 else 6), -1, dtype=np.int32)
    positions = np.empty((n_rows, dim), dtype=np.int32)
    vectors, rotations = [], []
    begin = 0
    for kind, places in zip(system.kinds, system.places, strict=True):
        rows = np.arange(begin, begin + len(places), dtype=np.int32)
        across = [name for name in kind.section if name != "r_x"][: dim - 2]
        for k, name in enumerate((*kind.axis[1:], *across)):
            axes[rows, dim * k : dim * (k + 1)] = places[:, kind.columns(name)]
        positions[rows] = places[:, kind.columns("r")]
        for name in kind.vectors[1:]:
            if len(kind.directions(name)) == dim:  # not r_z in the plane
                vectors.append(places[:, kind.columns(name)])
                rotations.append(rows)
        begin += len(places)

    single, shared, start, rows_of = _group_by_position(positions)
    vectors += [positions[single], positions[shared]]
    rotations += [single, n_rows + np.arange(len(shared), dtype=np.int32)]
    where, rotation_of = np.concatenate(vectors), np.concatenate(rotations)
    rotating = rotates[where].all(axis=1)
    frame: Frame = compiled_module("rotation").Frame(
        n_free + system.n_multipliers,
        axes,
        start,
        rows_of,
        np.ascontiguousarray(where[rotating], dtype=np.int32),
        np.ascontiguousarray(rotation_of[rotating], dtype=np.int32),
    )
    return frame


def _in_linear_constraints(system: System) -> Integers:
    """Return the coordinates of constraints with only linear terms."""
    c = system.constraints
    row, i, j = (np.array(x, dtype=np.int32) for x in (c.row, c.i, c.j))
    curved = np.zeros(system.n_multipliers, dtype=bool)
    curved[row[j != LINEAR]] = True
    return np.asarray(i[~curved[row]])


def _group_by_position(positions: Integers) -> tuple[Integers, Integers, Integers, Integers]:
    """Group rows by their position.

    Parameters
    ----------
    positions : (n_rows, dim) int32
        Indices of the position of each row.

    Returns
    -------
    single : (k,) int32
        Rows with a position of their own.
    shared : (m,) int32
        One row of each group with a common position.
    start, rows : (m + 1,), (p,) int32
        Rows of these groups.
    """
    order = np.argsort(positions[:, 0], kind="stable").astype(np.int32)
    first = positions[order, 0]
    begins = np.flatnonzero(np.append(True, first[1:] != first[:-1]))
    sizes = np.diff(np.append(begins, len(order)))
    alone = sizes == 1
    rows = order[np.repeat(~alone, sizes)]
    start = np.concatenate([[0], np.cumsum(sizes[~alone])]).astype(np.int32)
    return order[begins[alone]], order[begins[~alone]], start, rows
