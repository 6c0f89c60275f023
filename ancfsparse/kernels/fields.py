"""Fields of the elements at points on their axis, for many states and points at a time.

The compiled kernels integrate over elements; results need values at points, evaluated here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.kernels.hermite import bend_weights, position_weights, slope_weights


@dataclass(frozen=True)
class Points:
    """Points on elements.

    Parameters
    ----------
    kind : ElementKind
        The element.
    ends : ndarray, shape (k, p, 2 n_c)
        Coordinates of both nodes of the element that a point is on, in every state.
    xi : ndarray, shape (p,)
        Places within the elements, from 0 to 1 [-].
    length : ndarray, shape (p,)
        Lengths of the elements [m].
    """

    kind: ElementKind
    ends: Vector
    xi: Vector
    length: Vector

    @property
    def r(self) -> Vector:
        """Positions, shape (k, p, 3) [m]; in the plane z is zero."""
        return self._sum(position_weights(self.xi, self.length, self.kind.is_string))

    @property
    def r_x(self) -> Vector:
        """Slopes of the axis, shape (k, p, 3) [-]."""
        return self._sum(slope_weights(self.xi, self.length, self.kind.is_string))

    @property
    def r_xx(self) -> Vector:
        """Derivatives of the slopes along the reference shape, shape (k, p, 3) [1/m]."""
        return self._sum(bend_weights(self.xi, self.length, self.kind.is_string))

    def across(self, name: str) -> tuple[Vector, Vector]:
        """Return a section vector [-] and its derivative [1/m], each (k, p, 3).

        Parameters
        ----------
        name : str
            ``"r_y"`` or ``"r_z"``.
        """
        if name not in self.kind.vectors:
            return self._normal(name)
        first, last = np.moveaxis(spread(self.kind, self.ends, name), 2, 0)
        change = last - first
        return first + self.xi[:, None] * change, change / self.length[:, None]

    def _normal(self, name: str) -> tuple[Vector, Vector]:
        """Make the section vector that an element lacks of the axis and the one that it has."""
        pairs = (self.r_x, self.r_xx), self.across("r_z" if name == "r_y" else "r_y")
        (a, a_x), (b, b_x) = pairs if name == "r_z" else reversed(pairs)
        return np.cross(a, b), np.cross(a_x, b) + np.cross(a, b_x)

    def _sum(self, weights: Vector) -> Vector:
        k, p = self.ends.shape[:2]
        nodes = self.ends.reshape(k, p, 2, -1)
        out, column = np.zeros((k, p, 3)), 0
        for end in (0, 1):
            for name in self.kind.axis:
                own = nodes[:, :, end, self.kind.columns(name)]
                out[..., self.kind.directions(name)] += weights[:, column, None] * own
                column += 1
        return out


def spread(kind: ElementKind, ends: Vector, name: str) -> Vector:
    """Give a vector of both nodes three components.

    Parameters
    ----------
    kind : ElementKind
        The element.
    ends : ndarray, shape (k, p, 2 n_c)
        Coordinates of both nodes, or forces on them.
    name : str
        Of the vector: ``"r"`` for the position, ``"r_x"``, ``"r_y"``, ``"r_z"``.

    Returns
    -------
    ndarray, shape (k, p, 2, 3)
        Zero where an element has no such coordinate.
    """
    nodes = ends.reshape(*ends.shape[:2], 2, -1)
    out = np.zeros((*nodes.shape[:3], 3))
    out[..., kind.directions(name)] = nodes[..., kind.columns(name)]
    return out


def curvature(points: Points) -> Vector:
    """Evaluate how sections turn along the axis.

    Returns
    -------
    ndarray, shape (k, p, 3)
        Turn per length of the reference shape [1/m]: of a cable r' x r'' / |r'|^2, in space; of a
        thick beam its strains of twist and bending, about e_x, e_y and e_z of the section; zero of
        a string, which turns at its nodes alone.
    """
    r_x = points.r_x
    if points.kind.is_cable or points.kind.is_string:
        return np.cross(r_x, points.r_xx) / _dot(r_x, r_x)
    (r_y, r_yx), (r_z, r_zx) = points.across("r_y"), points.across("r_z")
    twist = (_dot(r_z, r_yx) - _dot(r_y, r_zx)) / 2.0
    if "r_x" in points.kind.section:  # sections turn with the axis
        bend_y, bend_z = -_dot(r_z, points.r_xx), _dot(r_y, points.r_xx)
    else:
        bend_y, bend_z = _dot(r_x, r_zx), -_dot(r_x, r_yx)
    return np.concatenate([twist, bend_y, bend_z], axis=-1)


def axes(points: Points) -> Vector:
    """Give the unit vectors of sections.

    Returns
    -------
    ndarray, shape (k, p, 3, 3)
        Rows e_x, e_y and e_z: of a cable or a string along its slope and, in the plane, to the left
        of it; of a thick beam across its section, along r_y, and at right angles to both.  Cables
        and strings in space have no e_y and e_z; they are zero.
    """
    out = np.zeros((*points.ends.shape[:2], 3, 3))
    if not (points.kind.is_cable or points.kind.is_string):
        r_y, r_z = points.across("r_y")[0], points.across("r_z")[0]
        out[:, :, 0], out[:, :, 1] = _unit(np.cross(r_y, r_z)), _unit(r_y)
        out[:, :, 2] = np.cross(out[:, :, 0], out[:, :, 1])
        return out
    out[:, :, 0] = _unit(points.r_x)
    if points.kind.dim == 2:
        out[:, :, 2] = 0.0, 0.0, 1.0
        out[:, :, 1] = np.cross(out[:, :, 2], out[:, :, 0])
    return out


def _unit(u: Vector) -> Vector:
    return np.asarray(u / np.sqrt(_dot(u, u)))


def _dot(u: Vector, v: Vector) -> Vector:
    """Return the dot products of vectors along the last axis, which is kept."""
    return np.asarray((u * v).sum(axis=-1, keepdims=True))
