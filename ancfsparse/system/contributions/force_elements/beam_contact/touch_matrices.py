"""Matrices of beams that touch each other, in equilibria and in modes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ancfsparse.array_types import Integers, Vector
from ancfsparse.kernels.hermite import bend_weights, position_weights, slope_weights
from ancfsparse.system.contributions.force_elements.beam_contact.compiled_interface import (
    CompiledBeamContact,
)

# Cosine of the angle of normal and axis at a foot, above which that is at a free end: others are
# found to rounding.
AT_END_RATIO = 1e-6
# Distance of a point from the centre of curvature of the other axis, over the radius of curvature:
# nearer ones have no force (geometry/side_weights.pxi), and no foot that slides at a finite rate.
MIN_CURVATURE_DISTANCE = 0.1


class TouchMatrices:
    """Sparse matrices, over all coordinates, of the points at which beams touch in a state.

    Each method returns None if no point contributes to its matrix.

    Parameters
    ----------
    lengths : (n,) float
        Lengths of the elements [m].
    compiled : CompiledBeamContact
        The forces of the contact.
    indices : (n, 4, dim) int array
        Coordinates of position and slope at both ends of each element.
    straight : (n,) int array
        Whether an element is straight, without slopes.
    """

    def __init__(
        self,
        lengths: Vector,
        compiled: CompiledBeamContact,
        indices: Integers,
        straight: Integers,
    ) -> None:
        self._compiled, self._indices, self._lengths = compiled, indices, lengths
        self._is_straight = straight.astype(bool)

    def sliding_friction(self, q: Vector) -> Any:
        """Return the derivative of friction that slides by the normal forces of its pairs."""
        import scipy.sparse as sp

        elements, weights, _, sliding = self._compiled.bristles(np.ascontiguousarray(q))
        if not sliding.any():
            return None
        touching, positions, force, depths = self._touches(q)
        pairs = {tuple(pair): k for k, pair in enumerate(elements.tolist())}
        rows = [pairs[min(pair), max(pair)] for pair in touching.tolist()]
        points, feet = self._sums(touching, positions, position_weights, len(q))
        normals = force / depths[:, None]  # times the stiffness of each point
        sums = sp.csr_array((np.ones(len(rows)), (rows, range(len(rows)))),
                            shape=(len(elements), len(rows)))  # fmt: skip
        distances = sums @ (_block_diagonal(normals[:, None, :]) @ (points - feet))
        one, other = (self._point_matrix(elements[:, k], weights[:, k], len(q)) for k in (0, 1))
        return (one - other).T @ _block_diagonal(sliding[:, :, None]) @ distances

    def approaches(self, q: Vector) -> Any:
        """Return the directions of approach of all points in contact."""
        elements, positions, force, _ = self._touches(q)
        if not len(elements):
            return None
        points, feet = self._sums(elements, positions, position_weights, len(q))
        return _block_diagonal(_unit(force)[:, None, :]) @ (points - feet)

    def rotation(self, q: Vector) -> Any:
        """Return the stiffness by the rotation of the normals and by feet that slide.

        The distance d(u) of a point from all points u of the other axis has the minimum d.  With
        its derivatives ``d_uu`` and ``d_uq`` in the foot, the stiffness is ``-F d_qq`` with
        ``d_qq = (1 - n n^T) / d - d_uq d_uq^T / d_uu`` for a force F.  Feet at free ends do not
        slide.
        """
        elements, positions, force, _ = self._touches(q)
        if not len(elements):
            return None
        points, feet = self._sums(elements, positions, position_weights, len(q))
        slopes, bends = (
            self._sums(elements, positions, weights, len(q))[1]
            for weights in (slope_weights, bend_weights)
        )
        gap, size, normals = points - feet, np.linalg.norm(force, axis=1), _unit(force)
        distances = np.linalg.norm((gap @ q).reshape(force.shape), axis=1)
        tangents, curvatures = ((each @ q).reshape(force.shape) for each in (slopes, bends))
        across = np.eye(force.shape[1]) - normals[:, :, None] * normals[:, None, :]
        turning = gap.T @ _block_diagonal((-size / distances)[:, None, None] * across) @ gap
        squares = np.sum(tangents**2, axis=1)
        along = _block_diagonal((tangents / distances[:, None])[:, None, :])
        sliding = along @ gap + _block_diagonal(normals[:, None, :]) @ slopes
        ratio = 1.0 - distances * np.sum(normals * curvatures, axis=1) / squares
        rates = size * distances / (squares * np.maximum(ratio, MIN_CURVATURE_DISTANCE))
        rates[np.abs(np.sum(normals * tangents, axis=1)) > AT_END_RATIO * np.sqrt(squares)] = 0.0
        return turning + sliding.T @ _block_diagonal(rates[:, None, None]) @ sliding

    def bristles(self, q: Vector) -> Any:
        """Return the stiffness of bristles between elements, outside of steps."""
        elements, weights, blocks, _ = self._compiled.bristles(np.ascontiguousarray(q))
        if not len(elements):
            return None
        one, other = (self._point_matrix(elements[:, k], weights[:, k], len(q)) for k in (0, 1))
        between = one.T @ _block_diagonal(blocks) @ other
        return -between - between.T

    def between_elements(self, q: Vector) -> Any:
        """Return the stiffness between both elements of each point along its normal."""
        elements, positions, force, depths = self._touches(q)
        if not len(elements):
            return None
        points, feet = self._sums(elements, positions, position_weights, len(q))
        along = _block_diagonal(_unit(force)[:, None, :])
        stiffness = _block_diagonal((np.linalg.norm(force, axis=1) / depths)[:, None, None])
        between = (along @ points).T @ stiffness @ (along @ feet)
        return -between - between.T

    def _touches(self, q: Vector) -> tuple[Integers, Vector, Vector, Vector]:
        """Return the points that touch; none far from a solution, where the residual is NaN."""
        try:
            return self._compiled.touches(np.ascontiguousarray(q))
        except ValueError:
            dim = self._indices.shape[2]
            return np.empty((0, 2), np.int32), np.empty((0, 2)), np.empty((0, dim)), np.empty(0)

    def _sums(
        self,
        elements: Integers,
        positions: Vector,
        weights_at: Callable[..., Vector],
        n: int,
    ) -> list[Any]:
        """Return matrices (k dim, n) of points and of their feet, by weights of nodal values."""
        sides = []
        for side in (0, 1):
            at = positions[:, side], self._lengths[elements[:, side]]
            straight = self._is_straight[elements[:, side]]
            weights = weights_at(*at)
            weights[straight] = 0.0
            weights[straight, ::2] = weights_at(*at, straight=True)[straight]
            sides.append(self._point_matrix(elements[:, side], weights, n))
        return sides

    def _point_matrix(self, elements: Integers, weights: Vector, n: int) -> Any:
        """Return the matrix (k dim, n) of points by the weights (k, 4) of nodal values."""
        import scipy.sparse as sp

        dim, columns = self._indices.shape[2], self._indices[elements]
        rows = np.arange(len(elements) * dim).reshape(-1, 1, dim)
        values = np.repeat(weights[:, :, None], dim, axis=2)
        indices = np.broadcast_to(rows, columns.shape).ravel(), columns.ravel()
        return sp.csr_array((values.ravel(), indices), shape=(len(elements) * dim, n))


def _unit(vectors: Vector) -> Vector:
    """Return the unit vectors of rows."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1)[:, None])


def _block_diagonal(blocks: Vector) -> Any:
    """Return the sparse matrix of blocks (k, m, n) on its diagonal."""
    import scipy.sparse as sp

    k, m, n = blocks.shape
    indptr = np.arange(k + 1)
    return sp.bsr_array((blocks, indptr[:-1], indptr), shape=(k * m, k * n)).tocsr()
