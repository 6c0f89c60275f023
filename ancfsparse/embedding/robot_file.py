"""Robots in URDF files: links and joints that form a tree, as numbers in SI units."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from io import BytesIO
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice, check_finite, check_not_negative
from ancfsparse.errors import InputError
from ancfsparse.file_names import check_file_name
from ancfsparse.messages import suggest_names

try:
    from yourdfpy import URDF
except ImportError:  # the extra `urdf` is not installed
    URDF = None

# The coordinate that a joint leaves free; a fixed joint and a floating one have none to state.
COORDINATES = {
    "revolute": "angle",
    "continuous": "angle",
    "prismatic": "displacement",
    "fixed": None,
    "floating": None,
}
LIMITED = ("revolute", "prismatic")
# Elements that are read; others are listed in `RobotData.unused`.
READ = {
    "link": ("inertial",),
    "joint": ("parent", "child", "origin", "axis", "limit", "dynamics", "mimic"),
}
OF_COORDINATES = ("dynamics", "mimic")  # read if the joint has a coordinate


@dataclass(frozen=True)
class Limits:
    """Limits of a joint in a URDF file.

    Attributes
    ----------
    lower, upper : float
        Range of the joint [rad or m]; infinite for a joint without a range.
    effort : float or None
        Largest moment or force of its drive [N m or N].
    velocity : float or None
        Largest rate of its drive [rad/s or m/s].
    """

    lower: float
    upper: float
    effort: float | None
    velocity: float | None

    @property
    def is_range(self) -> bool:
        """True if the joint has a range."""
        return self.upper < np.inf


@dataclass(frozen=True, eq=False)
class LinkData:
    """A link of the file.

    Attributes
    ----------
    name : str
        Name.
    mass : float
        Mass [kg].
    centre : ndarray, shape (3,)
        Centre of mass in the frame of the link [m].
    inertia : ndarray, shape (3, 3)
        Inertia about the centre of mass along the axes of the link [kg m2].
    """

    name: str
    mass: float
    centre: Vector
    inertia: Vector


@dataclass(frozen=True, eq=False)
class JointData:
    """A joint of the file.

    Attributes
    ----------
    name, kind, parent, child : str
        Name, type, and names of the links.
    origin : ndarray, shape (4, 4)
        Frame of the joint relative to the parent: rotation and position [m].
    axis : ndarray, shape (3,)
        Unit vector of its axis in its frame; zero if it is fixed or floating.
    limits : Limits
        Limits.
    damping : float
        Damping [N m s/rad or N s/m].
    friction : float
        Friction [N m or N].
    leader : str or None
        Name of the joint that it follows (mimic).
    ratio, shift : float
        Its coordinate is `shift` plus `ratio` times the coordinate of the leader.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: Vector
    axis: Vector
    limits: Limits
    damping: float = 0.0
    friction: float = 0.0
    leader: str | None = None
    ratio: float = 1.0
    shift: float = 0.0

    @property
    def coordinate(self) -> str | None:
        """``"angle"``, ``"displacement"`` or None."""
        return COORDINATES[self.kind]


@dataclass(frozen=True, eq=False)
class RobotData:
    """A robot of a file.

    Attributes
    ----------
    name : str
        Name.
    links : dict of str to LinkData
        Links by name.
    joints : dict of str to JointData
        Joints by name, from the root outwards.
    root : str
        Name of the link without a parent.
    unused : dict of str to tuple of str
        Elements that are not read, by their tags: names of their links and joints, or their own.
    """

    name: str
    links: dict[str, LinkData]
    joints: dict[str, JointData]
    root: str
    unused: dict[str, tuple[str, ...]]


def read_robot(path: object) -> RobotData:
    """Read a URDF file.

    Raises
    ------
    InputError
        If it is not a URDF file, its links and joints do not form a tree, a number is invalid, or
        yourdfpy is not installed.
    """
    if URDF is None:
        raise InputError(
            "a URDF file needs yourdfpy, which is not installed: pip install 'ancfsparse[urdf]', "
            "or add its links by Scene.add_body and its joints by Scene.revolute and others"
        )
    file = check_file_name("a robot", path, "arm.urdf")
    if not file.is_file():
        raise InputError(f"{file} is not a file")
    text = b""
    try:
        text = file.read_bytes()
        root = ET.fromstring(text)
        parsed = URDF.load(BytesIO(text), build_scene_graph=False, load_meshes=False).robot
    except Exception as error:  # yourdfpy has no error of its own for texts in place of numbers
        hint = ": expand it first, by the command xacro" if b"${" in text else ""
        raise InputError(
            f"{file} cannot be read as a URDF file ({type(error).__name__}: {error}){hint}"
        ) from error
    if root.tag != "robot" or not parsed.links:
        raise InputError(f"{file} has no robot with links")
    for kind in READ:
        names = [each.get("name") for each in root.findall(kind)]
        if repeated := [name for name in names if names.count(name) > 1]:
            raise InputError(f"{file} has two {kind}s named {repeated[0]!r}: give one another name")
    for link in root.findall("link"):
        for each in link.findall("inertial/inertia"):
            if lacking := [name for name in ("ixx", "iyy", "izz") if name not in each.attrib]:
                raise InputError(f"the inertia of link {link.get('name')!r} lacks {lacking[0]}")
    links = {each.name: _link(each) for each in parsed.links}
    joints = {each.name: _joint(each) for each in parsed.joints}
    base, ordered = _order(str(file), links, joints)
    return RobotData(parsed.name, links, ordered, base, _find_unused(root))


def _order(
    file: str, links: dict[str, LinkData], joints: dict[str, JointData]
) -> tuple[str, dict[str, JointData]]:
    """Return the root of the tree, and the joints from there outwards."""
    parent_joints: dict[str, JointData] = {}
    for joint in joints.values():
        for name in (joint.parent, joint.child):
            if name not in links:
                raise InputError(
                    f"joint {joint.name!r} has the link {name!r}, which {file} lacks: "
                    + suggest_names(name, links)
                )
        if joint.child in parent_joints:
            raise InputError(
                f"link {joint.child!r} is the child of two joints, "
                f"{parent_joints[joint.child].name!r} and {joint.name!r}: links must form a tree; "
                "close a loop by a joint of the scene"
            )
        parent_joints[joint.child] = joint
        if joint.leader is not None:
            check_choice(f"joint that joint {joint.name!r} follows", joint.leader, joints)
    roots = [name for name in links if name not in parent_joints]
    if len(roots) != 1:
        listing = ", ".join(map(repr, roots)) or "none"
        raise InputError(f"{file} must have one link without a parent, got {listing}")
    reached, ordered = [roots[0]], {}
    for link in reached:
        outer = {each.name: each for each in joints.values() if each.parent == link}
        ordered.update(outer)
        reached.extend(each.child for each in outer.values())
    if len(reached) < len(links):
        loop = next(name for name in links if name not in reached)
        raise InputError(
            f"link {loop!r} is not connected with the root {roots[0]!r}: its joints form a loop"
        )
    return roots[0], ordered


def _link(link: Any) -> LinkData:
    """Return a link with the inertia along its own axes."""
    inertial = link.inertial
    if inertial is None or inertial.mass is None:
        return LinkData(link.name, 0.0, np.zeros(3), np.zeros((3, 3)))
    mass = check_not_negative(f"the mass of link {link.name!r}", inertial.mass, "kg")
    frame = _frame(f"inertia of link {link.name!r}", inertial.origin)
    inertia = np.zeros((3, 3)) if inertial.inertia is None else inertial.inertia
    if not np.isfinite(inertia).all():
        raise InputError(f"the inertia of link {link.name!r} must be finite")
    turn = frame[:3, :3]
    return LinkData(link.name, mass, frame[:3, 3], turn @ inertia @ turn.T)


def _joint(joint: Any) -> JointData:
    """Return a joint with its numbers checked."""
    what = f"joint {joint.name!r}"
    if joint.type == "planar":
        raise InputError(
            f"{what} is planar, and scenes have no joint that slides in a plane: take two "
            "prismatic joints and a revolute one, with links that have masses between them"
        )
    kind = check_choice(f"type of {what}", joint.type, COORDINATES)
    frame = _frame(what, joint.origin)
    limits = _limits(what, kind, joint.limit)
    if COORDINATES[kind] is None:
        return JointData(joint.name, kind, joint.parent, joint.child, frame, np.zeros(3), limits)
    axis = np.asarray(joint.axis, float)
    length = float(np.linalg.norm(axis)) if axis.shape == (3,) else 0.0
    if not 0.0 < length < np.inf:
        raise InputError(f"the axis of {what} must be three numbers, not all zero, got {axis}")
    more: dict[str, Any] = {}
    if joint.dynamics is not None:
        for name in ("damping", "friction"):
            value = getattr(joint.dynamics, name)  # a text
            number = _number(f"the {name} of {what}", 0.0 if value is None else value)
            more[name] = check_not_negative(f"the {name} of {what}", number)
    if joint.mimic is not None:
        more["leader"] = joint.mimic.joint
        more["ratio"] = check_finite(f"the multiplier of {what}", joint.mimic.multiplier)
        more["shift"] = check_finite(f"the offset of {what}", joint.mimic.offset)
    return JointData(
        joint.name,
        kind,
        joint.parent,
        joint.child,
        frame,
        axis / length,
        limits,
        **more,
    )


def _limits(what: str, kind: str, limit: Any) -> Limits:
    if limit is None:
        if kind in LIMITED:
            raise InputError(
                f"{what} is {kind} and has no limit: add one"
                + (", or make it continuous" if kind == "revolute" else "")
            )
        return Limits(-np.inf, np.inf, None, None)
    values = {
        name: None if value is None else check_finite(f"the {name} limit of {what}", value)
        for name, value in vars(limit).items()
    }
    effort, velocity = values["effort"], values["velocity"]
    if kind not in LIMITED:
        return Limits(-np.inf, np.inf, effort, velocity)
    lower, upper = (
        values[name] or 0.0 for name in ("lower", "upper")
    )  # the defaults of the format
    if lower > upper:
        raise InputError(
            f"the lower limit of {what} must not exceed the upper one, got {lower:.6g} and "
            f"{upper:.6g}"
        )
    return Limits(lower, upper, effort, velocity)


def _frame(what: str, origin: Vector | None) -> Vector:
    frame = np.eye(4) if origin is None else np.asarray(origin, float)
    if not np.isfinite(frame).all():
        raise InputError(f"the origin of the {what} must be finite")
    return frame


def _number(what: str, text: object) -> float:
    try:
        return float(text)  # type: ignore[arg-type]
    except ValueError:
        raise InputError(f"{what} must be a number, got {text!r}") from None


def _find_unused(root: ET.Element) -> dict[str, tuple[str, ...]]:
    """Return the elements that are not read, by their tags."""
    unused: dict[str, tuple[str, ...]] = {}

    def add(elements: Iterable[ET.Element], owner: str | None = None) -> None:
        for each in elements:
            name = owner or each.get("name") or each.get("reference") or ""
            unused[each.tag] = (*unused.get(each.tag, ()), name)

    add(each for each in root if each.tag not in READ)
    for kind, tags in READ.items():
        for each in root.findall(kind):
            has_none = kind == "joint" and COORDINATES.get(each.get("type", "")) is None
            omitted = OF_COORDINATES if has_none else ()
            parts = (part for part in each if part.tag not in tags or part.tag in omitted)
            add(parts, each.get("name"))
    return unused
