"""The records of a scene, and the handles that were built from them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.checks import check_vector
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value, suggest_names
from ancfsparse.scene import records
from ancfsparse.scene.bodies.body import Body, Point
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.geometry.positions import COINCIDENCE_RATIO, Vector, check_position
from ancfsparse.scene.joints.constrained_points import ConstrainedPoints
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.loads.attachment import Attachment
from ancfsparse.scene.loads.loads import Load
from ancfsparse.scene.records.record import JointRef, Record

if TYPE_CHECKING:
    from ancfsparse.scene.records.prescribed_motion import PrescribedMotion
    from ancfsparse.scene.records.signal import Signal

AnyBody = TypeVar("AnyBody", bound=Body)
AnyJoint = TypeVar("AnyJoint", bound=Joint)
AnyLoad = TypeVar("AnyLoad", bound=Load)
Thing = TypeVar("Thing", bound=Attachment)


class SceneBase:
    """What was specified, in one gravity field, and the handles built from it.

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
        self.bodies: list[Body] = []
        self.joints: list[Joint] = []
        self.loads: list[Load] = []
        self.attachments: list[Attachment] = []
        self._bodies: dict[str, Body] = {}
        self._built: dict[object, Record] = {}
        self._holds = ConstrainedPoints()

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
        """What was specified, in the order of the calls."""
        return tuple(self._built.values())

    def record_of(self, handle: object) -> Record:
        """Return the record that a handle was built from.

        Parameters
        ----------
        handle : Body, Joint, Load or Attachment
            What a method of this scene has returned.

        Raises
        ------
        InputError
            If it is of another scene, or no handle.
        """
        try:
            return self._built[handle]
        except (KeyError, TypeError):  # or what has no hash
            raise InputError(
                "what a scene recorded is found by a handle that a method of this scene returned, "
                f"such as a beam, a joint or a load, got {format_value(handle)}"
            ) from None

    def _take(self, body: AnyBody, record: Record) -> AnyBody:
        if isinstance(body, ElasticBody):
            _check_range(body)
        self.bodies.append(body)
        self._bodies[body.name] = body
        self._record(record, body)
        return body

    def _add(self, joint: AnyJoint, record: Record) -> AnyJoint:
        self._holds.add(joint)
        return self._add_partial(joint, record)

    def _add_partial(self, joint: AnyJoint, record: Record) -> AnyJoint:
        """Add a joint that leaves its points free to move, so others may hold them too."""
        self.joints.append(joint)
        self._record(record, joint)
        return joint

    def _load(self, load: AnyLoad, record: Record) -> AnyLoad:
        self.loads.append(load)
        self._record(record, load)
        return load

    def _attach(self, thing: Thing, record: Record) -> Thing:
        self.attachments.append(thing)
        self._record(record, thing)
        return thing

    def _record(self, record: Record, handle: object) -> None:
        self._built[handle] = record

    def _label(self, name: str | None, kind: str) -> str:
        free = (f"{kind} {i}" for i in itertools.count(len(self.bodies)))
        label = next(each for each in free if each not in self._bodies) if name is None else name
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
        number = next(k for k, each in enumerate(self.joints) if each is joint)
        return JointRef(joint.nodes[0].beam.name, number)

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
            return records.define_motion(subject, 0, length, rate, second_rate)
        if rate is not None or second_rate is not None:
            raise InputError(
                f"{subject} has a rate and is constant: give it as a function, length=l(t), too"
            )
        return None

    def _points_of_rope(
        self, what: str, points: object
    ) -> tuple[tuple[Point | Vector, ...], list[float]]:
        """Return the points that a rope leads over, and the distances of consecutive ones [m].

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
        for k, each in enumerate(points):
            if isinstance(each, Point):
                ends.append(self._mine(what, each))
            elif isinstance(each, Body):
                raise InputError(
                    f"point {k} of {what} must be a single point, got {each.name}: give one of its "
                    "points, such as hook.origin or hook.at(...) of a rigid body, rod.end of a beam"
                )
            else:
                ends.append(check_position(f"point {k} of {what}", each, self.dim))
        nodes = [each for each in ends if isinstance(each, Point)]
        if not nodes:
            raise InputError(f"{what} needs a point of a beam or a body among its points")
        places = np.array([each.position if isinstance(each, Point) else each for each in ends])
        apart = np.linalg.norm(np.diff(places, axis=0), axis=1)
        k = int(np.argmin(apart))
        if apart[k] <= COINCIDENCE_RATIO * max(each.beam.size for each in nodes):
            raise InputError(
                f"points {k} and {k + 1} of {what} coincide, so its rope has no direction there: "
                "leave one of them out"
            )
        return tuple(ends), apart.tolist()


def _check_range(body: ElasticBody) -> None:
    """Refuse stiffnesses and masses that leave the range of floating-point numbers."""
    for name, value in (*body.stiffnesses().items(), *body.viscosities().items()):
        if not (math.isfinite(value) if isinstance(value, float) else np.isfinite(value).all()):
            raise InputError(
                f"{name} of {body.name} is {np.max(value):g}, beyond the range of floating-point "
                "numbers: check the units of its section and its material"
            )
