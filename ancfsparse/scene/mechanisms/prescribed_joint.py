"""Motors: the angle or the displacement of a joint follows a function of time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.scene.bodies.body import Builder, Led, Point
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.kinematics.linear_forms import Vector
from ancfsparse.scene.mechanisms.coordinate_functions import measure
from ancfsparse.scene.records.prescribed_motion import Angles, Course, Places, SpinRates, Spins
from ancfsparse.scene.records.signal import at_once


@dataclass(frozen=True)
class Times:
    """A motion times a factor.

    Parameters
    ----------
    factor : float
        The factor [m] of an angle, [1] of a displacement.
    """

    factor: float

    def __call__(self, course: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return values and rates (k, 3) [m, m/s, m/s2]."""
        return self.factor * course


@dataclass(frozen=True)
class Direction:
    """A vector that turns with a prescribed angle, or a rate of it.

    Parameters
    ----------
    given : tuple of Places
        The angle [rad], and as many of its rates as are needed.
    vector : tuple of float
        The vector where the angle is zero.
    """

    given: tuple[Places, ...]
    vector: tuple[float, float]

    @property
    def takes_arrays(self) -> bool:
        """Whether the angle and its rates are evaluated for all times at once."""
        return all(at_once(each.value) for each in self.given)

    def __call__(self, t: ArrayLike) -> Vector:
        """Return it at a time, (2,), or at many, (k, 2) [1, 1/s or 1/s2]."""
        angle, *rates = (_at(each, t) for each in self.given)
        along = np.cos(angle), np.sin(angle)
        u, v = self.vector
        out = np.stack([along[0] * u - along[1] * v, along[1] * u + along[0] * v], axis=-1)
        across = np.stack([-out[..., 1], out[..., 0]], axis=-1)
        if not rates:
            return np.asarray(out)
        if len(rates) == 1:
            return np.asarray(rates[0][..., None] * across)
        return np.asarray(rates[1][..., None] * across - rates[0][..., None] ** 2 * out)


def turned(course: Course, vector: Vector) -> Course:
    """Return the motion of a vector, (2,), that turns with a prescribed angle."""
    given = course.places, course.rates, course.second_rates
    along = float(vector[0]), float(vector[1])
    places = Angles(course.places.subject, 2, Direction(given[:1], along))
    if given[1] is None or given[2] is None:
        return Course(places, None, None)
    rates = Spins(given[1].subject, 2, Direction((given[0], given[1]), along))
    second = SpinRates(given[2].subject, 2, Direction((given[0], given[1], given[2]), along))
    return Course(places, rates, second)


def _at(given: Places, t: ArrayLike) -> Vector:
    function: Any = given.value
    value = function(t) if callable(function) else function
    return np.asarray(value, dtype=float)


@dataclass(frozen=True, eq=False)
class Driven(Joint):
    """Prescribe what a joint leaves free.

    Attributes
    ----------
    joint : Joint
        The joint.
    of : str
        ``"angle"`` or ``"displacement"``.
    course : Course
        It over time [rad or m].
    as_constraint : bool
        Prescribe it by an equation also where numbering could.
    """

    joint: Joint
    of: str
    course: Course
    as_constraint: bool = False
    name = "drive"

    def lower(self, builder: Builder) -> None:
        """Prescribe the direction of a planar body, or state ``factor (h(q) - s(t)) = 0`` [m]."""
        if self.turns_body and builder.turns:
            body, _ = self.joint.sides
            columns = builder.kind(body).columns("r_x")
            vector = np.asarray(body.beam.vectors[0, 0])
            builder.drive(builder.rows(body)[0, columns], turned(self.course, vector))
            return
        factor = self.joint.arm if self.of == "angle" else 1.0
        builder.equation(
            self.label,
            0.0,
            measures=[(factor, measure(builder, self.joint, self.of))],
            led=Led(self.course, 0, Times(factor)),
        )

    @property
    def turns_body(self) -> bool:
        """Whether it can be made by numbering: it turns a planar body against the ground."""
        a, b = self.joint.sides
        at_ground = b is None and self.of == "angle" and not self.as_constraint
        return at_ground and a.beam.dim == 2 and a.beam.masses is not None

    @property
    def nodes(self) -> tuple[Point, ...]:
        """Those of the joint."""
        return self.joint.nodes

    @property
    def sides(self) -> tuple[Point, Point | None]:
        """Those of the joint."""
        return self.joint.sides

    @property
    def axis(self) -> Vector | None:
        """That of the joint."""
        return self.joint.axis

    @property
    def label(self) -> str:
        """Name in messages."""
        return f"drive of the {self.of} of the {self.joint.label}"

    @property
    def has_multipliers(self) -> bool:
        """Whether it certainly makes an equation."""
        return not self.turns_body
