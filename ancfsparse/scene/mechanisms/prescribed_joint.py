"""Prescribed joints: the angle or the displacement of a joint follows a function of time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.kinematics.linear_forms import RheonomicTerm
from ancfsparse.scene.mechanisms.coordinate_functions import joint_coordinate
from ancfsparse.scene.records.prescribed_motion import PrescribedMotion, PrescribedValue
from ancfsparse.scene.records.signal import is_vectorized


@dataclass(frozen=True)
class RotatingVector:
    """A planar vector that rotates by a prescribed angle, or a derivative of it.

    Parameters
    ----------
    angle : tuple of PrescribedValue
        The angle [rad], and its rates up to the order of the derivative.
    vector : tuple of float
        The vector at angle zero.
    """

    angle: tuple[PrescribedValue, ...]
    vector: tuple[float, float]

    @property
    def takes_arrays(self) -> bool:
        """True if the angle and its rates are evaluated for all times at once."""
        return all(is_vectorized(function.value) for function in self.angle)

    def __call__(self, t: ArrayLike) -> Vector:
        """Return its value at a time, (2,), or at many, (k, 2) [1, 1/s or 1/s2]."""
        angle, *rates = (_evaluate(function, t) for function in self.angle)
        cos, sin = np.cos(angle), np.sin(angle)
        x, y = self.vector
        rotated = np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
        normal = np.stack([-rotated[..., 1], rotated[..., 0]], axis=-1)
        if not rates:
            return np.asarray(rotated)
        if len(rates) == 1:
            return np.asarray(rates[0][..., None] * normal)
        return np.asarray(rates[1][..., None] * normal - rates[0][..., None] ** 2 * rotated)


def rotating_vector(motion: PrescribedMotion, vector: Vector) -> PrescribedMotion:
    """Return the motion of a planar vector, (2,), that rotates by a prescribed angle."""
    start = float(vector[0]), float(vector[1])
    angle, rate, second_rate = motion.value, motion.rate, motion.second_rate

    def derivative(*angles: PrescribedValue) -> PrescribedValue:
        function, last = RotatingVector(angles, start), angles[-1]
        return PrescribedValue(last.subject, 2, function, last.unit)

    if rate is None or second_rate is None:
        return PrescribedMotion(derivative(angle), None, None, motion)
    return PrescribedMotion(
        derivative(angle), derivative(angle, rate), derivative(angle, rate, second_rate), motion
    )


def _evaluate(prescribed: PrescribedValue, t: ArrayLike) -> Vector:
    function: Any = prescribed.value
    value = function(t) if callable(function) else function
    return np.asarray(value, dtype=float)


@dataclass(frozen=True, eq=False)
class PrescribedJoint(Joint):
    """Prescribe a coordinate of a joint: its angle or its displacement.

    Attributes
    ----------
    joint, of, as_constraint
        As in `Scene.drive_joint`.
    motion : PrescribedMotion
        The coordinate over time [rad or m].
    """

    joint: Joint
    of: str
    motion: PrescribedMotion
    as_constraint: bool = False
    name = "drive"

    def lower(self, builder: ConstraintBuilder) -> None:
        """Prescribe the direction of a planar body, or state ``factor (h(q) - s(t)) = 0`` [m]."""
        if self.turns_body and builder.turns:
            body, _ = self.joint.sides
            columns = builder.kind(body).columns("r_x")
            vector = np.asarray(body.beam.vectors[0, 0])
            builder.drive(builder.rows(body)[0, columns], rotating_vector(self.motion, vector))
            return
        factor = self.joint.arm if self.of == "angle" else 1.0
        builder.equation(
            self.label,
            0.0,
            measures=[(factor, joint_coordinate(builder, self.joint, self.of))],
            rheonomic=RheonomicTerm(self.motion, 0, partial(np.multiply, factor)),
        )

    @property
    def turns_body(self) -> bool:
        """True if it rotates a planar rigid body relative to the ground, without an equation."""
        a, b = self.joint.sides
        at_ground = b is None and self.of == "angle" and not self.as_constraint
        return at_ground and a.beam.dim == 2 and a.beam.masses is not None

    @property
    def nodes(self) -> tuple[Point, ...]:
        """Points of the joint."""
        return self.joint.nodes

    @property
    def sides(self) -> tuple[Point, Point | None]:
        """Sides of the joint."""
        return self.joint.sides

    @property
    def axis(self) -> Vector | None:
        """Axis of the joint."""
        return self.joint.axis

    @property
    def label(self) -> str:
        """Name in messages."""
        return f"drive of the {self.of} of the {self.joint.label}"

    @property
    def has_multipliers(self) -> bool:
        """True if it is certainly made by an equation."""
        return not self.turns_body
