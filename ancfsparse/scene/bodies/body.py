"""What everything with coordinates has in common, and the points on it.

A body is a table of rows and a list of elements.  A row is a node together with one slope at it:
the nodes of a beam have one row each, a node of a net one for each line that runs through it.
Rows of one node share its position.  An element joins two rows.  A rigid body is one row and no
element.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import ElementKind
from ancfsparse.messages import format_value
from ancfsparse.scene.kinematics.linear_forms import Coordinates

if TYPE_CHECKING:
    from ancfsparse.scene.kinematics.joint_coordinates import JointCoordinate
    from ancfsparse.scene.kinematics.sliding_curve import CurveOffset
    from ancfsparse.scene.records.prescribed_motion import PrescribedMotion

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ancfsparse.checks import check_finite, check_integer
from ancfsparse.scene.records.picklable_functions import picklable
from ancfsparse.scene.records.record import BodyRef, PointRef

if TYPE_CHECKING:
    from ancfsparse.scene.kinematics.joint_coordinates import JointCoordinate
    from ancfsparse.scene.kinematics.sliding_curve import CurveOffset
    from ancfsparse.scene.records.prescribed_motion import PrescribedMotion

Vector = NDArray[np.float64]
Numbers = NDArray[np.int32]
VelocityField = Callable[[Vector], Vector]

MAX_OUT_OF_SPAN = 1e-9  # of a direction, over its length, attributed to rounding


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Body(ABC):
    """Coordinates with a reference shape: rows, and elements between them.

    Two bodies are equal only if they are the same one.

    Attributes
    ----------
    name : str
        Unique in its scene.
    element : str
        Name of its element: ``"string"``, ``"l2t2"``, ``"thin"``, ``"thick"``, or that of one built
        outside this package; ``"rigid"`` of a rigid body, which has no elements.
    options : dict of str to str
        The options this element has, and no others.
    kind : ElementKind
        What its coordinates are, and the kernels of its elements.
    positions : ndarray, shape (n_nodes, dim)
        Reference positions of the nodes [m], read-only.
    n_each : int
        Number of elements that was given: of a beam, or of every edge of a mesh; 0 of a rigid body.
    lengths : ndarray, shape (n_elements,)
        Length of every element [m], read-only.
    row_nodes : ndarray, shape (n_rows,)
        Node of every row, ascending, read-only.
    ends : ndarray, shape (n_elements, 2)
        The two rows of every element, read-only.
    vectors : ndarray, shape (n_rows or 1, k, dim)
        Reference slope and, in a beam, section vectors of every row, or one for all, read-only;
        of a rigid body its unit vectors.
    velocity : callable or None
        Initial velocities: maps reference places (k, dim) [m] to velocities (k, dim) [m/s].
        None for a body at rest.
    automatic : tuple of str
        Arguments that are ``"auto"``, to be chosen by a plan; element and mesh are stand-ins then.
    """

    name: str
    element: str
    options: Mapping[str, str]
    kind: ElementKind
    positions: Vector
    n_each: int
    lengths: Vector
    row_nodes: Numbers
    ends: Numbers
    vectors: Vector
    velocity: VelocityField | None = None
    automatic: tuple[str, ...] = ()

    def __getstate__(self) -> dict[str, Any]:
        """Give what is pickled: a velocity only if it can be."""
        return self.__dict__ | {"velocity": picklable(self.velocity)}

    @property
    def dim(self) -> int:
        """Number of components of a position, 2 or 3."""
        return int(self.positions.shape[1])

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return len(self.positions)

    @property
    def n_elements(self) -> int:
        """Number of elements."""
        return len(self.lengths)

    @property
    @abstractmethod
    def length(self) -> float:
        """Length of all elements together in the reference shape [m]."""

    @property
    @abstractmethod
    def size(self) -> float:
        """Extent in the reference shape [m], relative to which rounding is measured."""

    @property
    def shortest(self) -> float:
        """Length of the shortest element, the scale of small motions [m]."""
        return float(self.lengths.min())

    @property
    def corners(self) -> Vector:
        """Points that span its extent in the reference shape, (k, dim) [m]."""
        return self.positions

    @property
    @abstractmethod
    def speed(self) -> float | None:
        """Speed of waves along its elements, which velocities are compared with [m/s], or None."""

    @property
    def masses(self) -> Vector | None:
        """Constant masses (k, k) of position and vectors of its row, in addition to elements.

        The kinetic energy is ``1/2 sum A_ij v_i.v_j`` over them [kg, kg m, kg m2].
        """
        return None

    @property
    @abstractmethod
    def parts(self) -> Numbers:
        """Number of the piece that every row belongs to, (n_rows,); bodies define their pieces."""

    @abstractmethod
    def arc(self, point: Point) -> float:
        """Return the arc coordinate of a point in the reference shape [m]."""

    @abstractmethod
    def axes_of(self, row: int) -> Vector:
        """Return the unit vectors e_x, e_y (and e_z) of a row, shape (dim, dim)."""

    @abstractmethod
    def say(self, point: Point) -> str:
        """Describe where a point is, for messages."""

    @abstractmethod
    def hint(self, point: Point) -> str:
        """Describe which node to take instead of a point inside an element."""

    @abstractmethod
    def among(self, n_each: int, point: Point) -> PointRef:
        """Return a point as data of a body with another such number, at the same place."""

    @abstractmethod
    def corresponding_point(self, handle: Point) -> Point:
        """Return the point at the arc length of a point on the ``"auto"`` body replaced."""

    def interior_direction(self, node: Point) -> Vector:
        """Return a vector from a node into the body, (dim,), for the mark of a clamp."""
        row = self.rows_of(node.index).start
        slope = np.asarray(self.vectors[min(row, len(self.vectors) - 1), 0])
        return slope if (self.ends[:, 0] == row).any() else -slope

    @property
    def reference(self) -> BodyRef:
        """The body as data."""
        return BodyRef(self.name)

    def refer(self, point: Point) -> PointRef:
        """Return a point as data."""
        return PointRef(self.name, point.index, point.xi, point.offsets)

    def point(self, place: PointRef) -> Point:
        """Return the handle of a point that is data."""
        if place.offsets:
            raise InputError(
                f"{self.name} is not rigid and has no point at {format_value(place.offsets)}"
            )
        share = check_finite(f"xi of a point of {self.name}", place.xi)
        if share == 0.0:
            return self.node(place.index)
        number = check_integer(f"the number of an element of {self.name}", place.index)
        if not 0 <= number < self.n_elements or not 0.0 < share < 1.0:
            raise InputError(
                f"{self.name} has elements 0 to {self.n_elements - 1}, and places in them above 0 "
                f"and below 1; there is no place {share:g} in element {number}"
            )
        return Point(self, number, share)

    def inside(self, element: int, xi: float) -> Vector:
        """Return the position of a point inside an element in the reference shape, (dim,) [m]."""
        tail, head = self.positions[self.row_nodes[self.ends[element]]]
        return np.asarray((1.0 - xi) * tail + xi * head)

    def vectors_at(self, point: Point) -> Vector:
        """Return the vectors of a body or a beam at a point in the reference shape, (k, dim)."""
        last = len(self.vectors) - 1
        tail, head = (self.vectors[min(point.index + i, last)] for i in (0, 1))
        return np.asarray((1.0 - point.xi) * tail + point.xi * head)

    @abstractmethod
    def describe(self) -> dict[str, str]:
        """Describe for the digest of a scene what decides how it moves, but for its shape."""

    def constrain(self, builder: ConstraintBuilder) -> None:
        """State the equations of its coordinates that do not depend on joints: none by default."""
        del builder

    def rows_of(self, node: int) -> slice:
        """Return the rows of a node."""
        first, last = np.searchsorted(self.row_nodes, np.array([node, node + 1], dtype=np.int32))
        return slice(int(first), int(last))

    def node(self, i: int) -> Point:
        """Return one of the nodes.

        Parameters
        ----------
        i : int
            Number of the node, from 0: along a beam, or in the order of the array of a mesh.

        Returns
        -------
        Point
            Its handle.
        """
        number = check_integer(f"the number of a node of {self.name}", i)
        if isinstance(i, bool) or not 0 <= number < self.n_nodes:
            raise InputError(
                f"{self.name} has nodes 0 to {self.n_nodes - 1}, there is no node {format_value(i)}"
                + ("; its last one is `.end`" if number < 0 and hasattr(self, "end") else "")
            )
        return Point(self, number)


@dataclass(frozen=True, repr=False)
class Point:
    """A point on a beam, a mesh or a rigid body.

    Parameters
    ----------
    beam : Beam, Mesh or RigidBody
        What it is on.
    index : int
        Number of the node if `xi` is 0, else of the element the point is inside of.
    xi : float, optional
        Share of the element's length, in (0, 1) inside an element, 0 at a node.
    offsets : tuple of float, optional
        Of a point of a rigid body, or beside the axis of a beam, its coordinates along the vectors
        there [m]; empty at the origin and on the axis.
    """

    beam: Body
    index: int
    xi: float = 0.0
    offsets: tuple[float, ...] = ()

    def __repr__(self) -> str:
        """Describe where the point is."""
        return self.beam.say(self)

    @property
    def is_node(self) -> bool:
        """Whether the point is a node of the mesh, or the origin of a rigid body."""
        return self.xi == 0.0 and not self.offsets

    @property
    def reference(self) -> PointRef:
        """The point as data."""
        return self.beam.refer(self)

    @property
    def s(self) -> float:
        """Arc coordinate in the reference shape: along a beam, or along an edge of a mesh [m]."""
        return self.beam.arc(self)

    @property
    def frame(self) -> Vector:
        """Vectors of the node in the reference shape, (k, dim)."""
        vectors = self.beam.vectors
        row = 0 if len(vectors) == 1 else self.beam.rows_of(self.index).start
        return np.asarray(vectors[row])

    def spans(self, vector: Vector) -> bool:
        """Return True if the vectors of the node span a direction, (dim,)."""
        kind, dim = self.beam.kind, self.beam.dim
        if kind.is_string:
            return False
        if dim == 2:
            return True
        frame = self.frame[: (len(kind.node_coordinates) // dim) - 1]
        weights = np.linalg.lstsq(frame.T, vector, rcond=None)[0]
        off = np.linalg.norm(frame.T @ weights - vector)
        return bool(off <= MAX_OUT_OF_SPAN * np.linalg.norm(vector))

    @property
    def position(self) -> Vector:
        """Position in the reference shape, shape (dim,) [m]."""
        nodes = self.beam.positions
        place = self.beam.inside(self.index, self.xi) if self.xi else np.array(nodes[self.index])
        if self.offsets:
            place += np.array(self.offsets) @ self.beam.vectors_at(self)[: len(self.offsets)]
        return place


# Stands for the second coordinate of a linear term.
LINEAR = -1


class RheonomicTerm(NamedTuple):
    """What an equation follows: ``g(q) = s(t)``.

    Attributes
    ----------
    motion : PrescribedMotion
        A prescribed motion.
    column : int
        The component of it that counts.
    scale : callable, optional
        From its value and rates [m, m/s, m/s2], (k, 3), to s, s' and s''; by default they are it.
    """

    motion: PrescribedMotion
    column: int
    scale: Callable[[Vector], Vector] | None = None


class ConstraintBuilder(Protocol):
    """What joints are lowered to; coordinates are numbers that it gives out.

    Attributes
    ----------
    turns : bool
        Whether angles may be prescribed by numbering.
    lines : bool
        Whether `hold` may be used; it may not where joints hold a point several times.
    """

    turns: bool
    lines: bool

    def kind(self, node: Point) -> ElementKind:
        """Return the element at a node, which has the names of its coordinates."""
        ...

    def rows(self, node: Point) -> Coordinates:
        """Return the coordinates of all rows of a node, (k, n_c): position first, then slopes."""
        ...

    def position(self, node: Point) -> Coordinates:
        """Return the coordinates of the position of a node, (dim,)."""
        ...

    def ends(self, node: Point) -> Coordinates:
        """Return the coordinates of all rows that a point follows from, (k, n_c)."""
        ...

    def point(self, node: Point) -> tuple[Coordinates, Vector]:
        """Return coordinates (dim, p) and weights (p,) whose sums are a point of a body."""
        ...

    def fix(self, coordinates: Coordinates) -> None:
        """Hold coordinates at their reference values; the force that takes is the reaction."""
        ...

    def hold(self, coordinates: Coordinates) -> None:
        """Hold coordinates as `fix` does, in place of equations that hold just these."""
        ...

    def drive(self, coordinates: Coordinates, motion: PrescribedMotion) -> None:
        """Let coordinates follow a prescribed motion, one component of it each."""
        ...

    def share(self, one: Coordinates, other: Coordinates) -> None:
        """Make coordinates one, pair by pair."""
        ...

    def equation(
        self,
        label: str,
        offset: float,
        *terms: tuple[float, int, int],
        about: Sequence[float] = (),
        size: float = 0.0,
        rheonomic: RheonomicTerm | None = None,
        mass: float = 0.0,
        measures: Sequence[tuple[float, JointCoordinate | CurveOffset]] = (),
    ) -> None:
        """Hold ``offset + sum of c (q_i - about) (q_j - about) = 0`` by a multiplier.

        Parameters
        ----------
        label : str
            What it holds, for messages.
        offset : float
            Constant [m].
        *terms : (float, int, int)
            Factor c [1 or 1/m] and two coordinates; ``j = LINEAR`` makes the term ``c q_i``.
        about : sequence of float, optional
            Of each term [m].
        size : float, optional
            Of what the offset was added up from [m].
        rheonomic : RheonomicTerm, optional
            A function of time that takes the place of the zero [m].
        mass : float, optional
            What its gradients count with where masses are used as a matrix [kg], for coordinates
            that have none of their own.  A solution does not depend on it.
        measures : sequence of (float, JointCoordinate), optional
            Further terms: a factor [m or 1] and an angle or a length.
        """
        ...
