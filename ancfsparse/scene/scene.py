"""The scene: a list of beams, joints and loads, checked as they are added."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.checks import check_choice, check_flag
from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import element_kind
from ancfsparse.scene.bodies import Body, Node
from ancfsparse.scene.course import course_of
from ancfsparse.scene.digest import digest
from ancfsparse.scene.forces import Forces
from ancfsparse.scene.joints import (
    SAME_PLACE,
    Clamp,
    Connect,
    Drive,
    Holds,
    Joint,
    Pin,
    Rod,
    check_node,
    check_point,
)
from ancfsparse.scene.loads import DistributedForce, Load, PointForce, PointMoment
from ancfsparse.scene.masses import Masses
from ancfsparse.scene.springs import Springs
from ancfsparse.scene.straight import check_position, place
from ancfsparse.words import shown

AnyJoint = TypeVar("AnyJoint", bound=Joint)


class Scene(
    Masses,
    Springs,
    Forces,
):
    """Beams, joints, loads and what is attached, in one gravity field.

    Parameters
    ----------
    gravity : array_like, shape (2,) or (3,), optional
        Acceleration of gravity [m/s2].  Two components make the scene planar, three spatial.

    Attributes
    ----------
    dim : int
        2 if planar, 3 if spatial.
    gravity : ndarray, shape (dim,)
        Acceleration of gravity [m/s2], read-only.
    beams : list of Beam and Mesh
        In the order they were added.
    joints : list of Joint
        Likewise.
    loads : list of Load
        Likewise.
    attached : list of Attached
        Masses, springs and forces of the motion, likewise.
    """

    def __init__(self, gravity: ArrayLike = (0.0, -9.81)) -> None:
        super().__init__(gravity)
        self.joints: list[Joint] = []
        self.loads: list[Load] = []
        self._holds = Holds()

    def __repr__(self) -> str:
        """Count what the scene holds."""
        kind = "planar" if self.dim == 2 else "spatial"
        return (
            f"{kind} scene: beams {len(self.beams)}, joints {len(self.joints)}, "
            f"loads {len(self.loads)}" + f", attached {len(self.attached)}" * bool(self.attached)
        )

    def digest(self) -> dict[str, str]:
        """Describe its parts, so that its file can be distinguished from that of another scene."""
        return digest(self, self.joints, self.loads)

    def pin(self, node: Node, *, as_constraint: bool = False) -> Pin:
        """Hold the position of a node where it is, leave its rotation free.

        Parameters
        ----------
        node : Node
            The node, for example ``rod.start``.
        as_constraint : bool, optional
            Hold it by constraint equations, whose multipliers are the reaction, instead of by
            leaving its coordinates out.  The motion is the same.

        Returns
        -------
        Pin
            The joint.
        """
        own = self._mine("a pin", check_node("a pin", node))
        return self._add(Pin(own, check_flag("as_constraint of a pin", as_constraint)))

    def clamp(self, node: Node, stretch: str = "free") -> Clamp:
        """Hold the position and the rotation of a node; of a mesh, every slope at the node.

        Parameters
        ----------
        node : Node
            The node, for example ``rod.start``.
        stretch : str, optional
            ``"free"`` holds the section: of a cable the direction of the slope r_x, of a thick beam
            r_y and r_z, and with ``curvature="axis"`` r_x as well, which turns with them.
            ``"fixed"`` holds all of r_x too: a cable cannot stretch at the wall, and a beam with
            ``curvature="section"`` can neither stretch nor shear there, which makes the first
            element too stiff.

        Returns
        -------
        Clamp
            The joint.
        """
        check_choice("stretch of a clamp", stretch, ("free", "fixed"))
        return self._add(Clamp(self._mine("a clamp", check_node("a clamp", node)), stretch))

    def drive(
        self,
        node: Node,
        position: ArrayLike | Callable[[float], ArrayLike],
        *,
        rate: Callable[[float], ArrayLike] | None = None,
        second_rate: Callable[[float], ArrayLike] | None = None,
        as_constraint: bool = False,
    ) -> Drive:
        """Move the position of a node as prescribed, leave its rotation free.

        The force that takes is the reaction at the node; its work counts in the energy balance.

        Parameters
        ----------
        node : Node
            The node, for example ``rod.start``.
        position : array_like of shape (dim,), or callable
            Where it is [m], or a function of t [s] that returns it: a signal such as
            ``Ramp((0.1, 0.0), 0.5, smooth=True) + (2.0, 0.0)`` or a function of your own, whose
            second derivative must be continuous.  `simulate` starts where it is at the start, and
            with its velocity; from another place `solve_static` leads there.
        rate, second_rate : callable, optional
            Velocity [m/s] and acceleration [m/s2] as functions of t.  Those of a signal are known;
            for a function without them differences over six points a step apart stand for them,
            whose errors are of fourth order in the step; runs to an accuracy need them.
        as_constraint : bool, optional
            Move it by equations, whose multipliers are the reaction, instead of by prescribing its
            coordinates.  The motion is the same.

        Returns
        -------
        Drive
            The joint.
        """
        own = self._mine("a drive", check_node("a drive", node))
        check_flag("as_constraint of a drive", as_constraint)
        subject = f"the position of the drive at {own!r}"
        course = course_of(subject, self.dim, position, rate, second_rate)
        return self._add(Drive(own, course, as_constraint))

    def rod(
        self,
        node: Node,
        anchor: ArrayLike,
        *,
        length: Callable[[float], float] | None = None,
        rate: Callable[[float], float] | None = None,
        second_rate: Callable[[float], float] | None = None,
    ) -> Rod:
        """Tie a node to a fixed point with a rigid massless rod of their initial distance.

        Parameters
        ----------
        node : Node
            The node held.
        anchor : array_like, shape (dim,)
            The fixed point [m], apart from the node.
        length : callable, optional
            The distance as a function of t [m], for example of a rope that a winch pulls in, given
            as `drive` takes positions, with ``rate`` [m/s] and ``second_rate`` [m/s2].  By default
            it stays.  The rod pushes as well as it pulls.
        rate, second_rate : callable, optional
            Its derivatives, as `drive` takes them.

        Returns
        -------
        Rod
            The joint.
        """
        self._mine("a rod", check_node("a rod", node))
        point = check_position(f"anchor of the rod at {node!r}", anchor, self.dim)
        distance = float(np.linalg.norm(node.position - point))
        if distance <= SAME_PLACE * node.beam.size:
            raise InputError(
                f"the rod at {node!r} would have zero length: its anchor {place(point)} is the "
                "node itself; to hold the node there, use pin"
            )
        course = None
        if length is not None:
            course = course_of(f"the length of the rod at {node!r}", 0, length, rate, second_rate)
        return self._add(Rod(node, point, distance, course))

    def connect(self, a: Node, b: Node) -> Connect:
        """Join two nodes at one place, free to turn against each other.

        Parameters
        ----------
        a, b : Node
            Nodes with the same reference position.

        Returns
        -------
        Connect
            The joint, spherical in a spatial scene, a revolute joint in a planar one.
        """
        self._mine("a connection", check_node("a connection", a))
        self._mine("a connection", check_node("a connection", b))
        if a == b:
            raise InputError(f"a connection needs two nodes, got {a!r} twice")
        gap = float(np.linalg.norm(a.position - b.position))
        if gap > SAME_PLACE * max(a.beam.size, b.beam.size):
            raise InputError(
                f"{a!r} and {b!r} cannot be connected: they are {gap:.6g} m apart, at "
                f"{place(a.position)} and {place(b.position)}; move one beam so that they meet"
            )
        return self._add(Connect(a, b))

    def point_force(
        self, node: Node, value: ArrayLike | Callable[[float], ArrayLike]
    ) -> PointForce:
        """Apply a force at any point of a beam.

        Parameters
        ----------
        node : Node
            Where, for example ``rod.end`` or ``rod.at(0.3)``.
        value : array_like, shape (dim,), or callable
            The force [N], fixed in space, or a function of t [s] that returns it, such as `Ramp`,
            `Sine`, `Pulse` or `Table`.

        Returns
        -------
        PointForce
            The load.
        """
        load = PointForce(self._mine("a force", check_point("a force", node)), value)
        self.loads.append(load)
        return load

    def point_moment(
        self, node: Node, value: ArrayLike | Callable[[float], ArrayLike]
    ) -> PointMoment:
        """Apply a moment at a node of a beam.

        Parameters
        ----------
        node : Node
            Where, for example ``rod.end``.
        value : float, array_like of shape (3,), or callable
            The moment [N m], fixed in space, or a function of t [s] that returns it: one number
            about +z in a planar scene, three components in a spatial one.  A cable cannot be
            twisted: the part of a moment along its axis does nothing.  A beam with
            ``curvature="section"`` takes a moment on r_y and r_z, all others bend by r_x.

        Returns
        -------
        PointMoment
            The load.
        """
        load = PointMoment(self._mine("a moment", check_node("a moment", node)), value)
        kind = element_kind(node.beam.element, self.dim, **node.beam.options)
        if self.dim == 3 and kind.is_cable and not callable(value):
            axis, moment = node.beam.axes_of(node.beam.rows_of(node.index).start)[0], load.at(0.0)
            if moment.any() and np.linalg.norm(np.cross(moment, axis)) <= 1e-9 * np.linalg.norm(
                moment
            ):
                raise InputError(
                    f"the moment on {node!r} is along the axis of a cable, which cannot be "
                    "twisted: take element='thick'"
                )
        self.loads.append(load)
        return load

    def distributed_force(
        self, beam: Body, value: ArrayLike | Callable[[float], ArrayLike]
    ) -> DistributedForce:
        """Apply a force per reference length along a whole beam or mesh.

        Parameters
        ----------
        beam : Beam or Mesh
            Where.
        value : array_like, shape (dim,), or callable
            The force per length [N/m], fixed in space, or a function of t [s] that returns it,
            such as `Ramp`, `Sine`, `Pulse` or `Table`.

        Returns
        -------
        DistributedForce
            The load.
        """
        if not isinstance(beam, Body):
            raise InputError(f"a distributed force needs a beam of the scene, got {shown(beam)}")
        load = DistributedForce(self._own("a distributed force", beam), value)
        self.loads.append(load)
        return load

    def _mine(self, what: str, node: Node) -> Node:
        self._own(what, node.beam)
        return node

    def _add(self, joint: AnyJoint) -> AnyJoint:
        self._holds.add(joint)
        self.joints.append(joint)
        return joint


def check_scene(scene: object) -> None:
    """Refuse what is no scene."""
    if not isinstance(scene, Scene):
        raise InputError(f"a Scene is needed, got {shown(scene)}")
