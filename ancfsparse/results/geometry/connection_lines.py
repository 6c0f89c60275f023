"""Straight lines for ropes, springs and distance joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.results.geometry.body_outlines import PACKED
from ancfsparse.scene import Joint, Point
from ancfsparse.scene.force_elements.springs import Spring
from ancfsparse.scene.loads.attachment import Attachment
from ancfsparse.system.system import System

if TYPE_CHECKING:
    import h5py

TABLES = ("places", "weights", "fixed", "springs")


@dataclass(frozen=True, eq=False)
class ConnectionLines:
    """Lines between points of bodies, or fixed points.

    Attributes
    ----------
    places : ndarray of int, shape (n, 2, dim, p)
        Coordinates that the positions of both ends depend on.
    weights : ndarray, shape (n, 2, p)
        Their weights; zero for fixed points.
    fixed : ndarray, shape (n, 2, dim)
        Positions of fixed points [m]; zero for others.
    springs : ndarray of bool, shape (n,)
        True for springs, which are dashed.
    """

    places: NDArray[np.int32]
    weights: Vector
    fixed: Vector
    springs: NDArray[np.bool_]

    def __len__(self) -> int:
        """Return the number of lines."""
        return len(self.springs)

    def ends(self, q: Vector) -> Vector:
        """Return the ends of all lines from coordinates (j, n), shape (j, n_lines, 2, dim) [m]."""
        values = np.asarray(q[..., self.places])
        return np.asarray(self.fixed + np.einsum("jnedp,nep->jned", values, self.weights))

    def write(self, group: h5py.Group) -> None:
        """Write the lines to a group."""
        for name in TABLES if len(self) else ():
            group.create_dataset(f"link {name}", data=getattr(self, name), **PACKED)


def no_connections(dim: int) -> ConnectionLines:
    """Return an empty set of lines."""
    return ConnectionLines(
        np.zeros((0, 2, dim, 0), np.int32), np.zeros((0, 2, 0)), np.zeros((0, 2, dim)),
        np.zeros(0, bool),
    )  # fmt: skip


def read_connections(group: h5py.Group, dim: int) -> ConnectionLines:
    """Read the lines; none from a file of an early version.

    Raises
    ------
    KeyError, ValueError
        If the tables are damaged.
    """
    if "link places" not in group:
        return no_connections(dim)
    links = ConnectionLines(*(np.asarray(group[f"link {name}"]) for name in TABLES))
    n, _, _, p = links.places.shape
    if links.weights.shape != (n, 2, p) or links.fixed.shape != (n, 2, dim):
        raise ValueError("tables of lines are inconsistent")
    return links


def make_connections(system: System) -> ConnectionLines:
    """Return the lines of all joints and force elements of a system that have any."""
    rows, springs = [], []
    elements: tuple[Joint | Attachment, ...] = (*system.joints, *system.attachments)
    for element in elements:
        for pair in element.links:
            rows.append(tuple(_end(system, each) for each in pair))
            springs.append(isinstance(element, Spring))
    if not rows:
        return no_connections(system.scene.dim)
    width = max(len(weights) for ends in rows for _, weights, _ in ends)
    links = ConnectionLines(
        np.zeros((len(rows), 2, system.scene.dim, width), np.int32),
        np.zeros((len(rows), 2, width)),
        np.zeros((len(rows), 2, system.scene.dim)),
        np.array(springs),
    )
    for k, ends in enumerate(rows):
        for e, (places, weights, fixed) in enumerate(ends):
            links.places[k, e, :, : len(weights)] = places
            links.weights[k, e, : len(weights)] = weights
            links.fixed[k, e] = fixed
    return links


def _end(system: System, point: Point | Vector) -> tuple[NDArray[np.int32], Vector, Vector]:
    """Return coordinates and weights of a point, and its position if it is fixed."""
    dim = system.scene.dim
    if not isinstance(point, Point):
        return np.zeros((dim, 0), np.int32), np.zeros(0), point
    places, weights = system.point(point)
    return places.astype(np.int32), weights, np.zeros(dim)
