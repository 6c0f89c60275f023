"""Rigid pieces of a scene and the motions in which they do not strain."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.kernels.catalog import ElementKind
from ancfsparse.scene import Body
from ancfsparse.system.system import System

Vector = NDArray[np.float64]
Places = NDArray[np.int32]

# A line that leaves its axis by less than this share of its length is straight: a cable does not
# notice that it turns about itself.
STRAIGHTNESS = 1e-7
# Nodes whose moments are added up at once.
CHUNK_SIZE = 65_536


@dataclass(frozen=True)
class RigidPart:
    """A piece that is rigid if nothing strains: a beam, or a line of a mesh.

    It moves by translations of its size along the axes of space and by turns of one radian about
    axes through its start, so all motions are of one size whatever the piece is measured in.

    Attributes
    ----------
    name : str
        For messages.
    kind : ElementKind
        Its element.
    places : (n_rows, n_c) int
        Places of its coordinates.
    start : (3,) float
        The point about which it turns [m]; its z is zero in the plane.
    size : float
        Length of its path in the reference shape [m].
    axes : (k, 3) float
        Orthonormal axes of those turns that move anything.
    """

    name: str
    kind: ElementKind
    places: Places
    start: Vector
    size: float
    axes: Vector

    def motion(self, mode: Vector, dim: int) -> tuple[Vector, Vector]:
        """Return the translation of the start [m] and the rotation [rad], each (3,), of a mode."""
        moved = np.zeros(3)
        moved[:dim] = self.size * mode[:dim]
        return moved, mode[dim:] @ self.axes


def find_rigid_parts(system: System) -> list[RigidPart]:
    """Return the rigid parts of a scene: beams and the lines of meshes.

    Of meshes with very many lines they are what is connected (`Body.parts`).
    """
    pairs = zip(system.scene.bodies, system.places, strict=True)
    return [part for body, places in pairs for part in _parts(system, body, places)]


def _parts(system: System, body: Body, all_places: Places) -> Iterator[RigidPart]:
    order = np.argsort(body.parts, kind="stable")
    pieces = np.split(order, np.flatnonzero(np.diff(body.parts[order])) + 1)
    nodes, dim = body.row_nodes, system.dim
    # An element belongs to the part of its first row.
    lengths = np.bincount(body.parts[body.ends[:, 0]], weights=body.lengths)
    if not body.n_elements:
        lengths = np.array([body.size])
    for piece in pieces:
        name = body.name
        if len(pieces) > 1:
            name += f" (nodes {nodes[piece].min()} to {nodes[piece].max()})"
        start = np.zeros(3)
        start[:dim] = body.positions[nodes[piece[0]]]
        size = float(lengths[body.parts[piece[0]]])
        places = all_places[piece]
        yield RigidPart(
            name,
            body.kind,
            places,
            start,
            size,
            _rotation_axes(system, body.kind, places, start, size),
        )


def _rotation_axes(
    system: System, kind: ElementKind, places: Places, start: Vector, size: float
) -> Vector:
    """Return the axes about which a part can turn so that something moves, (k, 3)."""
    if system.dim == 2:
        return np.array([[0.0, 0.0, 1.0]])
    # A turn w moves vectors x by w x x: the squares add up to w.(tr S - S).w, S = sum of x x^T.
    moments = np.zeros((3, 3))
    for begin in range(0, len(places), CHUNK_SIZE):
        rows = system.q_ref[places[begin : begin + CHUNK_SIZE]]
        for name in kind.vectors:
            vectors = rows[:, kind.columns(name)]
            if name == "r":
                vectors = (vectors - start) / size
            moments += vectors.T @ vectors
    squares, axes = np.linalg.eigh(np.trace(moments) * np.eye(3) - moments)
    moving = axes[:, squares > STRAIGHTNESS**2 * squares[-1]].T
    return _align_axes(moving)


def _align_axes(axes: Vector) -> Vector:
    """Return an orthonormal basis of the same turns, along coordinate axes where it can be."""
    if len(axes) == 3:
        return np.eye(3)
    basis = []
    left = axes.T @ axes
    for _ in axes:
        # The coordinate axis that is nearest to the turns that are left.
        nearest = left[int(np.argmax(np.diag(left)))]
        basis.append(nearest / np.linalg.norm(nearest))
        left = left - np.outer(basis[-1], basis[-1] @ left)
    return np.array(basis)
