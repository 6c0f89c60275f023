"""The base class of a scene: its records, and the handles built from them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.array_types import Vector
from ancfsparse.checks import MAX_MAGNITUDE, check_vector
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value, suggest_names
from ancfsparse.scene import records
from ancfsparse.scene.bodies.body import Body, Point
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.geometry.positions import COINCIDENCE_RATIO, check_position
from ancfsparse.scene.joints.constrained_points import ConstrainedPoints
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.loads.attachment import Attachment
from ancfsparse.scene.loads.loads import Load
from ancfsparse.scene.records.record import JointRef, PointRef, Record

if TYPE_CHECKING:
    from ancfsparse.scene.records.prescribed_motion import PrescribedMotion
    from ancfsparse.scene.records.signal import Signal

AnyBody = TypeVar("AnyBody", bound=Body)
AnyJoint = TypeVar("AnyJoint", bound=Joint)
AnyHandle = TypeVar("AnyHandle")


class SceneBase:
    """The records of a scene in one gravity field, and the handles built from them.

    Parameters
    ----------
    gravity : array_like, shape (2,) or (3,)
        Acceleration of gravity [m/s2].  Two components make the scene planar, three spatial.
    """

    def __init__(self, gravity: ArrayLike) -> None:
        try:
            size = np.shape(gravity)
        except ValueError:  # rows that differ
            size = ()
        if size not in ((2,), (3,)):
            raise InputError(
                "gravity must have 2 components (planar scene) or 3 (spatial), got "
                f"{format_value(gravity)}"
            )
        self.dim: int = size[0]
        self._gravity: NDArray[np.float64] = check_vector("gravity", gravity, self.dim, "m/s2")
        largest = float(np.abs(self._gravity).max())
        if largest > MAX_MAGNITUDE:
            raise InputError(
                f"gravity must be at most {MAX_MAGNITUDE:g} m/s2, got {largest:g} m/s2"
            )
        self.bodies: list[Body] = []
        self.joints: list[Joint] = []
        self.loads: list[Load] = []
        self.attachments: list[Attachment] = []
        self._bodies: dict[str, Body] = {}
        self._built: dict[object, Record] = {}
        self._constrained_points = ConstrainedPoints()

    @property
    def gravity(self) -> NDArray[np.float64]:
        """Acceleration of gravity [m/s2], shape (dim,), read-only."""
        return self._gravity

    @property
    def beams(self) -> list[ElasticBody]:
        """Beams and meshes, in the order they were added."""
        return [body for body in self.bodies if isinstance(body, ElasticBody)]

    def body(self, name: str) -> Body:
        """Return the handle of a beam, a mesh or a rigid body.

        Parameters
        ----------
        name : str
            Its name.

        Raises
        ------
        InputError
            If no body has this name.
        """
        if not isinstance(name, str) or name not in self._bodies:
            raise InputError(
                f"the scene has no body {format_value(name)}: {suggest_names(name, self._bodies)}"
            )
        return self._bodies[name]

    @property
    def records(self) -> tuple[Record, ...]:
        """The records, in the order of the calls."""
        return tuple(self._built.values())

    def record_of(self, handle: object) -> Record:
        """Return the record that a handle was built from.

        Parameters
        ----------
        handle : Body, Joint, Load or Attachment
            Return value of a method of this scene.

        Raises
        ------
        InputError
            If it is not a handle of this scene.
        """
        try:
            return self._built[handle]
        except (KeyError, TypeError):  # or an object without a hash
            raise InputError(
                "a record is found by a handle that a method of this scene returned, "
                f"such as a beam, a joint or a load, got {format_value(handle)}"
            ) from None

    def _take(self, body: AnyBody, record: Record) -> AnyBody:
        if isinstance(body, ElasticBody):
            _check_range(body)
        self._bodies[body.name] = body
        return self._keep(self.bodies, body, record)

    def _add(self, joint: AnyJoint, record: Record) -> AnyJoint:
        self._constrained_points.add(joint)
        return self._add_partial(joint, record)

    def _add_partial(self, joint: AnyJoint, record: Record) -> AnyJoint:
        """Add a joint that constrains its points in part, so that others may as well."""
        return self._keep(self.joints, joint, record)

    def _attach(self, attachment: AnyHandle, record: Record) -> AnyHandle:
        return self._keep(self.attachments, attachment, record)

    def _keep(self, handles: list[Any], handle: AnyHandle, record: Record) -> AnyHandle:
        handles.append(handle)
        self._built[handle] = record
        return handle

    def _label(self, name: str | None, kind: str) -> str:
        names = (f"{kind} {i}" for i in itertools.count(len(self.bodies)))
        unused = (candidate for candidate in names if candidate not in self._bodies)
        label = next(unused) if name is None else name
        if not isinstance(label, str) or not label.strip():
            raise InputError(
                f"the name of a {kind} must be a non-empty string, got {format_value(name)}"
            )
        if label in self._bodies:
            raise InputError(f"the scene already has a body named {label!r}: give another name")
        return label

    def _own(self, what: str, body: AnyBody) -> AnyBody:
        if body not in self._built:
            raise InputError(
                f"{what} was given {body.name} of another scene: use a handle that a method of "
                "this scene returned"
            )
        return body

    def _joint(self, what: str, joint: object) -> JointRef:
        """Return the reference of a joint of this scene."""
        if not isinstance(joint, Joint):
            raise InputError(
                f"{what} needs a joint that a method of this scene returned, such as "
                f"scene.revolute(...), got {format_value(joint)}"
            )
        if joint not in self._built:
            raise InputError(
                f"{what} was given the {joint.label} of another scene: use a handle that a method "
                "of this scene returned"
            )
        return JointRef(joint.nodes[0].beam.name, self.joints.index(joint))

    def _mine(self, what: str, node: Point) -> Point:
        self._own(what, node.beam)
        return node

    @staticmethod
    def _length_over_time(
        subject: str,
        length: Signal | Callable[[float], float] | None,
        rate: Callable[[float], float] | None,
        second_rate: Callable[[float], float] | None,
    ) -> PrescribedMotion | None:
        """Return a length that changes as a prescribed motion; None if it is constant."""
        if length is not None:
            motion = records.define_motion(subject, 0, length, rate, second_rate)
            start = float(motion.value.at(0.0)[0])
            if abs(start) > MAX_MAGNITUDE:
                raise InputError(
                    f"{subject} must be at most {MAX_MAGNITUDE:g} m at t = 0, got {start:g} m"
                )
            return motion
        if rate is not None or second_rate is not None:
            raise InputError(
                f"{subject} has a rate and is constant: give it as a function, length=l(t), too"
            )
        return None

    def _points_of_rope(
        self, what: str, points: object
    ) -> tuple[tuple[Point | Vector, ...], tuple[PointRef | tuple[float, ...], ...], float]:
        """Return the points of a rope, as handles and as data, and its length [m].

        Raises
        ------
        InputError
            If a point is invalid, two consecutive ones coincide, or all are fixed in space.
        """
        if not isinstance(points, list | tuple) or len(points) < 2:
            raise InputError(
                f"{what} needs a list of two points or more, got {format_value(points)}"
            )
        ends: list[Point | Vector] = []
        for k, end in enumerate(points):
            if isinstance(end, Point):
                ends.append(self._mine(what, end))
            elif isinstance(end, Body):
                raise InputError(
                    f"point {k} of {what} must be a single point, got {end.name}: give one of its "
                    "points, such as hook.origin or hook.at(...) of a rigid body, rod.end of a beam"
                )
            else:
                ends.append(check_position(f"point {k} of {what}", end, self.dim))
        nodes = [end for end in ends if isinstance(end, Point)]
        if not nodes:
            raise InputError(f"{what} needs a point of a beam or a body among its points")
        positions = np.array([end.position if isinstance(end, Point) else end for end in ends])
        distances = np.linalg.norm(np.diff(positions, axis=0), axis=1)
        k = int(np.argmin(distances))
        if distances[k] <= COINCIDENCE_RATIO * max(node.beam.size for node in nodes):
            raise InputError(
                f"points {k} and {k + 1} of {what} coincide, so its rope has no direction there: "
                "leave one of them out"
            )
        data = (end.reference if isinstance(end, Point) else tuple(end.tolist()) for end in ends)
        return tuple(ends), tuple(data), sum(distances.tolist())


def _check_range(body: ElasticBody) -> None:
    """Refuse stiffnesses and masses beyond the range of floating-point numbers."""
    for name, value in (*body.stiffnesses().items(), *body.viscosities().items()):
        if not (math.isfinite(value) if isinstance(value, float) else np.isfinite(value).all()):
            raise InputError(
                f"{name} of {body.name} is {np.max(value):g}, beyond the range of floating-point "
                "numbers: check the units of its section and its material"
            )
