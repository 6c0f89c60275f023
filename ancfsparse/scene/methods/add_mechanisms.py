"""The methods of a scene that add joints between bodies, beams and the ground."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice, check_vector
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene import mechanisms
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.geometry.positions import COINCIDENCE_RATIO, place
from ancfsparse.scene.geometry.section_frames import normals
from ancfsparse.scene.joints.connect import ConnectSpec
from ancfsparse.scene.joints.joint import check_end, check_other_body, check_turns
from ancfsparse.scene.joints.pin import PinSpec
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.record import RECORD_TYPES, At, PointRef, Record, record_type, text

if TYPE_CHECKING:
    from ancfsparse.scene.records.plane import Plane

Kind = TypeVar("Kind", bound="mechanisms.TwoBodyJoint")

MAX_ANGLE_ERROR = 1e-9  # [rad], of a right angle
MAX_LENGTH_ERROR = 8.0 * np.finfo(float).eps  # of a unit vector


class BetweenSpec(Record):
    """A record of a joint between two points."""

    a: PointRef
    b: PointRef | None

    def describe(self, at: At, made: Any) -> str:
        """Describe the data of its constraints."""
        other = "ground" if self.b is None else at(self.b)
        more = "".join(
            f", {name} {text(value, at)}" for name, value in self.given.items() if name not in "ab"
        )
        return f"{self.method} ({at(self.a)}; {other}){more}"


class HingeSpec(BetweenSpec):
    """A record of a hinge."""

    axis: Any

    def project(self, handle: Any, plane: Plane) -> Record:
        """Return the record of a shared or a fixed position, if the axis is normal to the plane."""
        plane.across(self.axis)
        return PinSpec(self.a) if self.b is None else ConnectSpec(self.a, self.b)


class Mechanisms(SceneBase):
    """Joints of a scene that constrain directions, or a point to a line."""

    def revolute(
        self, a: Point, b: Point | None = None, *, axis: ArrayLike | None = None
    ) -> mechanisms.Revolute:
        """Join two points by a hinge: they coincide and rotate about a common axis.

        In a planar scene that is `connect`, or `pin` to the ground.

        Parameters
        ----------
        a : Point
            A point, for example ``crank.end``.
        b : Point, optional
            The other point, at the same position; by default the ground.
        axis : array_like, shape (3,)
            Direction of the axis in the reference shape.

        Returns
        -------
        Revolute
            The joint.  If the points are origins, and the axis is a vector of both bodies or of the
            body at the ground, it adds no equations.
        """
        self._check_spatial("revolute", "connect, or pin to the ground")
        ends = self._ends("a revolute joint", a, b)
        along = self._axis("a revolute joint", axis)
        return self._between(mechanisms.Revolute, ends, (along,), ((along,), normals(along)))

    def universal(
        self,
        a: Point,
        b: Point | None = None,
        *,
        axis_a: ArrayLike | None = None,
        axis_b: ArrayLike | None = None,
    ) -> mechanisms.Universal:
        """Join two points; an axis of the first stays normal to an axis of the second.

        Parameters
        ----------
        a, b
            As in `revolute`.
        axis_a, axis_b : array_like, shape (3,)
            Orthogonal directions in the reference shape, fixed in `a` and in `b`.
        """
        self._check_spatial("universal", "connect")
        ends = self._ends("a universal joint", a, b)
        one = self._axis("a universal joint", axis_a, "axis_a")
        other = self._axis("a universal joint", axis_b, "axis_b")
        if abs(one @ other) > MAX_ANGLE_ERROR:
            angle = float(np.degrees(np.arccos(np.clip(one @ other, -1.0, 1.0))))
            raise InputError(
                f"the axes of a universal joint must be at a right angle, got {angle:.6g} degrees"
            )
        return self._between(mechanisms.Universal, ends, (one, other), ((one,), (other,)))

    def cylindrical(
        self, a: Point, b: Point | None = None, *, axis: ArrayLike | None = None
    ) -> mechanisms.Cylindrical:
        """Let a point slide along an axis of both bodies and rotate about it.

        Parameters
        ----------
        a, b
            As in `revolute`; `a` is on the line through `b` along the axis.
        axis : array_like, shape (3,)
            Direction of the axis in the reference shape.

        Returns
        -------
        Cylindrical
            The joint.  If the axis is a coordinate axis and the origin of a body slides relative to
            the ground, its other coordinates are fixed without equations.
        """
        self._check_spatial("cylindrical", "prismatic")
        ends = self._ends("a cylindrical joint", a, b, apart=True)
        along = self._axis("a cylindrical joint", axis)
        self._check_line("a cylindrical joint", *ends, along)
        return self._between(mechanisms.Cylindrical, ends, (along,), ((along,), normals(along)))

    def prismatic(
        self, a: Point, b: Point | None = None, *, axis: ArrayLike
    ) -> mechanisms.Prismatic:
        """Let a point slide along an axis without rotation.

        Parameters
        ----------
        a, b
            As in `revolute`; `a` is on the line through `b` along the axis.
        axis : array_like, shape (dim,)
            Direction of the axis in the reference shape, which rotates with `b`.

        Returns
        -------
        Prismatic
            The joint.  If the axis is a coordinate axis and the origin of a body slides relative to
            the ground, its other coordinates are fixed without equations.
        """
        ends = self._ends("a prismatic joint", a, b, apart=True)
        along = self._axis("a prismatic joint", axis)
        self._check_line("a prismatic joint", *ends, along)
        needed = (along, *normals(along))
        return self._between(mechanisms.Prismatic, ends, (along,), (needed, needed))

    def weld(self, a: Point, b: Point | None = None, *, stretch: str = "free") -> mechanisms.Weld:
        """Join two points without relative rotation.

        At a beam it constrains the section, as a clamp does; at a cable in space the direction of
        the axis.  If thick beams meet at an angle, or a thick beam and a cable, the section there
        keeps its shape.

        Parameters
        ----------
        a, b
            As in `revolute`.
        stretch : str, optional
            ``"free"`` leaves beams free to stretch there; ``"fixed"`` also constrains their slope
            r_x: to its reference length at a body or the ground, to the stretch of another beam.
            Two cables in space with a common tangent can be welded by ``"fixed"`` only.
        """
        ends = self._ends("a weld", a, b)
        beams = [check_turns("a weld", node) for node in ends if node and node.beam.n_elements]
        cables = [node for node in beams if not node.spans(node.beam.axes_of(0)[-1])]
        check_choice("stretch of a weld", stretch, ("free", "fixed"))
        # Two cables with one tangent can share a slope.
        if (
            self.dim == 3
            and len(cables) == 2
            and not (stretch == "fixed" and cables[0].spans(cables[1].frame[0]))
        ):
            raise InputError(
                f"{a!r} and {b!r} cannot be welded: the coordinates of cables in space do not "
                "include rotation about their axes; take element='thick', weld both to a rigid "
                "body, or in line stretch='fixed'"
            )
        joint = mechanisms.Weld(*ends, stretch=stretch)
        return self._add(
            joint, WeldSpec(a.reference, None if b is None else b.reference, stretch=stretch)
        )

    def _check_spatial(self, name: str, instead: str) -> None:
        if self.dim == 2:
            raise InputError(f"a {name} joint needs a spatial scene; in a planar one use {instead}")

    def _ends(
        self, what: str, a: Point, b: Point | None, apart: bool = False
    ) -> tuple[Point, Point | None]:
        """Return the checked ends of a joint, which coincide unless `apart`."""
        one = self._mine(what, check_end(what, a))
        if b is None:
            return one, None
        other = self._mine(what, check_end(what, b))
        if one == other:
            raise InputError(f"{what} needs two points, got {a!r} twice")
        check_other_body(what, one, other)
        gap = float(np.linalg.norm(one.position - other.position))
        if not apart and gap > COINCIDENCE_RATIO * max(one.beam.size, other.beam.size):
            raise InputError(
                f"{what} cannot join {a!r} and {b!r}: they are {gap:.6g} m apart, at "
                f"{place(one.position)} and {place(other.position)}"
            )
        return one, other

    def _axis(self, what: str, axis: ArrayLike | None, name: str = "axis") -> Vector:
        if axis is None:  # checked here, so that planar scenes are refused first
            raise InputError(f"{what} needs {name}, its direction in the reference shape")
        given = check_vector(f"the axis of {what}", axis, self.dim)
        length = math.hypot(*given)  # does not overflow on the way
        if not 0.0 < length < math.inf:
            raise InputError(f"the axis of {what} has no direction, got {format_value(axis)}")
        # A unit vector stays as it is, so that copies and files of a scene equal it.
        return given if abs(length - 1.0) <= MAX_LENGTH_ERROR else np.asarray(given / length)

    @staticmethod
    def _check_line(what: str, a: Point, b: Point | None, axis: Vector) -> None:
        if b is None:
            return
        difference = a.position - b.position
        off = float(np.linalg.norm(difference - (difference @ axis) * axis))
        if off > COINCIDENCE_RATIO * max(a.beam.size, b.beam.size):
            raise InputError(
                f"{what} needs {a!r} on the line through {b!r} along its axis, but it is "
                f"{off:.6g} m off"
            )

    def _between(
        self,
        kind: type[Kind],
        ends: tuple[Point, Point | None],
        axes: tuple[Vector, ...],
        needed: tuple[Iterable[Vector], Iterable[Vector]],
    ) -> Kind:
        """Add a joint whose ends have the directions that each of them needs."""
        a, b = ends
        for node, directions in zip(ends, needed, strict=True):
            if node is not None and not all(node.spans(vector) for vector in directions):
                raise InputError(
                    f"the {kind.name} joint needs directions of {node!r} that it does not have: a "
                    "thin rod or a cable has only that of its axis; exchange the two ends, or "
                    "give the body an inertia"
                )
        joint = kind(a, b, axes)
        names = ("axis",) if len(axes) == 1 else ("axis_a", "axis_b")
        given: dict[str, Any] = dict(zip(names, axes, strict=True))
        other = None if b is None else b.reference
        record = RECORD_TYPES[kind.name](a.reference, other, **given)  # type: ignore[call-arg]
        if joint.is_point:
            return self._add(joint, record)
        return self._add_partial(joint, record)


RevoluteSpec = record_type(
    "RevoluteSpec", Mechanisms.revolute, HingeSpec, planar={"axis": "across"}
)
UniversalSpec = record_type("UniversalSpec", Mechanisms.universal, BetweenSpec)
CylindricalSpec = record_type("CylindricalSpec", Mechanisms.cylindrical, BetweenSpec)
PrismaticSpec = record_type("PrismaticSpec", Mechanisms.prismatic, BetweenSpec)
WeldSpec = record_type("WeldSpec", Mechanisms.weld, BetweenSpec)
