"""Which motions without strain a scene leaves free: what makes a static problem singular."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ancfsparse.scene import Beam
from ancfsparse.system.system import System

Vector = NDArray[np.float64]

# Singular values below this share of the largest are rounding.
RANK = 1e-7


def free_motions(system: System) -> list[str]:
    """Name the motions in which every beam stays rigid and that no joint prevents.

    Parameters
    ----------
    system : System
        Looked at in its reference shape.

    Returns
    -------
    list of str
        Such as ``"rotation about z of beam 0"``; empty if the joints hold everything.
    """
    parts = [_rigid_motions(system, beam) for beam in system.scene.beams]
    # Every coordinate of every beam by itself; then what shares a place must move alike.
    moves = sp.block_diag([basis for basis, _ in parts], format="csr")
    place = np.concatenate([places.ravel() for places in system.places])
    first = np.unique(place, return_index=True)[1]
    shared = np.flatnonzero(first[place] != np.arange(len(place)))
    conditions = sp.vstack(
        [
            moves[shared] - moves[first[place[shared]]],
            moves[place >= system.n_free],
            sp.csr_array(system.constraints.jacobian(system.q0)) @ moves[first],
        ]
    )
    sizes, vectors = np.linalg.eigh((conditions.T @ conditions).toarray())
    free = vectors[:, sizes <= RANK**2 * max(1.0, float(sizes[-1]))]
    return _names(system, parts, free.T)


def _names(system: System, parts: list[tuple[Vector, Vector]], free: Vector) -> list[str]:
    """Say what the free motions are: reduce them until each holds a named motion of its own.

    Rotations come first, because a turn about a distant point is a turn and a translation.
    """
    if len(free) == 0:
        return []
    ends = np.cumsum([basis.shape[1] for basis, _ in parts])
    shares = np.split(free, ends[:-1], axis=1)
    named = [
        np.linalg.lstsq(mix, share.T, rcond=None)[0].T
        for (_, mix), share in zip(parts, shares, strict=True)
    ]
    beams, dim = [beam.name for beam in system.scene.beams], system.dim
    turns = "z" if dim == 2 else "xyz"
    motions = [f"translation along {axis}" for axis in "xyz"[:dim]]
    motions += [f"rotation about {axis}" for axis in turns]
    rows = np.hstack(named)
    order = [k * len(motions) + m for m in range(len(motions))[::-1] for k in range(len(beams))]
    names: list[str] = []
    for column in order:
        pivot = len(names)
        if pivot == len(rows):
            break
        best = pivot + int(np.argmax(np.abs(rows[pivot:, column])))
        if abs(rows[best, column]) <= 1e-6 * np.max(np.abs(rows)):
            continue
        rows[[pivot, best]] = rows[[best, pivot]]
        rows[pivot] /= rows[pivot, column]
        others = np.arange(len(rows)) != pivot
        rows[others] -= np.outer(rows[others, column], rows[pivot])
        names.append(motions[column % len(motions)])
    moving = np.abs(rows).reshape(len(rows), len(beams), len(motions)).max(axis=2) > 1e-6
    told = [
        f"{name} of " + " and ".join(b for b, moves in zip(beams, row, strict=True) if moves)
        for name, row in zip(names, moving, strict=True)
    ]
    return sorted(told, key=lambda name: name.startswith("rotation"))


def _rigid_motions(system: System, beam: Beam) -> tuple[Vector, Vector]:
    """Return an orthonormal basis (n, k) of a beam's rigid motions and the named ones in it (k, m).

    The named motions are translations along and rotations about axes through the beam's start;
    a rotation of a cable about itself moves nothing and falls out of the basis.
    """
    dim = system.dim
    places = system.places[system.scene.beams.index(beam)]
    turns = [2] if dim == 2 else [0, 1, 2]
    named = np.zeros((*places.shape, dim + len(turns)))
    for d in range(dim):
        named[:, d, d] = 1.0
    for k in range(places.shape[1] // dim):
        columns = slice(dim * k, dim * (k + 1))
        vectors = np.zeros((len(places), 3))
        vectors[:, :dim] = system.q0[places[:, columns]] - (beam.positions[0] if k == 0 else 0.0)
        for t, axis in enumerate(turns):
            named[:, columns, dim + t] = np.cross(np.eye(3)[axis], vectors)[:, :dim]
    flat = named.reshape(-1, named.shape[2])
    basis, sizes, mix = np.linalg.svd(flat, full_matrices=False)
    real = sizes > RANK * sizes[0]
    return basis[:, real], sizes[real, None] * mix[real]
