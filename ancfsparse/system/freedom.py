"""Which motions without strain a scene leaves free: what makes a static problem singular."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ancfsparse.scene import Body
from ancfsparse.system.system import System

Vector = NDArray[np.float64]

# A free motion names no more of the parts that take part in it.
NAMED = 3
# Singular values below this share of the largest are rounding.
RANK = 1e-7


@dataclass(frozen=True)
class Part:
    """A piece that is rigid if nothing strains: a beam, a line of a mesh.

    Attributes
    ----------
    name : str
        For messages.
    places : (n_rows, n_c) int
        Places of its coordinates.
    basis : (n_rows * n_c, k) float
        Orthonormal basis of its rigid motions.
    mix : (k, m) float
        The named motions in that basis.
    """

    name: str
    places: NDArray[np.int32]
    basis: Vector
    mix: Vector


def free_motions(system: System) -> list[str]:
    """Name the motions in which every part stays rigid and that no joint prevents.

    Parts are the beams and the lines of meshes; of meshes with very many lines, what is connected.

    Parameters
    ----------
    system : System
        Looked at in its reference shape.

    Returns
    -------
    list of str
        Such as ``"rotation about z of beam 0"``; empty if the joints hold everything.
    """
    parts = [part for beam in system.scene.beams for part in _parts(system, beam)]
    # Every coordinate of every part by itself; then what shares a place must move alike.
    moves = sp.block_diag([part.basis for part in parts], format="csr")
    place = np.concatenate([part.places.ravel() for part in parts])
    first = np.unique(place, return_index=True)[1]
    shared = np.flatnonzero(first[place] != np.arange(len(place)))
    conditions = sp.vstack(
        [
            moves[shared] - moves[first[place[shared]]],
            moves[place >= system.n_free],
            system.constraints.jacobian(system.q0) @ moves[first],
        ]
    )
    sizes, vectors = np.linalg.eigh((conditions.T @ conditions).toarray())
    free = vectors[:, sizes <= RANK**2 * max(1.0, float(sizes[-1]))]
    return _names(system.dim, parts, free.T)


def _names(dim: int, parts: list[Part], free: Vector) -> list[str]:
    """Say what the free motions are: reduce them until each holds a named motion of its own.

    Rotations come first, because a turn about a distant point is a turn and a translation.
    """
    if len(free) == 0:
        return []
    ends = np.cumsum([part.basis.shape[1] for part in parts])
    shares = np.split(free, ends[:-1], axis=1)
    named = [
        np.linalg.lstsq(part.mix, share.T, rcond=None)[0].T
        for part, share in zip(parts, shares, strict=True)
    ]
    turns = "z" if dim == 2 else "xyz"
    motions = [f"translation along {axis}" for axis in "xyz"[:dim]]
    motions += [f"rotation about {axis}" for axis in turns]
    rows = np.hstack(named)
    order = [k * len(motions) + m for m in range(len(motions))[::-1] for k in range(len(parts))]
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
    moving = np.abs(rows).reshape(len(rows), len(parts), len(motions)).max(axis=2) > 1e-6
    told = [
        f"{name} of " + _listed([p.name for p, moves in zip(parts, row, strict=True) if moves])
        for name, row in zip(names, moving, strict=True)
    ]
    return sorted(told, key=lambda name: name.startswith("rotation"))


def _listed(names: list[str]) -> str:
    more = len(names) - NAMED
    return " and ".join(names[:NAMED] + ([f"{more} more"] if more > 0 else []))


def _parts(system: System, beam: Body) -> list[Part]:
    """Return the rigid parts of a beam or mesh."""
    rows = np.argsort(beam.parts, kind="stable")
    pieces = np.split(rows, np.flatnonzero(np.diff(beam.parts[rows])) + 1)
    places, nodes = system.places[system.scene.beams.index(beam)], beam.row_nodes
    names = [beam.name]
    if len(pieces) > 1:
        ends = [(nodes[piece].min(), nodes[piece].max()) for piece in pieces]
        names = [f"{beam.name} (nodes {low} to {high})" for low, high in ends]
    return [
        Part(
            name,
            places[piece],
            *_rigid_motions(system, places[piece], beam.positions[nodes[piece[0]]]),
        )
        for name, piece in zip(names, pieces, strict=True)
    ]


def _rigid_motions(
    system: System, places: NDArray[np.int32], start: Vector
) -> tuple[Vector, Vector]:
    """Return an orthonormal basis (n, k) of a part's rigid motions and the named ones in it (k, m).

    The named motions are translations along and rotations about axes through the part's start;
    a rotation of a cable about itself moves nothing and falls out of the basis.
    """
    dim = system.dim
    turns = [2] if dim == 2 else [0, 1, 2]
    named = np.zeros((*places.shape, dim + len(turns)))
    for d in range(dim):
        named[:, d, d] = 1.0
    for k in range(places.shape[1] // dim):
        columns = slice(dim * k, dim * (k + 1))
        vectors = np.zeros((len(places), 3))
        vectors[:, :dim] = system.q0[places[:, columns]] - (start if k == 0 else 0.0)
        for t, axis in enumerate(turns):
            named[:, columns, dim + t] = np.cross(np.eye(3)[axis], vectors)[:, :dim]
    flat = named.reshape(-1, named.shape[2])
    basis, sizes, mix = np.linalg.svd(flat, full_matrices=False)
    real = sizes > RANK * sizes[0]
    return basis[:, real], sizes[real, None] * mix[real]
