"""Indices and interpolation weights of points, slopes and nodes in the coordinate vector."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from ancfsparse.array_types import Integers, Vector
from ancfsparse.errors import InputError
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.kernels.hermite import position_weights, slope_weights
from ancfsparse.scene import Body, Point, check_point
from ancfsparse.scene.bodies.auto_element import decided
from ancfsparse.system.coordinates.nodal_vectors import weigh_ends, weigh_offsets

Handle = TypeVar("Handle", Body, Point)

UNIT_WEIGHT = np.ones(1)  # of a node, whose vectors are coordinates


class Coordinates:
    """The coordinates of a scene, body by body.

    Attributes
    ----------
    dim : int
        Dimension of the scene.
    bodies : tuple of Body
        Its bodies.
    kinds : list of ElementKind
        Element of each body.
    places : list of (n_rows, n_c) int32 arrays
        Indices in q of the coordinates of every row of each body.
    """

    dim: int
    bodies: tuple[Body, ...]
    kinds: list[ElementKind]
    places: list[Integers]
    _index: dict[int, int]

    def vectors(self, name: str) -> list[Integers]:
        """Return the indices of a nodal vector, ``"r"``, ``"r_x"``, ..., a table for each body.

        Each table has shape (n_rows, k) with the k components that the element has of the vector.
        """
        pairs = zip(self.kinds, self.places, strict=True)
        return [places[:, kind.columns(name)] for kind, places in pairs]

    @property
    def positions(self) -> Integers:
        """Indices of the positions of all rows, (n,); shared positions are repeated."""
        return np.concatenate([places.ravel() for places in self.vectors("r")])

    def resolve(self, handle: Handle) -> Handle:
        """Return the handle in this scene of a handle in the scene of a plan.

        There, element or mesh of a beam are unspecified; points are located by arc length.
        """
        body = handle.beam if isinstance(handle, Point) else handle
        if not body.automatic or id(body) in self._index:
            return handle
        return decided(self.bodies[self._index_of(body)], handle)

    def rows(self, node: Point) -> Integers:
        """Return the indices of the coordinates of all rows of a node, shape (k, n_c)."""
        node = self.resolve(node)
        return self.places[self._index_of(node.beam)][node.beam.rows_of(node.index)]

    def place(self, node: Point) -> Integers:
        """Return the indices of the coordinates of a node, shape (n_c,).

        Raises
        ------
        InputError
            If the node of a mesh has several slopes.
        """
        rows = self.rows(node)
        if len(rows) > 1:
            raise InputError(
                f"{node!r} has {len(rows)} slopes, one for each line through it: take a point "
                "on an edge next to it, mesh.at(edge, s)"
            )
        return np.asarray(rows[0])

    def elements(self, beam: Body) -> Integers:
        """Return the indices of the element coordinates of a beam, shape (n_e, 2 n_c)."""
        beam = self.resolve(beam)
        return self.places[self._index_of(beam)][beam.ends].reshape(beam.n_elements, -1)

    def point(self, node: Point) -> tuple[Integers, Vector]:
        """Return indices (dim, p) and weights (p,) of a position: r = sum of weights q[indices]."""
        node = self.resolve(check_point("a position", node))
        if not node.xi:
            return self._interpolate(node, "r", UNIT_WEIGHT)
        straight = self.kind_of(node.beam).is_string
        return self._interpolate(node, "r", position_weights(node.xi, self._length(node), straight))

    def slope(self, node: Point) -> tuple[Integers, Vector]:
        """Return indices (dim, p) and weights (p,) of the slope r'.

        Raises
        ------
        InputError
            At a node of a string, where the slope is discontinuous.
        """
        node = self.resolve(check_point("a slope", node))
        straight = self.kind_of(node.beam).is_string
        if straight and node.is_node:
            raise InputError(
                f"the slope of a string jumps at its nodes, such as {node!r}: take a "
                "point inside an element"
            )
        if not node.xi:
            return self._interpolate(node, "r_x", UNIT_WEIGHT)
        return self._interpolate(node, "r_x", slope_weights(node.xi, self._length(node), straight))

    def frame(self, node: Point) -> Integers:
        """Return the indices (3, dim) of the vectors r_x, r_y, r_z of a node under a moment, or -1.

        In the plane a moment cannot twist and acts on one vector.
        """
        places, kind = self.place(node), self.kind_of(node.beam)
        out = np.full((3, self.dim), -1, dtype=np.int32)
        for vector in kind.section if self.dim == 3 else kind.section[:1]:
            out["xyz".index(vector[-1])] = places[kind.columns(vector)]
        return out

    def _interpolate(self, node: Point, vector: str, weights: Vector) -> tuple[Integers, Vector]:
        """Interpolate a vector between the ends of an element, or return that of a node."""
        kind = self.kind_of(node.beam)
        offsets = node.offsets if vector == "r" else ()
        if offsets and not node.xi:
            return weigh_offsets(kind, self.rows(node)[0], offsets)
        if not node.xi:
            places = self.rows(node)[0] if vector == "r" else self.place(node)
            return places[kind.columns(vector)][:, None], UNIT_WEIGHT
        ends = self.places[self._index_of(node.beam)][node.beam.ends[node.index]]
        return weigh_ends(kind, ends, replace(node, offsets=offsets), weights)

    @staticmethod
    def _length(point: Point) -> float:
        """Return the length of the element that contains a point [m], 1 at a node."""
        return 1.0 if point.xi == 0.0 else float(point.beam.lengths[point.index])

    def describe(self, place: int) -> str:
        """Return beam, node and name of a coordinate by its index in q."""
        for beam, kind, places in zip(self.bodies, self.kinds, self.places, strict=True):
            hits = np.argwhere(places == place)
            if len(hits):
                row, coordinate = hits[0]
                node = beam.row_nodes[row]
                return f"{beam.name}, node {node}, {kind.node_coordinates[coordinate]}"
        raise IndexError(f"no coordinate has the index {place}")

    def unit(self, place: int) -> str:
        """Return the unit of the generalized force of a coordinate, N or N m."""
        return "N" if any((places == place).any() for places in self.vectors("r")) else "N m"

    def kind_of(self, beam: Body) -> ElementKind:
        """Return the element type of a beam of the scene."""
        return self.kinds[self._index_of(beam)]

    def _index_of(self, beam: Body) -> int:
        try:
            return self._index[id(beam)]
        except KeyError:
            names = [each.name for each in self.bodies]
            if beam.automatic and beam.name in names:
                return names.index(beam.name)
            own = beam.name if beam.name in names else names[0]
            raise foreign_handle(repr(beam), f"body({own!r})") from None


def foreign_handle(what: str, own: str) -> InputError:
    """Return the error for a handle of another scene, with one of the scene of the run."""
    return InputError(
        f"{what} is not part of this scene: take a handle of the scene of the run, such as "
        f"run.system.scene.{own}, or for the run of a file give the scene of the handle, as in "
        "ancfsparse.load(path, scene)"
    )
