"""Distance constraints: a point keeps its distance from an anchor, or from another point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ancfsparse.array_types import Integers, Vector
from ancfsparse.messages import format_numbers
from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.joints.frame_vectors import point
from ancfsparse.scene.joints.joint import Joint, Mark
from ancfsparse.scene.kinematics.linear_forms import LINEAR, RheonomicTerm
from ancfsparse.scene.records.record import At, PointRef, Record, text

if TYPE_CHECKING:
    from ancfsparse.scene.records.prescribed_motion import PrescribedMotion

Term = tuple[float, int, int]


@dataclass(frozen=True, eq=False)
class RodSpec(Record):
    """The record of `Scene.rod`."""

    node: PointRef
    anchor: tuple[float, ...]
    length: Callable[[float], float] | None = None
    rate: Callable[[float], float] | None = None
    second_rate: Callable[[float], float] | None = None
    method = "rod"
    planar: ClassVar = {"anchor": "put"}
    units: ClassVar = {"anchor": "m", "length": "m", "rate": "m/s", "second_rate": "m/s2"}

    def describe(self, at: At, made: Any) -> str:
        """Describe the data of its equation."""
        length = "" if self.length is None else f", length {text(self.length, at)}"
        return f"rod ({at(self.node)}) to {format_numbers(self.anchor)}{length}"


@dataclass(frozen=True, eq=False)
class DistanceSpec(Record):
    """The record of `Scene.distance`."""

    a: PointRef
    b: PointRef
    length: Callable[[float], float] | None = None
    rate: Callable[[float], float] | None = None
    second_rate: Callable[[float], float] | None = None
    method = "distance"
    planar: ClassVar = {}

    def describe(self, at: At, made: Any) -> str:
        """Describe the data of its equation."""
        length = "" if self.length is None else f", length {text(self.length, at)}"
        return f"distance ({at(self.a)}; {at(self.b)}){length}"


def half_squared_length(initial: float, motion: Vector) -> Vector:
    """Return ``l^2 / (2 l_0)`` and its rates (k, 3) [m, m/s, m/s2] from l, l' and l''."""
    length, rate, second_rate = motion.T
    columns = [0.5 * length**2, length * rate, rate**2 + length * second_rate]
    return np.stack(columns, axis=1) / initial


class DistanceConstraint(Joint):
    """An equation ``(|d|^2 - l(t)^2) / (2 l_0) = 0`` of a distance d, in metres.

    Its gradient has unit length in the reference shape.

    Attributes
    ----------
    length : float
        Distance l_0 in the reference shape [m].
    motion : PrescribedMotion or None
        Prescribed distance over time; None if it is constant.
    """

    length: float
    motion: PrescribedMotion | None
    has_multipliers = True
    constrains_directions = False

    def _add_equation(
        self, builder: ConstraintBuilder, label: str, terms: list[Term], about: list[float]
    ) -> None:
        """Add the equation of the squared distance."""
        rheonomic, offset = None, -0.5 * self.length
        if self.motion is not None:
            scale = partial(half_squared_length, self.length)
            rheonomic, offset = RheonomicTerm(self.motion, 0, scale), 0.0
        builder.equation(label, offset, *terms, about=about, rheonomic=rheonomic)


@dataclass(frozen=True, eq=False)
class RigidRod(DistanceConstraint):
    """Keep or prescribe the distance of a node from a fixed point, as a rigid massless rod does.

    Attributes
    ----------
    node, anchor
        As in `Scene.rod`.
    length, motion
        As in `DistanceConstraint`.
    """

    node: Point
    anchor: Vector
    length: float
    motion: PrescribedMotion | None = None
    name = "rod"

    def lower(self, builder: ConstraintBuilder) -> None:
        """State the equation of the distance from the anchor."""
        positions = builder.ends(self.node)[:, : len(self.anchor)]
        terms, about = squared_distance(
            *builder.point(self.node), positions, self.anchor, 0.5 / self.length
        )
        self._add_equation(builder, f"rod at {self.node!r}", terms, about)

    @property
    def mark(self) -> Mark:
        """Symbol in pictures."""
        return Mark("rod", self.anchor)

    @property
    def direction(self) -> Vector:
        """From the anchor to the node in the reference shape, a unit vector (dim,)."""
        return np.asarray((self.node.position - self.anchor) / self.length)


@dataclass(frozen=True, eq=False)
class Distance(DistanceConstraint):
    """Keep or prescribe the distance of two points.

    Attributes
    ----------
    a, b
        As in `Scene.distance`.
    length, motion
        As in `DistanceConstraint`.
    """

    a: Point
    b: Point
    length: float
    motion: PrescribedMotion | None = None
    name = "distance"

    def lower(self, builder: ConstraintBuilder) -> None:
        """State the equation of the distance of the points."""
        vector = point(builder, self.a) - point(builder, self.b)
        positions = {
            int(k)
            for node in self.nodes
            for k in builder.ends(node)[:, : len(vector.terms)].ravel()
        }
        terms: list[Term] = []
        about: list[float] = []
        for component, origin in zip(vector.terms, self.a.position, strict=True):
            for k, w in component.items():
                for j, x in component.items():
                    terms.append((0.5 / self.length * w * x, k, j))
                    # The weights of positions add up to zero, so any origin may be subtracted.
                    about.append(float(origin) if {k, j} <= positions else 0.0)
        self._add_equation(builder, f"distance of {self.a!r} and {self.b!r}", terms, about)

    @property
    def links(self) -> tuple[tuple[Point, Point], ...]:
        """The line between both points."""
        return ((self.a, self.b),)


def squared_distance(
    coordinates: Integers,
    weights: Vector,
    positions: Integers,
    anchor: Vector,
    factor: float,
) -> tuple[list[Term], list[float]]:
    """Return the terms of ``factor |sum of w q - anchor|^2``, and the origins of their factors.

    Parameters
    ----------
    coordinates : (dim, p) int
        Integers.
    weights : (p,) float
        Their weights.
    positions : (k, dim) int
        Which of them are positions; their weights add up to 1.
    anchor : (dim,) float
        Fixed point [m].
    factor : float
        Factor of the square [1/m].
    """
    terms: list[Term] = []
    about: list[float] = []
    for row, origin, own in zip(coordinates, anchor.tolist(), positions.T.tolist(), strict=True):
        for a, (i, w) in enumerate(zip(row.tolist(), weights.tolist(), strict=True)):
            for b, (j, x) in enumerate(zip(row[: a + 1].tolist(), weights.tolist(), strict=False)):
                product = (1.0 if a == b else 2.0) * factor * w * x
                are_positions = i in own and j in own
                terms.append((product, i, j))
                about.append(origin if are_positions else 0.0)
                if origin and not are_positions and (i in own or j in own):
                    terms.append((-product * origin, j if i in own else i, LINEAR))
                    about.append(0.0)
    return terms, about
