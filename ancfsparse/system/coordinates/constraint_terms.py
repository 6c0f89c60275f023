"""Holonomic constraints as sums of terms ``c (q_i - a) (q_j - a)`` and ``c q_i``.

Rigid rods, rigid bodies in natural coordinates and nearly all joints between them have this form,
whose second derivative is constant (Garcia de Jalon and Bayo, 1994).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.scene.kinematics.linear_forms import LINEAR

if TYPE_CHECKING:
    import scipy.sparse as sp

    from ancfsparse.scene.kinematics.joint_coordinates import JointCoordinate
    from ancfsparse.scene.kinematics.sliding_curve import CurveOffset


TERM_FIELDS = ("i", "j", "coefficient", "about")
EQUATION_FIELDS = ("offset", "offset_size", "mass", "labels", "source")


class Gradients(NamedTuple):
    """Entries of phi_q, of shape (k,): rows, columns and values [1]."""

    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    values: NDArray[np.float64]


@dataclass
class Constraints:
    """Terms of all constraint equations, and their sources.

    Attributes
    ----------
    row, i, j : lists of int
        Equation of each term and the indices of its factors; ``j = LINEAR`` in a linear term.
    coefficient : list of float
        Coefficient of each term [1 or 1/m].
    about : list of float
        Origin of both factors of a quadratic term [m]: far from the coordinate origin the square of
        a short length would be lost to rounding.
    offset : list of float
        Constant of each equation [m].
    offset_size : list of float
        Magnitude of the terms of this sum [m].
    mass : list of float
        Weight of the gradients of each equation in the mass matrix [kg], see
        ``ANCF_EQUATION_MASS`` in abi/system_abi.h.
    labels : list of str
        Description of each equation, for messages.
    source : list of (int, int)
        The ``id`` of the body or joint of each equation, and the number of the equation in it.
    measures : list of (int, float, Measure)
        Other terms: equation, factor [1 or m], and a joint coordinate or the offset of a point from
        its sliding curve.
    """

    row: list[int] = field(default_factory=list)
    i: list[int] = field(default_factory=list)
    j: list[int] = field(default_factory=list)
    coefficient: list[float] = field(default_factory=list)
    about: list[float] = field(default_factory=list)
    offset: list[float] = field(default_factory=list)
    offset_size: list[float] = field(default_factory=list)
    mass: list[float] = field(default_factory=list)
    labels: list[str] = field(default_factory=list)
    source: list[tuple[int, int]] = field(default_factory=list)
    measures: list[tuple[int, float, JointCoordinate | CurveOffset]] = field(default_factory=list)

    def add(
        self,
        label: str,
        offset: float,
        *terms: tuple[float, int, int],
        about: Sequence[float] = (),
        size: float = 0.0,
        mass: float = 0.0,
        measures: Sequence[tuple[float, JointCoordinate | CurveOffset]] = (),
        source: tuple[int, int] = (0, 0),
    ) -> None:
        """Add the equation ``offset + sum of terms = 0``, its offset of magnitude `size` [m]."""
        self.measures += [(len(self.offset), factor, each) for factor, each in measures]
        for (coefficient, i, j), a in zip(terms, about or [0.0] * len(terms), strict=True):
            self.row.append(len(self.offset))
            self.i.append(int(i))
            self.j.append(int(j))
            self.coefficient.append(float(coefficient))
            self.about.append(float(a))
        self.offset.append(float(offset))
        self.offset_size.append(max(size, abs(self.offset[-1])))
        self.mass.append(float(mass))
        self.labels.append(label)
        self.source.append(source)

    def without(self, n_free: int) -> list[int]:
        """Return the equations that contain none of the first `n_free` coordinates."""
        i, j = np.array(self.i, dtype=int), np.array(self.j, dtype=int)
        free = (i < n_free) | ((j != LINEAR) & (j < n_free))
        rows = np.array(self.row, dtype=int)[free]
        of_measures = [row for row, _, each in self.measures if (each.place < n_free).any()]
        rows = np.append(rows, of_measures).astype(int)
        return np.flatnonzero(np.bincount(rows, minlength=len(self.offset)) == 0).tolist()

    def ordered(self, order: NDArray[np.intp]) -> Constraints:
        """Return the same equations in another order."""
        new = np.empty(len(order), dtype=int)
        new[order] = np.arange(len(order))
        of_rows = {name: [getattr(self, name)[k] for k in order] for name in EQUATION_FIELDS}
        measures = [(int(new[row]), factor, each) for row, factor, each in self.measures]
        rows = [int(new[row]) for row in self.row]
        return replace(self, row=rows, measures=measures, **of_rows)

    def only(self, rows: Sequence[int]) -> Constraints:
        """Return some of the equations, in ascending order."""
        new = {row: k for k, row in enumerate(rows)}
        terms = [k for k, row in enumerate(self.row) if row in new]
        of_terms = {name: [getattr(self, name)[k] for k in terms] for name in TERM_FIELDS}
        of_rows = {name: [getattr(self, name)[k] for k in rows] for name in EQUATION_FIELDS}
        row = [new[self.row[k]] for k in terms]
        measures = [(new[k], factor, each) for k, factor, each in self.measures if k in new]
        return Constraints(**of_terms | of_rows | {"row": row}, measures=measures)

    def arm(self, row: int) -> float:
        """Return the length that converts an equation of angles to metres [m], 0 for others."""
        terms = [(factor, each.is_angle) for k, factor, each in self.measures if k == row]
        if row in self.row or not all(is_angle for _, is_angle in terms):
            return 0.0
        return next((abs(factor) for factor, _ in terms), 0.0)

    @property
    def linear(self) -> bool:
        """True if no equation has a quadratic term."""
        return not self.measures and all(j == LINEAR for j in self.j)

    def sizes(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the sum of the magnitudes of the terms of each equation, shape (m,) [m]."""
        i, j = np.array(self.i, dtype=np.int64), np.array(self.j, dtype=np.int64)
        a = np.array(self.about)
        terms = np.abs(self.coefficient) * (np.abs(q[i]) + np.abs(a))
        terms *= np.where(j == LINEAR, 1.0, np.abs(q[j] - a))
        out: NDArray[np.float64] = np.array(self.offset_size)
        out = out + np.bincount(self.row, terms, minlength=len(self.offset))
        for row, factor, measure in self.measures:
            out[row] += abs(factor) * measure.size(q)
        return out

    def jacobian(self, q: NDArray[np.float64]) -> sp.csr_array:
        """Return phi_q, sparse (m, n_all) [1]."""
        import scipy.sparse as sp

        rows, columns, values = self.gradients(q)
        return sp.csr_array((values, (rows, columns)), shape=(len(self.offset), len(q)))

    def gradients(self, q: NDArray[np.float64]) -> Gradients:
        """Return the entries of phi_q [1]; those with the same indices are summed."""
        row, i, j = (np.array(x, dtype=np.int64) for x in (self.row, self.i, self.j))
        c, a = np.array(self.coefficient), np.array(self.about)
        linear = j == LINEAR
        by_i = np.where(linear, c, c * (q[j] - a))
        rows, columns = [row, row[~linear]], [i, j[~linear]]
        values = [by_i, (c * (q[i] - a))[~linear]]
        for k, factor, measure in self.measures:
            at, gradient = measure.entries(q)
            rows.append(np.full(len(at), k))
            columns.append(at.astype(np.int64))
            values.append(factor * gradient)
        return Gradients(np.concatenate(rows), np.concatenate(columns), np.concatenate(values))

    def reach(self, q: NDArray[np.float64]) -> sp.csr_array:
        """Return the pattern of possible gradients, (m or more, n_all).

        A sliding point has a row for each element that it may reach.
        """
        import scipy.sparse as sp

        parts = [self.jacobian(q)]
        parts[0].data[:] = 1.0
        for places in (each.reach() for _, _, each in self.measures if each.is_sliding):
            start = np.arange(len(places) + 1) * places.shape[1]
            ones = np.ones(places.size)
            parts.append(sp.csr_array((ones, places.ravel(), start), shape=(len(places), len(q))))
        return parts[0] if len(parts) == 1 else sp.csr_array(sp.vstack(parts))

    def curvature(self, q: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (phi_q v)_q v, shape (m,) [m/s2], so that phi_q a + (phi_q v)_q v = 0."""
        out = np.zeros(len(self.offset))
        for row, i, j, c in zip(self.row, self.i, self.j, self.coefficient, strict=True):
            if j != LINEAR:
                out[row] += 2.0 * c * v[i] * v[j]
        for row, c, measure in self.measures:
            out[row] += c * measure.bending(q, v)
        return out
