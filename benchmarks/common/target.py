"""Numbers with their targets."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Target:
    """A number and the bound that it should keep."""

    what: str  # the quantity
    value: float
    bound: float
    at_most: bool = False  # an upper bound instead of a lower one

    @property
    def is_met(self) -> bool:
        """True if the number keeps the bound."""
        return self.value <= self.bound if self.at_most else self.value >= self.bound

    @property
    def side(self) -> str:
        """The side of the bound in words."""
        return "at most" if self.at_most else "at least"

    def record(self) -> dict[str, str | float | bool | None]:
        """Return it for JSON, which has no infinite numbers: null."""
        value = self.value if math.isfinite(self.value) else None
        side = self.side.replace(" ", "_")
        return {"what": self.what, "value": value, side: self.bound, "met": self.is_met}

    def sentence(self) -> str:
        """Return number, bound and verdict as a finding."""
        return (
            f"{self.what[:1].upper()}{self.what[1:]}: {self.value:.3g} "
            f"(target: {self.side} {self.bound:g}, {verdict(self.is_met)})"
        )

    def __str__(self) -> str:
        """Return number, bound and verdict as a line of a terminal."""
        found = "met" if self.is_met else "MISSED"
        return f"{self.what:<58}{self.value:>9.3g}   {self.side} {self.bound:g}: {found}"


def verdict(is_met: bool) -> str:
    """Return the verdict on a target in a word."""
    return "met" if is_met else "missed"
