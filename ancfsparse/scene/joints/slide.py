"""Slides: a point stays on the axis of a beam and moves along it without friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.scene.beams import Beam
from ancfsparse.scene.bodies import Node
from ancfsparse.scene.joints.joint import Builder, Joint, Vector
from ancfsparse.scene.joints.tracks import Offset, Track


@dataclass(frozen=True, eq=False)
class Slide(Joint):
    """Keep a point on the axis of a beam, from element to element.

    Attributes
    ----------
    point : Node
        The point.
    along : Beam
        The beam.
    lateral : (dim,) ndarray
        In space a direction that the axis must not turn to.
    """

    point: Node
    along: Beam
    lateral: Vector
    name = "slide"

    def lower(self, builder: Builder) -> None:
        """State ``n . (p - r(s*)) = 0`` for each normal."""
        kind = builder.kind(self.along.start)
        rows = np.array([builder.rows(self.along.node(k))[0] for k in range(self.along.n_nodes)])
        pairs = [rows[:, kind.columns(name)] for name in ("r", "r_x")]
        ends = np.stack([each[part] for part in (slice(-1), slice(1, None)) for each in pairs], 1)
        places, weights = builder.point(self.point)
        track = Track(ends, self.along.lengths, places, weights, self.lateral)
        for k in range(self.along.dim - 1):
            label = self.label + (f", normal {k + 1}" if self.along.dim == 3 else "")
            builder.equation(label, 0.0, measures=[(1.0, Offset(track, k))])

    @property
    def nodes(self) -> tuple[Node, ...]:
        """The point."""
        return (self.point,)

    @property
    def label(self) -> str:
        """Name in messages."""
        return f"slide of {self.point!r} along {self.along.name}"

    @property
    def has_multipliers(self) -> bool:
        """Whether it is made by equations: always."""
        return True
