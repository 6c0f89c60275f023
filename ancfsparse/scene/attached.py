"""What is attached to points of a scene and pushes there: masses, springs, forces."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar


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
