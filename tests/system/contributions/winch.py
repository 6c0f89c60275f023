"""A contribution written in Python: `ancf_contribution` through ctypes."""

import ctypes as ct

from tests.headers import implement


class Winch:
    """A force on a coordinate that grows by a newton with every accepted step.

    Parameters
    ----------
    place : int
        Of the coordinate in q.
    """

    def __init__(self, place):
        self.seen = []  # the coordinate at the start and after each accepted step
        self.calls = 0
        self._kept = (ct.c_double * 1)()

        def residual(_, state, r, phi):
            self.calls += 1
            r[place] -= self._kept[0]

        def begin(_, state):
            self._kept[0] = 0.0
            self.seen = [state[0].q[place]]

        def accept(_, state):
            self._kept[0] += 1.0
            self.seen.append(state[0].q[place])

        self._interface, self.capsule = implement(
            "ancf_contribution", n_memory=1, memory=self._kept, residual=residual, begin=begin,
            accept=accept,
        )  # fmt: skip
