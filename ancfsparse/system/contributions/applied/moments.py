"""Moments, as forces on the vectors of a node."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Indices, Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import Compiled, Contribution, matrix_unknowns
from ancfsparse.system.coordinates.discretization import Discretization


class MomentContribution(Contribution):
    """The moments of a scene."""

    is_load = True

    def __init__(self, system: Discretization) -> None:
        self._n_free, self._n_all, self._dim = system.n_free, system.n_all, system.dim
        # A moment about a fixed axis in space has no potential.
        self.conservative = system.dim == 2
        loads = system.loads
        self._place, self._column, self._axes = (
            loads.moment_place,
            loads.moment_column,
            loads.moment_axes,
        )

    def cliques(self) -> list[Indices]:
        """Return the coordinates that each moment acts on."""
        return [matrix_unknowns(self._places(), self._n_free)]

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled moments."""
        places = self._places()
        arrays = {
            "place": places,
            "slot": pattern.slots(*self.cliques()),
            "column": np.array(self._column, dtype=np.int32).ravel(),
            "axes": np.array([self._axes_of(k) for k in range(len(places))], np.int32).ravel(),
        }
        made: Compiled = compiled_module("moments").Moments(self._n_all, arrays)
        return made

    def power(self, q: Vector, v: Vector, amplitudes: Vector) -> Vector:
        """Return the power of the moments, shape (k,) [W]."""
        power = np.zeros(len(q))
        for places, column, axes in zip(self._place, self._column, self._axes, strict=True):
            moment = np.zeros((len(q), 3))
            moment[:, 3 - len(column) :] = amplitudes[:, column]
            if axes is not None:
                units = q[:, axes] / np.linalg.norm(q[:, axes], axis=2, keepdims=True)
                moment = np.einsum("kv,kvd->kd", moment, units)
            if places[0, 0] < 0:
                power += _power_on_section(q, v, places[1:], moment)
                continue
            slope, velocity = _angular_velocity(q, v, places[0])
            power += np.sum(moment * velocity, axis=1)
            along = np.sum(moment * slope, axis=1) / np.sum(slope**2, axis=1)
            across = [vector for vector in places[1:] if vector[0] >= 0]
            for vector in across:
                velocity = _angular_velocity(q, v, vector)[1]
                power += along / len(across) * np.sum(slope * velocity, axis=1)
        return power

    def _axes_of(self, k: int) -> NDArray[np.int32]:
        axes = self._axes[k]
        return np.full(9, -1, dtype=np.int32) if axes is None else axes.ravel()

    def _places(self) -> NDArray[np.int32]:
        return np.array(self._place, dtype=np.int32).reshape(-1, 3 * self._dim)


def of(system: Discretization) -> list[MomentContribution]:
    """Return the moments of a system."""
    return [MomentContribution(system)]


def _power_on_section(q: Vector, v: Vector, places: NDArray[np.int32], moment: Vector) -> Vector:
    """Return the power of moments (k, 3) on r_y and r_z, shape (k,) [W], see ``_moments.pyx``."""
    k, dim = len(q), places.shape[1]
    units, rates = np.zeros((k, 2, 3)), np.zeros((k, 2, 3))
    units[:, 1, 2] = 1.0  # of r_z in the plane
    given = places[:, 0] >= 0
    units[:, given, :dim], rates[:, given, :dim] = q[:, places[given]], v[:, places[given]]
    squares = np.sum(units**2, axis=(1, 2))[:, None, None] * np.eye(3)
    spread = squares - np.einsum("kvi,kvj->kij", units, units)
    turning = np.linalg.solve(spread, moment[:, :, None])[:, :, 0]
    return np.asarray(np.sum(turning * np.cross(units, rates).sum(axis=1), axis=1))


def _angular_velocity(q: Vector, v: Vector, place: NDArray[np.int32]) -> tuple[Vector, Vector]:
    """Return a vector of a node and its angular velocity u x u' / |u|^2, each (k, 3)."""
    u, rate = np.zeros((len(q), 3)), np.zeros((len(q), 3))
    u[:, : len(place)], rate[:, : len(place)] = q[:, place], v[:, place]
    return u, np.cross(u, rate) / np.sum(u**2, axis=1, keepdims=True)
