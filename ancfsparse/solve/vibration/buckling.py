"""Buckling loads: multiples of the loads at which equilibria become unstable."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_count
from ancfsparse.errors import ApproximateModesWarning, InputError, ModesError
from ancfsparse.results import Equilibrium
from ancfsparse.results.solutions.buckling import Buckling
from ancfsparse.scene import Scene
from ancfsparse.solve.linearization.linearized_system import linearized_in_memory
from ancfsparse.solve.linearization.matrices import free_submatrix, symmetric_from_lower
from ancfsparse.solve.linearization.rigid_body_modes import check_restrained
from ancfsparse.solve.vibration.symmetric_eigenproblem import (
    MAX_DENSE_COORDINATES,
    N_EXTRA_MODES,
    VECTORS_PER_MODE,
    admissible_motions,
)

if TYPE_CHECKING:
    import scipy.sparse as sp

    from ancfsparse.solve.linearization.linearized_system import LinearizedSystem


N_MATRICES = 20  # arrays on the pattern: six matrices with their triangles and indices
DIFFERENCE_ROTATION = 1e-5  # change of a slope over which the stiffness is differentiated [rad]
ZERO_RATIO = 1e-9  # eigenvalues over the largest that are rounding


def buckling(of: Scene | Equilibrium, n: int = 1) -> Buckling:
    """Find the buckling loads of a scene as multiples of its loads, and the buckling shapes.

    Stresses are assumed to grow in proportion to the loads, from the stress-free shape (Euler's
    loads) or from those of an equilibrium, at constant shape.  All loads and gravity grow together;
    prescribed motions and functions of the motion do not change.

    Parameters
    ----------
    of : Scene or Equilibrium
        A scene, about its stress-free shape; or a result of `solve_static`.  The closer an
        equilibrium is to the buckling load, the more accurate is the result.
    n : int, optional
        Number of buckling loads, the smallest multiples beyond the equilibrium.

    Returns
    -------
    Buckling
        Multiples of the loads of the scene, and shapes; at most n.

    Raises
    ------
    InputError
        If an argument is invalid, there are no loads, the equilibrium is not stable, or the factor
        cannot fit in memory.
    SingularSceneError
        If the joints leave a rigid motion free.
    ModesError
        If the loads cannot be found to working accuracy.

    Warns
    -----
    ApproximateModesWarning
        If some forces have no potential: `complex_modes` finds where they cause flutter.

    Notes
    -----
    Lanczos' method for ``(K + m K') x = 0`` with the factor of K, under the constraints; a second
    factor in a gap between multiples counts those below, so that none is missing.
    """
    n = check_count("n", n)
    n_vectors = VECTORS_PER_MODE * (n + N_EXTRA_MODES)
    with linearized_in_memory(of, None, N_MATRICES, n_vectors) as linearized:
        check_restrained(linearized.system)
        base = float(isinstance(of, Equilibrium))
        path = _StressPath(linearized, base)
        multiples, motions = _lowest_multiples(linearized, path, n)
    system = linearized.system
    if not system.conservative:
        warnings.warn(ApproximateModesWarning(), stacklevel=2)
    shapes = np.zeros((len(multiples), system.n_all))
    shapes[:, : system.n_free] = motions
    return Buckling(system, linearized.state, shapes, base + multiples)


class _StressPath:
    """Derivatives of the stresses of a state and of their stiffness with respect to the loads.

    Parameters
    ----------
    linearized : LinearizedSystem
        The matrices; its factor is replaced by that of the stiffness.
    base : float
        Load factor of its state.
    """

    def __init__(self, linearized: LinearizedSystem, base: float) -> None:
        system, state = linearized.system, linearized.state
        self._linearized, self._base = linearized, base
        self._loads = system.loads.amplitudes(np.array([state.t]))[0]
        self._grows = system.loads.growing
        negative = linearized.factor_stiffness()
        if negative is None or negative > 0:
            raise InputError(
                "the equilibrium is not stable: use one at a smaller load, or the scene itself, "
                "whose buckling loads are those of its stress-free shape"
            )
        zero = np.zeros_like(state.q)

        def force(load: float) -> Vector:
            args = load * system.dead_load, self.amplitudes(load)
            r = system.assembly.residual(state.q, zero, zero, state.lam, *args)[0]
            return np.array(r)[: system.n_free]

        loads = force(base) - force(base + 1.0)
        if not loads.any():
            raise InputError("the scene has no loads that could make it buckle: add some")
        dq, self._dlam = linearized.solve_with_multipliers(loads)
        self._dq = np.concatenate([dq, np.zeros(len(state.q) - len(dq))])
        positions = system.positions
        slopes = np.ones(len(self._dq), dtype=bool)
        slopes[positions] = False
        span = float(np.max(np.ptp(state.q[positions]), initial=0.0))
        rotation = np.max(np.abs(self._dq[slopes]), initial=0.0)
        rate = float(max(rotation, np.max(np.abs(self._dq[positions])) / span))
        self._small = DIFFERENCE_ROTATION / rate

    def amplitudes(self, load: float) -> Vector:
        """Return the amplitudes of the loads at a load factor."""
        return np.asarray(np.where(self._grows, load, 1.0) * self._loads)

    def change(self) -> Vector:
        """Return the derivative of the geometric stiffness by the load factor, on the pattern.

        The material stiffness is left out: it only rotates with the scene, and a linear
        extrapolation of the rotation would soften a bent beam by far more than stresses do.
        """
        system, state = self._linearized.system, self._linearized.state
        values = []
        for sign in (1.0, -1.0):
            step = sign * self._small
            q, lam = state.q + step * self._dq, state.lam + step * self._dlam
            amplitudes = self.amplitudes(self._base + step)
            matrix = np.array(system.assembly.matrix(0.0, 1.0, q, lam, amplitudes))
            values.append(matrix - system.assembly.material(0.0, 1.0, q))
        out = (values[0] - values[1]) / (2.0 * self._small)
        n = system.n_free
        indices = system.pattern.indices
        out[: len(indices)][indices >= n] = 0.0  # the constraints do not change
        return np.asarray(out)


def _lowest_multiples(
    linearized: LinearizedSystem, path: _StressPath, n: int
) -> tuple[Vector, Vector]:
    """Return the smallest positive multiples, and motions (k, n_free) with ``x.M x = 1``."""
    values = path.change()
    change = symmetric_from_lower(free_submatrix(linearized.system, values))
    size, m = len(linearized.diagonal), linearized.system.n_multipliers
    if size - m <= MAX_DENSE_COORDINATES:
        from scipy.linalg import eigh

        basis = admissible_motions(linearized)
        assert basis is not None
        linearized.factor_stiffness()
        # Flexible motions must not be lost in the rounding of stiff ones.
        basis = np.linalg.qr(linearized.solve_all(linearized.mass @ basis))[0]
        inner, outer = (basis.T @ (matrix @ basis) for matrix in (linearized.stiffness, change))
        roots, mixes = eigh(0.5 * (outer + outer.T), 0.5 * (inner + inner.T))
        vectors = basis @ mixes
    else:
        roots, vectors = _solve_lanczos(linearized, change, min(n + N_EXTRA_MODES, (size - m) // 2))
    order = np.argsort(roots)
    roots, vectors = roots[order], vectors[:, order]
    real = roots < -ZERO_RATIO * np.max(np.abs(roots))
    multiples, vectors = -1.0 / roots[real], vectors[:, real]
    _check_none_missing(linearized, values, multiples, n)
    multiples, vectors = multiples[:n], vectors[:, :n]
    vectors = vectors / np.sqrt(np.sum(vectors * (linearized.mass @ vectors), axis=0))
    return multiples, vectors.T.copy()


def _solve_lanczos(
    linearized: LinearizedSystem, change: sp.csr_array, k: int
) -> tuple[Vector, Vector]:
    """Return the k lowest roots of ``change x = root K x`` and their motions."""
    from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

    n = len(linearized.diagonal)
    force = np.sqrt(linearized.diagonal) * np.random.default_rng(0).standard_normal(n)

    def solve(r: Vector) -> Vector:
        return np.asarray(linearized.solve_all(np.ravel(r)[:, None])[:, 0])

    try:
        roots, vectors = eigsh(
            change,
            k,
            linearized.stiffness,
            Minv=LinearOperator((n, n), matvec=solve, dtype=float),
            which="SA",
            v0=solve(force),
        )
    except ArpackError as error:
        raise ModesError(str(error)) from error
    return roots, vectors


def _check_none_missing(
    linearized: LinearizedSystem, change: Vector, multiples: Vector, n: int
) -> None:
    """Check the number of multiples below a gap by the inertia of the stiffness there."""
    last = multiples[n - 1 :]
    gaps = np.diff(last) / last[1:]
    if not len(gaps):
        return
    at = n + int(np.argmax(gaps))
    between = 0.5 * (multiples[at - 1] + multiples[at])
    count = linearized.factor_stiffness(between * change)
    if count is not None and count != at:
        raise ModesError(f"{count} buckling loads are below a gap, and {at} were found")
