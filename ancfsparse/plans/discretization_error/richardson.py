"""Richardson extrapolation: the error of a solution from solutions at several resolutions.

A method of order p has the error e(x) = C x^-p at a resolution x, a number of elements or steps.
Two solutions differ by d = e(x) - e(r x), so e(r x) = d / (r^p - 1).  Three solutions show the
order; if it differs from that of the method, the smaller of both is used, and the larger at lower
resolutions.

An error with two terms of opposite signs, such as A h^3 - B h^4, has an extremum in between, about
which two solutions agree by chance.  The last difference is then far smaller than the previous one,
and shows an order that no method has.  It is taken to be at least the previous one, reduced by the
order of the method.

At lower resolutions the error is not below the one that solutions there show, by their differences
from the last one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ancfsparse.array_types import Vector

MIN_ORDER = 0.5  # smallest order that is extrapolated
MAX_ERROR_RATIO = 1e150  # of error to tolerance, such that its power 1/order does not overflow
ASYMPTOTIC_RANGE = (0.6, 1.75)  # observed order over that of the method in the asymptotic range


@dataclass(frozen=True)
class Estimate:
    """Error as a power of the resolution.

    Attributes
    ----------
    resolution : float
        Number of elements or of steps at which it was estimated.
    error : float
        The error there [unit of the quantity].
    order : float
        The power.
    is_asymptotic : bool
        Whether the order was observed, and is about that of the method.
    ratio : float
        Ratio of the two resolutions from which it was estimated.
    is_observed : bool
        Whether an order was observed at all, which takes three solutions.
    observed : float
        That order; if it is larger than the power, it is the power at lower resolutions.
    lower : tuple of pairs of float
        Lower resolutions, ascending, and bounds of the differences of solutions there from the
        last [unit].
    """

    resolution: float
    error: float
    order: float
    is_asymptotic: bool
    ratio: float = 2.0
    is_observed: bool = True
    observed: float = 0.0
    lower: tuple[tuple[float, float], ...] = ()

    def at(self, resolution: float) -> float:
        """Return the error at another resolution, at least the one that solutions show there."""
        error = self.error * (self.resolution / resolution) ** self._order(
            resolution < self.resolution
        )
        if resolution < self.resolution:
            known, errors = self._known
            log_error = np.interp(np.log(resolution), np.log(known), np.log(errors))
            error = max(error, np.exp(log_error))
        return float(error)

    def resolution_for(self, error: float) -> float:
        """Return the resolution with an error."""
        if self.error == 0.0:
            return 0.0
        ratio = self.error / error if error > 0.0 else math.inf
        if ratio > MAX_ERROR_RATIO:
            return math.inf
        result = self.resolution * ratio ** (1.0 / self._order(ratio < 1.0))
        known, errors = self._known
        if errors[-1] < error < errors[0]:
            log_result = np.interp(np.log(error), np.log(errors[::-1]), np.log(known[::-1]))
            result = max(result, np.exp(log_result))
        return float(result)

    def _order(self, is_lower: bool) -> float:
        """Return the power at lower or at higher resolutions."""
        return max(self.order, self.observed) if is_lower else self.order

    @property
    def _known(self) -> tuple[Vector, Vector]:
        """Resolutions of solutions, ascending, and their errors [unit]."""
        lower = [(x, self.error + d) for x, d in self.lower if x < self.resolution]
        known, errors = np.array([*lower, (self.resolution, self.error)]).T
        return known, np.maximum(errors, np.finfo(float).tiny)

    @property
    def conservative(self) -> float:
        """Error estimated with half the order if none was observed [unit of the quantity]."""
        return self.error if self.is_observed else self.with_order(0.5 * self.order).error

    def with_order(self, order: float) -> Estimate:
        """Return the estimate from the same two solutions with another order."""
        factor = (self.ratio**self.order - 1.0) / (self.ratio**order - 1.0)
        return replace(self, order=order, error=factor * self.error)


def estimate(
    resolutions: Sequence[float],
    differences: Sequence[float],
    order: float,
) -> Estimate:
    """Estimate the error at the last of several resolutions.

    Parameters
    ----------
    resolutions : sequence of float
        Increasing numbers of elements or steps, at least two.
    differences : sequence of float
        Differences between solutions at successive resolutions, one fewer [unit].
    order : float
        Order of the method.

    Returns
    -------
    Estimate
        With the observed order if three solutions show one smaller than the order of the method.
    """
    last = differences[-1]
    ratio = resolutions[-1] / resolutions[-2]
    error = last / (ratio**order - 1.0)
    bounds = np.cumsum(differences[::-1])[::-1]
    lower = tuple(zip(resolutions[:-1], map(float, bounds), strict=True))
    if last == 0.0:
        return Estimate(resolutions[-1], error, order, True, ratio, lower=lower)
    if len(differences) < 2 or differences[-2] == 0.0:
        return Estimate(resolutions[-1], error, order, False, ratio, False, lower=lower)
    previous, last_three = differences[-2], resolutions[-3:]
    observed = observed_order(last_three, previous, last)
    reduced = previous / _reduction(last_three, order)
    result = from_observed_order(resolutions[-1], last, reduced, order, observed, ratio)
    return replace(result, lower=lower)


def from_observed_order(
    resolution: float, last: float, reduced: float, order: float, observed: float, ratio: float
) -> Estimate:
    """Return the estimate from the last difference, with the smaller of two orders.

    It is at least the previous one, `reduced` by the order of the method, where it decreased faster
    than in the asymptotic range.
    """
    used = min(order, max(observed, MIN_ORDER))
    difference = max(last, reduced) if observed > ASYMPTOTIC_RANGE[1] * order else last
    is_asymptotic = ASYMPTOTIC_RANGE[0] * order <= observed <= ASYMPTOTIC_RANGE[1] * order
    error = difference / (ratio**used - 1.0)
    return Estimate(resolution, error, used, is_asymptotic, ratio, observed=observed)


def observed_order(resolutions: Sequence[float], first: float, second: float) -> float:
    """Return the order shown by two differences of three resolutions; -inf if none."""
    target = first / second
    low, high = 1e-3, 32.0
    if target <= _reduction(resolutions, low):
        return -math.inf
    if target >= _reduction(resolutions, high):
        return high
    for _ in range(60):
        middle = 0.5 * (low + high)
        is_below = _reduction(resolutions, middle) < target
        low, high = (middle, high) if is_below else (low, middle)
    return 0.5 * (low + high)


def _reduction(resolutions: Sequence[float], p: float) -> float:
    """Return the ratio of two differences of three resolutions by an order p.

    With ratios r and s of successive resolutions, d_1 / d_2 = (1 - r^-p) / (r^-p - (r s)^-p), which
    grows with p; equal ratios give r^p.
    """
    r, s = resolutions[1] / resolutions[0], resolutions[2] / resolutions[1]
    return float((1.0 - r**-p) / (r**-p - (r * s) ** -p))
