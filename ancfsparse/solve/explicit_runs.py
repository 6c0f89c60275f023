"""Explicit integrators on the way to an accuracy: which, in which steps, and what they leave."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, Parameter
from ancfsparse.integrators.explicit import Explicit
from ancfsparse.results import RunStats
from ancfsparse.solve.breaks import Breaks
from ancfsparse.solve.content import Content, fall, frequency, phase_lost, power_of_fall
from ancfsparse.solve.convergence import Convergence
from ancfsparse.solve.explicit_march import ExplicitMarch
from ancfsparse.solve.states import States, distance
from ancfsparse.solve.times import MOST_STEPS
from ancfsparse.solve.waves import Waves
from ancfsparse.system import System

Vector = NDArray[np.float64]

# Ratio of the steps of the first run to those of the second, by the order: the cheapest from whose
# difference the error can be estimated; and the largest ratio for later runs.
CLOSER, FURTHEST = {2: 1.35, 4: 1.3, 8: 1.25}, 2.2
# The same ratio at most where the error is predicted.
APART = 1.5
# Error over the predicted one: before the first estimate, and its bounds afterwards.
GUESS, LEAST_SCALE, MOST_SCALE = 1.5, 0.2, 1e3
# Least share of the error of a run by which its distance from the next exceeds that one's.
SMALLEST_SHARE = 0.1
# Where the distance of two runs is within this factor of the predicted one, so is the error; a
# margin on it; and the least predicted distance, over the error of the first run.
ALIKE, MARGIN, UNLIKE = 4.0, 1.5, 0.3
MOST_MORE = 10.0  # amplitude of vibrations over the predicted one, at most
# The error of the lowest order must be so much less than the motion as a whole lets expect.
LOOSE = 10.0
# Share of the accuracy that the predicted error of a run may have.
SAFETY = 0.7
# Share of the order that is believed of the fall of an error: where the phase lost of what parts
# two runs is below a bound [rad], elsewhere, and where both dissipate the fastest vibrations.
BELIEVED, UNRESOLVED, DISSIPATED, RESOLVED = 0.75, 0.5, 0.35, 0.1
# Share of its distance from a run of lower order that one of higher order is taken to be off.
LEAST_OF_TWO = 0.5
# Forces that the set-up is worth, about, and share of all cost from which on it does not matter.
SETUP, CHEAP = 100.0, 0.05
FINER = 1.05  # ratio of the steps that are thought of


class ExplicitRuns:
    """One way to an accuracy.

    Parameters
    ----------
    system, t, accuracy, max_energy_gain
        As `solve_accurately` takes them.
    integrators : list of Explicit
        Those that may be taken, by ascending order.
    breaks : Breaks
        Where loads jump or kink.
    watch : callable
        Is given the states of a run whenever there are more of them.
    waves : Waves or None
        What the motion is made of, where that is known.

    Attributes
    ----------
    states : States
        The best motion so far, None before there is one.
    error : float
        Its estimated error [m].
    failure : Exception
        Why there is no way on, None if there is one.
    content : Content
        What parts two runs, perhaps two of another way; None as long as that is not known.
    force_cost : float
        Modelled cost of an evaluation of the forces.
    name, steps
        The integrator and the steps of the best motion.
    running : RunStats
        Counts of the last run.
    """

    def __init__(
        self,
        system: System,
        t: Vector,
        accuracy: float,
        integrators: list[Explicit],
        max_energy_gain: float,
        breaks: Breaks,
        watch: Callable[[States], None],
        waves: Waves | None,
    ) -> None:
        self._system, self._t_end, self._length = system, float(t[-1]), float(t[-1] - t[0])
        self._waves, self._scale = waves, GUESS
        self._convergence = Convergence(accuracy)
        # The last two runs of one integrator: it, how fine both were, the second first, and how far
        # apart.
        self._before: tuple[Explicit, float, float, float] | None = None
        self._accuracy, self._integrators = accuracy, integrators
        self._march = ExplicitMarch(system, t, max_energy_gain, breaks, watch)
        self.force_cost = self._march.force_cost
        # Integrators and by how much their steps were shorter than stable ones, the best last.
        self._made: list[tuple[Explicit, float]] = []
        self._loose = False
        self._other: States | None = None  # the best motion of another way
        self.states: States | None = None
        self.error = math.inf
        self.failure: Exception | None = None
        self.content: Content | None = None
        self.name = repr(integrators[len(integrators) // 2])
        self.steps, self.running = 0, RunStats()

    def forecast(self) -> float:
        """Return what is yet to be spent until the accuracy is met, as `Price` models it."""
        if self.failure is not None:
            return math.inf
        cost = self._plan()[2]
        if cost > MOST_STEPS * self.force_cost:
            self.failure = InputError(
                "a run to {end} by {name} would take more than {most:.0e} evaluations of the "
                "forces: ask for a shorter time",
                end=Parameter("t_end", f"{self._t_end:g} s"),
                name=self.name,
                most=MOST_STEPS,
            )
            return math.inf
        if not self._march.is_set_up and (
            self._waves is not None or SETUP * self.force_cost < CHEAP * cost
        ):
            self._march.set_up()
            return self._plan()[2]
        return cost

    def receive(self, content: Content | None, states: States | None) -> None:
        """Take what another way has found: what its error is made of, and its best motion."""
        if self.content is None:
            self.content = content
        self._other = states

    def advance(self, budget: float) -> None:
        """Make the next run, unless the set-up finds that it costs more than another way."""
        self.running = RunStats(runs=0)
        if not self._march.is_set_up:
            self._march.set_up()
            if self.forecast() > budget:
                return
        integrator, finer, _ = self._plan()
        self.running = RunStats()
        before = self._march.omega
        states = self._march.run(integrator, finer, self.running)
        if states is None:
            self.failure = self._march.failure
            # Steps are measured by the stable one, which is shorter by now.
            shorter = before / self._march.omega
            self._made = [(each, shorter * fine) for each, fine in self._made]
            return
        self._take(integrator, finer, states)
        if self.error < math.inf:
            self.failure = self._convergence.add(self.error)
        if self._other is not None and self.states is not None:
            # Two ways have no error in common.
            self.error = min(self.error, distance(self._system, self.states, self._other))

    def _plan(self) -> tuple[Explicit, float, float]:
        """Return the next run, and what it and all that follow cost.

        The run is an integrator, and by how much its steps are shorter than stable ones.
        """
        if self.content is None and self._waves is None:
            # Nothing is known yet: order 4 where there is a choice, then a run to compare it with.
            usual = self._integrators[len(self._integrators) // 2]
            closer = CLOSER[usual.tableau.order]
            if self._made:
                first, finer = (self._integrators[0], 1.0) if self._loose else (usual, closer)
                return first, finer, self._march.cost(first, finer)
            return usual, 1.0, self._march.cost(usual, 1.0) + self._march.cost(usual, closer)
        plans = [self._plan_with(each) for each in self._integrators]
        return min(plans, key=lambda plan: plan[2])

    def _plan_with(self, integrator: Explicit) -> tuple[Explicit, float, float]:
        """Return the plan for an integrator, from what is known of the error."""
        closer = CLOSER[integrator.tableau.order]
        mine = [finer for each, finer in self._made if each == integrator]
        wanted, cost = self._wanted(integrator), 0.0
        if not mine:
            first = max(1.0, wanted / (closer if self._waves is None else APART))
            second = max(closer * first, wanted)
            both = self._march.cost(integrator, first) + self._march.cost(integrator, second)
            return integrator, first, both
        last = max(mine)
        steps = [min(max(wanted, closer * last), FURTHEST * last)]
        while steps[-1] < wanted:
            steps.append(min(wanted, FURTHEST * steps[-1]))
        cost = sum(self._march.cost(integrator, each) for each in steps)
        return integrator, steps[0], cost

    def _wanted(self, integrator: Explicit) -> float:
        """Return how much finer than stable the steps must be for the accuracy."""
        finer = 1.0
        while finer < 1e6 and self._predicted(integrator, finer) > SAFETY * self._accuracy:
            finer *= FINER
        return finer

    def _predicted(self, integrator: Explicit, finer: float) -> float:
        """Return the error that a run will have [m]."""
        if self._waves is not None:
            step = self._march.step(integrator, finer)
            return self._scale * self._waves.error(integrator.tableau, step)
        assert self.content is not None
        return self.content.error(self._lost(integrator, finer, self.content.omega))

    def _take(self, integrator: Explicit, finer: float, states: States) -> None:
        """Estimate the error of the better one of a run and the one before."""
        if self.states is None:
            self._loose = len(self._integrators) > 1 and self._is_loose(states)
            self._keep(integrator, finer, states, math.inf)
            return
        (other, coarser), before = self._made[-1], self.states
        apart = max(distance(self._system, states, before), np.finfo(float).tiny)
        omega = min(frequency(self._system, states, before, resolved=True), self._march.omega)
        pair = ((other, coarser), (integrator, finer))
        lost = sorted((self._lost(each, fine, omega) for each, fine in pair), reverse=True)
        self.content = Content.of(apart, omega, self._length, *lost)
        order = integrator.tableau.order
        if order < other.tableau.order:
            # The distance of runs of two orders is the error of the lower one.
            self._made.insert(0, (integrator, finer))
            self.error = apart
            return
        self._keep(integrator, finer, states, self._estimate(pair, apart))

    def _estimate(self, pair: tuple[tuple[Explicit, float], ...], apart: float) -> float:
        """Return the error of the second of two runs, which are so far apart [m]."""
        assert self.content is not None
        (other, coarser), (integrator, finer) = pair
        error, order = apart, integrator.tableau.order
        if other == integrator:
            omega = self._march.omega
            fastest = self._lost(integrator, finer, omega) * omega * self._length
            believed = BELIEVED
            if self.content.lost > RESOLVED:
                sudden = self._waves is not None  # smooth loads set off few of the fastest
                believed = DISSIPATED if sudden and order > 2 and fastest > 1.0 else UNRESOLVED
            power = believed * order
            if self._before is not None and self._before[:2] == (integrator, coarser):
                first, earlier = self._before[2:]
                power = min(power, power_of_fall(first, earlier, coarser, finer, apart))
                # Distances that decrease faster than the order are small by chance.
                apart = max(apart, earlier * fall(first, coarser, finer, order))
            error = apart / max((finer / coarser) ** power - 1.0, SMALLEST_SHARE)
            # Waves whose phase is lost do not converge with the order: all of the distance counts.
            if self.content.lost > 1.0:
                error = max(error, apart)
        elif self.content.lost < 1.0:
            # The distance is at least what the lower order is off less what the higher one is.
            error *= LEAST_OF_TWO
        self._before = (integrator, finer, coarser, apart)
        if self._waves is None:
            return error
        tableaus = (other.tableau, integrator.tableau)
        steps = (self._march.step(other, coarser), self._march.step(integrator, finer))
        predicted = self._waves.apart(tableaus, steps)
        first, second = (self._waves.error(*each) for each in zip(tableaus, steps, strict=True))
        scale = apart / max(predicted, UNLIKE * first, np.finfo(float).tiny)
        if other == integrator and order == 2 and 1.0 / ALIKE < scale < ALIKE:
            error = min(error, MARGIN * scale * second)
        error = max(error, min(max(scale, 1.0), MOST_MORE) * self._waves.unseen(tableaus, steps))
        if other == integrator:
            scale = error / max(second, np.finfo(float).tiny)
        self._scale = min(max(scale, LEAST_SCALE), MOST_SCALE)
        return error

    def _keep(self, integrator: Explicit, finer: float, states: States, error: float) -> None:
        self.states, self.error = states, error
        self.name, self.steps = repr(integrator), self.running.steps
        self._made.append((integrator, finer))

    def _lost(self, integrator: Explicit, finer: float, omega: float) -> float:
        """Return the share of its phase that a vibration loses in a run."""
        return phase_lost(integrator.tableau, omega * self._march.step(integrator, finer))

    def _is_loose(self, states: States) -> bool:
        """Whether the method of lowest order would do, judged by the motion as a whole."""
        start = np.broadcast_to(states.q[:1], states.q.shape)
        still = States(states.t, start, np.zeros_like(states.v), states.a, states.lam)
        amplitude = distance(self._system, states, still)
        omega = frequency(self._system, states, still)
        lost = self._lost(self._integrators[0], 1.0, omega)
        return LOOSE * amplitude * lost * omega * self._length < self._accuracy
