"""Targets, and whether they are reached."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Target:
    """A number to be reached.

    Attributes
    ----------
    what : str
        The quantity.
    value, wanted : float
        What it is and what it should be.
    at_most : bool
        Whether it should stay below, not above.
    """

    what: str
    value: float
    wanted: float
    at_most: bool = False

    @property
    def met(self) -> bool:
        """Whether it is reached."""
        return self.value <= self.wanted if self.at_most else self.value >= self.wanted

    def record(self) -> dict[str, str | float | bool | None]:
        """Return it for JSON, which has no infinite numbers: null."""
        bound = "at_most" if self.at_most else "at_least"
        value = self.value if math.isfinite(self.value) else None
        return {"what": self.what, "value": value, bound: self.wanted, "met": self.met}

    def __str__(self) -> str:
        """Put value, target and verdict on one line."""
        bound = "at most" if self.at_most else "at least"
        verdict = "met" if self.met else "MISSED"
        return f"{self.what:<58}{self.value:>9.3g}   {bound} {self.wanted:g}: {verdict}"
