"""Nets and lattices of cables and beams: their records and handles."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Integers, Vector
from ancfsparse.checks import check_count, check_finite
from ancfsparse.errors import InputError
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.scene.bodies.beam import NODE_TOLERANCE, relocate
from ancfsparse.scene.bodies.body import Point, VelocityField
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.bodies.element_choice import left_out
from ancfsparse.scene.geometry.section_frames import section_axes
from ancfsparse.scene.records.record import PointRef, Record, as_data
from ancfsparse.scene.sections.cross_section import AnySection
from ancfsparse.scene.sections.material import Material

if TYPE_CHECKING:
    from ancfsparse.scene.records.plane import Plane

MAX_SEPARATE_LINES = 200  # that are examined one by one for rigid-body motions


@dataclass(frozen=True, eq=False, kw_only=True)
class MeshSpec(Record):
    """The record of `Scene.add_mesh`."""

    nodes: ArrayLike
    edges: ArrayLike
    element: str | ElementKind
    section: AnySection
    material: Material
    n_elements: int | str = 1
    smooth: float = 5.0
    slack: float | None = None
    strain: str | None = None
    curvature: str | None = None
    section_strain: str | None = None
    velocity: ArrayLike | VelocityField | None = None
    name: Any = None
    method = "add_mesh"
    units: ClassVar = {"nodes": "m", "smooth": "degrees", "velocity": "m/s"}

    def __post_init__(self) -> None:
        """Keep the arguments as they are: they are checked when the mesh is built."""

    def project(self, handle: Mesh, plane: Plane) -> MeshSpec:
        """Return the record of a mesh of strings or cables for a planar scene."""
        if handle.kind.section[1:]:
            plane.refuse()
        return replace(self, **handle.planar_arguments(self, plane), nodes=plane.put(self.nodes))

    def checked(self, mesh: Mesh) -> MeshSpec:
        """Return the record as plain data, with the checked values of the mesh built from it."""
        nodes, edges = mesh.given()
        return replace(
            self,
            nodes=nodes,
            edges=edges,
            n_elements="auto" if "n_elements" in mesh.automatic else mesh.n_each,
            **{name: as_data(getattr(self, name)) for name in ("smooth", "slack", "velocity")},
            **left_out(self),
        )


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Mesh(ElasticBody):
    """Cables or beams between nodes, as `Scene.add_mesh` returns them.

    All edges at a node share its position.  Edges that continue each other in a line also share
    their slope and section and form one cable or beam; lines rotate independently.

    Attributes
    ----------
    name, element, options, kind, section, material, positions, n_each, lengths, velocity
        As in `ElasticBody`.  Nodes inside edges come after the specified nodes.
    edges : ndarray, shape (n_elements, 2)
        Nodes at the two ends of every element, edge after edge in the order given, reversed
        where all elements of a line then point the same way, read-only.
    flipped : ndarray, shape (n_elements,)
        Which elements were reversed, read-only.
    """

    edges: Integers
    flipped: np.ndarray[tuple[int], np.dtype[np.bool_]]
    branches = True

    def __repr__(self) -> str:
        """Identify the mesh."""
        count = "auto" if "n_elements" in self.automatic else str(self.n_elements)
        element = "auto" if "element" in self.automatic else self.element
        return (
            f"{self.name}: {self.n_nodes} nodes, {count} {element} elements, "
            f"{self.n_lines} line(s), {self.length:.6g} m, "
            f"{'planar' if self.dim == 2 else 'spatial'}"
        )

    @property
    def directions(self) -> Vector:
        """-1 for elements that were reversed, else 1, (n_elements,)."""
        return np.where(self.flipped, -1.0, 1.0)

    @property
    def n_lines(self) -> int:
        """Number of lines, each a cable or beam with a continuous slope."""
        return int(self.lines.max()) + 1

    @property
    def length(self) -> float:
        """Total length of the edges in the reference shape [m]."""
        return float(self.lengths.sum())

    @cached_property
    def size(self) -> float:
        """Diagonal of the bounding box of the nodes [m]."""
        return float(np.linalg.norm(np.ptp(self.positions, axis=0)))

    @cached_property
    def lines(self) -> Integers:
        """Number of the line of every row, shape (n_rows,)."""
        return _components(len(self.row_nodes), self.ends)

    @property
    def parts(self) -> Integers:
        """Line of every row, or its connected part of the mesh if there are very many lines."""
        if self.n_lines <= MAX_SEPARATE_LINES:
            return self.lines
        return _components(self.n_nodes, self.edges)[self.row_nodes]

    def arc(self, point: Point) -> float:
        """Return the distance of a point from the first end of its edge, as given [m]."""
        if point.is_node:
            raise InputError(f"{point!r} has no arc coordinate: several edges may meet there")
        position = point.index % self.n_each + self._xi_as_given(point)
        return float(position * self.lengths[point.index])

    def refer(self, point: Point) -> PointRef:
        """Return the reference to a point, with xi from the first node of the edge as given."""
        return PointRef(self.name, point.index, self._xi_as_given(point))

    def point(self, reference: PointRef) -> Point:
        """Return the handle of a point from its reference."""
        node = super().point(reference)
        return Point(self, node.index, self._xi_as_given(node))

    def given(self) -> tuple[Vector, Integers]:
        """Return its arguments: nodes (n, dim) [m] and edges (m, 2)."""
        edges = self.edges
        if self.flipped.any():
            edges = np.where(self.flipped[:, None], edges[:, ::-1], edges)
        if self.n_each > 1:
            edges = np.stack(
                [edges[:: self.n_each, 0], edges[self.n_each - 1 :: self.n_each, 1]], 1
            )
        edges.flags.writeable = False
        return self.positions[: self._n_given], edges

    def among(self, n_each: int, point: Point) -> PointRef:
        """Return a reference to the same point of a mesh with `n_each` elements per edge."""
        index, xi = point.index, self._xi_as_given(point)
        if point.is_node:
            edge, inside = divmod(index - self._n_given, max(1, self.n_each - 1))
            if edge < 0:
                return PointRef(self.name, index)
            index = edge * self.n_each + inside + 1
        index, xi = relocate(index, xi, self.n_each, n_each)
        if xi:
            return PointRef(self.name, index, xi)
        edge, inside = divmod(index, n_each)
        return PointRef(self.name, self._n_given + edge * (n_each - 1) + inside - 1)

    def corresponding_point(self, handle: Point) -> Point:
        """Return the same node, or the point at the same fraction of an edge."""
        return self.point(handle.beam.among(self.n_each, handle))

    @property
    def _n_given(self) -> int:
        """Number of the specified nodes."""
        return self.n_nodes - self.n_elements // self.n_each * (self.n_each - 1)

    def _xi_as_given(self, point: Point | PointRef) -> float:
        """Return xi of a point counted from the first node of the edge as given."""
        is_reversed = point.xi != 0.0 and self.flipped[point.index]
        return 1.0 - point.xi if is_reversed else point.xi

    def axes_of(self, row: int) -> Vector:
        """Return unit vectors along and across the slope of a row, shape (dim, dim)."""
        if self.vectors.shape[1] > 1:
            return np.asarray(self.vectors[row])
        return section_axes(self.vectors[row, 0], None, self.name)

    def say(self, point: Point) -> str:
        """Return the location of a point, for messages."""
        if point.is_node:
            return f"{self.name}, node {point.index}"
        return f"{self.name}, edge {point.index // self.n_each} at s = {self.arc(point):.6g} m"

    def hint(self, point: Point) -> str:
        """Return a hint which node to use instead of a point inside an element."""
        tail, head = self.edges[point.index]
        return f"its ends are {self.name}.node({tail}) and .node({head})"

    def at(self, edge: int, s: float) -> Point:
        """Return a point on an edge.

        Parameters
        ----------
        edge : int
            Number of the edge, in the order of the array given.
        s : float
            Distance from the first node of the edge, as given [m].

        Returns
        -------
        Point
            A node if `s` is that of a node (to rounding), else a point inside the edge.
        """
        check_count("the number of an edge", edge, 0)
        n_edges = self.n_elements // self.n_each
        if edge >= n_edges:
            raise InputError(f"{self.name} has edges 0 to {n_edges - 1}, there is no edge {edge}")
        first = edge * self.n_each
        length = float(self.lengths[first])
        position = check_finite(f"s on edge {edge} of {self.name}", s, "m") / length
        if not -NODE_TOLERANCE <= position <= self.n_each + NODE_TOLERANCE:
            raise InputError(
                f"s = {s:.6g} m lies outside edge {edge} of {self.name}: it runs from 0 to "
                f"{self.n_each * length:.6g} m"
            )
        inside = min(max(int(position), 0), self.n_each - 1)
        index, xi = first + inside, position - inside
        if self.flipped[index]:
            xi = 1.0 - xi
        for end, node in enumerate(self.edges[index]):
            if abs(xi - end) <= NODE_TOLERANCE:
                return Point(self, int(node))
        return Point(self, int(index), xi)


def _components(n: int, pairs: Integers) -> Integers:
    """Return the number of the connected part that each vertex of a graph is in, (n,)."""
    import scipy.sparse as sp
    from scipy.sparse.csgraph import connected_components

    links = np.ones(len(pairs), dtype=bool)
    graph = sp.coo_array((links, (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int32)
