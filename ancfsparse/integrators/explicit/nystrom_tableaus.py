"""Coefficients of explicit methods for ``M a = f(t) - Q(q)``, and one for forces of velocities too.

All have ``c_1 = 0``, and their last stage is the new position, so its acceleration is the first
one of the next step: a method of s stages costs s - 1 forces per step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from ancfsparse.array_types import Vector

# Radians per step over the order, below which phase errors follow from the order: with a quarter of
# it those of order 8 are rounding.
MIN_PHASE = 0.05


@dataclass(frozen=True, eq=False)
class Tableau:
    """An explicit Runge-Kutta-Nyström method.

    Attributes
    ----------
    order : int
        Order of positions and velocities.
    A : (s, s) float
        Weights of the accelerations in the positions of the stages; the last row makes the step.
    b, c : (s,) float
        Weights of the accelerations in the new velocity; times of the stages.
    interval : float
        A vibration of angular frequency omega does not grow while ``dt omega`` is below this.
    source : str
        Where the coefficients are published.
    B : (s, s) float, optional
        Weights of the accelerations in the velocities of the stages, where forces may depend on
        them; then the interval is also one of vibrations that decay, and of what creeps.
    """

    order: int
    A: Vector
    b: Vector
    c: Vector
    interval: float
    source: str
    B: Vector | None = None

    @property
    def forces(self) -> int:
        """Evaluations of the forces per step."""
        return len(self.b) - 1

    def transfer(self, z: float) -> Vector:
        """Return the (2, 2) matrix that a step applies to (q, dt v) of ``q'' = -(z / dt)^2 q``."""
        s = len(self.b)
        stages = np.column_stack([np.ones(s), self.c])
        rates = np.linalg.solve(np.eye(s) + z**2 * self.A, -(z**2) * stages)
        step = np.array([[1.0, 1.0], [0.0, 1.0]])
        return np.asarray(step + np.stack([self.A[-1] @ rates, self.b @ rates]))

    @cached_property
    def stability_polynomials(self) -> tuple[Vector, Vector]:
        """Trace and determinant of `transfer` by powers of z^2, the lowest first.

        A is strictly lower triangular, so ``(I + z^2 A)^-1`` is a sum of its first s powers.
        """
        s = len(self.b)
        entries = np.zeros((2, 2, s + 1))
        entries[..., 0] = [[1.0, 1.0], [0.0, 1.0]]
        rates = -np.column_stack([np.ones(s), self.c])
        for k in range(1, s + 1):
            entries[..., k] = np.stack([self.A[-1] @ rates, self.b @ rates])
            rates = -self.A @ rates
        (p, q), (r, t) = entries
        return p + t, np.convolve(p, t) - np.convolve(q, r)

    def phase_error(self, z: Vector) -> Vector:
        """Return the relative error of phase or amplitude of vibrations of z radians per step.

        It is 1 where they grow.  Where rounding would show, it is a power of z.
        """
        z = np.asarray(z, dtype=np.float64)
        resolved = np.clip(z, MIN_PHASE * self.order, self.interval)
        trace, determinant = (
            np.polynomial.polynomial.polyval(resolved**2, x) for x in self.stability_polynomials
        )
        root = np.sqrt((0.25 * trace**2 - determinant).astype(complex))
        offset = 0.5 * trace - np.exp(1j * resolved)
        error = np.minimum(np.abs(offset + root), np.abs(offset - root)) / resolved
        error *= np.minimum(z / resolved, 1.0) ** self.order
        return np.asarray(np.where(z < self.interval, error, 1.0))


def tableau(
    order: int,
    rows: Sequence[Sequence[float]],
    b: Sequence[float],
    c: Sequence[float],
    interval: float,
    source: str,
) -> Tableau:
    """Fill up the lower triangle of A, whose first row is empty."""
    A = np.zeros((len(b), len(b)))
    for i, row in enumerate(rows, start=1):
        A[i, : len(row)] = row
    return Tableau(order, A, np.array(b), np.array(c), interval, source)


VERLET = tableau(
    2,
    [[1 / 2]],
    [1 / 2, 1 / 2],
    [0, 1],
    2.0,
    "Hairer, Lubich and Wanner, Acta Numerica 12 (2003) 399: velocity Verlet, leapfrog",
)

FAMILIES = "Dormand, El-Mikkawy and Prince, IMA J. Numer. Anal. 7 (1987) "

# The fourth-order formula of the pair RKN4(3)4FM.
FOURTH = tableau(
    4,
    [
        [1 / 32],
        [7 / 1000, 119 / 500],
        [1 / 14, 8 / 27, 25 / 189],
    ],
    [1 / 14, 32 / 81, 250 / 567, 5 / 54],
    [0, 1 / 4, 7 / 10, 1],
    3.767,
    FAMILIES + "235",
)

# The eighth-order formula of the pair RKN8(6)9FM; its weight of the last stage is zero.
EIGHTH = tableau(
    8,
    [
        [1 / 800],
        [1 / 600, 1 / 300],
        [9 / 200, -9 / 100, 9 / 100],
        [-66701 / 197352, 28325 / 32892, -2665 / 5482, 2170 / 24669],
        [
            227015747 / 304251000,
            -54897451 / 30425100,
            12942349 / 10141700,
            -9499 / 304251,
            539 / 9250,
        ],
        [
            -1131891597 / 901789000,
            41964921 / 12882700,
            -6663147 / 3220675,
            270954 / 644135,
            -108 / 5875,
            114 / 1645,
        ],
        [
            13836959 / 3667458,
            -17731450 / 1833729,
            1063919505 / 156478208,
            -33213845 / 39119552,
            13335 / 28544,
            -705 / 14272,
            1645 / 57088,
        ],
        [223 / 7938, 0, 1175 / 8064, 925 / 6048, 41 / 448, 925 / 14112, 1175 / 72576],
    ],
    [
        223 / 7938,
        0,
        5875 / 36288,
        4625 / 21168,
        41 / 224,
        4625 / 21168,
        5875 / 36288,
        223 / 7938,
        0,
    ],
    [0, 1 / 20, 1 / 10, 3 / 10, 1 / 2, 7 / 10, 9 / 10, 1, 1],
    3.14,
    FAMILIES + "423",
)


@cache
def dormand_prince() -> Tableau:
    """Return the eighth-order formula of DOP853, a Runge-Kutta method for ``M a = f(t, q, v)``.

    SciPy's coefficients.  For ``q' = v``, ``v' = a`` a Runge-Kutta method needs only the rates of
    velocities: the weights in positions are the square of the weights in velocities.
    """
    from scipy.integrate import DOP853  # rarely needed, and slow to import

    s = DOP853.n_stages
    B = np.zeros((s + 1, s + 1))
    B[:s, :s], B[s, :s] = DOP853.A[:s, :s], DOP853.B
    source = "Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 1993, II.5"
    return Tableau(8, B @ B, B[s], B.sum(axis=1), 5.96, source, B)
