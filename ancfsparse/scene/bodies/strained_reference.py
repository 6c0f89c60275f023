"""Stress-free coordinates of elements with eigenstrain."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.kernels.hermite import slope_weights

GAUSS_POINTS = 10  # of the chord of an element, exact to rounding for rotations of a radian


def strained_ends(kind: ElementKind, ends: Vector, lengths: Vector, eigen: Vector) -> Vector:
    """Return the coordinates of both nodes of elements with their eigenstrain.

    Parameters
    ----------
    kind : ElementKind
        The element.
    ends : (n, 2, n_c) float
        Coordinates of both nodes without eigenstrain.
    lengths : (n,) float
        Lengths of the elements [m].
    eigen : (n, 2) float or, in space, (n, 3)
        Axial strain [-], and curvature [1/m] in the plane, or about e_y and e_z.

    Returns
    -------
    (n, 2, n_c) float
        The coordinates of elements of constant curvature.
    """
    out = np.array(ends)
    half, spin = 0.5 * lengths, _curvature_vectors(kind, ends, eigen)
    for end, sign in ((0, -1.0), (1, 1.0)):
        for name in kind.vectors[1:]:
            columns, axes = kind.columns(name), kind.directions(name)
            vector = np.zeros((len(ends), 3))
            vector[:, axes] = ends[:, end, columns]
            turned = _rotate(vector, (sign * half)[:, None] * spin)
            factor = 1.0 + eigen[:, :1] if name == "r_x" else 1.0
            out[:, end, columns] = (factor * turned)[:, axes]
    places, slopes = kind.columns("r"), kind.columns("r_x")
    axes = kind.directions("r")
    cubic = np.stack([ends[:, e, c] for e in (0, 1) for c in (places, slopes)], axis=1)
    points, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    chord = np.zeros((len(ends), 3))
    for point, weight in zip(points, weights, strict=True):
        slope = np.zeros((len(ends), 3))
        slope_shape = slope_weights(np.full(len(ends), 0.5 * (1.0 + point)), lengths)
        slope[:, axes] = np.einsum("nk,nkd->nd", slope_shape, cubic)
        chord += (weight * half)[:, None] * _rotate(slope, (point * half)[:, None] * spin)
    chord *= 1.0 + eigen[:, :1]
    out[:, 0, places], out[:, 1, places] = -0.5 * chord[:, axes], 0.5 * chord[:, axes]
    return out


def _curvature_vectors(kind: ElementKind, ends: Vector, eigen: Vector) -> Vector:
    """Return the curvature vector of every element in space, (n, 3) [1/m]."""
    spin = np.zeros((len(ends), 3))
    if kind.dim == 2:
        spin[:, 2] = eigen[:, 1]
        return spin
    for k, name in ((1, "r_y"), (2, "r_z")):
        axis = ends[:, :, kind.columns(name)].sum(axis=1)
        spin += eigen[:, k : k + 1] * axis / np.linalg.norm(axis, axis=1, keepdims=True)
    return spin


def _rotate(vectors: Vector, angles: Vector) -> Vector:
    """Rotate vectors (n, 3) by rotation vectors (n, 3) [rad], by Rodrigues' formula."""
    size = np.linalg.norm(angles, axis=1, keepdims=True)
    axis = np.divide(angles, size, out=np.zeros_like(angles), where=size > 0.0)
    along = np.sum(axis * vectors, axis=1, keepdims=True)
    across = np.cross(axis, vectors)
    return np.asarray(
        np.cos(size) * vectors + np.sin(size) * across + (1.0 - np.cos(size)) * along * axis
    )
