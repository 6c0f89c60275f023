"""Distances on grids, by cubic B-splines."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import laplace, map_coordinates, spline_filter

from ancfsparse.array_types import Vector
from ancfsparse.scene.force_elements.obstacles.cores import Core


def sampled_core(distances: Vector, low: Vector, cell: float) -> Core:
    """Return the core of distances at the nodes of a grid, whose first node is at `low` [m]."""
    high = low + cell * (np.array(distances.shape) - 2.0)
    bounds = np.stack([low + cell, high])
    return Core(np.eye(len(low)), bounds, 0.0, fit_spline(distances), cell)


def fit_spline(values: Vector) -> Vector:
    """Return the coefficients of a spline through values on a grid."""
    return np.ascontiguousarray(spline_filter(values, mode="mirror"))


def interpolate(coefficients: Vector, nodes: Vector) -> Vector:
    """Return the values of a spline at points (dim, ...), in units of the spacing."""
    return np.asarray(map_coordinates(coefficients, nodes, mode="mirror", prefilter=False))


def smallest_bend(core: Core) -> float:
    """Return the inverse of the largest sum of principal curvatures of the surface [m]."""
    assert core.coefficients is not None
    nodes = np.indices(core.coefficients.shape, dtype=float)
    distances = interpolate(core.coefficients, nodes)
    curvatures = laplace(distances)[np.abs(distances) < core.cell] / core.cell**2
    largest = float(np.max(curvatures, initial=0.0))
    return 1.0 / largest if largest > 0.0 else math.inf
