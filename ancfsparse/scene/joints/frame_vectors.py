"""Points and directions at joints as sums of coordinates, and equations between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ancfsparse.errors import InputError
from ancfsparse.scene.bodies.body import LINEAR, ConstraintBuilder, Point
from ancfsparse.scene.kinematics.linear_forms import (
    ALIGNED,
    Coordinates,
    LinearForm,
    Vector,
    _mixed,
)


def point(builder: ConstraintBuilder, node: Point) -> LinearForm:
    """Return the position of a point."""
    places, weights = builder.point(node)
    return LinearForm.of(list(places.T), weights.tolist())


def row_of(builder: ConstraintBuilder, node: Point) -> Coordinates:
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


def vectors_of(builder: ConstraintBuilder, node: Point) -> list[Coordinates]:
    """Return the coordinates of the vectors of a node, each (dim,)."""
    row, dim = row_of(builder, node), node.beam.dim
    width = (len(row) // dim - 1) * dim
    return list(row[dim : dim + width].reshape(-1, dim))


def direction(builder: ConstraintBuilder, node: Point, vector: Vector) -> LinearForm:
    """Return the direction that is `vector` in the reference shape and rotates with a node.

    In the plane one vector is a frame; in space it gives only the directions along it.
    """
    own = vectors_of(builder, node)
    frame = node.frame[: len(own)]
    if len(frame) == 1 and node.beam.dim == 2:
        size = float(frame[0] @ frame[0])
        along = float(vector @ frame[0]) / size
        beside = float(frame[0, 0] * vector[1] - frame[0, 1] * vector[0]) / size
        u = LinearForm.of(own, [1.0])
        weights = np.array([along, beside])
        if abs(beside) > ALIGNED:
            return _mixed(u, along, u.turned(), beside)
    else:
        weights = np.linalg.lstsq(frame.T, vector, rcond=None)[0]
    weights[np.abs(weights) <= ALIGNED] = 0.0
    weights[np.abs(weights - 1.0) <= ALIGNED] = 1.0
    found = LinearForm.of(own, weights[: len(own)].tolist())
    # The slopes of beams change their length: what they share is a direction.
    return replace(found, whole=None) if node.beam.n_elements else found


def is_one(one: LinearForm, other: LinearForm) -> bool:
    """Whether two vectors can be identified by numbering."""
    return one.whole is not None and (other.whole is not None or not any(other.terms))


def same(
    builder: ConstraintBuilder,
    label: str,
    one: LinearForm,
    other: LinearForm,
    size: float,
    factor: float = 1.0,
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


def across(
    builder: ConstraintBuilder, label: str, one: LinearForm, other: LinearForm, factor: float
) -> None:
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
