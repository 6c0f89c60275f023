"""States inside steps that a run divided, which it does not save: forces do work along them."""

import contextlib
from dataclasses import replace
from unittest import mock

import numpy as np

from ancfsparse.solve import stepping
from ancfsparse.solve.motion import implicit_run
from ancfsparse.solve.motion.checkpoints import Repetition


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

    The parts of steps that a run repeats are no longer its own.
    """
    states = []

    clocks = []

    class Halving(stepping.StepHalving):
        def __init__(self, system, time_loop, *args):
            super().__init__(system, Watched(time_loop, states), *args)
            clocks.append(self._clock)

        def recover(self, step, outcome):
            self._time_loop.t = self._clock.at(step - 1)
            return super().recover(step, outcome)

    class Again(Repetition):
        def begin(self, step):
            back = super().begin(step)
            if back is not None and clocks:
                last = clocks[-1].at(back.step)
                states[:] = [each for each in states if each[0] <= last]
            return back

    halving = mock.patch.object(stepping, "StepHalving", Halving)
    with halving, mock.patch.object(implicit_run, "Repetition", Again):
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
