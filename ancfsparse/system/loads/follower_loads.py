"""Follower forces: points and section axes as linear functions of coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Integers, Vector
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.kernels.hermite import position_weights, slope_weights

NODAL_VECTORS = ("r", "r_x", "r_y", "r_z")
"""Nodal vectors that a point and the axes of its section depend on, in space."""


@dataclass(frozen=True)
class Follower:
    """Forces along the axes of n sections.

    Attributes
    ----------
    place : (n, width, dim) int32
        Indices of the vectors that they depend on.
    weight : (n, 1 + n_axes, width) float
        Their weights in the position, and in each of the axes.
    column : (n, dim) int32
        Amplitudes along the axes, -1 without a component.
    factor : (n,) float
        Factors of the amplitudes.
    """

    place: Integers
    weight: Vector
    column: Integers
    factor: Vector

    @staticmethod
    def join(parts: Sequence[Follower]) -> Follower:
        """Join blocks with different numbers of vectors or axes."""
        width = max(each.place.shape[1] for each in parts)
        sums = max(each.weight.shape[1] for each in parts)
        places, weights = [], []
        for each in parts:
            more = width - each.place.shape[1]
            places.append(np.concatenate([each.place, each.place[:, :1].repeat(more, 1)], axis=1))
            missing = (0, 0), (0, sums - each.weight.shape[1]), (0, more)
            weights.append(np.pad(each.weight, missing))
        return Follower(
            np.ascontiguousarray(np.concatenate(places), dtype=np.int32),
            np.ascontiguousarray(np.concatenate(weights)),
            np.ascontiguousarray(np.concatenate([each.column for each in parts]), dtype=np.int32),
            np.concatenate([each.factor for each in parts]),
        )


def follower_at_node(
    kind: ElementKind, row: Integers, offsets: Sequence[float] = ()
) -> tuple[Integers, Vector]:
    """Return indices (1, width, dim) and weights (1, 1 + n_axes, width) at a node.

    Parameters
    ----------
    kind : ElementKind
        The element type.
    row : (n_c,) int32
        Indices of its coordinates.
    offsets : sequence of float, optional
        Coordinates of a point of a rigid body, or off the axis of a beam [m].
    """
    names = _vector_names(kind)
    place = np.stack([row[kind.columns(name)] for name in names])
    weight = np.eye(len(names))[: 1 + _count_axes(kind)]
    weight[0, 1 : 1 + len(offsets)] = offsets
    return place[None], weight[None]


def follower_inside(
    kind: ElementKind, ends: Integers, xi: Vector, lengths: Vector, offsets: Sequence[float] = ()
) -> tuple[Integers, Vector]:
    """Return indices (n, width, dim) and weights (n, 1 + n_axes, width) inside elements.

    Parameters
    ----------
    kind : ElementKind
        The element.
    ends : (n, 2, n_c) int32
        Indices of the coordinates of both nodes.
    xi : (n,) float
        Relative positions in the elements, from 0 to 1.
    lengths : (n,) float
        Lengths of the elements [m].
    offsets : sequence of float, optional
        Offsets from the axis along r_x, r_y and r_z [m].
    """
    names = _vector_names(kind)
    k = len(names)
    place = np.stack([ends[:, end, kind.columns(name)] for end in (0, 1) for name in names], axis=1)
    weight = np.zeros((len(ends), 1 + _count_axes(kind), 2 * k))
    axis = [end * k + column for end in (0, 1) for column in range(len(kind.axis))]
    weight[:, 0, axis] = position_weights(xi, lengths, kind.is_string)
    weight[:, 1, axis] = slope_weights(xi, lengths, kind.is_string)
    for row in range(2, weight.shape[1]):  # section vectors are linear along an element
        weight[:, row, row], weight[:, row, k + row] = 1.0 - xi, xi
    for column, offset in enumerate(offsets[1:], 2):
        weight[:, 0, column], weight[:, 0, k + column] = (1.0 - xi) * offset, xi * offset
    return place, weight


def _vector_names(kind: ElementKind) -> list[str]:
    """Return the names of the nodal vectors; in the plane r_z is a scalar and not among them."""
    return [name for name in NODAL_VECTORS[: 1 + kind.dim] if name in kind.vectors]


def _count_axes(kind: ElementKind) -> int:
    """Return the number of vectors that define the axes of a section: in the plane one."""
    return 1 if kind.dim == 2 else max(1, sum(name in kind.vectors for name in NODAL_VECTORS[1:]))
