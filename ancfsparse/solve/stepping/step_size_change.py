"""Correct the state of a time loop for a change of the step size or a jump of the loads."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.implicit.time_integration import Start
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import NewmarkLoop
    from ancfsparse.seeds import Seed


class StepSizeChange:
    """Corrections of the state at changes of the step size and jumps of the loads.

    Parameters
    ----------
    system, integrator, time_loop
        The moving system, its integrator and compiled time loop.
    seed : SparseSeed or IncompleteSeed
        Its factor is replaced if another one is needed.

    Attributes
    ----------
    factors : int
        Number of factorizations, each for one or two solutions.
    """

    def __init__(
        self, system: System, integrator: Implicit, time_loop: NewmarkLoop, seed: Seed
    ) -> None:
        self._system, self._integrator = system, integrator
        self._time_loop, self._seed = time_loop, seed
        self.factors = 0

    def change(self, old: float, dt: float, now: float) -> None:
        """Change the step size [s], with corrections for multipliers of second order."""
        system, integrator = self._system, self._integrator
        if integrator.keeps_energy:  # its steps do not begin with an acceleration to correct
            none = np.zeros(system.n_all)
            self._time_loop.change_step(dt, integrator, none, none)
            return
        jerk = self._time_loop.jerk
        change_v = np.zeros(system.n_all)
        if system.n_multipliers:
            n = system.n_free
            phi_q = system.constraints.jacobian(self._time_loop.state[0])
            rate = integrator.velocity_constant * (dt**2 - old**2) * (phi_q @ jerk)
            # Across the constraints of the present state; and distributed by the stiffness, since
            # by mass alone it would make the constrained nodes vibrate.
            self._factor(dt, system.loads.amplitudes(np.array([now]))[0])
            change_v[:n] = self._seed.solve(np.concatenate([np.zeros(n), rate]))[:n]
        change_b = integrator.shift * (dt - old) * jerk
        self._time_loop.change_step(dt, integrator, change_b, change_v)

    def jump(self, dt: float, before: float, after: float) -> None:
        """Continue after a jump of the loads between two times.

        Corrects the accelerations of Newmark's family by the low-frequency part that a step can
        resolve, as at the start (`low_frequency_part` in
        `solve.initial_conditions.consistent_state`).
        """
        system = self._system
        loads = system.loads.amplitudes(np.array([before, after]))
        if np.array_equal(*loads):
            return
        q, v, a, lam = self._time_loop.state
        if self._integrator.keeps_energy:  # as in `change`; but the time loop needs the new loads
            start, none = Start(q, v, a, a, lam, loads[1]), np.zeros(0)
            self._time_loop.move(start, q - dt * v, none, none)
            return
        zero, n = np.zeros(system.n_all), system.n_free
        old, new = (
            system.assembly.residual(q, v, zero, lam, system.dead_load, load)[0] for load in loads
        )
        self._factor(dt, loads[1])
        once = self._solution(old - new)
        twice = self._solution(system.assembly.inertia(once))
        change = 2.0 * once - twice
        change[n:] = 0.0
        self._time_loop.jump(change, loads[1])

    def _solution(self, force: Vector) -> Vector:
        n, out = self._system.n_free, np.zeros(self._system.n_all)
        right = np.concatenate([force[:n], np.zeros(self._system.n_multipliers)])
        out[:n] = self._seed.solve(right)[:n]
        return out

    def _factor(self, dt: float, loads: Vector) -> None:
        """Factor the matrix of a step; if it is indefinite, its material part."""
        q, _, _, lam = self._time_loop.state
        scale, damping = self._integrator.scale * dt**2, self._integrator.damping_scale * dt
        assembly = self._system.assembly
        self.factors += 1
        if self._seed.factor(assembly.matrix(1.0, scale, q, lam, loads, damping_factor=damping)):
            self._seed.factor(assembly.material(1.0, scale, q, damping_factor=damping))
