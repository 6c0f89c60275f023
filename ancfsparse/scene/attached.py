"""What is attached to points of a scene and pushes there: masses, springs, forces."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar

from ancfsparse.scene.bodies import Node


class Attached(ABC):
    """Something attached to points of beams.

    Attributes
    ----------
    contribution : str
        Module of `ancfsparse.system.contributions` that adds it to the equations of motion.
    """

    contribution: ClassVar[str]

    @property
    @abstractmethod
    def what(self) -> str:
        """Name in messages."""

    @abstractmethod
    def describe(self, at: Callable[[Node], str]) -> str:
        """Describe it for the digest of a scene; ``at`` describes a point."""
