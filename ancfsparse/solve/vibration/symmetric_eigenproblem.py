"""Lowest eigenvalues of undamped vibrations by shift-and-invert Lanczos, checked by a count."""

from __future__ import annotations

import math

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError, ModesError
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.solve.linearization.linearized_system import LinearizedSystem

Eigenpairs = tuple[Vector, Vector]

MAX_DENSE_COORDINATES = 100  # free coordinates up to which a dense solver is faster
RANK_TOLERANCE = 1e-8  # relative singular value that decides the rank of responses to random forces
MIN_SHIFT_RATIO = 1e-12  # over the squares of the highest frequencies: well above rounding
# At this distance the requested eigenvalues are well separated, and none is so close to the shift
# that the others are lost in rounding.
SHIFT_RATIO = 1e-2  # shift over the largest requested eigenvalue
MIN_SHIFT_DISTANCE = 3.0  # largest requested eigenvalue over the shift
MAX_SHIFT_DISTANCE = 1e5  # the same
MAX_SHIFTS = 12
MAX_RESTARTS = 30  # of Lanczos' method, which needs a few if eigenvalues are above rounding
N_EXTRA_MODES = 4  # eigenvalues above the requested ones, for a gap
VECTORS_PER_MODE = 5  # vectors over all coordinates per mode, of Lanczos' method and of refinement
MAX_RESIDUAL = 1e-6  # relative residual of a mode
ESTIMATE_TOLERANCE = 0.1  # relative error of the first estimate of eigenvalues
ROUNDING_UNITS = 4.0  # of an eigenvalue, in units of eps |x| |K| |x|
MOTION_ROUNDING_UNITS = 1e3  # rounding of a motion in units of eps, squared at zero stiffness


def lowest_modes(
    linearized: LinearizedSystem, n: int, motions: Vector | None
) -> tuple[Vector, Vector, Vector]:
    """Find the n lowest eigenvalues of ``K x + Phi_q^T mu = w M x``, ``Phi_q x = 0``.

    Parameters
    ----------
    linearized : LinearizedSystem
        The matrices.
    n : int
        Number of eigenvalues.
    motions : (n_free, k) float or None
        Result of `admissible_motions`.

    Returns
    -------
    values : (n,) float
        Eigenvalues in ascending order [1/s2].
    vectors : (n, n_free) float
        Motions with ``x.M x = 1``, orthogonal to one another.
    rounding : (n,) float
        Bound of the error of each eigenvalue from rounding of the stiffness [1/s2].

    Raises
    ------
    ModesError
        If the method does not converge.
    """
    _, vectors = (
        _solve_lanczos(linearized, n) if motions is None else _solve_dense(linearized, n, motions)
    )
    stiffness, mass = (
        np.sum(vectors * (matrix @ vectors), axis=0)
        for matrix in (linearized.stiffness, linearized.mass)
    )
    values, vectors = stiffness / mass, vectors / np.sqrt(mass)  # accurate also near zero
    largest = np.argmax(np.abs(vectors) * np.sqrt(linearized.diagonal)[:, None], axis=0)
    vectors = (vectors * np.sign(vectors[largest, np.arange(n)])).T.copy()
    size = np.abs(vectors)
    rounding = (
        ROUNDING_UNITS * EPSILON * np.sum(size * (abs(linearized.stiffness) @ size.T).T, axis=1)
    )
    return values, vectors, rounding + (MOTION_ROUNDING_UNITS * EPSILON) ** 2 * linearized.size


def max_modes(linearized: LinearizedSystem, motions: Vector | None) -> int:
    """Return the largest number of modes: all of a small system, half of a large one."""
    if motions is not None:
        return int(motions.shape[1])
    return (linearized.system.n_free - linearized.system.n_multipliers) // 2


def _solve_dense(linearized: LinearizedSystem, n: int, motions: Vector) -> Eigenpairs:
    """Solve the dense problem on the admissible motions, and refine the modes."""
    from scipy.linalg import eigh

    stiffness, mass = (motions.T @ (x @ motions) for x in (linearized.stiffness, linearized.mass))
    # A search for the lowest alone fails where many frequencies are equal or zero.
    values = eigh(stiffness, mass, eigvals_only=True)[:n]
    # The shift must not be close to eigenvalues that are zero up to rounding.
    shift = _factor_below(
        linearized,
        -max(SHIFT_RATIO * float(np.abs(values).max()), MIN_SHIFT_RATIO * linearized.size),
    )
    # Where some parts have next to no mass, rounding of the highest eigenvalues exceeds the lowest;
    # of the inverse problem, these are the largest.
    _, mixes = eigh(mass, stiffness - shift * mass)
    mixes = mixes[:, : -n - 1 : -1]
    return _refine(linearized, motions @ mixes)


def admissible_motions(linearized: LinearizedSystem) -> Vector | None:
    """Return a basis of the admissible motions, (n_free, k); None for a large system.

    Raises
    ------
    InputError
        If there are none.
    """
    unit, m = np.sqrt(linearized.diagonal), linearized.system.n_multipliers
    n = len(unit)
    if n <= MAX_DENSE_COORDINATES and not m:
        return np.diag(1.0 / unit)
    if n - m > MAX_DENSE_COORDINATES:
        return None
    # Beyond the squares of the highest frequencies no motion is preferred, and centrifugal forces
    # of a rotating frame cause no singular matrix.
    least = RANK_TOLERANCE / abs(_factor_below(linearized, -2.0 * linearized.size))
    random = np.random.default_rng(0)
    size = max(n - m, 0) + N_EXTRA_MODES
    while size <= 2 * MAX_DENSE_COORDINATES:
        forces = unit[:, None] * random.standard_normal((n, size))
        motions, sizes, _ = np.linalg.svd(
            unit[:, None] * linearized.solve_all(forces), full_matrices=False
        )
        # Without admissible motions all responses are rounding.
        rank = np.count_nonzero(sizes > max(RANK_TOLERANCE * sizes[0], least))
        if rank == 0:
            raise InputError(
                "the joints and prescribed motions of the scene leave nothing that can vibrate: "
                "leave one out, or use an elastic beam"
            )
        if rank < size:
            return np.asarray(motions[:, :rank] / unit[:, None])
        size *= 2  # some constraints are redundant
    return None


def _solve_lanczos(linearized: LinearizedSystem, n: int) -> Eigenpairs:
    """Solve a large problem with a shift below all eigenvalues, and check that none is missing."""
    k = n + N_EXTRA_MODES
    below = _select_shift(linearized, n)
    values, vectors = _refine(linearized, _modes_near_shift(linearized, k)[1])
    for _ in range(MAX_SHIFTS):
        missing = _count_missing(linearized, values, n)
        linearized.factor(below)
        if not missing:
            break
        further = _modes_near_shift(linearized, missing + 1, vectors)
        if further[0][0] > values[-1]:
            break  # none is missing: rounding affected the count
        values, vectors = _refine(linearized, np.hstack([vectors, further[1]]))
    else:
        raise ModesError(f"eigenvalues are still missing after {MAX_SHIFTS} searches")
    image = linearized.solve_all(linearized.mass @ vectors[:, :n]) * (values[:n] - below)
    error = vectors[:, :n] - image
    residual = np.sqrt(np.max(np.sum(error * (linearized.mass @ error), axis=0)))
    # Errors of modes by rounding of the factor; those of eigenvalues are their squares.
    if not residual <= MAX_RESIDUAL + ROUNDING_UNITS * EPSILON * linearized.size / abs(below):
        raise ModesError(f"a mode has the relative residual {residual:.2g}")
    return values[:n], vectors[:, :n]


def _select_shift(linearized: LinearizedSystem, n: int) -> float:
    """Factor at a shift below all eigenvalues and near the requested ones; return it."""
    least = MIN_SHIFT_RATIO * linearized.size
    if least == 0.0:
        return _factor_below(linearized, least)
    shift = -least
    for _ in range(MAX_SHIFTS):
        if linearized.factor(shift) is None:
            shift *= 2.0
            continue
        farthest = float(
            np.max(np.abs(_modes_near_shift(linearized, n, tolerance=ESTIMATE_TOLERANCE)[0]))
        )
        if MIN_SHIFT_DISTANCE <= farthest / -shift <= MAX_SHIFT_DISTANCE:
            break
        new = -max(SHIFT_RATIO * farthest, least)
        if new == shift:
            break
        shift = new
    return _factor_below(linearized, shift)


def _factor_below(linearized: LinearizedSystem, shift: float) -> float:
    """Factor at a shift, or at a lower one below all eigenvalues; return it."""
    shift = shift or -1.0  # without stiffness any shift will do
    while linearized.factor(shift) != 0:
        shift *= 4.0
        if not np.isfinite(shift):
            raise ModesError("the stiffness is not finite")
    return shift


def _modes_near_shift(
    linearized: LinearizedSystem, k: int, known: Vector | None = None, tolerance: float = 0.0
) -> Eigenpairs:
    """Find the k eigenvalues nearest the shift, orthogonal to known modes (n_free, j)."""
    from scipy.sparse.linalg import ArpackError, ArpackNoConvergence, LinearOperator, eigsh

    n, mass = len(linearized.diagonal), linearized.mass
    known = np.zeros((n, 0)) if known is None else known
    images = mass @ known

    def solve(force: Vector) -> Vector:
        x = linearized.solve(force)
        return np.asarray(x - known @ (images.T @ x))

    force = np.sqrt(linearized.diagonal) * np.random.default_rng(0).standard_normal(n)
    try:
        values, vectors = eigsh(
            linearized.stiffness,
            k,
            mass,
            sigma=linearized.shift,
            OPinv=LinearOperator((n, n), matvec=solve, dtype=float),
            v0=solve(force),  # satisfies the constraints; reproducible
            tol=tolerance,
            maxiter=MAX_RESTARTS,
        )
    except ArpackNoConvergence as error:
        frequency = math.sqrt(ROUNDING_UNITS * EPSILON * linearized.size) / (2.0 * math.pi)
        raise ModesError(
            f"Lanczos' method does not converge: the lowest frequencies are lost in the rounding "
            f"of the stiffness, which hides those below about {frequency:.3g} Hz; take longer "
            "elements, or the equilibrium under the loads, whose stress stiffens slender parts"
        ) from error
    except ArpackError as error:
        raise ModesError(str(error)) from error
    order = np.argsort(values)
    return values[order], vectors[:, order]


def _refine(linearized: LinearizedSystem, vectors: Vector) -> Eigenpairs:
    """Refine modes by an inverse iteration and a Rayleigh-Ritz projection."""
    from scipy.linalg import eigh

    vectors = linearized.solve_all(linearized.mass @ vectors)
    vectors = vectors / np.sqrt(np.sum(vectors * (linearized.mass @ vectors), axis=0))
    stiffness, mass = (vectors.T @ (x @ vectors) for x in (linearized.stiffness, linearized.mass))
    values, mixes = eigh(stiffness, mass)
    return values, vectors @ mixes


def _count_missing(linearized: LinearizedSystem, values: Vector, n: int) -> int:
    """Return the number of missing eigenvalues below a gap above the requested ones."""
    gaps = np.diff(values[n - 1 :]) / (np.abs(values[n:]) + abs(linearized.shift))
    if not len(gaps):
        return 0
    at = n - 1 + int(np.argmax(gaps))
    between = 0.5 * (values[at] + values[at + 1])
    if abs(between) <= MIN_SHIFT_RATIO * linearized.size:
        return 0  # all are zero up to rounding, and none is below the shift
    count = linearized.factor(between)
    return 0 if count is None else max(count - (at + 1), 0)
