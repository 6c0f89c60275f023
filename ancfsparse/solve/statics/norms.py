"""Norms of displacements and forces in statics, and the rounding of forces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.system import System

ROUNDING_UNITS = 32.0  # of a force, in units of eps |K| |q|


class Norms:
    """Norms weighted by the masses of a scene, independent of the mesh; infinite above 1e154.

    Parameters
    ----------
    system : System
        The system at rest.

    Attributes
    ----------
    mass : (n_free,) float
        Diagonal of the mass matrix, the weight of corrections and forces [kg, kg m2].
    total_mass : float
        Sum over all coordinates, moments of inertia over the squares of sizes [kg].
    slopes : (k,) int
        Indices of coordinates that are not positions.
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.mass = system.mass_diagonal
        bodies, is_slope = self._bodies()
        self._body, self.slopes = bodies[: system.n_free], np.flatnonzero(is_slope[: system.n_free])
        # Masses of slopes are moments of inertia, which are divided by the size of their body.
        sizes = np.array([body.size for body in system.scene.bodies])
        self._sizes = np.where(is_slope, sizes[bodies], 1.0)
        masses = np.array(self.mass)
        masses[self.slopes] /= self._sizes[self.slopes] ** 2
        self.total_mass = float(masses.sum())
        body_mass = np.bincount(self._body, masses, minlength=len(system.scene.bodies))
        self._body_mass = np.where(body_mass > 0.0, body_mass, 1.0)

    def _bodies(self) -> tuple[NDArray[np.int32], NDArray[np.bool_]]:
        """Return the body of each coordinate, the last of shared ones, and which are slopes."""
        system = self.system
        body, slope = np.zeros(system.n_all, dtype=np.int32), np.ones(system.n_all, dtype=bool)
        for k, indices in enumerate(system.places):
            body[indices] = k
        self._positions = system.positions
        slope[self._positions] = False
        return body, slope

    def typical_masses(self, coordinates: slice) -> Vector:
        """Return the median mass of all positions, for slopes times squared sizes [kg, kg m2]."""
        masses = np.delete(self.mass, self.slopes)
        return np.asarray(
            (np.median(masses) if len(masses) else 1.0) * self._sizes[coordinates] ** 2
        )

    def distance(self, dx: Vector) -> float:
        """Return the size of a correction: the root mean square of the displacement [m]."""
        with np.errstate(over="ignore"):
            return float(np.sqrt(self.mass @ dx**2 / self.total_mass * self.system.dim))

    def distances(self, dx: Vector) -> Vector:
        """Return the root mean squares of the displacements of the bodies [m], (n_bodies,)."""
        with np.errstate(over="ignore"):
            squares = np.bincount(self._body, self.mass * dx**2, minlength=len(self._body_mass))
        return np.asarray(np.sqrt(squares / self._body_mass * self.system.dim))

    def force_norm(self, r: Vector) -> float:
        """Return the norm of generalized forces, each over the root of its mass [N / kg^(1/2)].

        It measures forces at positions and slopes alike, and forces per length on any mesh.
        """
        with np.errstate(over="ignore"):
            return float(np.sqrt(np.sum(r**2 / self.mass)))

    def rounding_of(self, values: Vector, q: Vector, lam: Vector | None = None) -> Vector:
        """Return the rounding of every force [N, N m], by the values of the stiffness."""
        import scipy.sparse as sp

        n, size = self.system.n_free, self.system.pattern.n
        end = int(self.system.pattern.indptr[n])
        indices, indptr = self.system.pattern.indices[:end], self.system.pattern.indptr[: n + 1]
        lower = sp.csc_array((np.abs(values[:end]), indices, indptr), shape=(size, n))
        magnitude = np.zeros(size)
        magnitude[:n] = np.abs(q[:n])
        if lam is not None:
            magnitude[n:] = np.abs(lam)
        products = lower.T @ magnitude + (lower @ magnitude[:n])[:n]
        return np.asarray(ROUNDING_UNITS * EPSILON * products)
