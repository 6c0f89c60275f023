"""Penetrations that contacts are designed for, and warnings of too large ones."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError, PenetrationWarning
from ancfsparse.scene.force_elements.fixed_ends import MAX_START_DEPTH_RATIO
from ancfsparse.system.contributions.interface import Contribution

DEPTH_RATIO = 0.01  # penetration with the default stiffness, over the radius of the body
# The same in an impact with a restitution, whose duration all steps must resolve: with .01 they
# would be 10 to 30 times as short.
RESTITUTION_DEPTH_RATIO = 0.1
MAX_REST_RATIO = 0.03  # limit of penetrations at rest with the default stiffness, over the radius
# The same in a run: in a rope that is bent to its own radius single points reach .17 for a moment.
MAX_RUN_RATIO = 0.3
# Limit of penetrations with a given stiffness, over the radius.  Beyond it the axis is inside:
# round obstacles press a body that passes their middle to the other side.
MAX_SOFT_RATIO = 1.0


class Penetration(NamedTuple):
    """A penetration of a contact.

    Attributes
    ----------
    depth : float
        The penetration [m].
    radius : float
        Radius of the body, of two bodies the smaller one [m].
    stiffness : float
        Force per length and penetration there [N/m2].
    where : str
        Name of the point, between bodies also of its foot on the other one.
    """

    depth: float
    radius: float
    stiffness: float
    where: str


@dataclass(frozen=True)
class PenetrationLimit:
    """The largest penetration of a contact without a warning.

    Parameters
    ----------
    what : str
        The contact, in messages.
    is_default : bool
        Whether the stiffness follows from loads and speeds at the start.
    exponent : float
        Of the penetration in the force: 1 along a line, 3/2 where two lines cross.
    restitution : float
        Coefficient of restitution, 0 for none.
    """

    what: str
    is_default: bool
    exponent: float
    restitution: float

    def allows(self, deepest: Penetration, at_rest: bool) -> bool:
        """Return whether a penetration needs no warning."""
        largest = MAX_REST_RATIO if at_rest else MAX_RUN_RATIO
        return deepest.depth <= (largest if self.is_default else MAX_SOFT_RATIO) * deepest.radius

    def warning(self, deepest: Penetration, when: str, at_rest: bool) -> PenetrationWarning:
        """Return the warning of a penetration at a time or a load.

        A force at rest is proportional to the power `exponent` of the penetration, and the energy
        of an impact to the power `exponent` + 1.
        """
        ratio = deepest.depth / deepest.radius
        power = self.exponent if at_rest else self.exponent + 1.0
        enough = deepest.stiffness * (ratio / self._goal(at_rest)) ** power
        cause = (
            f"the default stiffness of {deepest.stiffness:.3g} N/m2 follows from the loads and "
            "speeds known at the start"
            if self.is_default
            else f"the given stiffness of {deepest.stiffness:.3g} N/m2 is too small for the "
            + ("loads" if at_rest else "motion")
        )
        return PenetrationWarning(
            f"{self.what} has a penetration of {deepest.depth:.3g} m, {ratio:.2g} times the radius "
            f"of {deepest.radius:.3g} m, {when} at {deepest.where}: {cause}. Give contact the "
            f"stiffness={enough:.2g}"
        )

    def _goal(self, at_rest: bool) -> float:
        return DEPTH_RATIO if at_rest else impact_ratio(self.restitution)


@dataclass(frozen=True)
class StartLimit:
    """The largest penetration of a contact with a given stiffness at the start of a motion.

    Parameters
    ----------
    what : str
        The contact, in messages.
    known_depth : callable
        Returns the largest penetration by loads, tensions and speeds known at the start [m].
    """

    what: str
    known_depth: Callable[[], float]

    def warnings(self, deepest: Penetration) -> list[Warning]:
        """Return a warning if a penetration is deeper, and too deep for the default stiffness."""
        depth, radius, stiffness, where = deepest
        if depth <= MAX_START_DEPTH_RATIO * radius or depth <= (known := self.known_depth()):
            return []
        return [
            PenetrationWarning(
                f"{self.what} begins with a penetration of {depth:.3g} m at {where}: with the "
                f"given stiffness of {stiffness:.3g} N/m2 the loads, tensions and speeds known at "
                f"the start cause at most {known:.2g} m, so the pressure pushes them apart at "
                "once. Give contact push_out=True, or start from an equilibrium, such as "
                "start=solve_static(scene)"
            )
        ]


def impact_ratio(restitution: float) -> float:
    """Return the penetration in an impact with the default stiffness, over the radius."""
    return RESTITUTION_DEPTH_RATIO if restitution else DEPTH_RATIO


class LimitedPenetration(Contribution):
    """A contact that warns of penetrations above its limit.

    Attributes
    ----------
    penetration_limit : PenetrationLimit or None
        Limit of the penetration; None for no limit.
    start_limit : StartLimit or None
        Likewise at the start of a motion.
    """

    penetration_limit: PenetrationLimit | None = None
    start_limit: StartLimit | None = None

    @property
    @abstractmethod
    def deepest_of_motion(self) -> Penetration:
        """The penetration in the last motion with the largest ratio to the radius."""

    @abstractmethod
    def deepest_at(self, q: Vector) -> Penetration:
        """Return the penetration in a state with the largest ratio to the radius."""

    def start_warnings(self, q: Vector) -> list[Warning]:
        """Return a warning if a motion begins with a penetration that known loads do not cause."""
        return [] if self.start_limit is None else self.start_limit.warnings(self.deepest_at(q))

    def run_warnings(self, t: Vector, q: Any) -> list[Warning]:
        """Return a warning if the penetration in any step of the last motion was too large.

        Saved states are searched for its time only then, since that takes longer than a step.
        """

        def when() -> str:
            try:
                return f"at t = {t[self._deepest_state(q)]:.4g} s,"
            except InputError:  # not all coordinates were saved
                return "in the run"

        return self.motion_warnings(when)

    def motion_warnings(self, when: Callable[[], str]) -> list[Warning]:
        """Return a warning if the penetration in any step of the present motion was too large."""
        limit, deepest = self.penetration_limit, self.deepest_of_motion
        if limit is None or limit.allows(deepest, at_rest=False):
            return []
        return [limit.warning(deepest, when(), at_rest=False)]

    def rest_warnings(self, q: Vector, when: Callable[[int], str]) -> list[Warning]:
        """Return a warning if the penetration in any of the equilibria was too large."""
        limit = self.penetration_limit
        if limit is None:
            return []
        k = self._deepest_state(q)
        deepest = self.deepest_at(q[k])
        return (
            [] if limit.allows(deepest, at_rest=True) else [limit.warning(deepest, when(k), True)]
        )

    def _deepest_state(self, q: Any) -> int:
        """Return the number of the state with the largest ratio of penetration to radius."""
        deepest = (self.deepest_at(q[k]) for k in range(len(q)))
        return int(np.argmax([each.depth / each.radius for each in deepest]))
