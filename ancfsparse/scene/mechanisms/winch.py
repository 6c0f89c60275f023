"""Winches: a massless rope over points without friction, of a length that is kept or changes."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ancfsparse.scene.bodies.body import ConstraintBuilder, Point, RheonomicTerm
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.kinematics.linear_forms import Vector
from ancfsparse.scene.mechanisms.coordinate_functions import distance, joint_coordinate
from ancfsparse.scene.records.prescribed_motion import PrescribedMotion


@dataclass(frozen=True, eq=False)
class Winch(Joint):
    """Keep or prescribe the sum of the distances of consecutive points; a drum may wind it.

    Attributes
    ----------
    points : tuple of Point or (dim,) ndarray
        Points of bodies and beams, or fixed in space [m].
    length : float
        Of the rope in the reference shape [m].
    motion : PrescribedMotion, optional
        Its length over time, where it changes.
    drum : Joint, optional
        A hinge whose angle winds the rope up.
    radius : float
        Of the drum [m].
    """

    points: tuple[Point | Vector, ...]
    length: float
    motion: PrescribedMotion | None = None
    drum: Joint | None = None
    radius: float = 0.0
    name = "winch"

    def lower(self, builder: ConstraintBuilder) -> None:
        """State ``sum of d_i + radius angle - l = 0``, whose multiplier is the tension."""
        fixed, measures = 0.0, []
        for one, other in pairwise(self.points):
            if isinstance(one, Point) or isinstance(other, Point):
                measures.append((1.0, distance(builder, one, other)))
            else:
                fixed += float(np.linalg.norm(one - other))
        if self.drum is not None:
            measures.append((self.radius, joint_coordinate(builder, self.drum, "angle")))
        rheonomic = None if self.motion is None else RheonomicTerm(self.motion, 0)
        offset = fixed - (self.length if rheonomic is None else 0.0)
        builder.equation(
            self.label, offset, measures=measures, size=self.length, rheonomic=rheonomic
        )

    @property
    def nodes(self) -> tuple[Point, ...]:
        """The points that are not fixed, and those of the drum."""
        more = () if self.drum is None else self.drum.nodes
        return *(each for each in self.points if isinstance(each, Point)), *more

    @property
    def links(self) -> tuple[tuple[Point | Vector, Point | Vector], ...]:
        """The lines from point to point."""
        return tuple(pairwise(self.points))

    @property
    def has_multipliers(self) -> bool:
        """Whether it is made by an equation: always."""
        return True
