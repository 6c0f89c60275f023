"""Motors: the angle or the displacement of a joint follows a function of time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.scene.bodies import Node
from ancfsparse.scene.course import Course
from ancfsparse.scene.joints.freedoms import measure
from ancfsparse.scene.joints.joint import Builder, Joint, Led, Vector


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
    """

    joint: Joint
    of: str
    course: Course
    name = "drive"

    def lower(self, builder: Builder) -> None:
        """State ``factor (h(q) - s(t)) = 0``, in metres."""
        factor = self.joint.arm if self.of == "angle" else 1.0
        builder.equation(
            self.label,
            0.0,
            measures=[(factor, measure(builder, self.joint, self.of))],
            led=Led(self.course, 0, Times(factor)),
        )

    @property
    def nodes(self) -> tuple[Node, ...]:
        """Those of the joint."""
        return self.joint.nodes

    @property
    def sides(self) -> tuple[Node, Node | None]:
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
        """Whether it is made by an equation: always."""
        return True
