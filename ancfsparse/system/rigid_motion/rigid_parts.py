"""Rigid parts of a scene and their rigid-body motions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Integers, Vector
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.scene import Body
from ancfsparse.system.system import System

# A straight cable is not changed by a rotation about its axis.
STRAIGHTNESS = 1e-7  # distance of a straight line from its axis, over its length
CHUNK_SIZE = 65_536  # nodes whose moments are summed together


@dataclass(frozen=True)
class RigidPart:
    """A part that moves rigidly without strain: a beam, or a line of a mesh.

    Its modes are translations by its size along the axes of space, and rotations of one radian
    about axes through its start, so that all modes have the same magnitude in any unit of length.

    Attributes
    ----------
    name : str
        Name for messages.
    kind : ElementKind
        Its element type.
    places : (n_rows, n_c) int
        Indices of its coordinates.
    start : (3,) float
        Centre of its rotations [m]; z is zero in the plane.
    size : float
        Length in the reference shape [m].
    axes : (k, 3) float
        Orthonormal axes of the rotations that displace coordinates.
    """

    name: str
    kind: ElementKind
    places: Integers
    start: Vector
    size: float
    axes: Vector

    def motion(self, mode: Vector, dim: int) -> tuple[Vector, Vector]:
        """Return the translation of the start [m] and the rotation [rad], each (3,), of a mode."""
        translation = np.zeros(3)
        translation[:dim] = self.size * mode[:dim]
        return translation, mode[dim:] @ self.axes


def find_rigid_parts(system: System) -> list[RigidPart]:
    """Return the rigid parts of a scene: beams and the lines of meshes.

    Meshes with very many lines are divided into connected components (`Body.parts`).
    """
    pairs = zip(system.scene.bodies, system.places, strict=True)
    return [part for body, places in pairs for part in _parts(system, body, places)]


def _parts(system: System, body: Body, all_places: Integers) -> Iterator[RigidPart]:
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
    system: System, kind: ElementKind, places: Integers, start: Vector, size: float
) -> Vector:
    """Return the axes of rotations that displace coordinates of a part, (k, 3)."""
    if system.dim == 2:
        return np.array([[0.0, 0.0, 1.0]])
    # A rotation w displaces vectors x by w x x; sum of squares w.(tr S - S).w, S = sum of x x^T.
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
    """Return an orthonormal basis of the same rotations, along coordinate axes if possible."""
    if len(axes) == 3:
        return np.eye(3)
    basis = []
    projector = axes.T @ axes
    for _ in axes:
        # The coordinate axis closest to the remaining rotations.
        nearest = projector[int(np.argmax(np.diag(projector)))]
        basis.append(nearest / np.linalg.norm(nearest))
        projector = projector - np.outer(basis[-1], basis[-1] @ projector)
    return np.array(basis)
