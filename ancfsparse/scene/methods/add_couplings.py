"""The methods of a scene that prescribe or couple joint coordinates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.checks import check_finite, check_flag, check_moderate, check_vector
from ancfsparse.errors import InputError, SingularSceneError
from ancfsparse.messages import format_value
from ancfsparse.scene import mechanisms, records
from ancfsparse.scene.bodies.beam import Beam
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.bodies.mesh import Mesh
from ancfsparse.scene.geometry.section_frames import normals
from ancfsparse.scene.joints.joint import Joint, check_end
from ancfsparse.scene.joints.joint_coordinate import COORDINATE_UNITS, select_coordinate
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.record import (
    At,
    BodyRef,
    JointRef,
    Record,
    as_data,
    record_type,
    text,
)

if TYPE_CHECKING:
    from ancfsparse.scene.records.signal import Signal


@dataclass(frozen=True, eq=False)
class DrivenSpec(Record):
    """The record of `Scene.drive_joint`."""

    joint: JointRef
    value: Any
    rate: Callable[[float], float] | None = None
    second_rate: Callable[[float], float] | None = None
    of: str | None = None
    as_constraint: bool = False
    method = "drive_joint"

    def describe(self, at: At, made: Any) -> str:
        """Describe the data of its equation."""
        kind = "drive as constraint" if self.as_constraint else "drive"
        return f"{kind} of {made.of} ({at(self.joint)}) along {text(self.value, at)}"


@dataclass(frozen=True, eq=False)
class WinchSpec(Record):
    """The record of `Scene.winch`."""

    points: tuple[Any, ...]
    length: Any = None
    rate: Callable[[float], float] | None = None
    second_rate: Callable[[float], float] | None = None
    drum: JointRef | None = None
    radius: float | None = None
    method = "winch"
    units: ClassVar = {"radius": "m"}

    def describe(self, at: At, made: Any) -> str:
        """Describe the data of its equation."""
        points = "; ".join(text(end, at) for end in self.points)
        length = "" if self.length is None else f", length {text(self.length, at)}"
        drum = "" if self.drum is None else f", drum {at(self.drum)} {self.radius:.9g}"
        return f"winch ({points}){length}{drum}"


class Couplings(SceneBase):
    """Joints of a scene that act on the coordinates of other joints."""

    def drive_joint(
        self,
        joint: Joint,
        value: float | Signal | Callable[[float], float],
        *,
        rate: Callable[[float], float] | None = None,
        second_rate: Callable[[float], float] | None = None,
        of: str | None = None,
        as_constraint: bool = False,
    ) -> mechanisms.PrescribedJoint:
        """Prescribe a joint coordinate: the angle of a hinge, the displacement of a sliding joint.

        `Trajectory.joint_force` is the required moment or force; its work is part of the energy
        balance.  The angle of a planar body relative to the ground is prescribed by coordinates if
        other joints permit and another coordinate of the scene remains free, unlike with one `Rod`
        on a pin: angle, angular velocity and acceleration are exact then.  All others are
        equations, whose velocities and accelerations have the error of the integrator.

        Parameters
        ----------
        joint : Joint
            A revolute, cylindrical or prismatic joint; in a planar scene also a pin or a connection
            of nodes, also of beams, whose slopes then rotate.
        value : float, Signal or callable
            The rotation [rad] of the first side of the joint relative to the second one or the
            ground, right-handed about the axis, counterclockwise in the plane; it is 0 in the
            reference shape and may exceed a turn.  Or the displacement of the first point relative
            to the second one along the axis [m].  A signal such as
            ``Ramp(math.pi, 0.5, smooth=True)`` or a function of t [s], whose second derivative must
            be continuous.  `simulate` starts with its initial rate.
        rate, second_rate : callable, optional
            Its derivatives, as in `drive`.
        of : str, optional
            ``"angle"`` or ``"displacement"``, where a joint has both.
        as_constraint : bool, optional
            Always use an equation; `EnergyMomentum` then conserves the energy to rounding.

        Raises
        ------
        InputError
            If the joint has no such coordinate, or the motion is not smooth.
        SingularSceneError
            If it is prescribed already.
        """
        reference = self._joint("a drive", joint)
        coordinate = select_coordinate("a drive", joint, of)
        subject = f"the {coordinate} of the {joint.label}"
        if any(
            isinstance(other, mechanisms.PrescribedJoint)
            and (other.joint, other.of) == (joint, coordinate)
            for other in self.joints
        ):
            raise SingularSceneError(f"{subject} is prescribed already: leave one drive out")
        motion = records.define_motion(
            subject, 0, value, rate, second_rate, COORDINATE_UNITS[coordinate]
        )
        flag = check_flag("as_constraint of a drive", as_constraint)
        record = DrivenSpec(reference, value, rate, second_rate, of, flag)
        return self._add_partial(
            mechanisms.PrescribedJoint(joint, coordinate, motion, flag), record
        )

    def slide(
        self, point: Point, along: Beam | Mesh, *, lateral: ArrayLike | None = None
    ) -> mechanisms.Slide:
        """Let a point slide along a beam or a mesh without friction, from element to element.

        Parameters
        ----------
        point : Point
            The point, such as ``carriage.origin``, of another body or beam, initially on the axis
            of the beam.
        along : Beam or Mesh
            The beam, with an axis that has slopes; or a mesh, along the line that the point is on
            at the start, straight at crossings.  The run ends with an error that keeps the
            previous states when the point reaches an end.
        lateral : array_like, shape (3,), optional
            In space, a direction to which the axis does not become parallel, such as the horizontal
            one across a rope; by default the section axis nearest to the horizontal.

        Returns
        -------
        Slide
            The joint; `Trajectory.joint_force` is the force of the beam on the point.

        Raises
        ------
        InputError
            If the point is not on the beam, is a point of the beam, or is on a closed line.
        """
        node = self._mine("a slide", check_end("a slide", point))
        if not isinstance(along, Beam | Mesh):
            raise InputError(
                f"a slide needs a beam or a mesh to slide along, got {format_value(along)}"
            )
        self._own("a slide", along)
        if node.beam is along:
            raise InputError(f"{node!r} is a point of {along.name} and cannot slide along itself")
        if along.kind.is_string:
            raise InputError(
                f"{along.name} is made of strings, whose axis has corners at the nodes, and a "
                "slide needs a smooth one: take element='thin'"
            )
        if isinstance(along, Beam):
            elements, axes = np.arange(along.n_elements), np.asarray(along.axes_of(0))
        else:
            elements = mechanisms.elements_under(node, along)
            ends = along.positions[along.row_nodes[along.ends[elements[0]]]]
            axis = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
            axes = np.vstack([axis, normals(axis)])
        across = axes[0]
        if lateral is not None and self.dim == 2:
            raise InputError(
                "lateral of a slide has no meaning in a planar scene, where the axis has one "
                "normal: leave it out"
            )
        if lateral is None and self.dim == 3:
            across = axes[1:][np.argmin(np.abs(axes[1:] @ self.gravity))]
        elif lateral is not None:
            across = check_vector("lateral of a slide", lateral, self.dim)
            length = float(np.linalg.norm(across))
            if length == 0.0 or np.linalg.norm(np.cross(across, axes[0])) < 1e-3 * length:
                raise InputError(
                    f"lateral of a slide must be across {along.name}, got {format_value(lateral)}"
                )
            across = across / length
        record = SlideSpec(node.reference, BodyRef(along.name), lateral=as_data(lateral))
        return self._add_partial(mechanisms.Slide(node, along, elements, across), record)

    def gear(
        self,
        one: Joint,
        other: Joint,
        ratio: float,
        *,
        of_one: str | None = None,
        of_other: str | None = None,
    ) -> mechanisms.Gear:
        """Couple two joints: the coordinate of the first is `ratio` times that of the second.

        A rack and pinion are a prismatic joint and a hinge, a screw is a cylindrical joint coupled
        with itself.  The energy is conserved.

        Parameters
        ----------
        one, other : Joint
            As in `drive_joint`; or two coordinates of one joint.
        ratio : float
            Change of the first coordinate over the change of the second [1, rad/m or m/rad];
            negative for external gears, which rotate in opposite directions.
        of_one, of_other : str, optional
            ``"angle"`` or ``"displacement"``, where a joint has both.

        Raises
        ------
        InputError
            If a joint has no such coordinate, or the ratio is zero or not finite.
        """
        references = self._joint("a gear", one), self._joint("a gear", other)
        of = select_coordinate("a gear", one, of_one), select_coordinate("a gear", other, of_other)
        if one is other and of[0] == of[1]:
            raise InputError(
                f"a gear needs two coordinates, got the {of[0]} of the {one.label} twice"
            )
        by = check_finite("ratio of a gear", ratio)
        if by == 0.0:
            raise InputError("ratio of a gear must not be zero: the first joint would be locked")
        check_moderate("ratio of a gear, without its sign,", abs(by), "1, rad/m or m/rad")
        record = GearSpec(*references, by, of_one=of_one, of_other=of_other)
        return self._add_partial(mechanisms.Gear(one, other, of, by), record)

    def winch(
        self,
        points: Sequence[Point | ArrayLike],
        *,
        length: Signal | Callable[[float], float] | None = None,
        rate: Callable[[float], float] | None = None,
        second_rate: Callable[[float], float] | None = None,
        drum: Joint | None = None,
        radius: float | None = None,
    ) -> mechanisms.Winch:
        """Add an inextensible massless rope over points, of constant or prescribed length.

        `Trajectory.tension` is its uniform tension, which may be negative, unlike that of `rope`.

        Parameters
        ----------
        points : sequence of Point or array_like of shape (dim,)
            Two or more, such as ``[(0, 3), hook.origin]``; one is a point of a beam or a body.
        length : Signal or callable, optional
            The length of the rope as a function of t [m], given as positions in `drive`.  By
            default it is constant.
        rate, second_rate : callable, optional
            Its derivatives, as in `drive`.
        drum : Joint, optional
            A hinge whose angle winds the rope up, instead of a prescribed length; a negative angle
            pays it out.
        radius : float, optional
            Radius of the drum [m].

        Raises
        ------
        InputError
            If a point is invalid, two consecutive ones coincide, or an argument is missing.
        """
        ends, places, initial = self._points_of_rope("a winch", points)
        if (drum is None) != (radius is None):
            raise InputError("a winch needs drum and radius together, a hinge and its radius [m]")
        if drum is not None and length is not None:
            raise InputError("a winch has a drum or a prescribed length, not both: drive the drum")
        motion = self._length_over_time("the length of the winch", length, rate, second_rate)
        wound, by = None, 0.0
        if drum is not None:
            wound = self._joint("a winch", drum)
            radius = by = check_moderate("radius of a drum", radius, "m")
            select_coordinate("a winch", drum, "angle")
        record = WinchSpec(places, length, rate, second_rate, wound, radius)
        return self._add_partial(mechanisms.Winch(ends, initial, motion, drum, by), record)


SlideSpec = record_type("SlideSpec", Couplings.slide)
GearSpec = record_type("GearSpec", Couplings.gear)
