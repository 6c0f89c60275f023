"""Graded meshes: node positions that equidistribute the interpolation error of the elements.

Cubic interpolation leaves an error h^2 |r''''| / 12 of the curvature, hence h^4 f of the bending
energy with the density f = |r''''|^2; quantities of interest err in proportion.  Of all meshes of
n elements the integral of f h^4 is least if h is proportional to f^(-1/5) (de Boor, 1973).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Vector

HALF_TOLERANCE = 1e-9  # elements; counts this near a half are rounded as a half
ENERGY_ORDER = 4.0  # power of h in the energy error of cubics
UNIFORM_FRACTION = 0.5  # of the nodes, since a trial run does not show all of the bending
# Parts of a beam had the same one or two elements on meshes of 8 and 12, which agreed; the moments
# there were 2.6 and 10 tolerances off.
COARSE_COUNT = 8  # elements of a mesh, of which those of finer ones are multiples in every part
# Ratios of .86 to .96 of adjacent elements on meshes of 19 to 63 hid 8.6 times a strain's error.
MAX_MORE = 1.1  # elements of a mesh similar to the coarse one over those requested
MAX_DENSITY = 4.0  # elements by length of a short part over the mean of the mesh


@dataclass(frozen=True)
class MeshGrading:
    """Distribution of the elements of a beam, for any number of elements.

    Attributes
    ----------
    positions : tuple of float
        Relative positions along the beam, from 0 to 1.
    element_fractions : tuple of float
        Fraction of the elements before each of these positions, from 0 to 1.
    """

    positions: tuple[float, ...]
    element_fractions: tuple[float, ...]

    def node_positions(self, count: int, inner: Sequence[float]) -> Vector:
        """Return relative positions of nodes of about `count` elements, `inner` ones included."""
        ends = np.array([0.0, *inner, 1.0])
        fractions = self._fractions(ends)
        out = [0.0]
        for i, n in enumerate(self.part_counts(count, inner)):
            even = np.linspace(fractions[i], fractions[i + 1], n + 1)[1:-1]
            out += [
                *np.interp(even, self.element_fractions, self.positions).tolist(),
                float(ends[i + 1]),
            ]
        return np.array(out)

    def part_counts(self, count: int, inner: Sequence[float]) -> list[int]:
        """Return the numbers of elements of the parts between `inner` nodes."""
        return part_counts(count, np.diff(self._fractions(np.array([0.0, *inner, 1.0]))).tolist())

    def _fractions(self, positions: Vector) -> Vector:
        return np.asarray(np.interp(positions, self.positions, self.element_fractions))

    @property
    def length_ratio(self) -> float:
        """Ratio of the longest to the shortest element of a fine mesh."""
        lengths = np.diff(self.positions) / np.diff(self.element_fractions)
        return float(lengths.max() / lengths.min())


def part_counts(count: int, fractions: Sequence[float]) -> list[int]:
    """Return the numbers of elements of parts with fractions of a mesh of `count` or more.

    Successive meshes have more elements in every part, in short ones too.  Fine meshes have them in
    one ratio, since the error depends on the ratios of the lengths of adjacent elements.
    """
    coarse = [COARSE_COUNT * each for each in fractions]
    smallest = [max(round_half_up(each), min(1.0, MAX_DENSITY * each)) for each in coarse]
    ratio = count / COARSE_COUNT
    common = math.gcd(*(int(each) for each in smallest))
    if common:
        similar = math.ceil(ratio * common - HALF_TOLERANCE) / common
        ratio = similar if similar <= MAX_MORE * ratio else ratio
    return [max(1, math.ceil(each * ratio - HALF_TOLERANCE)) for each in smallest]


def round_half_up(count: float) -> int:
    """Round a number of elements, halves upwards, so that lengths equal to rounding agree."""
    return math.floor(count + 0.5 + HALF_TOLERANCE)


def error_density(r: Vector, slopes: Vector, lengths: Vector, loaded: Vector) -> Vector:
    """Return the mean square over states of r'''' in every element, (n,) [1/m6].

    The larger of the values at both nodes, by divided differences of r'''.

    Parameters
    ----------
    r, slopes : ndarray, shape (k, n + 1, dim)
        Positions of the nodes [m], and derivatives of the position by the arc length [-].
    lengths : ndarray, shape (n,)
        Lengths of the elements [m].
    loaded : ndarray of bool, shape (n + 1,)
        Nodes with forces, where r''' jumps.
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


def equidistributed(f: Vector, nodes: Vector) -> MeshGrading:
    """Return the grading with equal errors in all elements.

    From the `error_density`, (n,), not zero everywhere, and relative positions of nodes, (n + 1,).
    """
    lengths = np.diff(nodes)
    rate = f ** (1.0 / (ENERGY_ORDER + 1.0))
    rate = UNIFORM_FRACTION + (1.0 - UNIFORM_FRACTION) * rate / float(lengths @ rate)
    fractions = np.concatenate([[0.0], np.cumsum(lengths * rate)])
    return MeshGrading(tuple(nodes.tolist()), tuple((fractions / fractions[-1]).tolist()))


def energy_error(f: Vector, nodes: Vector, grading: MeshGrading) -> float:
    """Return the energy error on a graded mesh, up to a power of the number of elements."""
    lengths = np.diff(nodes)
    rate = np.diff(np.interp(nodes, grading.positions, grading.element_fractions)) / lengths
    return float((f * lengths) @ rate**-ENERGY_ORDER)


UNIFORM = MeshGrading((0.0, 1.0), (0.0, 1.0))
