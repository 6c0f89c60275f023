"""Explicit integrators on the way to an accuracy: which, in which steps, and what they leave."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import AccuracyError, InputError, Parameter
from ancfsparse.integrators.explicit.explicit_methods import Explicit
from ancfsparse.integrators.interface.time_grid import MOST_STEPS
from ancfsparse.results import RunStats
from ancfsparse.solve.error_control.explicit_error_estimate import ExplicitErrors
from ancfsparse.solve.error_control.explicit_march import ExplicitMarch
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.error_models.modal_error_model import ModalSpectrum
from ancfsparse.solve.error_models.phase_error import (
    DominantFrequency,
    difference_frequency,
    phase_error,
)
from ancfsparse.solve.error_models.stagnation import StagnationCheck
from ancfsparse.solve.stepping.sampled_states import SampledStates, differs_by_rounding, distance
from ancfsparse.system import System

Vector = NDArray[np.float64]

# Ratio of the steps of the first run to those of the second, by the order: the cheapest from whose
# difference the error can be estimated; and the least and largest ratio for later runs, the latter
# smaller where errors do not decrease.
CLOSER, CLOSEST, FURTHEST, CAREFUL = {2: 1.35, 4: 1.3, 8: 1.25}, 1.1, 2.2, 1.5
# The same ratio at most where the error is predicted.
APART = 1.5
# The error of the lowest order must be so much less than the motion as a whole lets expect.
LOOSE = 10.0
# Share of the accuracy that the predicted error of a run may have.
SAFETY = 0.7
# Forces that the set-up is worth, about, and share of all cost from which on it does not matter.
SETUP, CHEAP = 100.0, 0.05
FINER = 1.05  # ratio of the steps that are compared
# Predicted error of a first run, over the accuracy, below which a lower order may confirm it, whose
# own is then as large as the accuracy.
CONFIRMED = 0.6
# A run of MANY steps, whose error is so many times the accuracy and seems to grow from rounding,
# is repeated with steps that are a little shorter.  If errors of steps were all, the distance of
# both would be about the order of the method times a thousandth of the error, far less than AGAIN.
MANY, DOUBTED, REPEATED, AGAIN = 10_000, 10.0, 1.001, 0.05


class ExplicitCandidate:
    """One way to an accuracy.

    Parameters
    ----------
    system, t, accuracy, max_energy_gain
        As `solve_accurately` takes them.
    integrators : list of Explicit
        Those that may be taken, by ascending order.
    discontinuities : Breaks
        Where loads jump or kink.
    watch : callable
        Is given the states of a run whenever there are more of them.
    spectrum : Waves or None
        What the motion is made of, where that is known.

    Attributes
    ----------
    states : States
        The best motion so far, None before there is one.
    error : float
        Its estimated error [m].
    failure : Exception
        Why there is no way on, None if there is one.
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
        discontinuities: LoadDiscontinuities,
        watch: Callable[[SampledStates], None],
        spectrum: ModalSpectrum | None,
    ) -> None:
        self._system, self._t_end, self._length = system, float(t[-1]), float(t[-1] - t[0])
        self._spectrum, self._convergence = spectrum, StagnationCheck(accuracy)
        self._accuracy, self._integrators = accuracy, integrators
        self._march = ExplicitMarch(
            system, t, max_energy_gain, discontinuities, watch, integrators[-1]
        )
        self._errors = ExplicitErrors(system, self._length, self._march, spectrum)
        self.force_cost = self._march.force_cost
        # Integrators and by how much their steps were shorter than stable ones, the best last.
        self._made: list[tuple[Explicit, float]] = []
        self._loose = False
        self._other: SampledStates | None = None  # the best motion of another way
        # Whether the next run shows if rounding decides; None as long as nothing points to it.
        self._rounding: bool | None = None
        self.states: SampledStates | None = None
        self.error = math.inf
        self.failure: Exception | None = None
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
            self._spectrum is not None or SETUP * self.force_cost < CHEAP * cost
        ):
            self._march.set_up()
            return self._plan()[2]
        return cost

    def warn(self) -> None:
        """Warn of places where the errors of these motions are not known well."""
        self._march.places.warn()

    @property
    def content(self) -> DominantFrequency | None:
        """What parts two runs, perhaps two of another way; None as long as that is not known."""
        return self._errors.content

    def receive(self, content: DominantFrequency | None, states: SampledStates | None) -> None:
        """Take what another way has found: what its error is made of, and its best motion."""
        if self._errors.content is None:
            self._errors.content = content
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
        before = self._march.step(integrator, 1.0)
        states = self._march.run(integrator, finer, self.running)
        if states is None:
            self.failure = self._march.failure
            # Steps are measured by the stable one, which is shorter by now.
            shorter = self._march.step(integrator, 1.0) / before
            self._made = [(each, shorter * fine) for each, fine in self._made]
            self._errors.shorten(shorter)
            return
        if self._rounding and self.states is not None:
            self._rounding, apart = False, distance(self._system, self.states, states)
            if apart > max(AGAIN * self.error, self._accuracy):
                self.failure = AccuracyError(self._accuracy, self.error, len(self._made) + 1)
            return
        last = self.states
        self._take(integrator, finer, states)
        if self.error < math.inf:
            self.failure = self._convergence.add(self.error)
        doubtful = self.steps > MANY and self.error > DOUBTED * self._accuracy
        if self._rounding is None and last is not None and doubtful:
            grew = differs_by_rounding(self._system, last, states, self.steps)
            self._rounding = True if grew else None
        if self._other is not None and self.states is not None:
            # Two ways have no error in common.
            self.error = min(self.error, distance(self._system, self.states, self._other))

    def _plan(self) -> tuple[Explicit, float, float]:
        """Return the next run, and what it and all that follow cost.

        The run is an integrator, and by how much its steps are shorter than stable ones.
        """
        if not self._errors.may_predict:
            # Nothing is known yet: order 4 where there is a choice, then a run to compare it with.
            usual = self._integrators[len(self._integrators) // 2]
            closer = CLOSER[usual.tableau.order]
            if self._made:
                first, finer = (self._integrators[0], 1.0) if self._loose else (usual, closer)
                return first, finer, self._march.cost(first, finer)
            return usual, 1.0, self._march.cost(usual, 1.0) + self._march.cost(usual, closer)
        plans = [self._plan_with(each) for each in self._integrators] + self._confirming()
        plan = min(plans, key=lambda plan: plan[2])
        if self._rounding:
            integrator, finer = self._made[-1]
            again = integrator, REPEATED * finer
            return *again, self._march.cost(*again) + plan[2]
        return plan

    def _confirming(self) -> list[tuple[Explicit, float, float]]:
        """Return plans to confirm that a first run is accurate enough by one of lower order.

        Its steps need not be shorter than those of the first run, and it is cheaper where these are
        as long as stable ones.
        """
        if len(self._made) != 1:
            return []
        first, finer = self._made[0]
        if self._errors.predicted(first, finer) > CONFIRMED * self._accuracy:
            return []
        lower = [each for each in self._integrators if each.tableau.order < first.tableau.order]
        steps = [self._wanted(each, 1.0) for each in lower]
        costs = [self._march.cost(*pair) for pair in zip(lower, steps, strict=True)]
        return list(zip(lower, steps, costs, strict=True))

    def _plan_with(self, integrator: Explicit) -> tuple[Explicit, float, float]:
        """Return the plan for an integrator, from what is known of the error."""
        closer = CLOSER[integrator.tableau.order]
        mine = [finer for each, finer in self._made if each == integrator]
        wanted, cost = self._wanted(integrator), 0.0
        if not mine:
            first = max(1.0, wanted / (closer if self._spectrum is None else APART))
            second = max(closer * first, wanted)
            both = self._march.cost(integrator, first) + self._march.cost(integrator, second)
            return integrator, first, both
        last = max(mine)
        closer = self._errors.closest(integrator, closer, CLOSEST)
        furthest = CAREFUL if self._convergence.stuck else FURTHEST
        steps = [min(max(wanted, closer * last), furthest * last)]
        while steps[-1] < wanted:
            steps.append(min(wanted, furthest * steps[-1]))
        cost = sum(self._march.cost(integrator, each) for each in steps)
        return integrator, steps[0], cost

    def _wanted(self, integrator: Explicit, share: float = SAFETY) -> float:
        """Return how much finer than stable the steps must be for a share of the accuracy."""
        finer = 1.0
        while finer < 1e6 and self._errors.predicted(integrator, finer) > share * self._accuracy:
            finer *= FINER
        return finer

    def _take(self, integrator: Explicit, finer: float, states: SampledStates) -> None:
        """Estimate the error of a run, and keep it unless it is of lower order than the last."""
        error = self._errors.add(integrator, finer, states)
        if self.states is None:
            self._loose = len(self._integrators) > 1 and self._is_loose(states)
        elif integrator.tableau.order < self._made[-1][0].tableau.order:
            self._made.insert(0, (integrator, finer))
            self.error = error
            return
        self.states, self.error = states, error
        self.name, self.steps = repr(integrator), self.running.steps
        self._made.append((integrator, finer))

    def _is_loose(self, states: SampledStates) -> bool:
        """Whether the method of lowest order would do, judged by the motion as a whole."""
        start = np.broadcast_to(states.q[:1], states.q.shape)
        still = SampledStates(states.t, start, np.zeros_like(states.v), states.a, states.lam)
        amplitude = distance(self._system, states, still)
        omega = difference_frequency(self._system, states, still)
        first = self._integrators[0]
        lost = phase_error(first.tableau, omega * self._march.step(first, 1.0))
        return LOOSE * amplitude * lost * omega * self._length < self._accuracy
