"""Robots of URDF files as bodies and joints of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice, check_finite, check_flag, check_positive
from ancfsparse.embedding.robot_file import JointData, Limits, RobotData, read_robot
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene import Joint, Point, Scene, check_scene
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.geometry.positions import check_position
from ancfsparse.scene.joints.joint_coordinate import COORDINATE_UNITS, FORCE_UNITS
from ancfsparse.scene.kinematics.rigid_motion import orientation_axes


@dataclass(frozen=True, eq=False, repr=False)
class Link:
    """A link of a robot: a frame in a rigid body, or in space if it is fixed.

    Attributes
    ----------
    name : str
        Name in the file.
    body : RigidBody or None
        The body that contains it; links joined by fixed joints share one.  None if it is fixed in
        space.
    offset, pose : ndarray, shape (4, 4)
        Its frame relative to the body, and at the start in space: rotation and position [m].
    """

    name: str
    body: RigidBody | None
    offset: Vector
    pose: Vector

    def __repr__(self) -> str:
        """Return the name and the body."""
        return f"link {self.name!r}: {'fixed in space' if self.body is None else self.body.name}"

    def point(self, coordinates: ArrayLike = (0.0, 0.0, 0.0)) -> Point:
        """Return a point for joints, loads and results.

        Parameters
        ----------
        coordinates : array_like, shape (3,), optional
            Its coordinates in the frame of the link [m].

        Raises
        ------
        InputError
            If the link is fixed in space.
        """
        local = check_position(f"the point of link {self.name!r}", coordinates, 3)
        if self.body is None:
            raise InputError(
                f"link {self.name!r} is fixed in space and has no points for joints: pin to the "
                "ground at its start_position"
            )
        return self.body.at(_transform(self.offset, local))

    def start_position(self, coordinates: ArrayLike = (0.0, 0.0, 0.0)) -> Vector:
        """Return the position of a point in space at the start, (3,) [m].

        Parameters
        ----------
        coordinates : array_like, shape (3,), optional
            Its coordinates in the frame of the link [m].
        """
        local = check_position(f"the point of link {self.name!r}", coordinates, 3)
        return _transform(self.pose, local)


@dataclass(frozen=True, eq=False, repr=False)
class Robot:
    """A robot in a scene, as `add` returns it.

    Attributes
    ----------
    name : str
        Name in the file.
    links : dict of str to Link
        Links by name.
    joints : dict of str to Joint
        Joints of the scene by name, for drives, springs and results: all but fixed and floating
        ones.  Their coordinates are counted from the start.
    limits : dict of str to Limits
        Limits of these joints [rad or m, N m or N, rad/s or m/s].  The scene has stops for the
        range only, where they were requested.
    start : dict of str to float
        Coordinates of these joints at the start, as the file counts them [rad or m].
    unused : dict of str to tuple of str
        Elements of the file that are not in the scene, by their tags: names of their links or
        joints, such as ``{"visual": ("base", "upper")}``.
    """

    name: str
    links: dict[str, Link]
    joints: dict[str, Joint]
    limits: dict[str, Limits]
    start: dict[str, float]
    unused: dict[str, tuple[str, ...]]

    def __repr__(self) -> str:
        """Return the name and the numbers of links and joints."""
        unused = f", without {', '.join(self.unused)}" if self.unused else ""
        return f"robot {self.name!r}: links {len(self.links)}, joints {len(self.joints)}{unused}"


def add(
    scene: Scene,
    path: str | Path,
    *,
    position: ArrayLike = (0.0, 0.0, 0.0),
    orientation: ArrayLike | None = None,
    fixed: bool = True,
    start: Mapping[str, float] | None = None,
    stops: float | Mapping[str, float] | None = None,
    slip: float | Mapping[str, float] | None = None,
    prefix: str = "",
) -> Robot:
    """Add the links and joints of a URDF file to a spatial scene.

    Links become rigid bodies; those connected by fixed joints become one.  Revolute, continuous and
    prismatic joints become joints of the scene with their damping, mimic joints are coupled as
    gears, and floating ones leave their link free.  Shapes for pictures and contact, transmissions
    and controllers are not added; `Robot.unused` lists them.

    Parameters
    ----------
    scene : Scene
        The scene.
    path : str or Path
        The file.
    position : array_like, shape (3,), optional
        Position of the frame of the first link, which has no parent [m].
    orientation : array_like of shape (4,) or (3, 3), optional
        Its orientation, as in `Scene.add_body`.
    fixed : bool, optional
        Whether the first link is fixed in space; otherwise it is free.
    start : dict of str to float, optional
        Coordinates of joints at the start by name [rad or m], by default zero.
    stops : float or dict of str to float, optional
        Stiffness of soft stops at the limits of joints, of all or by name [N m/rad or N/m];
        required if joints have limits.  ``{}`` keeps limits in `Robot.limits` only.
    slip : float or dict of str to float, optional
        Rate at which friction has 0.71 of its size, of all joints or by name [rad/s or m/s], as in
        `Scene.joint_friction`; required if joints have friction.  ``{}`` omits friction.
    prefix : str, optional
        Beginning of the names of bodies, to distinguish robots.

    Returns
    -------
    Robot
        Links and joints by name.

    Raises
    ------
    InputError
        If the file is invalid, has a planar joint or a link that moves without mass, or an argument
        is invalid; or if yourdfpy is not installed.
    """
    check_scene(scene)
    if scene.dim == 2:
        raise InputError(
            "a robot needs a spatial scene: give gravity three components, as in (0, 0, -9.81)"
        )
    if not isinstance(prefix, str):
        raise InputError(f"prefix must be a text, got {format_value(prefix)}")
    data = read_robot(path)
    is_fixed = check_flag("fixed", fixed)
    base = np.eye(4)
    base[:3, :3] = orientation_axes("orientation of the robot", 3, orientation).T
    base[:3, 3] = check_position("position of the robot", position, 3)
    moving = {name: each for name, each in data.joints.items() if each.coordinate is not None}
    values = _start_values(moving, start)
    limited = {name: each for name, each in moving.items() if each.limits.is_range}
    stiffness = _select_joints("stops", "limits", stops, limited, FORCE_UNITS, "/{}")
    for name in stiffness:
        _check_range(limited[name])
    rubbing = {name: each for name, each in moving.items() if each.friction > 0.0}
    rates = _select_joints("slip", "friction", slip, rubbing, COORDINATE_UNITS, "/s")

    frames = _compute_frames(data, values, base)
    bodies: dict[str, RigidBody | None] = {}
    for first in dict.fromkeys(first for first, _, _ in frames.values()):
        if first == data.root and is_fixed:
            bodies[first] = None
            continue
        offsets = {name: offset for name, (its, offset, _) in frames.items() if its == first}
        bodies[first] = _add_body(scene, data, offsets, frames[first][2], prefix + first)
    links = {
        name: Link(name, bodies[first], offset, pose)
        for name, (first, offset, pose) in frames.items()
    }
    joints = {name: _add_joint(scene, each, links) for name, each in moving.items()}
    for name, each in moving.items():
        joint = joints[name]
        if each.leader is not None:
            scene.gear(joint, joints[each.leader], each.ratio)
        if each.damping > 0.0:
            scene.joint_spring(joint, damping=each.damping)
        if name in rates:
            scene.joint_friction(joint, each.friction, slip=rates[name])
        if name in stiffness:
            low, high = (end - values[name] for end in (each.limits.lower, each.limits.upper))
            scene.joint_stop(joint, low, high, stiffness=stiffness[name])
    limits = {name: each.limits for name, each in moving.items()}
    return Robot(data.name, links, joints, limits, values, data.unused)


def _start_values(
    moving: Mapping[str, JointData], start: Mapping[str, float] | None
) -> dict[str, float]:
    """Return the coordinates of all joints at the start [rad or m]."""
    if start is not None and not isinstance(start, Mapping):
        raise InputError(
            f"start must name joints with their coordinates, as in {{'elbow': 0.5}}, got "
            f"{format_value(start)}"
        )
    specified = {}
    for name, value in (start or {}).items():
        joint = moving[check_choice("joint in start", name, moving)]
        if joint.leader is not None:
            raise InputError(
                f"start of joint {name!r} follows that of {joint.leader!r}: give the latter only"
            )
        specified[name] = check_finite(f"start of joint {name!r}", value)

    def value_of(joint: JointData, followers: tuple[str, ...] = ()) -> float:
        if joint.leader is None:
            return specified.get(joint.name, 0.0)
        if joint.name in followers or joint.leader not in moving:
            raise InputError(
                f"joint {joint.name!r} cannot follow {joint.leader!r}, "
                + ("which follows it" if joint.leader in moving else "which has no coordinate")
            )
        leader = value_of(moving[joint.leader], (*followers, joint.name))
        return joint.ratio * leader + joint.shift

    values = {name: value_of(each) for name, each in moving.items()}
    for name, value in values.items():
        limits = moving[name].limits
        if not limits.lower <= value <= limits.upper:
            raise InputError(
                f"joint {name!r} starts at {value:.6g}, outside its limits {limits.lower:.6g} to "
                f"{limits.upper:.6g}: give another start"
            )
    return values


def _check_range(joint: JointData) -> None:
    """Refuse a stop whose range is empty, or of angles a turn or more."""
    low, high = joint.limits.lower, joint.limits.upper
    is_turn = joint.coordinate == "angle" and high - low >= 2.0 * np.pi
    if is_turn or low == high:
        raise InputError(
            f"joint {joint.name!r} cannot have stops from {low:.6g} to {high:.6g}, whose range "
            + ("is a turn or more" if is_turn else "is empty")
            + ": give stops by name, without this joint"
        )


def _select_joints(
    what: str,
    cause: str,
    values: float | Mapping[str, float] | None,
    joints: Mapping[str, JointData],
    numerators: Mapping[str, str],
    denominator: str,
) -> dict[str, float]:
    """Return numbers of joints by name, from one for all or from a table."""

    def unit(name: str) -> str:
        of = str(joints[name].coordinate)
        return numerators[of] + denominator.format(COORDINATE_UNITS[of])

    if values is None:
        if joints:
            name = next(iter(joints))
            raise InputError(
                f"joint {name!r} has {cause}: give {what} [{unit(name)}], for all joints or by "
                f"name, or {what}={{}} to leave {cause} out of the scene"
            )
        return {}
    table = values if isinstance(values, Mapping) else dict.fromkeys(joints, values)
    return {
        check_choice(f"joint in {what}", name, joints): check_positive(
            f"{what} of joint {name!r}", value, unit(name) if name in joints else ""
        )
        for name, value in table.items()
    }


def _compute_frames(
    data: RobotData, values: Mapping[str, float], base: Vector
) -> dict[str, tuple[str, Vector, Vector]]:
    """Return for each link the first link of its body, its frame in that, and that in space."""
    frames = {data.root: (data.root, np.eye(4), base)}
    for name, joint in data.joints.items():
        first, offset, pose = frames[joint.parent]
        if joint.kind == "fixed":
            frames[joint.child] = first, offset @ joint.origin, pose @ joint.origin
            continue
        moved = np.eye(4)
        if joint.coordinate == "angle":
            moved[:3, :3] = Rotation.from_rotvec(values[name] * joint.axis).as_matrix()
        elif joint.coordinate == "displacement":
            moved[:3, 3] = values[name] * joint.axis
        frames[joint.child] = joint.child, np.eye(4), pose @ joint.origin @ moved
    return frames


def _add_body(
    scene: Scene, data: RobotData, offsets: Mapping[str, Vector], pose: Vector, name: str
) -> RigidBody:
    """Add the body of links from their frames relative to the first one."""
    links = [data.links[each] for each in offsets]
    masses = np.array([each.mass for each in links])
    if masses.sum() == 0.0:
        listing = ", ".join(repr(each) for each in offsets)
        raise InputError(
            f"the body of {listing} moves and has no mass: give a link an inertial element, or "
            "join it to another one by a fixed joint"
        )
    centres = np.array([_transform(offsets[each.name], each.centre) for each in links])
    centre = masses @ centres / masses.sum()
    inertia = np.zeros((3, 3))
    for each, arm in zip(links, centres - centre, strict=True):
        turn = offsets[each.name][:3, :3]
        inertia += turn @ each.inertia @ turn.T
        inertia += each.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return scene.add_body(
        position=pose[:3, 3],
        orientation=pose[:3, :3],
        mass=float(masses.sum()),
        centre=centre,
        inertia=inertia,
        name=name,
    )


def _add_joint(scene: Scene, joint: JointData, links: Mapping[str, Link]) -> Joint:
    """Join the origin of the child to the same point of the parent."""
    child, parent = links[joint.child], links[joint.parent]
    assert child.body is not None
    other = None if parent.body is None else parent.point(joint.origin[:3, 3])
    axis = child.pose[:3, :3] @ joint.axis
    if joint.coordinate == "angle":
        return scene.revolute(child.body.origin, other, axis=axis)
    return scene.prismatic(child.body.origin, other, axis=axis)


def _transform(frame: Vector, point: Vector) -> Vector:
    return np.asarray(frame[:3, :3] @ point + frame[:3, 3])
