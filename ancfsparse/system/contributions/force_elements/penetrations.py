"""Penetrations that contacts are made for, and warnings of larger ones."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError, PenetrationWarning
from ancfsparse.system.contributions.interface import Contribution

REST_RATIO = 0.01  # penetration at rest by a default stiffness, over the radius of the body
IMPACT_RATIO = 0.1  # penetration of an impact by it, over this radius
MAX_EXCESS = 3.0  # penetrations without a warning, over those that a default stiffness is for
# Penetration over the radius up to which a stiffness of the user can be soft.  Beyond it the axis
# is inside: round obstacles press a body that passes their middle to the other side.
MAX_SOFT_RATIO = 1.0


@dataclass(frozen=True)
class PenetrationLimit:
    """The largest penetration that a contact is made for.

    Parameters
    ----------
    what : str
        The contact, in messages.
    radius : float
        Radius of the body, of two bodies the smaller one [m].
    stiffness : float
        Force per length and penetration [N/m2].
    is_default : bool
        Whether the stiffness follows from loads and speeds at the start.
    exponent : float
        Of the penetration in the force: 1 along a line, 3/2 where two lines cross.
    """

    what: str
    radius: float
    stiffness: float
    is_default: bool
    exponent: float

    def allows(self, depth: float, at_rest: bool) -> bool:
        """Return whether a penetration [m] needs no warning."""
        largest = MAX_EXCESS * _goal(at_rest) if self.is_default else MAX_SOFT_RATIO
        return depth <= largest * self.radius

    def warning(self, depth: float, at: str, when: str, at_rest: bool) -> PenetrationWarning:
        """Return the warning of a penetration [m] at a point and a time or a load.

        A force at rest is proportional to the power `exponent` of the penetration, and the energy
        of an impact to the next one.
        """
        ratio = depth / self.radius
        power = self.exponent if at_rest else self.exponent + 1.0
        enough = self.stiffness * (ratio / _goal(at_rest)) ** power
        cause = (
            f"the default stiffness of {self.stiffness:.3g} N/m2 follows from the loads and speeds "
            "known at the start"
            if self.is_default
            else f"the given stiffness of {self.stiffness:.3g} N/m2 is too small for the "
            + ("loads" if at_rest else "motion")
        )
        return PenetrationWarning(
            f"{self.what} has a penetration of {depth:.3g} m, {ratio:.2g} times the radius of "
            f"{self.radius:.3g} m, {when} at {at}: {cause}. Give contact the stiffness={enough:.2g}"
        )


def _goal(at_rest: bool) -> float:
    return REST_RATIO if at_rest else IMPACT_RATIO


class LimitedPenetration(Contribution):
    """A contact that warns of penetrations that are larger than it is made for.

    Attributes
    ----------
    penetration_limit : PenetrationLimit or None
        Limit of the penetration; None if it can be any.
    """

    penetration_limit: PenetrationLimit | None = None

    @property
    @abstractmethod
    def deepest_of_motion(self) -> tuple[float, str]:
        """The largest penetration in the steps of the last motion [m], and its point."""

    def run_warnings(self, t: Vector, q: Any) -> list[Warning]:
        """Return a warning if the penetration in any step of the last motion was too large.

        Saved states are searched for its time only then, since that takes longer than a step.
        """
        limit, (depth, at) = self.penetration_limit, self.deepest_of_motion
        if limit is None or limit.allows(depth, at_rest=False):
            return []
        try:
            when = f"at t = {t[self._deepest_state(q)]:.4g} s,"
        except InputError:  # not all coordinates were saved
            when = "in the run"
        return [limit.warning(depth, at, when, at_rest=False)]

    def rest_warnings(self, q: Vector, when: Callable[[int], str]) -> list[Warning]:
        """Return a warning if the penetration in any of the equilibria was too large."""
        limit = self.penetration_limit
        if limit is None:
            return []
        k = self._deepest_state(q)
        depth, _, _, at = self.deepest_point(q[k])
        if limit.allows(depth, at_rest=True):
            return []
        return [limit.warning(depth, at, when(k), at_rest=True)]

    def _deepest_state(self, q: Any) -> int:
        """Return the number of the state with the largest penetration."""
        return int(np.argmax([self.deepest_point(q[k])[0] for k in range(len(q))]))
