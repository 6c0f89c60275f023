"""Rods: the distance of a node from a fixed point is kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ancfsparse.messages import format_numbers
from ancfsparse.scene.bodies.body import LINEAR, Builder, Led, Point
from ancfsparse.scene.joints.joint import Joint, Mark
from ancfsparse.scene.kinematics.linear_forms import Coordinates
from ancfsparse.scene.records.record import At, PointRef, Spec, text

if TYPE_CHECKING:
    from ancfsparse.scene.records.prescribed_motion import Course


Term = tuple[float, int, int]


@dataclass(frozen=True)
class HalfSquare:
    """``l^2 / (2 l_0)`` and its rates from those of a length.

    Parameters
    ----------
    length : float
        l_0 [m].
    """

    length: float

    def __call__(self, course: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return value and rates (k, 3) [m, m/s, m/s2] from l, l' and l''."""
        value, rate, second = course.T
        columns = [0.5 * value**2, value * rate, rate**2 + value * second]
        return np.stack(columns, axis=1) / self.length


@dataclass(frozen=True, eq=False)
class RodSpec(Spec):
    """The record of `Scene.rod`."""

    node: PointRef
    anchor: tuple[float, ...]
    length: Callable[[float], float] | None = None
    rate: Callable[[float], float] | None = None
    second_rate: Callable[[float], float] | None = None
    method = "rod"
    units: ClassVar = {"anchor": "m", "length": "m", "rate": "m/s", "second_rate": "m/s2"}

    def describe(self, at: At, made: Any) -> str:
        """Describe everything that its equation follows from."""
        length = "" if self.length is None else f", length {text(self.length, at)}"
        return f"rod ({at(self.node)}) to {format_numbers(self.anchor)}{length}"


@dataclass(frozen=True, eq=False)
class Rod(Joint):
    """Keep or prescribe the distance of a node from a fixed point, as a rigid massless rod does.

    Attributes
    ----------
    node : Point
        The node held.
    anchor : ndarray, shape (dim,)
        The fixed point [m], read-only.
    length : float
        The initial distance, kept [m].
    course : Course, optional
        The distance over time, where it is not kept.
    """

    node: Point
    anchor: NDArray[np.float64]
    length: float
    course: Course | None = None
    name = "rod"

    def lower(self, builder: Builder) -> None:
        """State (|r - p|^2 - l(t)^2) / (2 l) = 0: in metres, with a gradient of length one."""
        led = None if self.course is None else Led(self.course, 0, HalfSquare(self.length))
        own = builder.ends(self.node)[:, : len(self.anchor)]
        terms, about = squared(*builder.point(self.node), own, self.anchor, 0.5 / self.length)
        offset = -0.5 * self.length if led is None else 0.0
        builder.equation(f"rod at {self.node!r}", offset, *terms, about=about, led=led)

    @property
    def nodes(self) -> tuple[Point, ...]:
        """The node."""
        return (self.node,)

    @property
    def mark(self) -> Mark:
        """How pictures show it."""
        return Mark("rod", self.anchor)

    @property
    def direction(self) -> NDArray[np.float64]:
        """From the anchor to the node in the reference shape, a unit vector (dim,)."""
        return np.asarray((self.node.position - self.anchor) / self.length)

    @property
    def has_multipliers(self) -> bool:
        """Whether it is made by an equation: always."""
        return True


def squared(
    places: Coordinates,
    weights: NDArray[np.float64],
    positions: Coordinates,
    anchor: NDArray[np.float64],
    factor: float,
) -> tuple[list[Term], list[float]]:
    """Return the terms of ``factor |sum of w q - anchor|^2``, and what their places count from.

    Parameters
    ----------
    places : (dim, p) int
        Coordinates.
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
    for row, held, own in zip(places, anchor.tolist(), positions.T.tolist(), strict=True):
        for a, (i, w) in enumerate(zip(row.tolist(), weights.tolist(), strict=True)):
            for b, (j, x) in enumerate(zip(row[: a + 1].tolist(), weights.tolist(), strict=False)):
                product = (1.0 if a == b else 2.0) * factor * w * x
                both = i in own and j in own
                terms.append((product, i, j))
                about.append(held if both else 0.0)
                if held and not both and (i in own or j in own):
                    terms.append((-product * held, j if i in own else i, LINEAR))
                    about.append(0.0)
    return terms, about
