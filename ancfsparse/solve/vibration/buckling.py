"""Buckling: the multiples of the loads under which equilibria stop being stable."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_count
from ancfsparse.errors import ApproximateModesWarning, InputError, ModesError
from ancfsparse.nonlinear import Newton
from ancfsparse.results import Equilibrium
from ancfsparse.results.solutions.buckling import Buckling
from ancfsparse.scene import Scene
from ancfsparse.solve.linearization.linearized_system import linearize, scene_to_linearize
from ancfsparse.solve.linearization.matrices import free_submatrix, symmetric_from_lower
from ancfsparse.solve.linearization.rigid_body_modes import check_restrained
from ancfsparse.solve.preparation.memory_estimate import (
    NO_MEMORY,
    check_factor_fits,
    estimate_memory,
    within_memory,
)
from ancfsparse.solve.vibration.symmetric_eigenproblem import BEYOND, DENSE, VECTORS, all_motions

if TYPE_CHECKING:
    import scipy.sparse as sp

    from ancfsparse.results.solutions.buckling import Buckling
    from ancfsparse.solve.linearization.linearized_system import LinearizedSystem

Vector = NDArray[np.float64]

# Arrays of values on the pattern: six matrices, from their triangles, with indices.
MATRICES = 20
# Change of a slope over which the stiffness is differentiated along the path of the loads.
TURN = 1e-5
# Eigenvalues of the change relative to the largest that are zero but for rounding.
NOTHING_LESS = 1e-9


def buckling(of: Scene | Equilibrium, n: int = 1) -> Buckling:
    """Find the multiples of the loads under which a scene buckles, and how.

    The stresses are taken to grow in proportion to the loads, from the stress-free shape (Euler's
    loads) or from those of an equilibrium, while the shape stays the one there.  All loads and
    gravity grow together; prescribed motions and functions of the motion stay as they are.

    Parameters
    ----------
    of : Scene or Equilibrium
        A scene, about its stress-free shape; or what `solve_static` has returned.  The closer an
        equilibrium is to the point of buckling, the more exact is what is found about it.
    n : int, optional
        How many buckling loads, those of smallest multiples beyond the equilibrium.

    Returns
    -------
    Buckling
        Multiples of the loads in the scene, and shapes; at most n.

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
    factor between two of the multiples counts those below, so that none is missing.
    """
    n = check_count("n", n)
    scene = scene_to_linearize(of)
    with within_memory(estimate_memory(scene, 0, 0, False, Newton(), matrices=MATRICES)):
        pencil = linearize(of, None)
        check_restrained(pencil.system)
        vectors = 8.0 * VECTORS * (n + BEYOND) * pencil.seed.n
        check_factor_fits(replace(NO_MEMORY, vectors=vectors), pencil.seed)
        base = float(isinstance(of, Equilibrium))
        path = _Path(pencil, base)
        multiples, motions = _lowest(pencil, path, n)
    system = pencil.system
    if not system.conservative:
        warnings.warn(ApproximateModesWarning(), stacklevel=2)
    shapes = np.zeros((len(multiples), system.n_all))
    shapes[:, : system.n_free] = motions
    return Buckling(system, pencil.state, base + multiples, shapes)


class _Path:
    """How the stresses of a state and their stiffness change with the loads.

    Parameters
    ----------
    pencil : Pencil
        The matrices; its factor is replaced by that of the stiffness.
    base : float
        Share of the loads in its state.
    """

    def __init__(self, pencil: LinearizedSystem, base: float) -> None:
        system, state = pencil.system, pencil.state
        self._pencil, self._base = pencil, base
        self._loads = system.loads.amplitudes(np.array([state.t]))[0]
        self._grows = system.loads.growing
        negative = pencil.factor_stiffness()
        if negative is None or negative > 0:
            raise InputError(
                "the equilibrium is not stable: take one under a smaller share of the loads, or "
                "the scene itself, whose buckling loads are those of its stress-free shape"
            )
        rest = np.zeros_like(state.q)

        def force(share: float) -> Vector:
            args = share * system.dead_load, self.amplitudes(share)
            r = system.assembly.residual(state.q, rest, rest, state.lam, *args)[0]
            return np.array(r)[: system.n_free]

        pull = force(base) - force(base + 1.0)
        if not pull.any():
            raise InputError("the scene has no loads that could make it buckle: add some")
        dq, self._dlam = pencil.solve_with_multipliers(pull)
        self._dq = np.concatenate([dq, np.zeros(len(state.q) - len(dq))])
        positions = system.positions
        slopes = np.ones(len(self._dq), dtype=bool)
        slopes[positions] = False
        span = float(np.max(np.ptp(state.q[positions]), initial=0.0))
        turn = np.max(np.abs(self._dq[slopes]), initial=0.0)
        way = float(max(turn, np.max(np.abs(self._dq[positions])) / span))
        self._small = TURN / way

    def amplitudes(self, share: float) -> Vector:
        """Return the amplitudes of the loads under a share of them."""
        return np.asarray(np.where(self._grows, share, 1.0) * self._loads)

    def change(self) -> Vector:
        """Return the derivative of the stress stiffness by the share, values on the pattern.

        That of the material is left out.  It only turns with the scene, and a linear extrapolation
        of the turn would soften a beam that bends by far more than stresses do.
        """
        system, state = self._pencil.system, self._pencil.state
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
        out[: len(indices)][indices >= n] = 0.0  # the constraints stay
        return np.asarray(out)


def _lowest(pencil: LinearizedSystem, path: _Path, n: int) -> tuple[Vector, Vector]:
    """Return the smallest positive multiples, and motions (k, n_free) with ``x.M x = 1``."""
    values = path.change()
    change = symmetric_from_lower(free_submatrix(pencil.system, values))
    size, m = len(pencil.diagonal), pencil.system.n_multipliers
    if size - m <= DENSE:
        from scipy.linalg import eigh

        basis = all_motions(pencil)
        assert basis is not None
        pencil.factor_stiffness()
        # Motions that the stiffness leaves easy must not be lost beside stiff ones.
        basis = np.linalg.qr(pencil.solve_all(pencil.mass @ basis))[0]
        inner, outer = (basis.T @ (each @ basis) for each in (pencil.stiffness, change))
        roots, mixes = eigh(0.5 * (outer + outer.T), 0.5 * (inner + inner.T))
        vectors = basis @ mixes
    else:
        roots, vectors = _by_lanczos(pencil, change, min(n + BEYOND, (size - m) // 2))
    order = np.argsort(roots)
    roots, vectors = roots[order], vectors[:, order]
    real = roots < -NOTHING_LESS * np.max(np.abs(roots))
    multiples, vectors = -1.0 / roots[real], vectors[:, real]
    _check_none_missing(pencil, values, multiples, n)
    multiples, vectors = multiples[:n], vectors[:, :n]
    vectors = vectors / np.sqrt(np.sum(vectors * (pencil.mass @ vectors), axis=0))
    return multiples, vectors.T.copy()


def _by_lanczos(pencil: LinearizedSystem, change: sp.csr_array, k: int) -> tuple[Vector, Vector]:
    """Return the k lowest roots of ``change x = root K x`` and their motions."""
    from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

    n = len(pencil.diagonal)
    force = np.sqrt(pencil.diagonal) * np.random.default_rng(0).standard_normal(n)

    def solve(r: Vector) -> Vector:
        return np.asarray(pencil.solve_all(np.ravel(r)[:, None])[:, 0])

    try:
        roots, vectors = eigsh(
            change,
            k,
            pencil.stiffness,
            Minv=LinearOperator((n, n), matvec=solve, dtype=float),
            which="SA",
            v0=solve(force),
        )
    except ArpackError as error:
        raise ModesError(str(error)) from error
    return roots, vectors


def _check_none_missing(
    pencil: LinearizedSystem, change: Vector, multiples: Vector, n: int
) -> None:
    """Count the multiples below a gap by the inertia of the stiffness there."""
    last = multiples[n - 1 :]
    gaps = np.diff(last) / last[1:]
    if not len(gaps):
        return
    at = n + int(np.argmax(gaps))
    between = 0.5 * (multiples[at - 1] + multiples[at])
    count = pencil.factor_stiffness(between * change)
    if count is not None and count != at:
        raise ModesError(f"{count} buckling loads are below a gap, and {at} were found")
