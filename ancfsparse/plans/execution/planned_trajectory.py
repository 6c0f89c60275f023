"""A motion that was run as planned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.plans.execution.plan_data import PlanData
from ancfsparse.results import Trajectory
from ancfsparse.scene import Point

Array = NDArray[np.float64]

SPATIAL = 3


@dataclass(frozen=True, eq=False, repr=False)
class PlannedRun(Trajectory):
    """A motion that was run as planned.

    Attributes
    ----------
    plan : PlanData
        The plan that it came to its end by, which differs from the first one if that changed.
    measured : tuple of float
        With ``verify``, by how much each quantity differs from the run one rung up [its unit];
        empty otherwise.
    """

    plan: PlanData | None = None
    measured: tuple[float, ...] = ()

    def _lifted(self, values: Array, node: Point, point: bool = False) -> Array:
        """Return vectors of a planar run in the space of a scene that moves in a plane."""
        flat = self.plan.flat if self.plan else None
        if flat is None or node.beam.dim != SPATIAL:
            return values
        return flat.plane.place(values) if point else flat.plane.lift(values)

    def position(self, node: Point) -> Array:
        """Give the position of a point over time, see `Trajectory.position`."""
        return self._lifted(super().position(node), node, point=True)

    def velocity(self, node: Point) -> Array:
        """Give the velocity of a point over time, see `Trajectory.velocity`."""
        return self._lifted(super().velocity(node), node)

    def acceleration(self, node: Point) -> Array:
        """Give the acceleration of a point over time, see `Trajectory.acceleration`."""
        return self._lifted(super().acceleration(node), node)

    def slope(self, node: Point) -> Array:
        """Give the slope r' over time, see `Trajectory.slope`."""
        return self._lifted(super().slope(node), node)

    def reaction(self, node: Point) -> Array:
        """Give the force of joints at a node over time, see `Trajectory.reaction`."""
        return self._lifted(super().reaction(node), node)

    def __repr__(self) -> str:
        """Sum the run up, with what was predicted and measured."""
        lines = [super().__repr__()]
        predictions = self.plan.predictions if self.plan else ()
        for i, each in enumerate(predictions):
            line = f"  {each.wanted.quantity!r}: predicted error {each.error:.1e}"
            if self.measured:
                line += f", measured {self.measured[i]:.1e}"
            lines.append(f"{line} {each.wanted.quantity.unit}".rstrip())
        return "\n".join(lines)
