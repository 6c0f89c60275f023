"""Richardson's estimate: what is left of an error, from solutions at several resolutions.

A method of order p leaves e(x) = C x^-p at a resolution x, elements or steps.  Two solutions differ
by e(x) - e(r x), so e(r x) = d / (r^p - 1).  Three show the order; where it disagrees with what the
method has, the more pessimistic is taken.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

# Orders below are not believed to hold on: a series that hardly converges has no estimate.
LEAST_ORDER = 0.5
# An error over the one asked for, of which the power by any order is still a number.
OUT_OF_REACH = 1e150
# Observed orders within these shares of the known one are those of a method that has settled.
SETTLED = (0.6, 1.75)


@dataclass(frozen=True)
class Estimate:
    """An error as a power of the resolution.

    Attributes
    ----------
    resolution : float
        Number of elements or of steps at which it is known.
    error : float
        The error there [unit of the quantity].
    order : float
        Its power.
    settled : bool
        Whether the order was observed, and is about that of the method.
    ratio : float
        Ratio of the two resolutions whose solutions it was estimated from.
    seen : bool
        Whether any order was observed: two solutions show none.
    """

    resolution: float
    error: float
    order: float
    settled: bool
    ratio: float = 2.0
    seen: bool = True

    def at(self, resolution: float) -> float:
        """Return the error at another resolution."""
        return float(self.error * (self.resolution / resolution) ** self.order)

    def needed(self, error: float) -> float:
        """Return the resolution at which the error is no more than this."""
        if self.error == 0.0:
            return 0.0
        ratio = self.error / error if error > 0.0 else math.inf
        if ratio > OUT_OF_REACH:
            return math.inf
        return float(self.resolution * ratio ** (1.0 / self.order))

    @property
    def careful(self) -> float:
        """The error, with half of the order where none was observed [unit of the quantity]."""
        return self.error if self.seen else self.with_order(0.5 * self.order).error

    def with_order(self, order: float) -> Estimate:
        """Return the estimate from the same two solutions with another order."""
        more = (self.ratio**self.order - 1.0) / (self.ratio**order - 1.0)
        return replace(self, order=order, error=more * self.error)


def estimate(
    resolutions: Sequence[float], differences: Sequence[float], order: float, noise: float = 0.0
) -> Estimate:
    """Estimate the error at the last of some resolutions.

    Parameters
    ----------
    resolutions : sequence of float
        Growing numbers of elements or steps, at least two.
    differences : sequence of float
        By how much the solution at each differs from that at the next, one fewer [unit].
    order : float
        Order of the method.
    noise : float, optional
        Differences up to here are rounding and show no order [unit].

    Returns
    -------
    Estimate
        By the observed order where three solutions show a lower one than the method has.
    """
    last = differences[-1]
    ratio = resolutions[-1] / resolutions[-2]
    known = last / (ratio**order - 1.0)
    if last <= noise:
        return Estimate(resolutions[-1], known, order, True, ratio)
    if len(differences) < 2 or differences[-2] <= noise:
        return Estimate(resolutions[-1], known, order, False, ratio, seen=False)
    seen = observed(resolutions[-3:], differences[-2], last)
    believed = min(order, max(seen, LEAST_ORDER))
    settled = SETTLED[0] * order <= seen <= SETTLED[1] * order
    error = last / (ratio**believed - 1.0)
    return Estimate(resolutions[-1], error, believed, settled, ratio)


def observed(resolutions: Sequence[float], first: float, second: float) -> float:
    """Return the order that two differences of three resolutions show; -inf if none.

    With ratios r and s of successive resolutions, d_1 / d_2 = (1 - r^-p) / (r^-p - (r s)^-p), which
    grows with p; equal ratios give log(d_1 / d_2) / log r.
    """
    r, s = resolutions[1] / resolutions[0], resolutions[2] / resolutions[1]
    target = first / second

    def quotient(p: float) -> float:
        return float((1.0 - r**-p) / (r**-p - (r * s) ** -p))

    low, high = 1e-3, 32.0
    if target <= quotient(low):
        return -math.inf
    if target >= quotient(high):
        return high
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if quotient(middle) < target else (low, middle)
    return 0.5 * (low + high)
