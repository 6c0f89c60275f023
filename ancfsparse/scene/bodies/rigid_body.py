"""Rigid bodies in natural coordinates: an origin and orthonormal vectors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_finite
from ancfsparse.errors import InputError
from ancfsparse.messages import format_numbers
from ancfsparse.scene.bodies.body import Body, Point
from ancfsparse.scene.geometry.positions import check_position, place
from ancfsparse.scene.geometry.section_frames import section_axes
from ancfsparse.scene.records.record import PointRef

if TYPE_CHECKING:
    from ancfsparse.scene.bodies.body import ConstraintBuilder
    from ancfsparse.scene.bodies.rigid_shapes import RigidShape

VECTOR_LETTERS = "uvw"
ORIGIN_RATIO = 1e-12  # distance of a point that is the origin, over the size of the body
CENTRE_RATIO = 1e-9  # distance of a point that is the centre of mass, over the size of the body


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class RigidBody(Body):
    """A rigid body, as `Scene.add_body` returns it.

    Its coordinates are the position of its origin and the unit vectors of its axes, for a thin rod
    only the first one.  Points of the body are linear in them, so the mass matrix is constant and
    there are no gyroscopic forces; constraints keep the vectors orthonormal.

    Attributes
    ----------
    name, options, positions, vectors, velocity
        As in `Body`: one row, whose position is the origin.
    mass : float
        Mass [kg].
    spread : ndarray, shape (k + 1, k + 1)
        Mass, static moments and second moments of origin and k vectors [kg, kg m, kg m2].
    shape : RigidShape or None
        Shape.
    """

    mass: float
    spread: Vector
    shape: RigidShape | None = None
    speed = None  # it has no elastic waves

    def __repr__(self) -> str:
        """Return the name, the mass and the dimension."""
        kind = "planar" if self.dim == 2 else "spatial"
        return f"{self.name}: rigid, {self.mass:.6g} kg, {kind}"

    @property
    def masses(self) -> Vector:
        """Constant masses of origin and vectors."""
        return self.spread

    @property
    def total_mass(self) -> float:
        """Its mass [kg]."""
        return self.mass

    @property
    def n_vectors(self) -> int:
        """Number of its vectors."""
        return int(self.vectors.shape[1])

    @property
    def length(self) -> float:
        """Its `size` [m], in place of the length of elements."""
        return self.size

    @cached_property
    def size(self) -> float:
        """Root mean square distance of its mass from its origin [m]."""
        return float(np.sqrt(np.trace(self.spread[1:, 1:]) / self.mass))

    @property
    def shortest(self) -> float:
        """Its `size` [m]."""
        return self.size

    @property
    def corners(self) -> Vector:
        """Points at distance `size` from its origin along the axes of space, (2 dim, dim) [m]."""
        steps = self.size * np.eye(self.dim)
        return np.concatenate([self.positions + steps, self.positions - steps])

    @property
    def origin(self) -> Point:
        """The origin of its frame."""
        return Point(self, 0)

    @property
    def default_point(self) -> Point:
        """Its origin."""
        return self.origin

    @property
    def centre(self) -> Point:
        """Its centre of mass."""
        return self._point(self.spread[0, 1:] / self.mass)

    @property
    def end(self) -> Point:
        """The far end of a rod.

        Raises
        ------
        InputError
            If the body is not a rod.
        """
        if self.shape is None or not self.shape.is_line:
            raise InputError(
                f"{self.name} is not a rod and has no end: take {self.name}.at((x, y, z))"
            )
        return self._point(np.array([2.0 * float(self.shape.centre[0])]))

    def at(self, point: ArrayLike) -> Point:
        """Return a point of the body.

        Parameters
        ----------
        point : float or array_like of shape (dim,)
            Its coordinates in the frame of the body [m]; of a rod the distance along it.

        Raises
        ------
        InputError
            If a coordinate is not finite, or the point is off the line of a rod.
        """
        what = f"the point of {self.name}"
        if self.n_vectors == 1 and not np.iterable(point):
            point = check_finite(what, point, "m") * np.eye(self.dim)[0]
        given = check_position(what, point, self.dim)
        if given[self.n_vectors :].any():
            raise InputError(
                f"{what} {place(given)} is off its line: a thin rod has only points along its x "
                "axis; give the body an inertia instead of the shape Rod"
            )
        return self._point(given[: self.n_vectors])

    def _point(self, offsets: Vector) -> Point:
        near = np.abs(offsets) <= ORIGIN_RATIO * self.size
        return Point(self, 0, 0.0, () if near.all() else tuple(float(x) for x in offsets))

    def point(self, reference: PointRef) -> Point:
        """Return the handle of a point from its reference."""
        if not reference.offsets:
            return self.origin
        what = f"the point of {self.name}"
        return self._point(check_position(what, reference.offsets, self.n_vectors))

    def among(self, n_each: int, point: Point) -> PointRef:
        """Return the reference to a point: a rigid body has no elements."""
        return self.refer(point)

    def corresponding_point(self, handle: Point) -> Point:
        """Return the point of a rod at the arc length of a point of the beam that it replaces."""
        return self.at(handle.s)

    def interior_direction(self, node: Point) -> Vector:
        """Return the vector from a point to the centre of mass, at which it is the first vector."""
        offset = self.centre.position - node.position
        return offset if np.linalg.norm(offset) > CENTRE_RATIO * self.size else self.vectors[0, 0]

    def arc(self, point: Point) -> float:
        """Raise an error: a rigid body has no arc coordinate."""
        raise InputError(f"{point!r} has no arc coordinate: it is a point of a rigid body")

    def axes_of(self, row: int) -> Vector:
        """Return its unit vectors, (dim, dim); the normals of a rod are arbitrary."""
        if self.n_vectors == self.dim:
            return np.asarray(self.vectors[0])
        return section_axes(self.vectors[0, 0], None, self.name)

    def say(self, point: Point) -> str:
        """Return the location of a point, for messages."""
        if point.is_node:
            return f"{self.name} at its origin"
        return f"{self.name} at {place(np.array(point.offsets))}"

    def hint(self, point: Point) -> str:
        """Return a hint which node to use instead of a point."""
        return f"take {self.name}.origin, or give the body with its origin there"

    def describe(self) -> dict[str, str]:
        """Return the properties that determine its motion, for the digest."""
        return {
            "element": f"rigid, {self.n_vectors} vectors",
            "mesh": "one row",
            "inertia": format_numbers(self.spread),
        }

    def constrain(self, builder: ConstraintBuilder) -> None:
        """Add the equations (u.u - 1) / 2 = 0 and u.v = 0, times the size, in metres.

        Their gradients are added to the mass matrix, which alone is singular for a flat body.
        Rounding of u.v is relative to the lengths of both: the terms of the sum may all be zero.
        """
        size = self.size
        row = builder.rows(self.origin)[0]
        vectors = [row[self.kind.columns(name)] for name in self.kind.vectors[1:]]
        for k, u in enumerate(vectors):
            for j, v in enumerate(vectors[: k + 1]):
                is_norm = j == k
                factor = 0.5 * size if is_norm else size
                builder.equation(
                    f"rigidity of {self.name}, {VECTOR_LETTERS[j]}.{VECTOR_LETTERS[k]}",
                    -factor if is_norm else 0.0,
                    *((factor, a, b) for a, b in zip(u, v, strict=True)),
                    size=factor,
                    mass=self.mass,
                )
