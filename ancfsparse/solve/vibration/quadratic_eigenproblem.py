"""Complex modes: the quadratic eigenvalue problem of damped motions, linearised and inverted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import ModesError
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.solve.linearization.linearized_system import LinearizedSystem
from ancfsparse.solve.linearization.nonconservative_tangent import ROUNDING_RATIO as DIFFERENCE
from ancfsparse.solve.linearization.nonconservative_tangent import (
    NonconservativeTangent,
    solve_with_correction,
)
from ancfsparse.solve.vibration.symmetric_eigenproblem import (
    BEYOND,
    MOTION,
    ROUNDING,
    TOLERANCE,
)

Vector = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Rate of the factor relative to the highest wanted frequency: small, so that the distances from it
# are nearly the sizes of eigenvalues, and well above rounding.
RATE = 0.05
# Relative singular value below which motions without stiffness are the same.
SAME = 1e-4


@dataclass(frozen=True)
class Roots:
    """Eigenvalues and motions of ``(w^2 M + w C + K) x + Phi_q^T mu = 0``, ``Phi_q x = 0``.

    Attributes
    ----------
    values : (n,) complex
        By size, one of each conjugate pair [1/s].
    motions : (n, n_free) complex
        With ``x^H M x = 1``.
    rounding : (n,) float
        Bound of the error of each eigenvalue from rounding of the matrices [1/s].
    """

    values: Complex
    motions: Complex
    rounding: Vector


class Damped:
    """The linearised equations of damped motions, inverted about a positive real rate.

    With displacements x and velocities v scaled by the masses, the eigenvalues 1 / (w - rate) of
    the inverse are largest for the eigenvalues w next to the rate.  The factor has the symmetric
    parts alone; what Coriolis forces and forces without a potential add is
    solved for by GMRES on top of it.

    Parameters
    ----------
    pencil : Pencil
        The matrices; its factor is replaced.
    rate : float
        [1/s].
    """

    def __init__(self, pencil: LinearizedSystem, rate: float) -> None:
        self.pencil, self.rate = pencil, rate
        system = pencil.system
        amplitudes = system.loads.amplitudes(np.array([pencil.state.t]))[0]
        self.mass, self.unit = pencil.mass, np.sqrt(pencil.diagonal)
        missing = NonconservativeTangent(system)
        stiffness = missing.stiffness(pencil.state.q, amplitudes)
        damping = missing.damping(pencil.state.q, amplitudes, rate)
        if system.gyroscopic is not None:
            damping = damping + system.gyroscopic
        self._beside = stiffness + rate * damping
        self.stiffness = pencil.stiffness + stiffness
        self.damping = pencil.damping() + damping
        self.doubt = DIFFERENCE * abs(stiffness)  # differences of forces are not exact
        if pencil.factor_at_rate(rate) is None:
            raise ModesError("the matrix of damped motions is singular")

    def solve(self, force: Vector) -> Vector:
        """Solve ``(rate^2 M + rate C + K) x = force`` under the constraints, (n_free,)."""

        def solve(r: Vector) -> Vector:
            return np.asarray(self.pencil.solve_all(r[:, None])[:, 0])

        x = solve_with_correction(solve, self._beside, force, self.unit)
        if x is None:
            raise ModesError(
                "forces without a potential or Coriolis forces are too strong for the factor"
            )
        return x

    def inverse(self, z: Vector) -> Vector:
        """Apply the inverse to scaled displacements and velocities, (2 n_free,)."""
        n, rate = len(self.unit), self.rate
        x, v = np.ravel(z)[:n] / self.unit, np.ravel(z)[n:] / self.unit
        moved = -rate * self.solve(self.mass @ (rate * (v + x)) + self.damping @ x)
        return np.concatenate([self.unit * moved, self.unit * (x + moved)])

    def residual(self, value: complex, x: Complex) -> Complex:
        """Return how far an eigenvalue is from moving x as it should, as a motion."""
        moved = value * self.damping @ x + self.stiffness @ x + value**2 * (self.mass @ x)
        return np.asarray(self.solve(moved.real) + 1j * self.solve(moved.imag))

    def size(self, x: Complex) -> float:
        """Return the size of a motion by the masses."""
        return float(np.sqrt(np.real(np.vdot(x, self.mass @ x))))


def nearest(pencil: LinearizedSystem, n: int, frequency: float, motions: Vector | None) -> Roots:
    """Find the n roots of smallest size.

    Parameters
    ----------
    pencil : Pencil
        The matrices; its factor is replaced.
    n : int
        How many, with conjugate pairs as one.
    frequency : float
        About the largest of them without damping [1/s].
    motions : (n_free, k) float or None
        What `all_motions` has returned.

    Raises
    ------
    ModesError
        If the method does not converge, or there are fewer roots.
    """
    damped = Damped(pencil, RATE * max(frequency, ROUNDING * np.sqrt(EPSILON * pencil.size)))
    most = (2 * motions.shape[1]) if motions is not None else 2 * len(pencil.diagonal) - 2
    wanted = 2 * (n + BEYOND)
    while True:
        if motions is not None:
            values, vectors = _by_dense(damped, motions)
        else:
            values, vectors = _by_arnoldi(damped, min(wanted, most))
        everything = len(values) >= most
        reach = np.inf if everything else np.max(np.abs(values - damped.rate)) - damped.rate
        roots = _sorted(damped, values, vectors)
        if np.count_nonzero(np.abs(roots.values) <= reach) >= n:
            break
        if everything:
            raise ModesError(f"there are {len(roots.values)} motions, and {n} were asked for")
        wanted *= 2
    values, x, rounding = roots.values[:n], roots.motions[:n], roots.rounding[:n]
    for value, motion in zip(values, x, strict=True):
        off = damped.size(damped.residual(complex(value), motion))
        if not off <= TOLERANCE + ROUNDING * EPSILON * pencil.size / damped.rate**2:
            raise ModesError(f"a mode has the relative residual {off:.2g}")
    return Roots(values, x, rounding)


def _by_dense(damped: Damped, motions: Vector) -> tuple[Complex, Complex]:
    """Find all roots by the inverse on a basis of all motions, (n_free, k)."""
    k = motions.shape[1]
    basis, scaled = motions, damped.unit[:, None] * motions
    back = np.linalg.pinv(scaled)
    inverse = np.empty((2 * k, 2 * k))
    for column in range(2 * k):
        z = np.zeros(2 * len(basis))
        half = slice(0, len(basis)) if column < k else slice(len(basis), None)
        z[half] = scaled[:, column % k]
        out = damped.inverse(z)
        inverse[:k, column] = back @ out[: len(basis)]
        inverse[k:, column] = back @ out[len(basis) :]
    shifted, mixes = np.linalg.eig(inverse)
    values: Complex = damped.rate * (1.0 + 1.0 / shifted.astype(np.complex128))
    return values, np.asarray(basis @ mixes[:k], dtype=np.complex128)


def _by_arnoldi(damped: Damped, k: int) -> tuple[Complex, Complex]:
    """Find the k roots next to the rate, at least."""
    from scipy.sparse.linalg import ArpackError, LinearOperator, eigs

    n = len(damped.unit)
    random = np.random.default_rng(0).standard_normal(2 * n)
    try:
        shifted, vectors = eigs(
            LinearOperator((2 * n, 2 * n), matvec=damped.inverse, dtype=float),
            k,
            which="LM",
            v0=damped.inverse(damped.inverse(random)),  # satisfies the constraints
            tol=0.0,
        )
    except ArpackError as error:
        raise ModesError(str(error)) from error
    return damped.rate * (1.0 + 1.0 / shifted), vectors[:n] / damped.unit[:, None]


def _sorted(damped: Damped, values: Complex, vectors: Complex) -> Roots:
    """Take one of each pair, motions without stiffness once, by size."""
    kept = values.imag >= 0.0
    values, x = values[kept], vectors[:, kept]
    x = x / np.sqrt(np.real(np.sum(x.conj() * (damped.mass @ x), axis=0)))
    pencil, size = damped.pencil, np.abs(x)
    square = ROUNDING * EPSILON * np.sum(size * (abs(damped.stiffness) @ size), axis=0)
    square += np.sum(size * (damped.doubt @ size), axis=0) + (MOTION * EPSILON) ** 2 * pencil.size
    # In a steady rotation stress cancels centrifugal forces: both round.
    if pencil.system.gyroscopic is not None:
        entries = pencil.system.gyroscopic.tocoo()
        rates = np.abs(entries.data) / (damped.unit[entries.row] * damped.unit[entries.col])
        square += ROUNDING * EPSILON * np.max(rates, initial=0.0) ** 2
        square += ROUNDING * EPSILON * pencil.stiffest @ size**2
    still = np.abs(values) <= np.sqrt(square)
    if still.any():
        values, x, square = _once(damped, values, x, square, still)
    turn = np.sum(x * (damped.mass @ x), axis=0)
    x = x * np.exp(-0.5j * np.angle(turn))
    order = np.argsort(np.abs(values), kind="stable")
    values, x, square = values[order], x[:, order], square[order]
    root = np.sqrt(square)
    rounding = np.where(
        np.abs(values) > root, square / (2.0 * np.maximum(np.abs(values), root)), root
    )
    if pencil.system.gyroscopic is not None:  # of the inverse, which has no symmetry
        rounding += ROUNDING**2 * EPSILON * np.abs(values) ** 2 / damped.rate
    return Roots(values, x.T.copy(), rounding)


def _once(
    damped: Damped, values: Complex, x: Complex, square: Vector, still: NDArray[np.bool_]
) -> tuple[Complex, Complex, Vector]:
    """Replace roots that are zero within rounding, which come twice, by their motions."""
    both = np.hstack([x[:, still].real, x[:, still].imag]) * damped.unit[:, None]
    motions, sizes, _ = np.linalg.svd(both, full_matrices=False)
    free = motions[:, sizes > SAME * sizes[0]] / damped.unit[:, None]
    free = free / np.sqrt(np.sum(free * (damped.mass @ free), axis=0))
    k = free.shape[1]
    bound = np.full(k, square[still].max())
    return (
        np.concatenate([np.zeros(k), values[~still]]),
        np.hstack([free, x[:, ~still]]),
        np.concatenate([bound, square[~still]]),
    )
