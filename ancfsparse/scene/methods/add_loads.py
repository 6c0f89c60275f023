"""The methods of a scene that add loads."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.checks import check_flag
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.bodies.mesh import Mesh
from ancfsparse.scene.joints.joint import check_node, check_point, check_turns
from ancfsparse.scene.loads.loads import (
    ChangingGravity,
    DistributedForce,
    PointForce,
    PointMoment,
)
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.record import At, Record, record_type, text


class LoadSpec(Record):
    """The base of the records of loads."""

    def describe(self, at: At, made: Any) -> str:
        """Describe its position and its value, for the digest."""
        where, value, *more = self.given.values()
        options = "".join(
            f", {name} {text(option, at)}"
            for name, option in zip([*self.given][2:], more, strict=True)
            if option is not None and option is not False
        )
        return f"{type(made).__name__} ({at(where)}): {text(value, at)}{options}"


class Loads(SceneBase):
    """Loads of a scene."""

    def point_force(
        self,
        node: Point,
        value: ArrayLike | Callable[[float], ArrayLike],
        *,
        follow: bool = False,
    ) -> PointForce:
        """Apply a force at any point of a beam or of a rigid body.

        Parameters
        ----------
        node : Point
            The point, for example ``rod.end`` or ``rod.at(0.3)``.
        value : array_like, shape (dim,), or callable
            The force [N], or a function of t [s] that returns it, such as `Ramp`, `Sine`, `Pulse`
            or `Table`.
        follow : bool, optional
            True for a follower force, with components along the axes of the section: in the plane
            along the slope and its left normal, in space along the vectors r_x (the slope), r_y and
            r_z of a thick beam or a rigid body.  A cable in space has only its slope, so the force
            is one number.
        """
        own = self._mine("a force", check_point("a force", node))
        follow = check_flag("follow", follow)
        if follow and own.beam.kind.is_string and own.is_node:
            raise InputError(
                f"a force on {own!r} cannot follow its slope, which jumps at the nodes of a "
                "string: take a point inside an element, or element='thin'"
            )
        load = PointForce(own, value, follow)
        return self._keep(
            self.loads, load, PointForceSpec(own.reference, load.value, follow=follow)
        )

    def point_moment(
        self,
        node: Point,
        value: ArrayLike | Callable[[float], ArrayLike],
        *,
        follow: bool = False,
    ) -> PointMoment:
        """Apply a moment at a node of a beam or to a rigid body.

        Parameters
        ----------
        node : Point
            The node, for example ``rod.end``.
        value : float, array_like of shape (3,), or callable
            The moment [N m], or a function of t [s] that returns it: one number
            about +z in a planar scene, three components in a spatial one.  A cable has no
            torsion: the part of a moment along its axis has no effect.  A moment acts on r_y and
            r_z of a beam with ``curvature="section"``, on r_x of all others.
        follow : bool, optional
            True for a follower moment, about the axes r_x, r_y and r_z of the section.  In the
            plane it makes no difference.
        """
        own = check_turns("a moment", self._mine("a moment", check_node("a moment", node)))
        follow = check_flag("follow", follow)
        load = PointMoment(own, value, follow)
        if follow and self.dim == 3 and len(node.beam.kind.vectors) < 4:
            raise InputError(
                f"a moment on {node!r} cannot follow its section, which has no axis but the slope: "
                "take element='thick', or a moment about axes of space"
            )
        if self.dim == 3 and node.beam.kind.is_cable and not callable(value):
            axis, moment = node.beam.axes_of(node.beam.rows_of(node.index).start)[0], load.at(0.0)
            if moment.any() and np.linalg.norm(np.cross(moment, axis)) <= 1e-9 * np.linalg.norm(
                moment
            ):
                raise InputError(
                    f"the moment on {node!r} is along the axis of a cable, which cannot be "
                    "twisted: take element='thick'"
                )
        return self._keep(
            self.loads, load, PointMomentSpec(own.reference, load.value, follow=follow)
        )

    def distributed_force(
        self,
        beam: ElasticBody,
        value: ArrayLike | Callable[[float], ArrayLike],
        *,
        shape: Callable[[float], float] | None = None,
        follow: bool = False,
    ) -> DistributedForce:
        """Apply a force per reference length along a whole beam or mesh.

        Parameters
        ----------
        beam : Beam or Mesh
            The body.
        value : array_like, shape (dim,), or callable
            The force per length [N/m], or a function of t [s] that returns it, such as `Ramp`,
            `Sine`, `Pulse` or `Table`.
        shape : callable, optional
            Factor of the force along a beam as a function of the arc coordinate s [m], from 0 at
            the start to the length.  It is integrated with five Gauss points per element.
        follow : bool, optional
            True for a follower force along the axes of the sections, as in `point_force`; in the
            plane ``(0, p)`` is a pressure on the right-hand side of the beam.  It remains a force
            per reference length.
        """
        if not isinstance(beam, ElasticBody):
            raise InputError(
                f"a distributed force needs a beam of the scene, got {format_value(beam)}"
            )
        own = self._own("a distributed force", beam)
        if shape is not None and not callable(shape):
            raise InputError(
                f"shape must be a function of the arc coordinate in m, got {format_value(shape)}"
            )
        if shape is not None and isinstance(beam, Mesh):
            raise InputError(
                f"shape is a function of the arc coordinate, and the mesh {beam.name} has no such "
                "coordinate: load it uniformly, or by forces on points"
            )
        follow = check_flag("follow", follow)
        load = DistributedForce(own, value, shape, follow)
        load.factors(np.array([0.0, beam.length]))
        record = DistributedForceSpec(beam.reference, load.value, shape=shape, follow=follow)
        return self._keep(self.loads, load, record)

    def changing_gravity(self, value: ArrayLike | Callable[[float], ArrayLike]) -> ChangingGravity:
        """Apply time-dependent gravity, in addition to the constant gravity of the scene.

        In a frame that accelerates by a(t), such as a vehicle, a lift or a shaken table, it is
        ``-a(t)``, and positions and velocities are those relative to the frame.

        Parameters
        ----------
        value : array_like, shape (dim,), or callable
            The acceleration [m/s2], or a function of t [s] that returns it, such as `Ramp`, `Sine`,
            `Pulse` or `Table`.
        """
        load = ChangingGravity(self.dim, value)
        return self._keep(self.loads, load, ChangingGravitySpec(load.value))


FORCE = {"follow": "absent", "value": "into"}
PointForceSpec = record_type("PointForceSpec", Loads.point_force, LoadSpec, {"value": "N"}, FORCE)
PointMomentSpec = record_type(
    "PointMomentSpec", Loads.point_moment, LoadSpec, {"value": "N m"}, {"value": "across"}
)
DistributedForceSpec = record_type(
    "DistributedForceSpec", Loads.distributed_force, LoadSpec, {"value": "N/m"}, FORCE
)
ChangingGravitySpec = record_type(
    "ChangingGravitySpec",
    Loads.changing_gravity,
    units={"value": "m/s2"},
    planar={"value": "into"},
)
