"""Loads and prescribed motions of a static scene at a time, under a load factor."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.system import System

LINEAR_LOAD_FACTOR = 1e-6  # load factor over which prescribed motions are taken as linear


class ImposedLoads:
    """Loads and prescribed motions at a time, both scaled by a load factor.

    Parameters
    ----------
    system : System
        The system at rest.
    t : float
        The time [s].

    Attributes
    ----------
    amplitudes : (n_amplitudes,) float
        Amplitudes of the loads.
    forces_first : bool
        Whether prescribed motions begin only at full forces: a cable that sags is slackened more
        easily than a straight one.
    """

    def __init__(self, system: System, t: float) -> None:
        self._system = system
        self._grows = system.loads.growing
        self._dead = system.dead_load
        self._rest = np.zeros(system.n_all)
        self.forces_first = False
        self.set_time(t)

    def set_time(self, t: float) -> None:
        """Set the loads at a time [s], and the motions of supports from the reference shape."""
        system, prescribed = self._system, self._system.prescribed
        self.amplitudes = np.asarray(system.loads.amplitudes(np.array([t]))[0])
        first, end = system.n_all - prescribed.n, system.n_multipliers - prescribed.n_equations
        self._q_start, self._s_start = system.q_ref[first:], np.zeros(0)
        self._q_change, self._s_change = np.zeros(prescribed.n), np.zeros(0)
        if not prescribed:
            return
        now = prescribed.at(t)
        lam = np.zeros(system.n_multipliers)
        args = (self._rest, self._rest, lam, self._dead, self.amplitudes)
        self._s_start = np.asarray(system.assembly.residual(system.q_ref, *args)[1])[end:]
        self._q_change, self._s_change = now.q - self._q_start, now.s - self._s_start

    @property
    def places(self) -> Vector:
        """Fixed coordinates, and prescribed ones under all loads."""
        system = self._system
        fixed = system.q_ref[system.n_free : system.n_all - len(self._q_change)]
        return np.append(fixed, self._q_start + self._q_change)

    @property
    def is_driven(self) -> bool:
        """True if a prescribed motion differs from the reference shape at this time."""
        return bool(self._q_change.any() or self._s_change.any())

    @property
    def small_factor(self) -> float:
        """Load factor below which the residual is linear in it; 1 without prescribed motions."""
        return LINEAR_LOAD_FACTOR if self.is_driven else 1.0

    def force_factor(self, load: float) -> float:
        """Return the factor of the forces at a load factor."""
        return min(1.0, 2.0 * load) if self.forces_first else load

    def dead_load(self, load: float) -> Vector:
        """Return the dead load at a load factor, (n_all,) [N, N m]."""
        return np.asarray(self.force_factor(load) * self._dead)

    def amplitudes_at(self, load: float) -> Vector:
        """Return the amplitudes of the loads at a load factor."""
        return np.asarray(np.where(self._grows, self.force_factor(load), 1.0) * self.amplitudes)

    def move_supports(self, q: Vector, load: float) -> Vector:
        """Return coordinates with the prescribed ones of a load factor."""
        if not self._q_change.any():
            return q
        q = np.array(q)
        q[len(q) - len(self._q_change) :] = (
            self._q_start + self._motion_factor(load) * self._q_change
        )
        return q

    def residual(self, q: Vector, lam: Vector, load: float) -> tuple[Vector, Vector]:
        """Return the forces at all coordinates, and the violation of the constraints.

        The prescribed coordinates are those in `q`, see `move_supports`.
        """
        forces = self.dead_load(load), self.amplitudes_at(load)
        r, phi = self._system.assembly.residual(q, self._rest, self._rest, lam, *forces)
        values = self._s_start + self._motion_factor(load) * self._s_change
        phi = np.asarray(phi)
        phi[len(phi) - len(values) :] -= values
        return np.asarray(r), phi

    def _motion_factor(self, load: float) -> float:
        return max(0.0, 2.0 * load - 1.0) if self.forces_first else load
