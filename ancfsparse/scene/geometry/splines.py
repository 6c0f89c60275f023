"""Splines through points, and curves given by functions, as functions of the arc length."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev, legendre
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import call_function, check_reals
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.geometry.curves import Arc, Helix, Path

Function = Callable[[Vector], Vector]
AnyCurve = Arc | Helix | ArrayLike | Function

PANEL_POINTS = 16  # Gauss points of an interval, and Chebyshev points of a panel

INITIAL_PANELS = 8
MAX_PANELS = 4096
MAX_TRUNCATION = 1e-12  # error of the interpolation, over the extent of the curve
MIN_CORNER_ANGLE = 1e-6  # [rad], between the tangents at both sides of a point
COINCIDENCE_RATIO = 1e-12  # distance of coincident points, over the length


def path_of(what: str, curve: AnyCurve, dim: int) -> Path:
    """Return the `curve` of `Scene.add_beam` as a function of its arc length.

    Raises
    ------
    InputError
        If it is not a curve, is not smooth, or has another dimension.
    """
    if isinstance(curve, Arc | Helix):
        own = 3 if isinstance(curve, Helix) else len(curve.centre)
        if own != dim:
            raise InputError(
                f"{what} has {own} dimensions, but the scene has {dim}: give a curve of {dim} "
                "dimensions"
            )
        return curve
    if callable(curve):
        return _Smooth(what, *_interpolate(what, curve, dim))
    return _Smooth(what, *_spline(what, curve, dim))


class _Smooth:
    """A curve of a parameter u as a function of its arc length.

    Parameters
    ----------
    what : str
        Name in messages.
    knots : ndarray, shape (n + 1,)
        Ends of the intervals of u within which it is analytic.
    value, slope : callable
        Positions [m] and derivatives by u, (k, dim), at (k,).
    """

    def __init__(self, what: str, knots: Vector, value: Function, slope: Function) -> None:
        self._value, self._slope = value, slope
        self._rule = legendre.leggauss(PANEL_POINTS)
        total = 0.0
        while True:  # halve the intervals until the length has converged
            lengths = self._between(knots[:-1], knots[1:])
            previous, total = total, float(lengths.sum())
            if abs(total - previous) <= 1e-14 * total or len(knots) > 64 * MAX_PANELS:
                break
            knots = np.sort(np.concatenate([knots, 0.5 * (knots[:-1] + knots[1:])]))
        self._knots, self._arcs = knots, np.concatenate([[0.0], np.cumsum(lengths)])
        speeds = np.linalg.norm(slope(knots), axis=1)
        slow = int(np.argmin(speeds))
        if not speeds[slow] > COINCIDENCE_RATIO * total:
            raise InputError(
                f"{what} has zero velocity at parameter {knots[slow]:.6g}, where it has no "
                "direction: give a curve whose derivative is nowhere zero"
            )

    @property
    def length(self) -> float:
        """Length [m]."""
        return float(self._arcs[-1])

    def at(self, s: Vector) -> tuple[Vector, Vector]:
        """Return positions [m] and unit tangents, each (k, dim), at arc lengths (k,) [m]."""
        arcs, knots = self._arcs, self._knots
        i = np.clip(np.searchsorted(arcs, s, side="right") - 1, 0, len(arcs) - 2)
        fraction = (s - arcs[i]) / (arcs[i + 1] - arcs[i])
        u = knots[i] + fraction * (knots[i + 1] - knots[i])
        for _ in range(8):  # Newton's method: the derivative of the arc length is the speed
            off = arcs[i] + self._between(knots[i], u) - s
            u = np.clip(u - off / np.linalg.norm(self._slope(u), axis=1), knots[i], knots[i + 1])
        slopes = self._slope(u)
        return self._value(u), slopes / np.linalg.norm(slopes, axis=1)[:, None]

    def _between(self, start: Vector, end: Vector) -> Vector:
        """Return the lengths of intervals of u, (k,) [m]."""
        x, w = self._rule
        half = 0.5 * (end - start)
        u = start[:, None] + half[:, None] * (1.0 + x)
        speeds = np.linalg.norm(self._slope(u.ravel()), axis=1).reshape(u.shape)
        return np.asarray(half * (speeds @ w))


def _spline(what: str, points: ArrayLike, dim: int) -> tuple[Vector, Function, Function]:
    """Interpolate points by a cubic spline in the chord length."""
    from scipy.interpolate import CubicSpline

    table = check_reals(what, points, "an Arc, a Helix, a table of points or a function")
    if table.ndim != 2 or table.shape[1] != dim or len(table) < 2 or not np.isfinite(table).all():
        raise InputError(
            f"{what} must be an Arc, a Helix, a function, or at least two points of {dim} finite "
            f"numbers, got {format_value(points)}"
        )
    chords = np.linalg.norm(np.diff(table, axis=0), axis=1)
    coincide = chords <= COINCIDENCE_RATIO * chords.sum()
    if coincide.any():
        i = int(np.argmax(coincide))
        raise InputError(f"{what} has the same point twice, number {i} and {i + 1}: leave one out")
    closed = (
        len(table) > 3 and np.linalg.norm(table[-1] - table[0]) <= COINCIDENCE_RATIO * chords.sum()
    )
    if closed:
        table[-1] = table[0]
    knots = np.concatenate([[0.0], np.cumsum(chords)])
    spline = CubicSpline(knots, table, bc_type="periodic" if closed else "not-a-knot")
    return knots, spline, spline.derivative()


def _interpolate(what: str, curve: Function, dim: int) -> tuple[Vector, Function, Function]:
    """Interpolate a function by Chebyshev polynomials in panels, doubled to the tolerance."""
    x = np.cos(np.pi * (np.arange(PANEL_POINTS) + 0.5) / PANEL_POINTS)
    transform = chebyshev.chebvander(x, PANEL_POINTS - 1).T * (2.0 / PANEL_POINTS)
    transform[0] *= 0.5
    panels = INITIAL_PANELS
    while True:
        knots = np.linspace(0.0, 1.0, panels + 1)
        middle, half = 0.5 * (knots[:-1] + knots[1:]), 0.5 / panels
        values = _evaluate(what, curve, (middle[:, None] + half * x).ravel(), dim)
        coefficients = np.einsum(
            "kj,pjd->kpd", transform, values.reshape(panels, PANEL_POINTS, dim)
        )
        extent = np.linalg.norm(np.ptp(values, axis=0))
        if not extent > 0.0:
            raise InputError(f"{what} is a single point: its function always returns {values[0]}")
        truncation = np.abs(coefficients[-2:]).max(axis=(0, 2))
        if truncation.max() <= MAX_TRUNCATION * extent:
            break
        if panels == MAX_PANELS:
            raise InputError(
                f"{what} is not smooth near parameter {middle[np.argmax(truncation)]:.4g}: a kink "
                "or a jump needs two beams that are welded, noise a spline through points"
            )
        panels *= 2
    slopes = chebyshev.chebder(coefficients) / half

    def evaluate(table: Vector, u: Vector) -> Vector:
        panel = np.clip((u * panels).astype(int), 0, panels - 1)
        basis = chebyshev.chebvander((u - middle[panel]) / half, len(table) - 1)
        return np.asarray(np.einsum("uk,kud->ud", basis, table[:, panel]))

    ends = np.stack([chebyshev.chebval(side, slopes) for side in (-1.0, 1.0)])
    before, after = (side / np.linalg.norm(side, axis=1)[:, None] for side in (ends[1], ends[0]))
    angles = np.linalg.norm(after[1:] - before[:-1], axis=1)
    if angles.max() > MIN_CORNER_ANGLE:
        raise InputError(
            f"{what} has a corner at parameter {knots[1 + np.argmax(angles)]:.4g}: make it of two "
            "beams that are welded"
        )
    return knots, lambda u: evaluate(coefficients, u), lambda u: evaluate(slopes, u)


def _evaluate(what: str, curve: Function, u: Vector, dim: int) -> Vector:
    result = call_function(what, curve, u.copy(), f"for an array of {len(u)} parameters")
    values = check_reals(f"the result of {what}", result, "an array of numbers")
    if values.shape != (len(u), dim):
        raise InputError(
            f"{what} returned shape {values.shape} for parameters of shape {u.shape}: one row of "
            f"{dim} coordinates per parameter is needed, as numpy.column_stack makes it"
        )
    if not np.isfinite(values).all():
        i = int(np.argmin(np.isfinite(values).all(axis=1)))
        raise InputError(f"{what} must be finite, got {values[i]} at parameter {u[i]:.6g}")
    return values
