"""Where points, slopes and nodes of a scene stand among its coordinates."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import ElementKind
from ancfsparse.kernels.hermite import position_weights, slope_weights
from ancfsparse.scene import Body, Point, check_point
from ancfsparse.scene.bodies.auto_element import decided
from ancfsparse.system.coordinates.nodal_vectors import weigh_ends, weigh_offsets
from ancfsparse.system.coordinates.numbering import Places

Vector = NDArray[np.float64]
Handle = TypeVar("Handle", Body, Point)

# Of a node, whose vectors are coordinates.
UNIT_WEIGHT = np.ones(1)


class Coordinates:
    """The coordinates of a scene, body by body.

    Attributes
    ----------
    dim : int
        Dimension of the scene.
    bodies : tuple of Body
        Its bodies.
    kinds : list of ElementKind
        The element of each.
    places : list of (n_rows, n_c) int32 arrays
        Of each the place in q of every coordinate of every row.
    """

    dim: int
    bodies: tuple[Body, ...]
    kinds: list[ElementKind]
    places: list[Places]
    _index: dict[int, int]

    def vectors(self, name: str) -> list[Places]:
        """Return the places of a nodal vector, ``"r"`` or ``"r_x"``, ..., a table for each body.

        Each has shape (n_rows, k), with as many columns as its element has components of it.
        """
        pairs = zip(self.kinds, self.places, strict=True)
        return [places[:, kind.columns(name)] for kind, places in pairs]

    @property
    def positions(self) -> Places:
        """Places of the positions of all rows, (n,), those that rows share several times."""
        return np.concatenate([places.ravel() for places in self.vectors("r")])

    def resolve(self, handle: Handle) -> Handle:
        """Return a handle of the scene that was solved, for one of the scene a plan was made for.

        The element or mesh of a beam was open there; its points are found by arc length.
        """
        body = handle.beam if isinstance(handle, Point) else handle
        if not body.automatic or id(body) in self._index:
            return handle
        return decided(self.bodies[self._index_of(body)], handle)

    def rows(self, node: Point) -> Places:
        """Return the places of the coordinates of all rows of a node, shape (k, n_c)."""
        node = self.resolve(node)
        return self.places[self._index_of(node.beam)][node.beam.rows_of(node.index)]

    def place(self, node: Point) -> Places:
        """Return the places of a node's coordinates, shape (n_c,).

        Raises
        ------
        InputError
            If the node of a mesh has more slopes than one.
        """
        rows = self.rows(node)
        if len(rows) > 1:
            raise InputError(
                f"{node!r} has {len(rows)} slopes, one for each line through it: ask for a point "
                "on an edge beside it, mesh.at(edge, s)"
            )
        return np.asarray(rows[0])

    def elements(self, beam: Body) -> Places:
        """Return the places of a beam's element coordinates, shape (n_e, 2 n_c)."""
        beam = self.resolve(beam)
        return self.places[self._index_of(beam)][beam.ends].reshape(beam.n_elements, -1)

    def point(self, node: Point) -> tuple[Places, Vector]:
        """Return places (dim, p) and weights (p,) of a position: r = sum of weights q[places]."""
        node = self.resolve(check_point("a position", node))
        if not node.xi:
            return self._interpolate(node, "r", UNIT_WEIGHT)
        straight = self.kind_of(node.beam).is_string
        return self._interpolate(node, "r", position_weights(node.xi, self._length(node), straight))

    def slope(self, node: Point) -> tuple[Places, Vector]:
        """Return places (dim, p) and weights (p,) of the slope r'.

        Raises
        ------
        InputError
            At a node of a string, where it jumps.
        """
        node = self.resolve(check_point("a slope", node))
        straight = self.kind_of(node.beam).is_string
        if straight and node.is_node:
            raise InputError(
                f"the slope of a string jumps at its nodes, such as {node!r}: ask for it at a "
                "point inside an element"
            )
        if not node.xi:
            return self._interpolate(node, "r_x", UNIT_WEIGHT)
        return self._interpolate(node, "r_x", slope_weights(node.xi, self._length(node), straight))

    def frame(self, node: Point) -> Places:
        """Return the places (3, dim) of those of r_x, r_y and r_z at a node that a moment acts on.

        -1 stands for the others.  In the plane a moment cannot twist and acts on one vector.
        """
        places, kind = self.place(node), self.kind_of(node.beam)
        out = np.full((3, self.dim), -1, dtype=np.int32)
        for vector in kind.section if self.dim == 3 else kind.section[:1]:
            out["xyz".index(vector[-1])] = places[kind.columns(vector)]
        return out

    def _interpolate(self, node: Point, vector: str, weights: Vector) -> tuple[Places, Vector]:
        """Weigh the ends of an element, or take this vector of a node as it is."""
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
        """Length of the element a point is inside of [m]; 1 at a node, where none is needed."""
        return 1.0 if point.xi == 0.0 else float(point.beam.lengths[point.index])

    def describe(self, place: int) -> str:
        """Describe which beam, node and coordinate a place in q is."""
        for beam, kind, places in zip(self.bodies, self.kinds, self.places, strict=True):
            found = np.argwhere(places == place)
            if len(found):
                row, coordinate = found[0]
                node = beam.row_nodes[row]
                return f"{beam.name}, node {node}, {kind.node_coordinates[coordinate]}"
        raise IndexError(f"no coordinate stands at place {place}")

    def unit(self, place: int) -> str:
        """Return the unit of the force that belongs to a place in q, N or N m."""
        return "N" if any((places == place).any() for places in self.vectors("r")) else "N m"

    def kind_of(self, beam: Body) -> ElementKind:
        """Return the element that a beam of the scene is made of."""
        return self.kinds[self._index_of(beam)]

    def _index_of(self, beam: Body) -> int:
        try:
            return self._index[id(beam)]
        except KeyError:
            names = [each.name for each in self.bodies] if beam.automatic else []
            if beam.name in names:
                return names.index(beam.name)
            raise InputError(f"{beam!r} is not part of this scene") from None
