"""Sliding joints: a point stays on the axis of a beam or a line of a mesh without friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Integers, Vector
from ancfsparse.errors import InputError
from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.kinematics.sliding_curve import CurveOffset, SlidingCurve


@dataclass(frozen=True, eq=False)
class Slide(Joint):
    """Keep a point on the axis of a beam or a line of a mesh, from element to element.

    Attributes
    ----------
    point, along
        As in `Scene.slide`.
    elements : (n,) int
        Its elements, or the elements of the line, in order.
    lateral : (dim,) ndarray
        Direction in space to which the axis must not become parallel.
    """

    point: Point
    along: ElasticBody
    elements: NDArray[np.intp]
    lateral: Vector
    name = "slide"
    has_multipliers = True

    def lower(self, builder: ConstraintBuilder) -> None:
        """Add the equation ``n . (p - r(s*)) = 0`` for each normal."""
        body = self.along
        kind = builder.kind(body.node(0))
        rows = np.array([self._row(builder, row) for row in self._rows])
        pairs = [rows[:, kind.columns(name)] for name in ("r", "r_x")]
        ends = np.stack([pair[part] for part in (slice(-1), slice(1, None)) for pair in pairs], 1)
        indices, weights = builder.point(self.point)
        curve = SlidingCurve(ends, body.lengths[self.elements], indices, weights, self.lateral)
        for k in range(body.dim - 1):
            label = self.label + (f", normal {k + 1}" if body.dim == 3 else "")
            builder.equation(label, 0.0, measures=[(1.0, CurveOffset(curve, k))])

    @property
    def _rows(self) -> list[int]:
        """Rows of the body along the axis."""
        ends = self.along.ends[self.elements]
        return [int(ends[0, 0]), *ends[:, 1].tolist()]

    def _row(self, builder: ConstraintBuilder, row: int) -> Integers:
        node = int(self.along.row_nodes[row])
        first = self.along.rows_of(node).start
        return np.asarray(builder.rows(self.along.node(node))[row - first])

    @property
    def label(self) -> str:
        """Name in messages."""
        return f"slide of {self.point!r} along {self.along.name}"


def elements_under(point: Point, along: ElasticBody) -> NDArray[np.intp]:
    """Return the elements of the line through a point, in order.

    At a crossing the line continues straight, as its slope does.

    Raises
    ------
    InputError
        If the line is closed, so that no element is the first.
    """
    ends = along.ends
    begin, end = (along.positions[along.row_nodes[ends[:, k]]] for k in (0, 1))
    chord = end - begin
    squares = np.einsum("ed,ed->e", chord, chord)
    xi = np.einsum("ed,ed->e", point.position - begin, chord) / squares
    nearest = begin + np.clip(xi, 0.0, 1.0)[:, None] * chord
    start = int(np.argmin(np.linalg.norm(point.position - nearest, axis=1)))
    after = dict(zip(ends[:, 0].tolist(), range(len(ends)), strict=True))
    before = dict(zip(ends[:, 1].tolist(), range(len(ends)), strict=True))
    first = start
    while (previous := before.get(int(ends[first, 0]))) is not None:
        first = previous
        if first == start:
            raise InputError(
                f"{point!r} is on a closed line of {along.name}, which has no start to count from: "
                "leave out one of its edges, or let it slide along a beam"
            )
    line = [first]
    while (following := after.get(int(ends[line[-1], 1]))) is not None:
        line.append(following)
    return np.array(line)
