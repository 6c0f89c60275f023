"""A march whose step follows the motion: grown, cut and tried again by a local error estimate."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, interp1d

from ancfsparse.integrators import Implicit
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Event, RunStats
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.setup import CAUSES, count, events, prepare, stopped
from ancfsparse.system import System

Vector = NDArray[np.float64]

# Steps change by powers of the root of two, and seldom: the seed of a step serves the next ones.
RATIO = math.sqrt(2.0)
# Steps in a row that must be easy before they grow, and steps that are taken in one go at most.
PATIENCE, CHUNK, COORDINATES = 8, 500, 4_000_000
# A step may grow if the larger one would have this share of the error allowed.
SAFETY = 0.7
# Share of a step's error that the iteration may leave.
ITERATION_SHARE = 0.02
SHORTEST = 1e-10  # a step, over the length of the run
MOST_EVENTS = 1000  # that are kept, as where steps have one length


@dataclass
class States:
    """States at the times asked for.

    Attributes
    ----------
    t : (k,) float
        Times [s].
    q, v, a : (k, n_all) float
        Coordinates and their rates, between steps cubic in q, v, a as Hermite says.
    lam : (k, m) float
        Multipliers, linear between steps.
    """

    t: Vector
    q: Vector
    v: Vector
    a: Vector
    lam: Vector

    def fill(self, t: Vector, q: Vector, v: Vector, a: Vector, lam: Vector) -> None:
        """Interpolate the states asked for in (t[0], t[-1]] from accepted steps."""
        span = slice(*np.searchsorted(self.t, [t[0], t[-1]], side="right"))
        if span.start == span.stop:
            return
        wanted = np.minimum(self.t[span], t[-1])
        self.q[span] = CubicHermiteSpline(t, q, v)(wanted)
        self.v[span] = CubicHermiteSpline(t, v, a)(wanted)
        self.a[span] = interp1d(t, a, axis=0)(wanted)
        self.lam[span] = interp1d(t, lam, axis=0)(wanted)


class Stepper:
    """One run with a local error per step.

    Parameters
    ----------
    system : System
        What moves.
    integrator : Implicit
        A scheme of second order.
    solver : Method or "auto"
        How steps are solved.
    local_error : float
        Error that a step may make, root mean square weighted by mass [m].
    dt : float
        First step [s].
    t : (k,) float
        Times asked for, the first one 0 [s].
    max_energy_gain, threads
        As in `simulate`.

    Attributes
    ----------
    left : float
        Error that the iteration of a step may leave, a small share of the step's own [m].
    """

    def __init__(
        self,
        system: System,
        integrator: Implicit,
        solver: Any,
        local_error: float,
        dt: float,
        t: Vector,
        max_energy_gain: float,
        threads: int = 1,
    ) -> None:
        begin = time.perf_counter()
        self.system, self.integrator = system, integrator
        self.local_error, self.dt, self.max_energy_gain = local_error, dt, max_energy_gain
        self.seed: SparseSeed
        self.march, self.iteration, self.seed, self.judge, why, a = prepare(
            system, dt, integrator, solver, "default", max_energy_gain, threads
        )
        self.left = ITERATION_SHARE * local_error
        self.iteration.set_tolerance(self.judge.at(dt, self.left))
        mass = system.mass_diagonal
        places = np.concatenate([p[:, : system.dim].ravel() for p in system.places])
        total = mass[places[places < system.n_free]].sum()
        error = abs(integrator.velocity_constant)  # the position's is the same, 1/12 + shift^2 / 4
        self.march.control(
            self.seed, mass / total, error, local_error, SAFETY * local_error / RATIO**3, PATIENCE
        )
        q, _, _, lam = self.march.state
        n, m = system.n_all, system.n_multipliers
        self.states = States(t, *(np.empty((len(t), width)) for width in (n, n, n, m)))
        self.states.q[0], self.states.v[0], self.states.a[0] = q, system.v0, a
        self.states.lam[0] = lam
        self._extra = 0  # factors of the changes of steps
        self.stats = RunStats(solver=why, seconds={"set-up": time.perf_counter() - begin})

    def run(self) -> States:
        """March past the last time asked for.

        Raises
        ------
        StepFailure, EnergyGain
            Without a trajectory.
        """
        try:
            self._run()
        finally:
            count(self.stats, self.iteration)
            self.stats.factorizations += self._extra
            self.stats.solves += self._extra
        return self.states

    def _run(self) -> None:
        now, end = 0.0, float(self.states.t[-1])
        n, m = self.system.n_all, self.system.n_multipliers
        chunk = max(1, min(CHUNK, COORDINATES // n))
        buffer = [np.empty((chunk + 1, width)) for width in (n, n, n, m)]
        while now < end:
            wanted = min(chunk, math.ceil((end - now) / self.dt))
            times = now + self.dt * np.arange(wanted + 1.0, dtype=np.float64)
            for table, start in zip(buffer, self.march.state, strict=True):
                table[0] = start
            # Loads may not be defined past the end, where the last step may reach.
            amplitudes = self.system.loads.amplitudes(np.minimum(times[1:], end))
            self.iteration.step, before = self.stats.steps, now - self.stats.steps * self.dt
            clock = time.perf_counter()
            taken, code = self.march.advance(self.iteration, wanted, amplitudes, 1, 0, *buffer)
            self.stats.march_seconds += time.perf_counter() - clock
            if self.seed.error is not None:
                raise self.seed.error
            self.note(events(self.iteration.take_events(), before, self.dt))
            if taken:
                rows = slice(0, taken + 1)
                self.states.fill(times[rows], *(table[rows] for table in buffer))
                self.stats.steps += taken
                now = times[taken]
            outcome = Outcome(code)
            if outcome == Outcome.CONVERGED and now >= end and self.march.gained_energy():
                outcome = Outcome.HAD_GAINED
            if outcome == Outcome.CONVERGED:
                continue
            hopeless = self.dt < SHORTEST * end and outcome != Outcome.MAY_GROW
            if outcome in (Outcome.GAINED_ENERGY, Outcome.HAD_GAINED) or hopeless:
                raise stopped(
                    self.system,
                    self.march,
                    self.iteration,
                    outcome,
                    self.stats.steps,
                    now,
                    self.dt,
                    self.max_energy_gain,
                    None,
                )
            dt = self._next(outcome)
            if outcome not in (Outcome.MAY_GROW, Outcome.TOO_INACCURATE):
                what, step = f"step of {dt:.3g} s", self.stats.steps + 1
                rate = self.iteration.contraction
                self.note([Event(step, now + self.dt, what, CAUSES[outcome], rate)])
            self._change(dt, now)

    def note(self, found: list[Event]) -> None:
        """List events, the first thousand."""
        self.stats.events += found[: MOST_EVENTS - len(self.stats.events)]

    def _next(self, outcome: Outcome) -> float:
        """Return the step to go on with."""
        if outcome == Outcome.MAY_GROW:
            return self.dt * RATIO
        if outcome == Outcome.TOO_INACCURATE:
            self.stats.rejected_steps += 1
            ratio = (SAFETY * self.local_error / self.march.step_error) ** (1.0 / 3.0)
            return self.dt * RATIO ** max(-6, min(-1, math.floor(math.log(ratio, RATIO))))
        return self.dt / 2.0

    def _change(self, dt: float, now: float) -> None:
        """Change the step, with what keeps multipliers of second order."""
        jerk = self.march.jerk
        change_v = np.zeros(self.system.n_all)
        if self.system.n_multipliers:
            q, _, _, lam = self.march.state
            phi_q, n = self.system.constraints.jacobian(q), self.system.n_free
            rate = self.integrator.velocity_constant * (dt**2 - self.dt**2) * (phi_q @ jerk)
            # Across the constraints as they are now, not as they were when the seed was made; and
            # spread by the stiffness: by the mass alone it would shake the nodes that are held.
            scale, damping = self.integrator.scale * dt**2, self.integrator.damping_scale * dt
            loads = self.system.loads.amplitudes(np.array([now]))[0]
            self.seed.factor(
                self.system.assembly.matrix(1.0, scale, q, lam, loads, damping_factor=damping)
            )
            self._extra += 1
            change_v[:n] = self.seed.solve(np.concatenate([np.zeros(n), rate]))[:n]
        change_b = self.integrator.shift * (dt - self.dt) * jerk
        self.march.change_step(dt, self.integrator, change_b, change_v)
        self.iteration.set_tolerance(self.judge.at(dt, self.left))
        self.iteration.mark_stale()
        self.dt = dt
