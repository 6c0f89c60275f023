"""The methods of a scene that add joints."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.checks import check_choice, check_flag
from ancfsparse.errors import InputError
from ancfsparse.scene import records
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.geometry.positions import COINCIDENCE_RATIO, check_position, place
from ancfsparse.scene.joints.clamp import Clamp, ClampSpec
from ancfsparse.scene.joints.connect import Connect, ConnectSpec
from ancfsparse.scene.joints.distance import Distance, DistanceSpec, RigidRod, RodSpec
from ancfsparse.scene.joints.joint import check_end, check_other_body, check_point, check_turns
from ancfsparse.scene.joints.pin import Pin, PinSpec
from ancfsparse.scene.joints.prescribed_point import DriveSpec, PrescribedPoint
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.record import as_data


class Joints(SceneBase):
    """Joints of a scene."""

    def pin(self, node: Point, *, as_constraint: bool = False) -> Pin:
        """Fix the position of a point, leave its rotation free.

        Parameters
        ----------
        node : Point
            The point, for example ``rod.start`` or ``rod.at(0.3)``; inside an element it is fixed
            by equations.
        as_constraint : bool, optional
            Add constraint equations, whose multipliers are the reaction, instead of eliminating
            coordinates.  The motion is the same.
        """
        own = self._mine("a pin", check_point("a pin", node))
        as_constraint = check_flag("as_constraint of a pin", as_constraint)
        return self._add(Pin(own, as_constraint), PinSpec(own.reference, as_constraint))

    def clamp(self, node: Point, stretch: str = "free") -> Clamp:
        """Fix the position and the rotation of a node; of a mesh, every slope at the node.

        Parameters
        ----------
        node : Point
            The node, for example ``rod.start``.
        stretch : str, optional
            ``"free"`` fixes the section: the direction of the slope r_x of a cable, r_y and r_z of
            a thick beam, and with ``curvature="axis"`` also r_x, which rotates with them.
            ``"fixed"`` also fixes the whole slope r_x: a cable cannot stretch at the wall, and a
            beam with ``curvature="section"`` can neither stretch nor shear there, which makes the
            first element too stiff.
        """
        check_choice("stretch of a clamp", stretch, ("free", "fixed"))
        own = check_turns("a clamp", self._mine("a clamp", check_end("a clamp", node)))
        return self._add(Clamp(own, stretch), ClampSpec(own.reference, stretch))

    def drive(
        self,
        node: Point,
        position: ArrayLike | Callable[[float], ArrayLike],
        *,
        rate: Callable[[float], ArrayLike] | None = None,
        second_rate: Callable[[float], ArrayLike] | None = None,
        as_constraint: bool = False,
    ) -> PrescribedPoint:
        """Prescribe the position of a point, leave its rotation free.

        The required force is the reaction at the node; its work is part of the energy balance.

        Parameters
        ----------
        node : Point
            The point, for example ``rod.start`` or ``rod.at(0.3)``.
        position : array_like of shape (dim,), or callable
            The position [m], or a function of t [s] that returns it: a signal such as
            ``Ramp((0.1, 0.0), 0.5, smooth=True) + (2.0, 0.0)`` or a user function, whose
            second derivative must be continuous.  `simulate` starts at its initial position and
            velocity; from another position `solve_static` leads there.
        rate, second_rate : callable, optional
            Velocity [m/s] and acceleration [m/s2] as functions of t.  A signal has its own; for
            other functions the default is differences over six points a step apart, whose errors
            are of fourth order in the step.  Error-controlled runs require them.
        as_constraint : bool, optional
            Add equations, whose multipliers are the reaction, instead of prescribing coordinates.
            The motion is the same.
        """
        own = self._mine("a drive", check_point("a drive", node))
        as_constraint = check_flag("as_constraint of a drive", as_constraint)
        subject = f"the position of the drive at {own!r}"
        motion = records.define_motion(subject, self.dim, position, rate, second_rate)
        record = DriveSpec(own.reference, as_data(position), rate, second_rate, as_constraint)
        return self._add(PrescribedPoint(own, motion, as_constraint), record)

    def rod(
        self,
        node: Point,
        anchor: ArrayLike,
        *,
        length: Callable[[float], float] | None = None,
        rate: Callable[[float], float] | None = None,
        second_rate: Callable[[float], float] | None = None,
    ) -> RigidRod:
        """Tie a point to a fixed one with a rigid massless rod of their initial distance.

        Parameters
        ----------
        node : Point
            The constrained point.
        anchor : array_like, shape (dim,)
            The fixed point [m], which differs from the node.
        length : callable, optional
            The distance as a function of t [m], for example of a rope that a winch pulls in, given
            as positions in `drive`, with ``rate`` [m/s] and ``second_rate`` [m/s2].  By default
            it is constant.  The rod transmits tension and compression.
        rate, second_rate : callable, optional
            Its derivatives, as in `drive`.
        """
        self._mine("a rod", check_point("a rod", node))
        point = check_position(f"anchor of the rod at {node!r}", anchor, self.dim)
        difference = node.position - point
        distance = math.sqrt(difference @ difference)
        if distance <= COINCIDENCE_RATIO * node.beam.size:
            raise InputError(
                f"the rod at {node!r} would have zero length: its anchor {place(point)} is the "
                "node itself; to hold the node there, use pin"
            )
        subject = f"the length of the rod at {node!r}"
        motion = self._length_over_time(subject, length, rate, second_rate)
        record = RodSpec(node.reference, as_data(point), length, rate, second_rate)
        return self._add(RigidRod(node, point, distance, motion), record)

    def connect(self, a: Point, b: Point, *, apart: bool = False) -> Connect:
        """Make two points coincide, with free relative rotation.

        Parameters
        ----------
        a, b : Point
            Points with the same reference position, unless `apart`.
        apart : bool, optional
            True if they may differ in the reference shape.  `assemble` and `solve_static` make them
            coincide; a motion starts from their result.

        Returns
        -------
        Connect
            The joint, spherical in a spatial scene, a revolute joint in a planar one.
        """
        self._mine("a connection", check_point("a connection", a))
        self._mine("a connection", check_point("a connection", b))
        if a == b:
            raise InputError(f"a connection needs two points, got {a!r} twice")
        check_other_body("a connection", a, b)
        gap = float(np.linalg.norm(a.position - b.position))
        apart = check_flag("apart", apart)
        if not apart and gap > COINCIDENCE_RATIO * max(a.beam.size, b.beam.size):
            raise InputError(
                f"{a!r} and {b!r} cannot be connected: they are {gap:.6g} m apart, at "
                f"{place(a.position)} and {place(b.position)}; move one beam so that they meet, "
                "or give apart=True and let assemble move them"
            )
        return self._add(Connect(a, b, apart), ConnectSpec(a.reference, b.reference, apart))

    def distance(
        self,
        a: Point,
        b: Point,
        *,
        length: Callable[[float], float] | None = None,
        rate: Callable[[float], float] | None = None,
        second_rate: Callable[[float], float] | None = None,
    ) -> Distance:
        """Keep or prescribe the distance between two points, as a rigid massless rod does.

        Parameters
        ----------
        a, b : Point
            Two different points.
        length, rate, second_rate : callable, optional
            As in `rod`, for example of a hydraulic cylinder.

        Returns
        -------
        Distance
            The joint; to a fixed point it is `rod`.
        """
        self._mine("a distance", check_point("a distance", a))
        self._mine("a distance", check_point("a distance", b))
        check_other_body("a distance", a, b)
        initial = float(np.linalg.norm(a.position - b.position))
        if initial <= COINCIDENCE_RATIO * max(a.beam.size, b.beam.size):
            raise InputError(f"{a!r} and {b!r} coincide: to keep them together, use connect")
        subject = f"the distance of {a!r} and {b!r}"
        motion = self._length_over_time(subject, length, rate, second_rate)
        record = DistanceSpec(a.reference, b.reference, length, rate, second_rate)
        return self._add_partial(Distance(a, b, initial, motion), record)
