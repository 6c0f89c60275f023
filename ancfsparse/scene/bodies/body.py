"""The base class of bodies, the points on them, and the interface of constraints.

A body is a table of rows and a list of elements.  A row is a node together with one slope: a node
of a beam has one row, a node of a net one for each line through it.  Rows of one node have the same
position.  An element connects two rows.  A rigid body is one row without elements.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ancfsparse.array_types import Integers, Vector
from ancfsparse.checks import check_finite, check_integer
from ancfsparse.errors import InputError
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.messages import format_value
from ancfsparse.scene.kinematics.linear_forms import RheonomicTerm
from ancfsparse.scene.records.picklable_functions import picklable
from ancfsparse.scene.records.record import BodyRef, PointRef

if TYPE_CHECKING:
    from ancfsparse.scene.kinematics.joint_coordinates import JointCoordinate
    from ancfsparse.scene.kinematics.sliding_curve import CurveOffset
    from ancfsparse.scene.records.prescribed_motion import PrescribedMotion

VelocityField = Callable[[Vector], Vector]

MAX_OUT_OF_SPAN = 1e-9  # of a direction, over its length, attributed to rounding


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Body(ABC):
    """Coordinates with a reference shape: rows, and elements between them.

    Two bodies are equal only if they are identical.

    Attributes
    ----------
    name : str
        Unique in its scene.
    element : str
        Name of its element: ``"string"``, ``"l2t2"``, ``"thin"``, ``"thick"``, that of a
        user element, or ``"rigid"`` for a rigid body, which has no elements.
    options : dict of str to str
        The options of this element.
    kind : ElementKind
        Its coordinates, and the kernels of its elements.
    positions : ndarray, shape (n_nodes, dim)
        Reference positions of the nodes [m], read-only.
    n_each : int
        Number of elements of a beam, or of every edge of a mesh; 0 for a rigid body.
    lengths : ndarray, shape (n_elements,)
        Length of every element [m], read-only.
    row_nodes : ndarray, shape (n_rows,)
        Node of every row, in ascending order, read-only.
    ends : ndarray, shape (n_elements, 2)
        The two rows of every element, read-only.
    vectors : ndarray, shape (n_rows or 1, k, dim)
        Reference slope and section vectors of every row, or one for all, read-only; the unit
        vectors of a rigid body.
    velocity : callable or None
        Initial velocities (k, dim) [m/s] as a function of reference positions (k, dim) [m]; None
        for a body at rest.
    automatic : tuple of str
        Arguments that are ``"auto"`` and chosen by a plan, until which the body is a stand-in.
    """

    name: str
    element: str
    options: Mapping[str, str]
    kind: ElementKind
    positions: Vector
    n_each: int
    lengths: Vector
    row_nodes: Integers
    ends: Integers
    vectors: Vector
    velocity: VelocityField | None = None
    automatic: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling."""
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
        """Total length of the elements in the reference shape [m]."""

    @property
    @abstractmethod
    def size(self) -> float:
        """Extent in the reference shape [m], the scale of rounding errors."""

    @property
    def shortest(self) -> float:
        """Length of the shortest element, the scale of small motions [m]."""
        return float(self.lengths.min())

    @property
    def corners(self) -> Vector:
        """Points that bound it in the reference shape, (k, dim) [m]."""
        return self.positions

    @property
    @abstractmethod
    def total_mass(self) -> float:
        """Mass in the reference shape [kg]."""

    @property
    def default_point(self) -> Point | None:
        """The point that tables and reports show by default, or None."""
        return None

    @property
    @abstractmethod
    def speed(self) -> float | None:
        """Wave speed in its elements, the scale of velocities [m/s], or None."""

    @property
    def masses(self) -> Vector | None:
        """Constant mass matrix (k, k) of the position and vectors of its row, besides elements.

        The kinetic energy is ``1/2 sum A_ij v_i.v_j`` over them [kg, kg m, kg m2].
        """
        return None

    @property
    def lines(self) -> Integers:
        """Number of the line of every row, each with a continuous slope, (n_rows,): one line."""
        return np.zeros(len(self.row_nodes), dtype=np.int32)

    @property
    def parts(self) -> Integers:
        """Number of the connected part of every row, (n_rows,), by default its line."""
        return self.lines

    @property
    def n_cycles(self) -> int:
        """Number of independent cycles of its elements if they are connected, or less."""
        return max(0, self.n_elements - self.n_nodes + 1)

    @abstractmethod
    def arc(self, point: Point) -> float:
        """Return the arc coordinate of a point in the reference shape [m]."""

    @abstractmethod
    def axes_of(self, row: int) -> Vector:
        """Return the unit vectors e_x, e_y (and e_z) of a row, shape (dim, dim)."""

    @abstractmethod
    def say(self, point: Point) -> str:
        """Return the location of a point, for messages."""

    @abstractmethod
    def hint(self, point: Point) -> str:
        """Return a hint which node to use instead of a point inside an element."""

    @abstractmethod
    def among(self, n_each: int, point: Point) -> PointRef:
        """Return a reference to the same point of a body with `n_each` elements."""

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
        """Reference to the body, as data."""
        return BodyRef(self.name)

    def refer(self, point: Point) -> PointRef:
        """Return the reference to a point, as data."""
        return PointRef(self.name, point.index, point.xi, point.offsets)

    def point(self, reference: PointRef) -> Point:
        """Return the handle of a point from its reference."""
        if reference.offsets:
            raise InputError(
                f"{self.name} is not rigid and has no point at {format_value(reference.offsets)}"
            )
        xi = check_finite(f"xi of a point of {self.name}", reference.xi)
        if xi == 0.0:
            return self.node(reference.index)
        number = check_integer(f"the number of an element of {self.name}", reference.index)
        if not 0 <= number < self.n_elements or not 0.0 < xi < 1.0:
            raise InputError(
                f"{self.name} has elements 0 to {self.n_elements - 1}, and xi in them is between 0 "
                f"and 1; there is no point at xi = {xi:g} in element {number}"
            )
        return Point(self, number, xi)

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
        """Return the properties that determine its motion except its shape, for the digest."""

    def constrain(self, builder: ConstraintBuilder) -> None:
        """Add the equations of its coordinates that do not depend on joints, by default none."""
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
    """A point of a beam, a mesh or a rigid body.

    Parameters
    ----------
    beam : Beam, Mesh or RigidBody
        The body.
    index : int
        Number of the node if `xi` is 0, else of the element the point is inside of.
    xi : float, optional
        Fraction of the element's length, in (0, 1) inside an element, 0 at a node.
    offsets : tuple of float, optional
        Integers along the vectors of a rigid body, or of the section of a beam [m]; empty at the
        origin and on the axis.
    """

    beam: Body
    index: int
    xi: float = 0.0
    offsets: tuple[float, ...] = ()

    def __repr__(self) -> str:
        """Return the location of the point."""
        return self.beam.say(self)

    @property
    def is_node(self) -> bool:
        """True for a node of the mesh, or the origin of a rigid body."""
        return self.xi == 0.0 and not self.offsets

    @property
    def reference(self) -> PointRef:
        """Reference to the point, as data."""
        return self.beam.refer(self)

    @property
    def s(self) -> float:
        """Arc coordinate along a beam, or along an edge of a mesh, in the reference shape [m]."""
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
        inside = self.xi != 0.0
        position = self.beam.inside(self.index, self.xi) if inside else np.array(nodes[self.index])
        if self.offsets:
            position += np.array(self.offsets) @ self.beam.vectors_at(self)[: len(self.offsets)]
        return position


class ConstraintBuilder(Protocol):
    """The interface to which joints are lowered; it numbers the coordinates.

    Attributes
    ----------
    turns : bool
        Whether angles may be prescribed without equations.
    lines : bool
        Whether `hold` may be used, which requires that no point is constrained several times.
    """

    turns: bool
    lines: bool

    def kind(self, node: Point) -> ElementKind:
        """Return the element type at a node, which names its coordinates."""

    def rows(self, node: Point) -> Integers:
        """Return the coordinates of all rows of a node, (k, n_c): position first, then slopes."""

    def position(self, node: Point) -> Integers:
        """Return the coordinates of the position of a node, (dim,)."""

    def ends(self, node: Point) -> Integers:
        """Return the coordinates of all rows that determine a point, (k, n_c)."""

    def point(self, node: Point) -> tuple[Integers, Vector]:
        """Return coordinates (dim, p) and weights (p,) whose weighted sum is a point."""

    def fix(self, coordinates: Integers) -> None:
        """Fix coordinates at their reference values; the required force is the reaction."""

    def hold(self, coordinates: Integers) -> None:
        """Fix coordinates as `fix` does, in place of equations for single coordinates."""

    def drive(self, coordinates: Integers, motion: PrescribedMotion) -> None:
        """Prescribe coordinates by the components of a motion."""

    def share(self, one: Integers, other: Integers) -> None:
        """Identify coordinates, pair by pair."""

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
        """Add the equation ``offset + sum of c (q_i - about) (q_j - about) = 0``.

        Parameters
        ----------
        label : str
            Name in messages.
        offset : float
            Constant [m].
        *terms : (float, int, int)
            Factor c [1 or 1/m] and two coordinates; ``j = LINEAR`` makes the term ``c q_i``.
        about : sequence of float, optional
            Origin of the factors of each term [m].
        size : float, optional
            Magnitude of the summands of the offset [m], for rounding errors.
        rheonomic : RheonomicTerm, optional
            Right-hand side as a function of time, instead of zero [m].
        mass : float, optional
            Weight of its gradients in the mass matrix [kg], for coordinates that have no mass.  The
            solution does not depend on it.
        measures : sequence of (float, JointCoordinate), optional
            Further terms: factors [m or 1] and joint coordinates.
        """
