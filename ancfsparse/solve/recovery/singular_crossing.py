"""Cross singular configurations by one long explicit step.

Near a configuration where constraints become dependent, accelerations amplify the rounding of
positions by the third power of one over the distance, and a step that ends there hardly has a
solution.  The motion itself is smooth.  So a step of order 8, whose stages leave a gap in which the
configuration lies, crosses it, and regular steps keep a distance.

Undamped implicit integrators retain errors of constraint forces that alternate from step to step,
and rotation amplifies them.  They are removed by one explicit step and a new start after it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.integrators import DormandPrince, Implicit
from ancfsparse.integrators.explicit.explicit_methods import make_explicit
from ancfsparse.integrators.interface.time_grid import TimeGrid
from ancfsparse.results import Event
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.initial_conditions.consistent_state import regularize
from ancfsparse.solve.linearization.matrices import (
    SADDLE_REGULARIZATION,
    constraint_magnitudes,
    saddle_seed,
)
from ancfsparse.solve.stepping.explicit_setup import check_explicit_scene
from ancfsparse.solve.stepping.interpolation import differentiate_quintics
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import ExplicitLoop

METHOD = DormandPrince()
MIN_PIVOT_RATIO = 1e5  # over the regularization: below, constraints are redundant by rounding
# Independence of a constraint, below which a singular configuration may be near; for bars in a row
# it is about three times their angle from the line.
NEAR_INDEPENDENCE = 0.5
# Rotation of a body in the long step [rad].  In 10 s of 40 linkages with steps of 4 and 10 ms, 0.08
# gives errors of 5e-10 m, 0.15 of 5e-10 and 0.3 of 5e-8; with 31 ms, 2e-8, 1e-7 and 4e-8 m.
CROSSING_ROTATION = 0.15
# Rotation of a body between two looks at the pivots, over their independence [rad], and the least.
TEST_ROTATION = 0.1
MIN_TEST_ROTATION = 0.03
MAX_OFFSET_RATIO = 0.02  # of the configuration from the middle of the gap, over the long step
N_CENTRINGS = 3  # attempts to place the gap
N_LENGTHS = 6  # long steps that to try, each half of the one before
MIN_STEP_RATIO = 0.05  # shortest step before and after the long one, over it
# Difference of the crossing by a step of half the length, over the displacement: in rows of
# linkages 1e-10; larger where a load changes within the step.  The first length with a good one is
# taken, or that with the least.
GOOD_DIFFERENCE_RATIO = 1e-9
MAX_DIFFERENCE_RATIO = 1e-5
# Rotation of a body after which an undamped implicit integrator is restarted [rad]: alternating
# constraint forces grow in it by exp(1.2) (theory.md, double root).  With 0.3 and 0.1 rad errors of
# five mechanisms are about as large; without renewal, three of them stop.
RENEWAL_ROTATION = 1.0


def _middle_of_widest_gap() -> float:
    """Return the middle of the longest interval without a stage, in steps."""
    stages = np.unique(METHOD.tableau.c)
    k = int(np.argmax(np.diff(stages)))
    return float(0.5 * (stages[k] + stages[k + 1]))


GAP = _middle_of_widest_gap()


@dataclass(frozen=True)
class Crossing:
    """A motion across a singular configuration.

    Attributes
    ----------
    step : int
        Number of the step at its end.
    event : Event or None
        The crossing; None for a step at a regular place.
    times : (k,) float
        Times of the states [s].
    states : tuple of (k, n) float
        ``(q, v, a, lam)``.
    work : float
        Change of the energy [J].
    """

    step: int
    event: Event | None
    times: Vector
    states: tuple[Vector, ...]
    work: float

    def interpolate(self, t: Vector) -> list[Vector]:
        """Return ``(q, v, a, lam)`` at times; multipliers lie on straight lines.

        Close to the configuration the multipliers of a state are lost in rounding.
        """
        motion = [differentiate_quintics(t, self.times, self.states, k) for k in range(3)]
        columns = [np.interp(t, self.times, column) for column in self.states[3].T]
        return [*motion, np.stack(columns, axis=1)]

    @property
    def jerk(self) -> Vector:
        """Rate of the accelerations at the end."""
        return np.ravel(differentiate_quintics(self.times[-1:], self.times, self.states, 3))


class SingularCrossing:
    """Look for singular configurations ahead, and cross them.

    Parameters
    ----------
    system : System
        The moving system, with rigid bodies.
    clock : TimeGrid
        Times of the steps.
    n_steps : int
        Number of steps.
    saddle : SparseSeed
        Seed of the masses with all constraints.
    regularization : float, optional
        Of the matrices of an implicit integrator [1/kg]; an explicit one has factored the seed.
    renews : bool, optional
        Whether to take an explicit step from time to time, and to start the integrator after it
        without alternating constraint forces.

    Attributes
    ----------
    failed : float or None
        Time of the first configuration that no long step crosses [s].
    """

    def __init__(
        self,
        system: System,
        clock: TimeGrid,
        n_steps: int,
        saddle: SparseSeed,
        regularization: float | None = None,
        renews: bool = False,
    ) -> None:
        self._renews, self._turned = renews, 0.0
        self._system, self._clock, self._n_steps, self._saddle = system, clock, n_steps, saddle
        self._own = regularize(system, 0.0, SADDLE_REGULARIZATION)
        self._regularization, self._sizes = regularization, constraint_magnitudes(system)
        turning = [
            np.ravel(indices[:, body.kind.columns(name)])
            for body, indices in zip(system.scene.bodies, system.places, strict=True)
            if body.masses is not None
            for name in body.kind.vectors[1:]
        ]
        self._turning = np.unique(np.concatenate(turning))
        self._largest = np.zeros(system.n_multipliers)
        self._last: tuple[float, float] | None = None  # time and independence at the last look
        self.failed: float | None = None
        self._restore_regularization()

    def begin_again(self) -> None:
        """Look ahead without regard to the states before."""
        self._turned, self._last = 0.0, None
        self._largest[:] = 0.0

    def anticipate(self, step: int, q: Vector, v: Vector) -> tuple[int, Crossing | None]:
        """Look ahead from the state after a step.

        Returns
        -------
        int
            Steps until the next look.
        Crossing or None
            The motion across a singular configuration, if one is near.
        """
        t, dt, last = self._clock.at(step), self._clock.dt, self._last
        rate = max(float(np.max(np.abs(v[self._turning]))), 1e-9 / dt)
        if self._regularization is not None:
            self.factor(q)
        independence = self._independence()
        self._last = t, independence
        pause = max(TEST_ROTATION * independence, MIN_TEST_ROTATION) / rate
        if last is not None and independence < min(last[1], NEAR_INDEPENDENCE):
            ahead = independence * (t - last[0]) / (last[1] - independence)
            lead = GAP * CROSSING_ROTATION / rate
            if ahead < lead + dt and t + ahead < self._clock.at(self._n_steps):
                if self._regularization is not None:
                    q, v = self._project(t, q, v)
                crossing = self._cross(step, t + ahead, CROSSING_ROTATION / rate, q, v)
                self._restore_regularization()
                if crossing is not None:
                    self._last = None
                    return 1, crossing
                pause = MIN_TEST_ROTATION / rate
            else:
                pause = min(pause, 0.5 * (ahead - lead))
        self._turned += 0.0 if last is None else rate * (t - last[0])
        if self._renews and self._turned > RENEWAL_ROTATION and step + 1 < self._n_steps:
            self._turned = 0.0
            return 1, self._renew(step, q, v)
        # From rest, bodies may rotate faster before long.
        return max(1, min(int(pause / dt), step)), None

    def _renew(self, step: int, q: Vector, v: Vector) -> Crossing | None:
        """Take one explicit step; None if it fails."""
        t, end = self._clock.at(step), self._clock.at(step + 1)
        memory = self._system.assembly.memory
        q, v = self._project(t, q, v)
        self._system.assembly.set_regularization(self._own)
        states, _ = self._integrate(q, v, [t, end])
        crossing = None
        if states is None:
            self._remember(memory)
        else:
            work = self._energy(end, states[0][-1], states[1][-1]) - self._energy(t, q, v)
            crossing = Crossing(step + 1, None, np.array([t, end]), states, work)
        self._restore_regularization()
        return crossing

    def factor(self, q: Vector) -> None:
        """Factor the masses with all constraints at a state."""
        system = self._system
        system.assembly.set_regularization(self._own)
        amplitudes = np.zeros(system.loads.n_amplitudes)
        lam = np.zeros(system.n_multipliers)
        self._saddle.factor(system.assembly.matrix(1.0, 0.0, q, lam, amplitudes))
        self._restore_regularization()

    def impulse(self, q: Vector, rate: Vector) -> Vector:
        """Return the velocities by an impulse of the constraints, with given rates of these."""
        n, out = self._system.n_free, np.zeros(self._system.n_all)
        self.factor(q)
        out[:n] = self._saddle.solve(np.concatenate([np.zeros(n), rate]))[:n]
        return out

    def _project(self, t: float, q: Vector, v: Vector) -> tuple[Vector, Vector]:
        """Project a state of an implicit integrator, which meets constraints to its tolerance.

        Its velocities differ from rates of the coordinates by the second order of the step.
        """
        system, q = self._system, q.copy()
        first = system.n_multipliers - system.prescribed.n_equations
        prescribed = system.prescribed.at(t) if system.prescribed else None
        amplitudes, zero = np.zeros(system.loads.n_amplitudes), np.zeros(system.n_all)
        phi = system.assembly.residual(
            q, zero, zero, np.zeros(system.n_multipliers), zero, amplitudes
        )[1]
        if prescribed is not None:
            phi[first:] -= prescribed.s
        q += self.impulse(q, -phi)
        rate = -(system.constraints.jacobian(q) @ v)
        if prescribed is not None:
            rate[first:] += prescribed.s_rate
        return q, v + self.impulse(q, rate)

    def _cross(
        self, step: int, place: float, length: float, q: Vector, v: Vector
    ) -> Crossing | None:
        """Cross a configuration at a time by a step of a length at most; None if none suits."""
        t, t_end, dt = self._clock.at(step), self._clock.at(self._n_steps), self._clock.dt
        self._system.assembly.set_regularization(self._own)
        memory = self._system.assembly.memory
        best, smallest = None, MAX_DIFFERENCE_RATIO
        for _ in range(N_LENGTHS):
            for _ in range(N_CENTRINGS):
                length = min(length, (place - t) / GAP, (t_end - place) / (1.0 - GAP))
                after = place + (1.0 - GAP) * length - t
                last = min(step + math.ceil(after / dt), self._n_steps)
                times = self._times(t, place, length, self._clock.at(last))
                wide, middle = self._integrate(q, v, times)
                self._remember(memory)
                if wide is None or not t < middle < t_end:
                    break
                offset, place = abs(middle - place), middle
                if offset <= MAX_OFFSET_RATIO * length:
                    break
            times = self._times(t, place, 0.5 * length, self._clock.at(last))
            narrow, _ = self._integrate(q, v, times)
            self._remember(memory)
            if wide is not None and narrow is not None:
                difference = float(
                    np.max(np.abs(wide[0][-1] - narrow[0][-1])) / np.max(np.abs(wide[0][-1] - q))
                )
                if difference < smallest:
                    best, smallest = (last, place, length), difference
                    if difference < GOOD_DIFFERENCE_RATIO:
                        break
            length *= 0.5
        if best is None:
            self.failed = place if self.failed is None else self.failed
            return None
        last, place, length = best
        times = self._times(t, place, 0.5 * length, self._clock.at(last))
        inner, _ = self._integrate(q, v, times)  # its states lie closer together
        self._remember(memory)
        outer, _ = self._integrate(q, v, self._times(t, place, length, self._clock.at(last)))
        assert inner is not None
        assert outer is not None
        for table, end in zip(inner, outer, strict=True):
            table[-1] = end[-1]
        work = self._energy(times[-1], outer[0][-1], outer[1][-1]) - self._energy(t, q, v)
        event = Event(step + 1, place, f"one step of {length:.3g} s", "dependent", math.nan)
        return Crossing(last, event, np.array(times), inner, work)

    def _times(self, t: float, place: float, length: float, t_end: float) -> list[float]:
        """Return the ends of the steps to a time: one has a length and lies around a place."""
        out, shortest = [t], MIN_STEP_RATIO * length
        begin = place - GAP * length
        out += [x for x in (begin, begin + length) if t + shortest < x < t_end - shortest]
        return [*out, t_end]

    def _integrate(
        self, q: Vector, v: Vector, times: list[float]
    ) -> tuple[tuple[Vector, ...] | None, float]:
        """March from one time to the next; return the states, and the time of least independence.

        No states if a step fails.
        """
        states: list[tuple[Vector, ...]] = []
        independent: list[float] = []
        for t, after in pairwise(times):
            stages = t + (after - t) * np.append(0.0, METHOD.stages)
            inputs, failure = self._system.inputs(stages, rates=True)
            if failure is not None:
                return None, math.nan
            loop = self._loop(after - t, q, v, inputs[0])
            if not states:
                states.append(loop.state)
                independent.append(self._independence())
            unused = [np.empty((1, len(table))) for table in loop.state]
            if loop.advance(None, 1, inputs[1:], 2, 0, *unused)[1]:
                return None, math.nan
            states.append(loop.state)
            independent.append(self._independence())
            q, v = loop.state[:2]
        # Before and after a configuration, the independence is proportional to the distance.
        k = int(np.argmax(np.diff(times)))
        fraction = independent[k] / (independent[k] + independent[k + 1])
        middle = times[k] + fraction * (times[k + 1] - times[k])
        return tuple(np.array(table) for table in zip(*states, strict=True)), middle

    def _loop(self, dt: float, q: Vector, v: Vector, inputs: Vector) -> ExplicitLoop:
        """Return an explicit loop, which does not reset the memory of contributions."""
        system, memory = self._system, self._system.assembly.memory
        loop = make_explicit(
            system, dt, METHOD, q, v, inputs, self._saddle, math.inf, 0.0, 0.0, self._sizes
        )
        if self._remember(memory):
            loop.refresh()
        return loop

    def _energy(self, t: float, q: Vector, v: Vector) -> float:
        """Return the energy of a state, as time loops compare it [J]."""
        inputs = self._system.inputs(np.array([t]), rates=True)[0][0]
        return float(self._loop(self._clock.dt, q, v, inputs).memory["watch"]["start"])

    def _remember(self, memory: Vector) -> bool:
        """Restore the memory of contributions; return whether there is any."""
        if len(memory):
            self._system.assembly.memory = memory
        return len(memory) > 0

    def _restore_regularization(self) -> None:
        if self._regularization is not None:
            self._system.assembly.set_regularization(self._regularization)

    def _independence(self) -> float:
        """Return the least independence of a constraint, by the pivots of the last factor.

        The square root of a pivot over its largest value until then.
        """
        pivots = -self._saddle.pivots[self._system.n_free :]
        self._largest = np.maximum(self._largest, pivots)
        is_sound = self._largest > MIN_PIVOT_RATIO * self._own
        ratios = pivots[is_sound] / self._largest[is_sound]
        return math.sqrt(max(float(np.min(ratios, initial=1.0)), 0.0))


def prepare_crossings(
    system: System, clock: TimeGrid, n_steps: int, integrator: Implicit
) -> SingularCrossing | None:
    """Return the search for an implicit run; None if explicit steps cannot follow the scene.

    Parameters
    ----------
    system, clock, n_steps
        As for `SingularCrossing`.
    integrator : Implicit
        The integrator of the run.
    """
    try:
        check_explicit_scene(system, METHOD)
    except InputError:
        return None
    saddle, regularization = saddle_seed(system), regularize(system, integrator.scale * clock.dt**2)
    is_undamped = integrator.gamma == 0.5 and not integrator.keeps_energy
    return SingularCrossing(system, clock, n_steps, saddle, regularization, is_undamped)
