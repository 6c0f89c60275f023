"""Graded meshes: where the nodes of a beam stand, by equidistribution of what its elements miss.

Cubics leave h^2 |r''''| / 12 of a curvature, and so of the energy of bending h^4 times a density
f = |r''''|^2; quantities err by as much.  Of all meshes of n elements the sum of f h^4 over the
length is least where h is proportional to f^(-1/5) (de Boor, 1973).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Power of h in what cubics leave of the energy.
POWER = 4.0
# Share of the nodes that are spread evenly, since a pilot does not show all that bends.
EVEN = 0.5


@dataclass(frozen=True)
class Grade:
    """How the elements of a beam are spread, on meshes of any number.

    Attributes
    ----------
    places : tuple of float
        Shares of the length, from 0 to 1.
    below : tuple of float
        Share of the elements that stand before each of them, from 0 to 1.
    """

    places: tuple[float, ...]
    below: tuple[float, ...]

    def mesh(self, count: int, inner: Sequence[float]) -> Array:
        """Return the shares of the length at which about so many elements end, inner ones too."""
        ends = np.array([0.0, *inner, 1.0])
        share = np.interp(ends, self.places, self.below)
        out = [0.0]
        for i, part in enumerate(np.diff(share)):
            n = max(1, round(count * part))
            even = np.linspace(share[i], share[i + 1], n + 1)[1:-1]
            out += [*np.interp(even, self.below, self.places).tolist(), float(ends[i + 1])]
        return np.array(out)

    @property
    def ratio(self) -> float:
        """Longest over shortest element of a fine mesh."""
        lengths = np.diff(self.places) / np.diff(self.below)
        return float(lengths.max() / lengths.min())


def density(r: Array, slopes: Array, lengths: Array, loaded: Array) -> Array:
    """Return the mean square of r'''' in every element, over states.

    Parameters
    ----------
    r, slopes : ndarray, shape (k, n + 1, dim)
        Positions of the nodes [m], and derivatives of the position by the arc length [-].
    lengths : ndarray, shape (n,)
        Lengths of the elements [m].
    loaded : ndarray of bool, shape (n + 1,)
        Nodes with forces, where r''' jumps.

    Returns
    -------
    ndarray, shape (n,)
        The larger one of both nodes, by divided differences of r''' [1/m6].
    """
    h = lengths[:, None]
    third = 12.0 * (r[:, :-1] - r[:, 1:]) / h**3 + 6.0 * (slopes[:, :-1] + slopes[:, 1:]) / h**2
    fourth = np.diff(third, axis=1) / (0.5 * (h[1:] + h[:-1]))
    square = np.full(len(lengths) + 1, np.nan)
    square[1:-1] = np.square(fourth).sum(axis=2).mean(axis=0)
    square[loaded] = np.nan
    out = np.fmax(square[:-1], square[1:])
    known = ~np.isnan(out)
    if not known.any():
        return np.zeros(len(out))
    return np.asarray(np.interp(np.arange(len(out)), np.flatnonzero(known), out[known]))


def equidistributed(f: Array, nodes: Array) -> Grade:
    """Return the grade in which every element misses as much.

    Parameters
    ----------
    f : ndarray, shape (n,)
        As `density` returns it, not zero everywhere.
    nodes : ndarray, shape (n + 1,)
        Shares of the length at which elements end.
    """
    own = np.diff(nodes)
    rate = f ** (1.0 / (POWER + 1.0))
    rate = EVEN + (1.0 - EVEN) * rate / float(own @ rate)
    below = np.concatenate([[0.0], np.cumsum(own * rate)])
    return Grade(tuple(nodes.tolist()), tuple((below / below[-1]).tolist()))


def missed(f: Array, nodes: Array, grade: Grade) -> float:
    """Return what elements of a grade miss, over all, up to a power of their number."""
    own = np.diff(nodes)
    rate = np.diff(np.interp(nodes, grade.places, grade.below)) / own
    return float((f * own) @ rate**-POWER)


UNIFORM = Grade((0.0, 1.0), (0.0, 1.0))
