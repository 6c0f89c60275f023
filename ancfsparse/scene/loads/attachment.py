"""What is attached to points of a scene and pushes there: masses, springs, forces."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ancfsparse.scene.bodies.body import Point

Vector = NDArray[np.float64]


class Attachment(ABC):
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

    @property
    def links(self) -> tuple[tuple[Point | Vector, Point | Vector], ...]:
        """Pairs of points between which pictures draw a line."""
        return ()
