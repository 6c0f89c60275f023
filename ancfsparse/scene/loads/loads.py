"""Loads: constant, or functions of time that return the load at time t [s]."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import call_function, check_finite
from ancfsparse.scene.bodies.body import Body, Point
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.loads.attachment import Marks
from ancfsparse.scene.records.picklable_functions import picklable
from ancfsparse.scene.records.time_dependent import TimeDependentValue, Value

MAX_ARROWS = 7  # of a distributed force, which are enough to see where it acts
# The value of a follower force of a cable in space, for messages.
AXIAL_FORCE = "one number along the axis, the only axis that a cable has in space"


@dataclass(frozen=True, eq=False)
class PointForce(TimeDependentValue):
    """A force at a point, fixed in space or along the axes of the section.

    Attributes
    ----------
    node, value, follow
        As in `Scene.point_force`.
    """

    node: Point
    value: Value
    follow: bool = False
    unit = "N"
    number = AXIAL_FORCE

    @property
    def what(self) -> str:
        """Name in messages."""
        return f"the force on {self.node!r}"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a value: (dim,), or () along the axis of a cable in space."""
        return _components(self.node.beam, self.follow)

    @property
    def marks(self) -> Marks:
        """Its symbol in pictures, with the direction at t = 0."""
        return [("force", self.node, None if self.follow else direction_of(self.at(0.0)))]


@dataclass(frozen=True, eq=False)
class PointMoment(TimeDependentValue):
    """A moment at a node, about axes of space or of the section.

    Attributes
    ----------
    node, value, follow
        As in `Scene.point_moment`.
    """

    node: Point
    value: Value
    follow: bool = False
    unit = "N m"

    @property
    def what(self) -> str:
        """Name in messages."""
        return f"the moment on {self.node!r}"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a value: () in a planar scene, else (3,)."""
        return () if self.node.beam.dim == 2 else (3,)

    @property
    def marks(self) -> Marks:
        """Its symbol in pictures, in the plane with direction (1, 0) or (-1, 0)."""
        is_planar = self.node.beam.dim == 2
        sign = np.sign(self.at(0.0)[0]) * np.eye(2)[0] if is_planar else None
        return [("moment", self.node, sign)]


@dataclass(frozen=True, eq=False)
class DistributedForce(TimeDependentValue):
    """A force per reference length along a whole beam or mesh.

    Attributes
    ----------
    beam, value, along, follow
        As in `Scene.distributed_force`, where `along` is `shape`.
    """

    beam: ElasticBody
    value: Value
    along: Callable[[float], float] | None = None
    follow: bool = False
    unit = "N/m"
    number = AXIAL_FORCE

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling."""
        return super().__getstate__() | {"along": picklable(self.along)}

    @property
    def what(self) -> str:
        """Name in messages."""
        return f"the distributed force on {self.beam.name}"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a value: (dim,), or () along the axis of a cable in space."""
        return _components(self.beam, self.follow)

    @property
    def marks(self) -> Marks:
        """Symbols in pictures at some nodes of its body, with directions at t = 0."""
        body, value, arcs = self.beam, self.at(0.0), getattr(self.beam, "arcs", None)
        factors = np.ones(body.n_nodes) if arcs is None else self.factors(arcs)
        has_direction = not self.follow and (self.along is None or arcs is not None)
        for node in np.unique(np.linspace(0, body.n_nodes - 1, MAX_ARROWS).astype(int)).tolist():
            direction = direction_of(factors[node] * value) if has_direction else None
            yield "force", body.node(node), direction

    def factors(self, arcs: Vector) -> Vector:
        """Return the factor at arc coordinates [m], of any shape [-].

        Raises
        ------
        InputError
            If the function fails, or does not return a finite number.
        """
        if self.along is None:
            return np.ones_like(arcs)
        out = np.empty_like(arcs)
        for k, s in enumerate(arcs.ravel().tolist()):
            name = f"the shape of {self.what} at s = {s:.6g} m"
            out.flat[k] = check_finite(name, call_function(name, self.along, s))
        return out


@dataclass(frozen=True, eq=False)
class ChangingGravity(TimeDependentValue):
    """A time-dependent uniform acceleration of all masses, in addition to gravity.

    Attributes
    ----------
    dim : int
        Dimension of the scene.
    value : ndarray, shape (dim,), or callable
        As in `Scene.changing_gravity`.
    """

    dim: int
    value: Value
    unit = "m/s2"
    what = "the changing gravity"
    marks: Marks = ()

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a value, (dim,)."""
        return (self.dim,)


def direction_of(force: Vector) -> Vector:
    """Return the unit vector of a force, zero of none."""
    return force / (float(np.linalg.norm(force)) or 1.0)


def _components(body: Body, follow: bool) -> tuple[int, ...]:
    """Return the shape of a force: a follower force of a cable in space has one component."""
    return () if follow and body.dim == 3 and len(body.kind.vectors) <= 2 else (body.dim,)


Load = PointForce | PointMoment | DistributedForce | ChangingGravity
