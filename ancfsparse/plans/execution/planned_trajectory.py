"""Trajectory of a planned run."""

from __future__ import annotations

from dataclasses import dataclass

from ancfsparse.array_types import Vector
from ancfsparse.plans.execution.plan_data import PlanData
from ancfsparse.plans.execution.unmet_errors import UnmetError, unmet_errors
from ancfsparse.results import Trajectory
from ancfsparse.scene import Point

SPATIAL = 3


@dataclass(frozen=True, eq=False, repr=False)
class PlannedRun(Trajectory):
    """Trajectory of a planned run.

    Attributes
    ----------
    plan : Plan
        The plan of the completed run, which differs from the first one if that was changed.
    measured : tuple of float
        With ``verify``, the difference of each quantity from the run one refinement level finer
        [its unit]; empty otherwise.
    """

    plan: PlanData | None = None
    measured: tuple[float, ...] = ()

    @property
    def _is_accurate(self) -> bool:
        return not self._unmet_errors

    @property
    def _unmet_errors(self) -> list[UnmetError]:
        return unmet_errors(self.plan, self.measured) if self.plan else []

    @property
    def _aim(self) -> str:
        """Return the unfulfilled aim of an unfinished run."""
        if not self._ended:
            return super()._aim
        return "; ".join(str(each) for each in self._unmet_errors)

    def _in_space(self, values: Vector, node: Point, is_position: bool = False) -> Vector:
        """Return vectors of a planar run in the space of the scene."""
        planar = self.plan.planar if self.plan else None
        if planar is None or node.beam.dim != SPATIAL:
            return values
        return planar.plane.place(values) if is_position else planar.plane.lift(values)

    def position(self, node: Point) -> Vector:
        """Return the position of a point over time, see `Trajectory.position`."""
        return self._in_space(super().position(node), node, is_position=True)

    def velocity(self, node: Point) -> Vector:
        """Return the velocity of a point over time, see `Trajectory.velocity`."""
        return self._in_space(super().velocity(node), node)

    def acceleration(self, node: Point) -> Vector:
        """Return the acceleration of a point over time, see `Trajectory.acceleration`."""
        return self._in_space(super().acceleration(node), node)

    def slope(self, node: Point) -> Vector:
        """Return the slope r' over time, see `Trajectory.slope`."""
        return self._in_space(super().slope(node), node)

    def reaction(self, node: Point) -> Vector:
        """Return the force of joints at a node over time, see `Trajectory.reaction`."""
        return self._in_space(super().reaction(node), node)

    def __repr__(self) -> str:
        """Return a summary of the run with predicted and measured errors."""
        lines = [super().__repr__()]
        predictions = self.plan.predictions if self.plan else ()
        for i, each in enumerate(predictions):
            line = f"  {each.goal.quantity!r}: predicted error {each.bound:.1e}"
            if self.measured:
                line += f", measured {self.measured[i]:.1e}"
            lines.append(f"{line} {each.goal.quantity.unit}".rstrip())
        return "\n".join(lines)
