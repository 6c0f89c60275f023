"""Points and directions at joints as linear forms, and equations between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ancfsparse.array_types import Integers, Vector
from ancfsparse.errors import InputError
from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.kinematics.linear_forms import (
    COMPONENT_TOLERANCE,
    LINEAR,
    LinearForm,
    linear_combination,
)


def point(builder: ConstraintBuilder, end: Point | Vector) -> LinearForm:
    """Return the position of a point of a body, or of one that is fixed in space."""
    if not isinstance(end, Point):
        return LinearForm.fixed(end)
    indices, weights = builder.point(end)
    return LinearForm.of(list(indices.T), weights.tolist())


def row_of(builder: ConstraintBuilder, node: Point) -> Integers:
    """Return the coordinates of a node that has one slope, (n_c,).

    Raises
    ------
    InputError
        If several lines of a mesh meet there, which rotate independently.
    """
    rows = builder.rows(node)
    if len(rows) > 1:
        raise InputError(
            f"a joint needs a direction at {node!r}, which has {len(rows)} slopes, one for each "
            "line through it: take a neighbouring node on an edge, mesh.at(edge, s) with "
            "n_elements=2 or more"
        )
    row: Integers = rows[0]
    return row


def vectors_of(builder: ConstraintBuilder, node: Point) -> list[Integers]:
    """Return the coordinates of the slope and section vectors of a node, each (dim,)."""
    row, dim = row_of(builder, node), node.beam.dim
    width = (len(row) // dim - 1) * dim
    return list(row[dim : dim + width].reshape(-1, dim))


def direction(builder: ConstraintBuilder, node: Point | None, vector: Vector) -> LinearForm:
    """Return the direction that is `vector` in the reference shape and rotates with a node.

    Without a node it is fixed in space.

    In the plane one vector defines a frame; in space it defines only its own direction.
    """
    if node is None:
        return LinearForm.fixed(vector)
    vectors = vectors_of(builder, node)
    frame = node.frame[: len(vectors)]
    if len(frame) == 1 and node.beam.dim == 2:
        size = float(frame[0] @ frame[0])
        along = float(vector @ frame[0]) / size
        normal = float(frame[0, 0] * vector[1] - frame[0, 1] * vector[0]) / size
        u = LinearForm.of(vectors, [1.0])
        weights = np.array([along, normal])
        if abs(normal) > COMPONENT_TOLERANCE:
            return linear_combination(u, along, u.rotated(), normal)
    else:
        weights = np.linalg.lstsq(frame.T, vector, rcond=None)[0]
    weights[np.abs(weights) <= COMPONENT_TOLERANCE] = 0.0
    weights[np.abs(weights - 1.0) <= COMPONENT_TOLERANCE] = 1.0
    form = LinearForm.of(vectors, weights[: len(vectors)].tolist())
    # The slopes of beams change their length, so only their direction can be identified.
    return replace(form, coordinates=None) if node.beam.n_elements else form


def can_identify(one: LinearForm, other: LinearForm) -> bool:
    """Return True if two vectors can be made equal without equations."""
    return one.coordinates is not None and (other.coordinates is not None or not any(other.terms))


def equate(
    builder: ConstraintBuilder,
    label: str,
    one: LinearForm,
    other: LinearForm,
    size: float,
    factor: float = 1.0,
) -> None:
    """Make two vectors equal: identify coordinates if possible, else add linear equations.

    The magnitude `size` of their components [m] determines the rounding error.
    """
    if one.coordinates is not None and other.coordinates is not None:
        builder.share(one.coordinates, other.coordinates)
        return
    for coordinates, rest in ((one.coordinates, other), (other.coordinates, one)):
        if coordinates is not None and not any(rest.terms):
            builder.fix(coordinates)
            return
    difference = one - other
    for d, terms in enumerate(difference.terms):
        linear = ((factor * w, k, LINEAR) for k, w in terms.items())
        name = f"{label}, component {d + 1}"
        builder.equation(name, factor * float(difference.constant[d]), *linear, size=size)


def make_orthogonal(
    builder: ConstraintBuilder, label: str, one: LinearForm, other: LinearForm, factor: float
) -> None:
    """Add the equation ``factor one . other = 0``, with a factor in metres."""
    offset, size, terms = 0.0, factor, []
    pairs = zip(one.terms, other.terms, one.constant, other.constant, strict=True)
    for first, second, c, e in pairs:
        offset += factor * float(c * e)
        size += abs(factor * float(c * e))
        terms += [(factor * w * float(e), k, LINEAR) for k, w in first.items() if e != 0.0]
        terms += [(factor * w * float(c), k, LINEAR) for k, w in second.items() if c != 0.0]
        terms += [(factor * w * x, k, j) for k, w in first.items() for j, x in second.items()]
    builder.equation(label, offset, *terms, size=size)
