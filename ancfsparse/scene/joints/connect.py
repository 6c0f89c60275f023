"""Connections: two nodes at one place, free to turn against each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ancfsparse.scene.bodies import Node
from ancfsparse.scene.joints.joint import Builder, Joint


@dataclass(frozen=True, eq=False)
class Connect(Joint):
    """Let two nodes share one position, free to turn against each other.

    Attributes
    ----------
    a, b : Node
        The nodes.
    """

    a: Node
    b: Node
    name = "connection"

    def lower(self, builder: Builder) -> None:
        """Share the position."""
        builder.share(builder.position(self.a), builder.position(self.b))

    @property
    def nodes(self) -> tuple[Node, ...]:
        """Both nodes."""
        return self.a, self.b

    @property
    def joins(self) -> bool:
        """Whether it makes its nodes one point: always."""
        return True

    def describe(self, at: Callable[[Node], str]) -> str:
        """Describe everything that its numbering follows from."""
        return f"connection ({at(self.a)}; {at(self.b)})"
