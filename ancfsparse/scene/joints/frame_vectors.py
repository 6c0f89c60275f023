"""Points and directions at joints as sums of coordinates, and equations between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ancfsparse.errors import InputError
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.joints.joint import LINEAR, Builder, Coordinates, Vector

# A direction whose components are within this of those of a vector of a frame is that vector.
ALIGNED = 1e-12
# Share of a direction outside the span of the vectors of a node that is taken for rounding.
OFF = 1e-9


@dataclass(frozen=True)
class Sum:
    """A vector that is linear in coordinates: ``constant + sum of w q``, component by component.

    Attributes
    ----------
    terms : tuple of dict from int to float
        Per component the weight of each coordinate.
    constant : (dim,) float
        The part that is fixed in space.
    whole : (dim,) int or None
        The coordinates that it consists of, if it is just these.
    """

    terms: tuple[dict[int, float], ...]
    constant: Vector
    whole: Coordinates | None = None

    @classmethod
    def fixed(cls, vector: Vector) -> Sum:
        """Return a vector that stays as it is."""
        return cls(tuple({} for _ in vector), np.asarray(vector, dtype=float))

    @classmethod
    def of(cls, vectors: Sequence[Coordinates], weights: Sequence[float]) -> Sum:
        """Return a weighted sum of vectors of coordinates."""
        used = [(v, w) for v, w in zip(vectors, weights, strict=True) if w != 0.0]
        dim = len(vectors[0])
        terms = tuple({int(v[d]): float(w) for v, w in used} for d in range(dim))
        alone = len(used) == 1 and used[0][1] == 1.0
        return cls(terms, np.zeros(dim), used[0][0] if alone else None)

    def turned(self) -> Sum:
        """Return the vector rotated by +90 degrees in the plane."""
        x, y = self.terms
        constant = np.array([-self.constant[1], self.constant[0]])
        return Sum(({k: -w for k, w in y.items()}, x), constant)

    def component(self, along: Vector) -> Coordinates | None:
        """Return the coordinate (1,) that is the component along a unit vector; None if none is."""
        d = int(np.argmax(np.abs(along)))
        if self.whole is None or np.abs(np.delete(along, d)).max() > ALIGNED:
            return None
        return self.whole[[d]]

    def __sub__(self, other: Sum) -> Sum:
        """Return the difference of two."""
        terms = []
        for mine, its in zip(self.terms, other.terms, strict=True):
            both = dict(mine)
            for k, w in its.items():
                both[k] = both.get(k, 0.0) - w
            terms.append(both)
        return Sum(tuple(terms), self.constant - other.constant)


def point(builder: Builder, node: Point) -> Sum:
    """Return the position of a point."""
    places, weights = builder.point(node)
    return Sum.of(list(places.T), weights.tolist())


def row_of(builder: Builder, node: Point) -> Coordinates:
    """Return the coordinates of a node that has one slope, (n_c,).

    Raises
    ------
    InputError
        If lines of a mesh that turn against each other meet there.
    """
    rows = builder.rows(node)
    if len(rows) > 1:
        raise InputError(
            f"a joint needs a direction at {node!r}, which has {len(rows)} slopes, one for each "
            "line through it: take a node on an edge beside it, mesh.at(edge, s) with n_elements=2 "
            "or more"
        )
    row: Coordinates = rows[0]
    return row


def vectors_of(builder: Builder, node: Point) -> list[Coordinates]:
    """Return the coordinates of the vectors of a node, each (dim,)."""
    row, dim = row_of(builder, node), node.beam.dim
    width = (len(row) // dim - 1) * dim
    return list(row[dim : dim + width].reshape(-1, dim))


def direction(builder: Builder, node: Point, vector: Vector) -> Sum:
    """Return the direction that is `vector` in the reference shape and rotates with a node.

    In the plane one vector is a frame; in space it gives only the directions along it.
    """
    own = vectors_of(builder, node)
    frame = frame_at(node)[: len(own)]
    if len(frame) == 1 and node.beam.dim == 2:
        size = float(frame[0] @ frame[0])
        along = float(vector @ frame[0]) / size
        beside = float(frame[0, 0] * vector[1] - frame[0, 1] * vector[0]) / size
        u = Sum.of(own, [1.0])
        weights = np.array([along, beside])
        if abs(beside) > ALIGNED:
            return _mixed(u, along, u.turned(), beside)
    else:
        weights = np.linalg.lstsq(frame.T, vector, rcond=None)[0]
    weights[np.abs(weights) <= ALIGNED] = 0.0
    weights[np.abs(weights - 1.0) <= ALIGNED] = 1.0
    found = Sum.of(own, weights[: len(own)].tolist())
    # The slopes of beams change their length: what they share is a direction.
    return replace(found, whole=None) if node.beam.n_elements else found


def frame_at(node: Point) -> Vector:
    """Return the vectors of a node in the reference shape, (k, dim)."""
    every = node.beam.vectors
    row = 0 if len(every) == 1 else node.beam.rows_of(node.index).start
    return np.asarray(every[row])


def spans(node: Point, vector: Vector) -> bool:
    """Whether the vectors of a node span a direction."""
    if node.beam.kind.is_string:
        return False
    frame = frame_at(node)[: (len(node.beam.kind.node_coordinates) // node.beam.dim) - 1]
    if node.beam.dim == 2:
        return True
    weights = np.linalg.lstsq(frame.T, vector, rcond=None)[0]
    return bool(np.linalg.norm(frame.T @ weights - vector) <= OFF * np.linalg.norm(vector))


def _mixed(one: Sum, a: float, other: Sum, b: float) -> Sum:
    terms = []
    for mine, its in zip(one.terms, other.terms, strict=True):
        both = {k: a * w for k, w in mine.items()}
        for k, w in its.items():
            both[k] = both.get(k, 0.0) + b * w
        terms.append(both)
    return Sum(tuple(terms), a * one.constant + b * other.constant)


def is_one(one: Sum, other: Sum) -> bool:
    """Whether two vectors can be identified by numbering."""
    return one.whole is not None and (other.whole is not None or not any(other.terms))


def same(
    builder: Builder, label: str, one: Sum, other: Sum, size: float, factor: float = 1.0
) -> None:
    """Make two vectors equal: by numbering where both are coordinates, else by linear equations.

    The rounding of their components is that of a size [m].
    """
    if one.whole is not None and other.whole is not None:
        builder.share(one.whole, other.whole)
        return
    for whole, rest in ((one.whole, other), (other.whole, one)):
        if whole is not None and not any(rest.terms):
            builder.fix(whole)
            return
    apart = one - other
    for d, terms in enumerate(apart.terms):
        linear = ((factor * w, k, LINEAR) for k, w in terms.items())
        name = f"{label}, component {d + 1}"
        builder.equation(name, factor * float(apart.constant[d]), *linear, size=size)


def across(builder: Builder, label: str, one: Sum, other: Sum, factor: float) -> None:
    """Hold two vectors at a right angle: ``factor one . other = 0``, the factor in metres."""
    offset, size, terms = 0.0, factor, []
    pairs = zip(one.terms, other.terms, one.constant, other.constant, strict=True)
    for mine, its, c, e in pairs:
        offset += factor * float(c * e)
        size += abs(factor * float(c * e))
        terms += [(factor * w * float(e), k, LINEAR) for k, w in mine.items() if e != 0.0]
        terms += [(factor * w * float(c), k, LINEAR) for k, w in its.items() if c != 0.0]
        terms += [(factor * w * x, k, j) for k, w in mine.items() for j, x in its.items()]
    builder.equation(label, offset, *terms, size=size)
