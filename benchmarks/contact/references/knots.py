"""A knot that its ends tighten: no part passes through another one, and tension against size."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.problems import knot
from ancfsparse.problems.contacts import ROD_RADIUS, RUBBER, SETTLING_TIME, TIGHTENING_TIME
from ancfsparse.solve import simulate
from benchmarks.contact.references.comparison import (
    Comparison,
    compare_absolute,
    compare_relative,
    limit_above,
    limit_below,
)

SAVE_EVERY = 100  # steps
N_POINTS = 300  # of the axis, for crossings of its projection
TREFOIL = 3  # determinant of the knot; 1 without a knot
MIN_DISTANCE = 10.0  # by which the ends move, over the diameter
FRICTION_FACTOR = 0.492  # of mu eps^3 in the law of Audoly, Clauvelin and Neukirch (2007)
LAW_TOLERANCE = 0.1  # of the tension; the law is that for a thin rod, eps towards zero


@dataclass(frozen=True)
class KnotData:
    """A rod, the motion of its ends, and the times at which its tension is compared."""

    radius: float  # of the rod [m]
    slenderness: float  # radius of the rod over the final radius of the loop
    slowness: float  # of the ends
    friction: float
    dt: float  # [s]
    times: tuple[float, ...]  # [s]


KNOTS = (
    KnotData(ROD_RADIUS, 0.08, 1.0, 0.1, 2e-3, (7.6, 15.6)),
    KnotData(ROD_RADIUS, 0.08, 1.0, 0.0, 2e-3, (7.6, 15.6)),
    KnotData(0.25 * ROD_RADIUS, 1.0 / 60.0, 2.0, 0.0, 8e-3, (64.0, 112.0)),
)


def compare_knots() -> list[Comparison]:
    """Compare tightening knots with a trefoil and their tensions with the law of thin rods."""
    return [row for data in KNOTS for row in _compare_knot(data)]


def _compare_knot(data: KnotData) -> list[Comparison]:
    h, mu = data.radius, data.friction
    case = knot(mu, data.slenderness, thickness=2.0 * h, slowness=data.slowness)
    settling, tightening = (t * ROD_RADIUS / h for t in (SETTLING_TIME, TIGHTENING_TIME))
    t_end = settling + data.slowness * tightening
    run = simulate(
        case.scene, t_end, data.dt, integrator=GeneralizedAlpha(0.5), save_every=SAVE_EVERY
    )
    rod: Any = case.bodies["rod"]
    values = case.quantities(run)
    points = [rod.at(s) for s in np.linspace(0.0, rod.length, N_POINTS).tolist()]
    axes = np.stack([run.position(point) for point in points], axis=1)
    determinants = [compute_determinant(axis) for axis in axes[::5]]
    ends = run.displacement(rod.end) - run.displacement(rod.start)
    distance = float(np.linalg.norm(ends[-1])) / (2.0 * h)
    radii = values["radius"][run.t > settling]
    name = f"knot of {2e3 * h:g} mm, mu {mu:g}"
    rows = [
        limit_below(f"{name}: motion of its ends over the diameter", distance, MIN_DISTANCE),
        compare_absolute(f"{name}: smallest determinant", min(determinants), TREFOIL, 0.0),
        compare_absolute(f"{name}: largest determinant", max(determinants), TREFOIL, 0.0),
        limit_above(f"{name}: growth of the loop between states [m]", np.diff(radii).max(), 0.0),
    ]
    for t in data.times:
        state = round(t / (SAVE_EVERY * data.dt))
        eps = math.sqrt(h / values["radius"][state])
        law = 0.5 * eps**4 + FRICTION_FACTOR * mu * eps**3
        bending = RUBBER.youngs_modulus * math.pi * h**4 / 4.0
        tension = values["tension"][state] * h**2 / bending
        quantity = f"{name}, sqrt(h/R) {eps:.3f}: T h^2 / B"
        rows.append(compare_relative(quantity, tension, law, LAW_TOLERANCE))
    return rows


def compute_determinant(axis: Vector) -> int:
    """Return the determinant of a knot whose ends are far away along x, from its axis (n, 3).

    Each crossing of the projection along z has an equation in its three arcs: twice the arc above
    less both arcs below.  The determinant of the knot leaves out one row and column.
    """
    starts, steps = axis[:-1], np.diff(axis, axis=0)
    crossings = []  # arc coordinates, in segments: below and above
    for i in range(len(starts) - 2):
        gaps, others = starts[i + 2 :, :2] - starts[i, :2], steps[i + 2 :, :2]
        areas = _cross(steps[i, :2], others)
        with np.errstate(divide="ignore", invalid="ignore"):
            here, there = _cross(gaps, others) / areas, _cross(gaps, steps[i, :2]) / areas
        crosses = (here >= 0.0) & (here < 1.0) & (there >= 0.0) & (there < 1.0)
        for k in np.flatnonzero(crosses).tolist():
            j = i + 2 + k
            heights = starts[[i, j], 2] + np.array([here[k], there[k]]) * steps[[i, j], 2]
            pair = i + float(here[k]), j + float(there[k])
            crossings.append(pair if heights[0] < heights[1] else pair[::-1])
    n = len(crossings)
    if n < 2:
        return 1
    below = np.sort([under for under, _ in crossings])
    matrix = np.zeros((n, n))  # arcs from one passage below to the next; the last joins the first
    for row, (under, over) in zip(matrix, crossings, strict=True):
        arc = int(np.searchsorted(below, under))
        row[arc] -= 1.0
        row[(arc + 1) % n] -= 1.0
        row[int(np.searchsorted(below, over)) % n] += 2.0
    return round(abs(float(np.linalg.det(matrix[1:, 1:]))))


def _cross(a: Vector, b: Vector) -> Vector:
    """Return the areas that vectors of the plane span."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
