"""The lowest eigenvalues of small motions by shift-and-invert Lanczos, checked by counting."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, ModesError
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.solve.linearization.linearized_system import LinearizedSystem

Vector = NDArray[np.float64]
Found = tuple[Vector, Vector]

# Up to this many degrees of freedom a dense solver finds all eigenvalues sooner.
DENSE = 100
# Relative singular value that decides the rank of responses to random forces.
RANK = 1e-8
# Least shift relative to the squares of the highest frequencies: well above rounding.
LEAST_SHIFT = 1e-12
# Shift relative to the largest wanted eigenvalue, and its tolerance: seen from it the wanted
# eigenvalues are well separated, and none is so close that the others are lost in rounding.
SHARE, NEAREST, FARTHEST = 1e-2, 3.0, 1e5
MOST_SHIFTS = 12
# Restarts of Lanczos' method, which takes a few where eigenvalues are above rounding.
MOST_RESTARTS = 30
# Eigenvalues beyond the wanted ones, among which a gap is looked for; and vectors over all
# coordinates for each of all these, of Lanczos' method and of what refines its modes.
BEYOND, VECTORS = 4, 5
# Largest relative residual of a mode, and the error of a first look at the eigenvalues.
TOLERANCE, ROUGH = 1e-6, 0.1
# Rounding of an eigenvalue in units of eps |x| |K| |x|, and of a motion in units of eps, whose
# square counts where nothing else is stiff.
ROUNDING, MOTION = 4.0, 1e3


def lowest(
    pencil: LinearizedSystem, n: int, motions: Vector | None
) -> tuple[Vector, Vector, Vector]:
    """Find the n lowest eigenvalues of ``K x + Phi_q^T mu = w M x``, ``Phi_q x = 0``.

    Parameters
    ----------
    pencil : Pencil
        The matrices.
    n : int
        How many.
    motions : (n_free, k) float or None
        What `all_motions` has returned.

    Returns
    -------
    values : (n,) float
        Eigenvalues in ascending order [1/s2].
    vectors : (n, n_free) float
        Motions, with ``x.M x = 1`` and orthogonal to one another.
    rounding : (n,) float
        Bound of the error of each eigenvalue from rounding of the stiffness [1/s2].

    Raises
    ------
    ModesError
        If the method does not converge.
    """
    _, vectors = _by_lanczos(pencil, n) if motions is None else _by_dense(pencil, n, motions)
    stiff, heavy = (
        np.sum(vectors * (each @ vectors), axis=0) for each in (pencil.stiffness, pencil.mass)
    )
    values, vectors = stiff / heavy, vectors / np.sqrt(heavy)  # to rounding, also where near zero
    largest = np.argmax(np.abs(vectors) * np.sqrt(pencil.diagonal)[:, None], axis=0)
    vectors = (vectors * np.sign(vectors[largest, np.arange(n)])).T.copy()
    size = np.abs(vectors)
    rounding = ROUNDING * EPSILON * np.sum(size * (abs(pencil.stiffness) @ size.T).T, axis=1)
    return values, vectors, rounding + (MOTION * EPSILON) ** 2 * pencil.size


def most_modes(pencil: LinearizedSystem, motions: Vector | None) -> int:
    """Return how many modes can be found: all if there are few, else half."""
    if motions is not None:
        return int(motions.shape[1])
    return (pencil.system.n_free - pencil.system.n_multipliers) // 2


def _by_dense(pencil: LinearizedSystem, n: int, motions: Vector) -> Found:
    """Solve a small dense problem on the admissible motions, and refine its modes."""
    from scipy.linalg import eigh

    stiffness, mass = (motions.T @ (each @ motions) for each in (pencil.stiffness, pencil.mass))
    # All modes: a search for the lowest alone fails where many frequencies are equal or zero.
    values, mixes = (found[..., :n] for found in eigh(stiffness, mass))
    # The shift must not be close to eigenvalues that are zero up to rounding.
    _factor_below(pencil, -max(SHARE * float(np.abs(values).max()), LEAST_SHIFT * pencil.size))
    return _refined(pencil, motions @ mixes)


def all_motions(pencil: LinearizedSystem) -> Vector | None:
    """Return a basis of the admissible motions, (n_free, k); None if there are too many.

    Raises
    ------
    InputError
        If there are none.
    """
    unit, m = np.sqrt(pencil.diagonal), pencil.system.n_multipliers
    n = len(unit)
    if n <= DENSE and not m:
        return np.diag(1.0 / unit)
    if n - m > DENSE:
        return None
    # At a shift beyond the squares of the highest frequencies no motion is preferred, and none that
    # a rotating frame throws outward is singular.
    least = RANK / abs(_factor_below(pencil, -2.0 * pencil.size))
    random = np.random.default_rng(0)
    size = max(n - m, 0) + BEYOND
    while size <= 2 * DENSE:
        forces = unit[:, None] * random.standard_normal((n, size))
        motions, sizes, _ = np.linalg.svd(
            unit[:, None] * pencil.solve_all(forces), full_matrices=False
        )
        # Where nothing can move, all of them are rounding.
        rank = np.count_nonzero(sizes > max(RANK * sizes[0], least))
        if rank == 0:
            raise InputError(
                "the joints and drives of the scene hold everything, so nothing can vibrate: leave "
                "one out, or take an elastic beam"
            )
        if rank < size:
            return np.asarray(motions[:, :rank] / unit[:, None])
        size *= 2  # some constraints are redundant
    return None


def _by_lanczos(pencil: LinearizedSystem, n: int) -> Found:
    """Solve a large problem with a shift below all eigenvalues; check that none is missing."""
    k = n + BEYOND
    below = _place_shift(pencil, n)
    values, vectors = _refined(pencil, _near(pencil, k)[1])
    for _ in range(MOST_SHIFTS):
        missing = _missing(pencil, values, n)
        pencil.factor(below)
        if not missing:
            break
        more = _near(pencil, missing + 1, vectors)
        if more[0][0] > values[-1]:
            break  # nothing is missing: the count suffered from rounding
        values, vectors = _refined(pencil, np.hstack([vectors, more[1]]))
    else:
        raise ModesError(f"eigenvalues are still missing after {MOST_SHIFTS} searches")
    again = pencil.solve_all(pencil.mass @ vectors[:, :n]) * (values[:n] - below)
    off = vectors[:, :n] - again
    residual = np.sqrt(np.max(np.sum(off * (pencil.mass @ off), axis=0)))
    # Errors of modes from rounding of the factor; those of eigenvalues are their squares.
    if not residual <= TOLERANCE + ROUNDING * EPSILON * pencil.size / abs(below):
        raise ModesError(f"a mode has the relative residual {residual:.2g}")
    return values[:n], vectors[:, :n]


def _place_shift(pencil: LinearizedSystem, n: int) -> float:
    """Factor at a shift below all eigenvalues and not far from the wanted ones; return it."""
    least = LEAST_SHIFT * pencil.size
    if least == 0.0:
        return _factor_below(pencil, least)
    shift = -least
    for _ in range(MOST_SHIFTS):
        if pencil.factor(shift) is None:
            shift *= 2.0
            continue
        farthest = float(np.max(np.abs(_near(pencil, n, tolerance=ROUGH)[0])))
        if NEAREST <= farthest / -shift <= FARTHEST:
            break
        new = -max(SHARE * farthest, least)
        if new == shift:
            break
        shift = new
    return _factor_below(pencil, shift)


def _factor_below(pencil: LinearizedSystem, shift: float) -> float:
    """Factor at a shift, or at a lower one below all eigenvalues; return it."""
    shift = shift or -1.0  # nothing is stiff: any shift does
    while pencil.factor(shift) != 0:
        shift *= 4.0
        if not np.isfinite(shift):
            raise ModesError("the stiffness is not finite")
    return shift


def _near(
    pencil: LinearizedSystem, k: int, known: Vector | None = None, tolerance: float = 0.0
) -> Found:
    """Find the k eigenvalues next to the shift, ascending, apart from known modes (n_free, j)."""
    from scipy.sparse.linalg import ArpackError, ArpackNoConvergence, LinearOperator, eigsh

    n, mass = len(pencil.diagonal), pencil.mass
    known = np.zeros((n, 0)) if known is None else known
    moved = mass @ known

    def solve(force: Vector) -> Vector:
        x = pencil.solve(force)
        return np.asarray(x - known @ (moved.T @ x))

    force = np.sqrt(pencil.diagonal) * np.random.default_rng(0).standard_normal(n)
    try:
        values, vectors = eigsh(
            pencil.stiffness,
            k,
            mass,
            sigma=pencil.shift,
            OPinv=LinearOperator((n, n), matvec=solve, dtype=float),
            v0=solve(force),  # satisfies the constraints; the same in every call
            tol=tolerance,
            maxiter=MOST_RESTARTS,
        )
    except ArpackNoConvergence as error:
        lost = math.sqrt(ROUNDING * EPSILON * pencil.size) / (2.0 * math.pi)
        raise ModesError(
            f"Lanczos' method does not converge: the lowest frequencies are lost in the rounding "
            f"of the stiffness, which hides those below about {lost:.3g} Hz; take longer elements, "
            "or the equilibrium under the loads, whose stress stiffens slender parts"
        ) from error
    except ArpackError as error:
        raise ModesError(str(error)) from error
    order = np.argsort(values)
    return values[order], vectors[:, order]


def _refined(pencil: LinearizedSystem, vectors: Vector) -> Found:
    """Improve modes together: one inverse iteration, and a Rayleigh-Ritz projection."""
    from scipy.linalg import eigh

    vectors = pencil.solve_all(pencil.mass @ vectors)
    vectors = vectors / np.sqrt(np.sum(vectors * (pencil.mass @ vectors), axis=0))
    stiffness, mass = (vectors.T @ (each @ vectors) for each in (pencil.stiffness, pencil.mass))
    values, mixes = eigh(stiffness, mass)
    return values, vectors @ mixes


def _missing(pencil: LinearizedSystem, values: Vector, n: int) -> int:
    """Count the eigenvalues below a gap above the wanted ones; return how many are missing."""
    gaps = np.diff(values[n - 1 :]) / (np.abs(values[n:]) + abs(pencil.shift))
    if not len(gaps):
        return 0
    at = n - 1 + int(np.argmax(gaps))
    between = 0.5 * (values[at] + values[at + 1])
    if abs(between) <= LEAST_SHIFT * pencil.size:
        return 0  # all are zero but for rounding, and none is below the shift
    count = pencil.factor(between)
    return 0 if count is None else max(count - (at + 1), 0)
