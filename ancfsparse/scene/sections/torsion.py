"""Saint-Venant torsion of a polygon by rational functions with poles at its corners.

The stress function is psi - rho^2 / 2 with psi harmonic and rho the distance from the centre: psi
is rho^2 / 2 on the outline, and that plus one constant around each hole.  It is the real part of
an analytic function f without logarithms, since its conjugate, the warping, has one value
everywhere.  With it J = int rho^2 dA - int |f'|^2 dA.

f is a polynomial, powers of 1/z in holes, and poles that cluster at the corners, outside of the
material (Gopal and Trefethen, SIAM J. Numer. Anal. 57 (2019) 2074), fitted on the outline.  Poles
are added where the misfit is largest until the constant has converged.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator

import numpy as np

from ancfsparse.array_types import Complex, Vector
from ancfsparse.scene.sections.cross_section import power

TOLERANCE = 1e-5  # change of the constant by the last poles, over the constant
MAX_UNKNOWNS = 700
DEGREE = 12  # of the polynomial, and of the powers in holes
INITIAL_POLES = 3  # at each corner
CLUSTERING = 4.0  # logarithm of the distance of poles over the square root of their number
FIT_POINTS = 5  # of an interval of the outline, for the least-squares fit
GAUSS_POINTS = 12  # of an interval of the outline, for its integrals
MAX_MISFIT_RATIO = 0.1  # of a corner, over the largest one, without more poles


def torsion_constant(loops: list[Complex]) -> tuple[float, float]:
    """Solve the torsion of a polygon.

    Parameters
    ----------
    loops : list of (n,) complex
        Corners of the outline, counterclockwise, then of every hole, clockwise [m].

    Returns
    -------
    constant, change : float
        Torsion constant, and its change by the last poles [m4].
    """
    centre = loops[0].mean()
    size = float(np.abs(loops[0] - centre).max())
    loops = [(loop - centre) / size for loop in loops]
    corners, outward = (
        np.concatenate(loops),
        np.concatenate([_outward_bisectors(loop) for loop in loops]),
    )
    reach = _free_distances(loops, corners, outward)
    counts, previous = np.full(len(corners), INITIAL_POLES), math.inf
    while True:
        distances = [_pole_distances(n, far) for n, far in zip(counts, reach, strict=True)]
        f, levels = _fit(loops, corners, outward, distances)
        misfit, constant = np.zeros(len(corners)), 0.0
        for level, nearest, z, dz in _intervals(loops, levels, distances, GAUSS_POINTS):
            values, turned = f(z), np.conj(z) * dz
            off = np.abs(values.real - 0.5 * np.abs(z) ** 2 - level).max()
            misfit[nearest] = max(misfit[nearest], off)
            # int rho^2 dA, and int |f'|^2 dA by parts, as integrals along the outline
            constant += float((0.25 * np.abs(z) ** 2 * turned.imag).sum())
            constant += float((values.imag * turned.real).sum())
        change, previous = abs(constant - previous), constant
        if change <= TOLERANCE * constant or 2 * counts.sum() >= MAX_UNKNOWNS:
            factor = power(size, 4)
            return factor * constant, factor * min(change, constant)
        counts = np.where(
            misfit > MAX_MISFIT_RATIO * misfit.max(), counts + np.maximum(3, counts // 3), counts
        )


def _outward_bisectors(loop: Complex) -> Complex:
    """Return the unit bisectors of the corners, out of the material on the left of the loop."""
    before, after = np.roll(loop, 1) - loop, np.roll(loop, -1) - loop
    inside = np.angle(before / after) % (2.0 * math.pi)
    return np.asarray(-after / np.abs(after) * np.exp(0.5j * inside))


def _free_distances(loops: list[Complex], corners: Complex, outward: Complex) -> Vector:
    """Return half the distance along the bisectors to other material; at most the size."""
    starts = np.concatenate(loops)
    along = np.concatenate([np.roll(loop, -1) - loop for loop in loops])
    reach = np.ones(len(corners))
    for k, (corner, bisector) in enumerate(zip(corners, outward, strict=True)):
        cross = (np.conj(bisector) * along).imag
        with np.errstate(divide="ignore", invalid="ignore"):
            offset = starts - corner
            far = (np.conj(along) * offset).imag / -cross
            fraction = (np.conj(bisector) * offset).imag / -cross
        hit = (far > 1e-9) & (fraction >= 0.0) & (fraction <= 1.0)
        reach[k] = min(1.0, 0.5 * far[hit].min(initial=2.0))
    return reach


def _pole_distances(n: int, reach: float) -> Vector:
    return reach * np.exp(-CLUSTERING * (math.sqrt(n) - np.sqrt(np.arange(1, n + 1))))


def _intervals(
    loops: list[Complex], levels: Iterable[float], distances: list[Vector], points: int
) -> Iterator[tuple[float, int, Complex, Complex]]:
    """Divide the outline into intervals, towards the corners shorter than their nearest poles.

    An interval is the level of its loop, the number of the nearest corner, points, and steps there.
    """
    x, w = np.polynomial.legendre.leggauss(points)
    first = 0
    for loop, level in zip(loops, levels, strict=True):
        n = len(loop)
        for k in range(n):
            along = loop[(k + 1) % n] - loop[k]
            for end, sign in ((first + k, 1.0), (first + (k + 1) % n, -1.0)):
                start = loop[k] if sign > 0 else loop[(k + 1) % n]
                finest = distances[end][0] / (4.0 * abs(along))
                halvings = max(1, math.ceil(-math.log2(2.0 * finest)))
                breaks = np.concatenate([[0.0], 0.5 ** np.arange(halvings + 1, 0, -1)])
                half = 0.5 * np.diff(breaks)
                t = (0.5 * (breaks[1:] + breaks[:-1])[:, None] + half[:, None] * x).ravel()
                z = start + sign * along * t
                yield level, end, z, along * (half[:, None] * w).ravel()
        first += n


def _fit(
    loops: list[Complex], corners: Complex, outward: Complex, distances: list[Vector]
) -> tuple[Callable[[Complex], Complex], Vector]:
    """Fit f on the outline; return it and the constants of the loops."""
    from scipy.linalg import lstsq

    poles = np.concatenate([c + d * o for c, o, d in zip(corners, outward, distances, strict=True)])
    sizes = np.concatenate(distances)
    holes = [(loop.mean(), np.abs(loop - loop.mean()).min()) for loop in loops[1:]]

    def basis(z: Complex) -> Complex:
        powers = [z[:, None] ** np.arange(DEGREE + 1)]
        powers += [(r / (z - c)[:, None]) ** np.arange(1, DEGREE + 1) for c, r in holes]
        return np.hstack([*powers, sizes / (z[:, None] - poles)])

    intervals = list(_intervals(loops, range(len(loops)), distances, FIT_POINTS))
    z = np.concatenate([interval[2] for interval in intervals])
    number = np.concatenate([np.full(len(i[2]), i[0]) for i in intervals])
    columns = basis(z)
    constants = -(number[:, None] == np.arange(1, len(loops))).astype(float)
    matrix = np.hstack([columns.real, -columns.imag[:, 1:], constants])
    solution = lstsq(matrix, 0.5 * np.abs(z) ** 2, lapack_driver="gelsy", cond=1e-15)[0]
    n = columns.shape[1]
    coefficients = solution[:n] + 1j * np.concatenate([[0.0], solution[n : 2 * n - 1]])
    return lambda z: basis(z) @ coefficients, np.concatenate([[0.0], solution[2 * n - 1 :]])
