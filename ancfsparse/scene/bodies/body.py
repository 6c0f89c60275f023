"""What everything with coordinates has in common, and the points on it.

A body is a table of rows and a list of elements.  A row is a node together with one slope at it:
the nodes of a beam have one row each, a node of a net one for each line that runs through it.
Rows of one node share its position.  An element joins two rows.  A rigid body is one row and no
element.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_finite, check_integer
from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import ElementKind
from ancfsparse.messages import checksum, format_value
from ancfsparse.scene.records.record import BodyRef, PointRef
from ancfsparse.scene.records.transferable_functions import sendable
from ancfsparse.scene.sections.material import Material
from ancfsparse.scene.sections.sections import AnySection, parameters_of

if TYPE_CHECKING:
    from ancfsparse.scene.joints.joint import Builder

Vector = NDArray[np.float64]
Numbers = NDArray[np.int32]
VelocityField = Callable[[Vector], Vector]


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
        return self.__dict__ | {"velocity": sendable(self.velocity)}

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

    def constrain(self, builder: Builder) -> None:
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


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ElasticBody(Body):
    """Nodes and elements of one kind, section and material.

    Attributes
    ----------
    section : Rectangle, Circle, Tube, IBeam, Polygon or Section
        Its cross-section.
    material : Material
        What it is made of.
    """

    section: AnySection
    material: Material

    def finer(self, times: int) -> dict[str, Any]:
        """Return what changes in its record if every element is divided."""
        if "n_elements" in self.automatic:
            raise InputError(
                f"{self.name} has n_elements='auto', which a plan decides: nothing can be refined"
            )
        return {"n_elements": times * self.n_each}

    def describe(self) -> dict[str, str]:
        """Describe element, section, material and mesh."""
        links = np.concatenate([self.row_nodes, self.ends.ravel()]).astype("<i4")
        return {
            "element": repr(self.kind)
            if self.kind.package or self.kind.values
            else " ".join([self.element, *self.options.values()]),
            "section": repr(self.section),
            "material": repr(self.material),
            "mesh": f"{self.n_elements} elements, {checksum(links.tobytes())}",
        }

    def free_of_stress(self, ends: Vector) -> Vector:
        """Return the coordinates of both nodes of every element without stress, (n, 2, n_c).

        `ends` holds those of the reference shape, from which they may differ by eigenstrains.
        """
        return ends

    @property
    def speed(self) -> float:
        """Speed of sound in its material [m/s]."""
        return math.sqrt(self.material.youngs_modulus / self.material.density)

    def stiffnesses(self) -> dict[str, float]:
        """Give the base parameters of the kernels that all elements have in common.

        Returns
        -------
        dict of str to float
            ``axial_stiffness`` = ``youngs_modulus_area`` E A,
            ``shear_modulus_area`` G A, ``lame_area`` lam A, ``shear_stiffness_y`` and ``_z``
            k G A [N]; ``torsion_stiffness`` G J, ``bending_stiffness_y`` E int z^2 dA,
            ``bending_stiffness_z`` = ``bending_stiffness`` E int y^2 dA [N m2];
            ``mass_per_length`` rho A [kg/m]; ``inertia_y`` rho int y^2 dA and ``inertia_z``
            rho int z^2 dA [kg m]; ``poisson_ratio``.

        Notes
        -----
        ``inertia_y`` goes with the section vector r_y and so holds int y^2 dA, which as a second
        moment of area is named after the axis it turns about: ``section.inertia_z``.
        """
        return {
            name: value for group in self._parameters().values() for name, value in group.items()
        }

    @property
    def profile(self) -> Any:
        """Its section; where that changes, its means over elements."""
        return self.section

    @property
    def strains_damped(self) -> bool:
        """Whether the rates of its strains are damped."""
        return self.material.axial_retardation > 0.0 or self.material.bending_retardation > 0.0

    @property
    def masses_damped(self) -> bool:
        """Whether its velocity in space is damped."""
        return self.material.rayleigh[0] > 0.0

    def viscosities(self) -> dict[str, float]:
        """Give what takes the place of `stiffnesses` in the kernels of damping.

        Returns
        -------
        dict of str to float
            The stiffnesses times retardation times, the masses times Rayleigh's alpha, and
            ``poisson_ratio`` as it is.
        """
        material = self.material
        factors = {
            "stretching": material.axial_retardation,
            "turning": material.bending_retardation,
            "masses": material.rayleigh[0],
            "ratios": 1.0,
        }
        return {
            name: factors[kind] * value
            for kind, group in self._parameters().items()
            for name, value in group.items()
        }

    def _parameters(self) -> dict[str, dict[str, float]]:
        """Give all parameters, by what damps them, those of its element alone too."""
        groups = parameters_of(self.profile, self.material)
        for name, group in self.kind.own.items():
            groups[group][name] = self.kind.values[name]
        return groups


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
    def position(self) -> Vector:
        """Position in the reference shape, shape (dim,) [m]."""
        nodes = self.beam.positions
        place = self.beam.inside(self.index, self.xi) if self.xi else np.array(nodes[self.index])
        if self.offsets:
            place += np.array(self.offsets) @ self.beam.vectors_at(self)[: len(self.offsets)]
        return place
