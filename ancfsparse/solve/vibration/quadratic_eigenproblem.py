"""Complex modes: the quadratic eigenvalue problem of damped vibrations, by inversion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Complex, Vector
from ancfsparse.errors import InputError, ModesError
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.solve.linearization.linearized_system import LinearizedSystem
from ancfsparse.solve.linearization.nonconservative_tangent import (
    ROUNDING_RATIO as DIFFERENCE,
    NonconservativeTangent,
    solve_with_correction,
)
from ancfsparse.solve.vibration.symmetric_eigenproblem import (
    MAX_RESIDUAL,
    MOTION_ROUNDING_UNITS,
    N_EXTRA_MODES,
    ROUNDING_UNITS,
)

# Distances from it are then nearly the sizes of eigenvalues, and it is well above rounding.
RATE_RATIO = 0.05  # rate of the factor over the highest requested frequency
RANK_TOLERANCE = 1e-4  # relative singular value below which motions without stiffness coincide


@dataclass(frozen=True)
class ComplexEigenpairs:
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


class DampedSystem:
    """The linearized equations of damped motions, inverted about a positive real rate.

    With displacements x and velocities v scaled by the masses, the eigenvalues 1 / (w - rate) of
    the inverse are largest for the eigenvalues w nearest the rate.  The factor contains the
    symmetric parts; Coriolis and nonconservative forces are added by GMRES.

    Parameters
    ----------
    linearized : LinearizedSystem
        The matrices; its factor is replaced.
    rate : float
        Rate of the factor [1/s].
    """

    def __init__(self, linearized: LinearizedSystem, rate: float) -> None:
        self.linearized, self.rate = linearized, rate
        system = linearized.system
        amplitudes = system.loads.amplitudes(np.array([linearized.state.t]))[0]
        self.mass, self.unit = linearized.mass, np.sqrt(linearized.diagonal)
        missing = NonconservativeTangent(system)
        stiffness = missing.stiffness(linearized.state.q, amplitudes)
        damping = missing.damping(linearized.state.q, amplitudes, rate)
        if system.gyroscopic is not None:
            damping = damping + system.gyroscopic
        self._unsymmetric = stiffness + rate * damping
        self.stiffness = linearized.stiffness + stiffness
        self.damping = linearized.damping() + damping
        self.stiffness_error = DIFFERENCE * abs(stiffness)  # of finite differences
        if linearized.factor_at_rate(rate) is None:
            raise ModesError("the matrix of damped motions is singular")

    def solve(self, force: Vector) -> Vector:
        """Solve ``(rate^2 M + rate C + K) x = force`` under the constraints, (n_free,)."""

        def solve(r: Vector) -> Vector:
            return np.asarray(self.linearized.solve_all(r[:, None])[:, 0])

        x = solve_with_correction(solve, self._unsymmetric, force, self.unit)
        if x is None:
            raise ModesError("nonconservative or Coriolis forces are too strong for the factor")
        return x

    def inverse(self, z: Vector) -> Vector:
        """Apply the inverse to scaled displacements and velocities, (2 n_free,)."""
        n, rate = len(self.unit), self.rate
        x, v = np.ravel(z)[:n] / self.unit, np.ravel(z)[n:] / self.unit
        dx = -rate * self.solve(self.mass @ (rate * (v + x)) + self.damping @ x)
        return np.concatenate([self.unit * dx, self.unit * (x + dx)])

    def residual(self, value: complex, x: Complex) -> Complex:
        """Return the residual of an eigenpair as a motion."""
        r = value * self.damping @ x + self.stiffness @ x + value**2 * (self.mass @ x)
        return np.asarray(self.solve(r.real) + 1j * self.solve(r.imag))

    def size(self, x: Complex) -> float:
        """Return the norm of a motion, weighted by the masses."""
        return float(np.sqrt(np.real(np.vdot(x, self.mass @ x))))


def smallest_roots(
    linearized: LinearizedSystem, n: int, frequency: float, motions: Vector | None
) -> ComplexEigenpairs:
    """Find the n roots of smallest absolute value.

    Parameters
    ----------
    linearized : LinearizedSystem
        The matrices; its factor is replaced.
    n : int
        Number of roots, a conjugate pair counting as one.
    frequency : float
        Approximate largest frequency without damping [1/s].
    motions : (n_free, k) float or None
        Result of `admissible_motions`.

    Raises
    ------
    InputError
        If there are fewer roots.
    ModesError
        If the method does not converge.
    """
    damped = DampedSystem(
        linearized, RATE_RATIO * max(frequency, ROUNDING_UNITS * np.sqrt(EPSILON * linearized.size))
    )
    limit = (2 * motions.shape[1]) if motions is not None else 2 * len(linearized.diagonal) - 2
    k = 2 * (n + N_EXTRA_MODES)
    while True:
        if motions is not None:
            values, vectors = _solve_dense(damped, motions)
        else:
            values, vectors = _solve_arnoldi(damped, min(k, limit))
        are_all = len(values) >= limit
        reach = np.inf if are_all else np.max(np.abs(values - damped.rate)) - damped.rate
        roots = _sort_roots(damped, values, vectors)
        if np.count_nonzero(np.abs(roots.values) <= reach) >= n:
            break
        if are_all:
            raise InputError(f"n must be at most {len(roots.values)} in this scene, got {n}")
        k *= 2
    values, x, rounding = roots.values[:n], roots.motions[:n], roots.rounding[:n]
    largest = MAX_RESIDUAL + ROUNDING_UNITS * EPSILON * linearized.size / damped.rate**2
    for k, value in enumerate(values.tolist()):
        residual = damped.size(damped.residual(value, x[k]))
        if motions is not None and not residual <= largest:
            x[k] = _refine_motion(damped, motions, value, x[k])
            residual = damped.size(damped.residual(value, x[k]))
        if not residual <= largest:
            raise ModesError(f"a mode has the relative residual {residual:.2g}")
    return ComplexEigenpairs(values, x, rounding)


def _solve_dense(damped: DampedSystem, motions: Vector) -> tuple[Complex, Complex]:
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


def _refine_motion(damped: DampedSystem, motions: Vector, value: complex, x: Complex) -> Complex:
    """Improve the motion of a root by one inverse iteration on a basis of all motions.

    The inverse about the rate gives motions of roots far from it with larger errors than the roots
    (Peters and Wilkinson, Inverse iteration, ill-conditioned equations and Newton's method, 1979).
    """
    columns = value**2 * (damped.mass @ motions) + value * (damped.damping @ motions)
    matrix = motions.T @ (columns + damped.stiffness @ motions)
    mixed = np.linalg.solve(matrix, motions.T @ (damped.mass @ x))
    refined: Complex = np.asarray(motions @ mixed, dtype=np.complex128)
    refined /= damped.size(refined)
    phase = np.vdot(refined, damped.mass @ x)
    return np.asarray(refined * phase / abs(phase))


def _solve_arnoldi(damped: DampedSystem, k: int) -> tuple[Complex, Complex]:
    """Find at least the k roots nearest the rate."""
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


def _sort_roots(damped: DampedSystem, values: Complex, vectors: Complex) -> ComplexEigenpairs:
    """Sort roots by size, with one of each pair and one of each motion without stiffness."""
    upper = values.imag >= 0.0
    values, x = values[upper], vectors[:, upper]
    x = x / np.sqrt(np.real(np.sum(x.conj() * (damped.mass @ x), axis=0)))
    linearized, size = damped.linearized, np.abs(x)
    square = ROUNDING_UNITS * EPSILON * np.sum(size * (abs(damped.stiffness) @ size), axis=0)
    square += np.sum(size * (damped.stiffness_error @ size), axis=0)
    square += (MOTION_ROUNDING_UNITS * EPSILON) ** 2 * linearized.size
    # In a steady rotation stress and centrifugal forces cancel, both with rounding.
    if linearized.system.gyroscopic is not None:
        entries = linearized.system.gyroscopic.tocoo()
        rates = np.abs(entries.data) / (damped.unit[entries.row] * damped.unit[entries.col])
        square += ROUNDING_UNITS * EPSILON * np.max(rates, initial=0.0) ** 2
        square += ROUNDING_UNITS * EPSILON * linearized.stiffest @ size**2
    is_zero = np.abs(values) <= np.sqrt(square)
    if is_zero.any():
        values, x, square = _merge_zero_roots(damped, values, x, square, is_zero)
    phase = np.sum(x * (damped.mass @ x), axis=0)
    x = x * np.exp(-0.5j * np.angle(phase))
    order = np.argsort(np.abs(values), kind="stable")
    values, x, square = values[order], x[:, order], square[order]
    root = np.sqrt(square)
    rounding = np.where(
        np.abs(values) > root, square / (2.0 * np.maximum(np.abs(values), root)), root
    )
    if linearized.system.gyroscopic is not None:  # rounding of the unsymmetric inverse
        rounding += ROUNDING_UNITS**2 * EPSILON * np.abs(values) ** 2 / damped.rate
    return ComplexEigenpairs(values, x.T.copy(), rounding)


def _merge_zero_roots(
    damped: DampedSystem, values: Complex, x: Complex, square: Vector, is_zero: NDArray[np.bool_]
) -> tuple[Complex, Complex, Vector]:
    """Replace double roots that are zero up to rounding by single ones with their motions."""
    both = np.hstack([x[:, is_zero].real, x[:, is_zero].imag]) * damped.unit[:, None]
    motions, sizes, _ = np.linalg.svd(both, full_matrices=False)
    free = motions[:, sizes > RANK_TOLERANCE * sizes[0]] / damped.unit[:, None]
    free = free / np.sqrt(np.sum(free * (damped.mass @ free), axis=0))
    k = free.shape[1]
    bound = np.full(k, square[is_zero].max())
    return (
        np.concatenate([np.zeros(k), values[~is_zero]]),
        np.hstack([free, x[:, ~is_zero]]),
        np.concatenate([bound, square[~is_zero]]),
    )
