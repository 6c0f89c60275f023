"""States inside steps that a run divided, which it does not save: forces do work along them."""

import contextlib
from dataclasses import replace
from unittest import mock

import numpy as np

from ancfsparse.nonlinear import Outcome
from ancfsparse.solve import recovery
from ancfsparse.solve.recovery.checkpoints import RepeatedSteps
from ancfsparse.solve.recovery.step_halving import StepHalving


class Watched:
    """A time loop that enters the states it reaches in a list."""

    def __init__(self, time_loop, states):
        self._time_loop, self._states = time_loop, states
        self.t = self.dt = 0.0

    def __getattr__(self, name):
        return getattr(self._time_loop, name)

    def change_step(self, dt, *args):
        self.dt = dt
        self._time_loop.change_step(dt, *args)

    def advance(self, *args):
        taken, outcome = self._time_loop.advance(*args)
        if taken:
            self.t += self.dt
            self._states.append((self.t, *self._time_loop.state))
        return taken, outcome


@contextlib.contextmanager
def recorded_parts():
    """Return a list of the time and the state after each part of the steps of a run.

    The parts of steps that a run repeats are no longer its own, unless it discards the repetition.
    """
    states = []

    clocks = []

    class Halving(StepHalving):
        def __init__(self, run):
            super().__init__(run)
            self._time_loop = Watched(self._time_loop, states)
            clocks.append(self._clock)

        def solve(self, step, outcome):
            self._time_loop.t = self._clock.at(step - 1)
            return super().solve(step, outcome)

    class Again(RepeatedSteps):
        def attempt(self, step, outcome):
            outcome = super().attempt(step, outcome)
            if outcome == Outcome.CONVERGED and clocks:
                self._before_trial = list(states)
                last = clocks[-1].at(self.failure.back)
                states[:] = [each for each in states if each[0] <= last]
            return outcome

        def end_trial(self):
            is_discarded = super().end_trial()
            if is_discarded and clocks:
                states[:] = self._before_trial
            return is_discarded

    halving = mock.patch.object(recovery, "StepHalving", Halving)
    with halving, mock.patch.object(recovery, "RepeatedSteps", Again):
        yield states


def with_parts(path, states):
    """Return a run with the states after the parts of its steps too, for its energies."""
    states = (each for each in states if each[0] < path.t[-1])
    inside = [each for each in states if np.abs(path.t - each[0]).min() > 1e-9 * each[0]]
    if not inside:
        return path
    tables = zip((path.t, path.q, path.v, path.a, path.lam), zip(*inside, strict=True), strict=True)
    t, q, v, a, lam = (np.concatenate([saved, np.array(new)]) for saved, new in tables)
    order = np.argsort(t)
    history = path.internal[np.searchsorted(path.t, t[order], side="right") - 1]
    return replace(
        path, t=t[order], q=q[order], v=v[order], a=a[order], lam=lam[order], internal=history
    )
