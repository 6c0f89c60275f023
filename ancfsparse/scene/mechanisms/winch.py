"""Winches: an inextensible massless rope over points without friction."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.kinematics.linear_forms import RheonomicTerm
from ancfsparse.scene.mechanisms.coordinate_functions import distance, joint_coordinate
from ancfsparse.scene.records.prescribed_motion import PrescribedMotion


@dataclass(frozen=True, eq=False)
class Winch(Joint):
    """Keep or prescribe the length of a rope over points, which a drum may wind up.

    Attributes
    ----------
    points, drum, radius
        As in `Scene.winch`.
    length : float
        Length of the rope in the reference shape [m].
    motion : PrescribedMotion, optional
        Prescribed length over time, if it changes.
    """

    points: tuple[Point | Vector, ...]
    length: float
    motion: PrescribedMotion | None = None
    drum: Joint | None = None
    radius: float = 0.0
    name = "winch"
    constrains_directions = False
    has_multipliers = True
    is_rope = True

    def lower(self, builder: ConstraintBuilder) -> None:
        """Add ``sum of d_i + radius angle - l = 0``, whose multiplier is the tension."""
        fixed, coordinates = 0.0, []
        for one, other in pairwise(self.points):
            if isinstance(one, Point) or isinstance(other, Point):
                coordinates.append((1.0, distance(builder, one, other)))
            else:
                fixed += float(np.linalg.norm(one - other))
        if self.drum is not None:
            coordinates.append((self.radius, joint_coordinate(builder, self.drum, "angle")))
        rheonomic = None if self.motion is None else RheonomicTerm(self.motion, 0)
        offset = fixed - (self.length if rheonomic is None else 0.0)
        builder.equation(
            self.label, offset, measures=coordinates, size=self.length, rheonomic=rheonomic
        )

    @property
    def nodes(self) -> tuple[Point, ...]:
        """The points of bodies, and the points of the drum."""
        more = () if self.drum is None else self.drum.nodes
        return *(end for end in self.points if isinstance(end, Point)), *more

    @property
    def links(self) -> tuple[tuple[Point | Vector, Point | Vector], ...]:
        """The lines from point to point."""
        return tuple(pairwise(self.points))
