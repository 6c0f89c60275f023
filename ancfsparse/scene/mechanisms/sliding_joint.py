"""Slides: a point stays on the axis of a beam or a line of a mesh, without friction along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.kinematics.linear_forms import Coordinates, Vector
from ancfsparse.scene.kinematics.sliding_curve import CurveOffset, SlidingCurve


@dataclass(frozen=True, eq=False)
class Slide(Joint):
    """Keep a point on the axis of a beam or a line of a mesh, from element to element.

    Attributes
    ----------
    point : Point
        The point.
    along : Beam or Mesh
        The beam, or the mesh of which the point is on a line.
    elements : (n,) int
        Its elements, or those of the line, one after the other.
    lateral : (dim,) ndarray
        In space a direction that the axis must not turn to.
    """

    point: Point
    along: ElasticBody
    elements: NDArray[np.intp]
    lateral: Vector
    name = "slide"

    def lower(self, builder: ConstraintBuilder) -> None:
        """State ``n . (p - r(s*)) = 0`` for each normal."""
        body = self.along
        kind = builder.kind(body.node(0))
        rows = np.array([self._row(builder, row) for row in self._rows])
        pairs = [rows[:, kind.columns(name)] for name in ("r", "r_x")]
        ends = np.stack([each[part] for part in (slice(-1), slice(1, None)) for each in pairs], 1)
        places, weights = builder.point(self.point)
        track = SlidingCurve(ends, body.lengths[self.elements], places, weights, self.lateral)
        for k in range(body.dim - 1):
            label = self.label + (f", normal {k + 1}" if body.dim == 3 else "")
            builder.equation(label, 0.0, measures=[(1.0, CurveOffset(track, k))])

    @property
    def _rows(self) -> list[int]:
        """Rows of the body along the axis."""
        ends = self.along.ends[self.elements]
        return [int(ends[0, 0]), *ends[:, 1].tolist()]

    def _row(self, builder: ConstraintBuilder, row: int) -> Coordinates:
        node = int(self.along.row_nodes[row])
        first = self.along.rows_of(node).start
        return np.asarray(builder.rows(self.along.node(node))[row - first])

    @property
    def nodes(self) -> tuple[Point, ...]:
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


def elements_under(point: Point, along: ElasticBody) -> NDArray[np.intp]:
    """Return the elements of the line that a point is on, one after the other.

    At a crossing the line goes straight on, as its slope does.

    Raises
    ------
    InputError
        If the lines of a mesh are closed there, so that none of its elements is the first.
    """
    ends = along.ends
    begin, end = (along.positions[along.row_nodes[ends[:, k]]] for k in (0, 1))
    way = end - begin
    share = np.einsum("ed,ed->e", point.position - begin, way) / np.einsum("ed,ed->e", way, way)
    nearest = begin + np.clip(share, 0.0, 1.0)[:, None] * way
    here = int(np.argmin(np.linalg.norm(point.position - nearest, axis=1)))
    after = dict(zip(ends[:, 0].tolist(), range(len(ends)), strict=True))
    before = dict(zip(ends[:, 1].tolist(), range(len(ends)), strict=True))
    first = here
    while (previous := before.get(int(ends[first, 0]))) is not None:
        first = previous
        if first == here:
            raise InputError(
                f"{point!r} is on a closed line of {along.name}, which has no start to count from: "
                "leave out one of its edges, or let it slide along a beam"
            )
    line = [first]
    while (following := after.get(int(ends[line[-1], 1]))) is not None:
        line.append(following)
    return np.array(line)
