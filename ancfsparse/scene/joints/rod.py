"""Rods: the distance of a node from a fixed point is kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.scene.bodies import Node
from ancfsparse.scene.joints.joint import Builder, Joint
from ancfsparse.words import numbers

# Share of a beam's length within which two nodes count as being at one place.
SAME_PLACE = 1e-9


@dataclass(frozen=True, eq=False)
class Rod(Joint):
    """Keep the distance of a node from a fixed point, as a rigid massless rod does.

    Attributes
    ----------
    node : Node
        The node held.
    anchor : ndarray, shape (dim,)
        The fixed point [m], read-only.
    length : float
        The initial distance, kept [m].
    """

    node: Node
    anchor: NDArray[np.float64]
    length: float
    name = "rod"

    def lower(self, builder: Builder) -> None:
        """State (|r - p|^2 - l^2) / (2 l) = 0: in metres, with a gradient of length one."""
        builder.equation(
            f"rod at {self.node!r}",
            -0.5 * self.length,
            *((0.5 / self.length, i, i) for i in builder.position(self.node)),
            about=self.anchor.tolist(),
        )

    @property
    def nodes(self) -> tuple[Node, ...]:
        """The node."""
        return (self.node,)

    @property
    def direction(self) -> NDArray[np.float64]:
        """From the anchor to the node in the reference shape, a unit vector (dim,)."""
        return np.asarray((self.node.position - self.anchor) / self.length)

    @property
    def has_multipliers(self) -> bool:
        """Whether it is made by an equation: always."""
        return True

    def describe(self, at: Callable[[Node], str]) -> str:
        """Describe everything that its equation follows from."""
        return f"rod ({at(self.node)}) to {numbers(self.anchor)}"
