"""Point masses with rotary inertia, and rotating frames of reference."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import MAX_MAGNITUDE, check_not_negative, check_vector
from ancfsparse.errors import InputError
from ancfsparse.messages import format_numbers, format_value
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.joints.joint import check_node, check_point, check_turns
from ancfsparse.scene.kinematics.rigid_motion import check_inertia, second_moments, spin_matrix
from ancfsparse.scene.loads.attachment import Attachment, Marks
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.record import At, PointRef, Record, as_data

ROUNDING_RATIO = 1e-12  # of moments of inertia, over the largest one


@dataclass(frozen=True, eq=False)
class MassSpec(Record):
    """The record of `Scene.add_mass`."""

    node: PointRef
    mass: float
    inertia: float | Vector | None = None
    method = "add_mass"
    planar: ClassVar = {"inertia": "absent"}
    units: ClassVar = {"mass": "kg", "inertia": "kg m2"}

    def describe(self, at: At, made: Any) -> str:
        """Describe its position and its numbers."""
        return f"mass ({at(self.node)}): {format_numbers([self.mass, *made.inertia.flat])}"


@dataclass(frozen=True, eq=False)
class PointMass(Attachment):
    """A mass at a point of a beam, with an optional rotary inertia.

    Attributes
    ----------
    node, mass
        As in `Scene.add_mass`.
    inertia : ndarray, shape (3, 3) or (1, 1)
        Moments of inertia about the node [kg m2], in the frame e_x, e_y, e_z of the beam there; one
        about z in a planar scene.  Zeros if it has none.
    """

    node: Point
    mass: float
    inertia: Vector
    contribution = "bodies.masses"

    @property
    def what(self) -> str:
        """Name in messages."""
        return f"the mass at {self.node!r}"

    @property
    def marks(self) -> Marks:
        """Its symbol in pictures."""
        return [("mass", self.node, None)]


@dataclass(frozen=True, eq=False)
class RotatingFrameSpec(Record):
    """The record of `Scene.rotating_frame`."""

    angular_velocity: float | tuple[float, ...]
    point: tuple[float, ...] | None = None
    method = "rotating_frame"
    units: ClassVar = {"angular_velocity": "rad/s", "point": "m"}

    def describe(self, at: At, made: Any) -> str:
        """Describe the rotation."""
        return f"rotating frame: {format_numbers([*made.spin.flat, *made.point])}"


@dataclass(frozen=True, eq=False)
class RotatingFrame(Attachment):
    """A uniformly rotating frame of reference.

    Attributes
    ----------
    spin : ndarray, shape (dim, dim)
        Skew matrix W of the angular velocity [rad/s]: a point at rest in the frame has the velocity
        ``W (r - point)`` in space.
    point : ndarray, shape (dim,)
        A point of the axis [m].
    """

    spin: Vector
    point: Vector
    contribution = "bodies.rotating_frame"
    what = "the rotating frame"


class Masses(SceneBase):
    """Masses of a scene."""

    def add_mass(self, node: Point, mass: float, *, inertia: ArrayLike | None = None) -> PointMass:
        """Attach a point mass to a beam; gravity acts on it.

        Parameters
        ----------
        node : Point
            Where, for example ``rod.end`` or ``rod.at(0.3)``.
        mass : float
            The mass [kg], zero or more.
        inertia : float or array_like of shape (3,) or (3, 3), optional
            Rotary inertia about the node [kg m2], for nodes alone.  In a planar scene one number
            about z.  In a spatial one the principal moments about e_x, e_y and e_z of the beam
            there, or the whole matrix in that frame; it needs ``element="thick"``, since a cable
            has no frame.  It turns with the vectors r_x, r_y, r_z of the node, so it grows with
            the squares of their lengths: by twice the strain at the node.

        Raises
        ------
        InputError
            If the mass or a moment is negative or not finite, the moments violate the
            triangle inequality, or the node has no frame.
        """
        point = check_point("a mass", node)
        self._own("a mass", point.beam)
        what = f"the mass at {point!r}"
        value = check_not_negative(what, mass, "kg")
        if inertia is None:
            matrix = np.zeros((1, 1) if self.dim == 2 else (3, 3))
        else:
            self._check_frame(check_node("a rotary inertia", point))
            about = f"the rotary inertia at {point!r}"
            matrix = (
                np.array([[check_not_negative(about, inertia, "kg m2")]])
                if self.dim == 2
                else _tensor(about, inertia)
            )
        if value == 0.0 and not matrix.any():
            raise InputError(f"{what} is zero: give a mass or an inertia")
        matrix.flags.writeable = False
        given = None if inertia is None else matrix.item() if self.dim == 2 else matrix
        record = MassSpec(point.reference, value, given)
        return self._attach(PointMass(point, value, matrix), record)

    def rotating_frame(
        self, angular_velocity: ArrayLike, *, point: ArrayLike | None = None
    ) -> RotatingFrame:
        """Describe the scene in a frame that rotates steadily: centrifugal and Coriolis forces.

        All masses have them.  What rotates steadily in space is at rest in the frame, so
        `solve_static` finds the shape of a rotating blade, rotor or rope, `complex_modes` its
        vibrations, and `simulate` its motion.  Joints to the ground are joints to the frame;
        positions, velocities, drives and gravity are those in the frame, so gravity is that along
        the axis, or else turns with the frame.

        Parameters
        ----------
        angular_velocity : float or array_like of shape (3,)
            Of the frame [rad/s]; in a planar scene one number, counterclockwise.
        point : array_like, shape (dim,), optional
            A point of the axis [m], by default the origin.

        Raises
        ------
        InputError
            If an argument is invalid, or the scene has a rotating frame.

        Notes
        -----
        The theory is in docs/theory.md.
        """
        if any(isinstance(attachment, RotatingFrame) for attachment in self.attachments):
            raise InputError(
                "the scene is described in a rotating frame already: add up both angular velocities"
            )
        what = "angular velocity of the rotating frame"
        spin = spin_matrix(what, angular_velocity, self.dim)
        largest, limit = float(np.abs(spin).max()), math.sqrt(MAX_MAGNITUDE)
        if largest > limit:
            raise InputError(
                f"{what} must be at most {limit:g} rad/s, whose squares are in the range of "
                f"floating-point numbers, got {largest:g} rad/s"
            )
        position = np.zeros(self.dim)
        if point is not None:
            position = check_vector("point of the rotating frame", point, self.dim, "m")
        spin.flags.writeable = False
        record = RotatingFrameSpec(as_data(angular_velocity), as_data(point))
        return self._attach(RotatingFrame(spin, position), record)

    @property
    def turning(self) -> float:
        """Angular speed of the frame that the scene is described in [rad/s]."""
        frames = [item for item in self.attachments if isinstance(item, RotatingFrame)]
        return float(np.linalg.norm(frames[0].spin)) / math.sqrt(2.0) if frames else 0.0

    def _check_frame(self, node: Point) -> None:
        kind = check_turns("a rotary inertia", node).beam.kind
        if self.dim == 3 and kind.is_cable:
            raise InputError(
                f"{node!r} has no frame for a rotary inertia to turn with, because a cable has "
                "no rotation about its axis: take element='thick', or the mass alone"
            )
        if self.dim == 3 and not {"r_y", "r_z"} <= set(kind.vectors):
            raise InputError(
                f"a rotary inertia at {node!r} turns with r_x, r_y and r_z, and element "
                f"{kind.name} has {', '.join(kind.vectors[1:])}: take element='thick', or the mass "
                "alone"
            )


def _tensor(what: str, inertia: ArrayLike) -> Vector:
    matrix = check_inertia(what, inertia, "matrix", ROUNDING_RATIO)
    # The second moments of the mass along each axis are sums of squares.
    least = float(np.linalg.eigvalsh(second_moments(matrix)).min())
    if least < -ROUNDING_RATIO * np.abs(matrix).max():
        raise InputError(
            f"{what} is not physical: each principal moment is at most the sum of the other two "
            f"and not negative, got {format_value(inertia)}"
        )
    return matrix
