"""Energy gains of a scheme, separated from those of unconverged steps.

Rough motions are chaotic: a run by another solver is another motion, and tells nothing of this one.
So each step is solved once more from the very state before it, by Newton.
"""

import math

import numpy as np

import ancfsparse as ancf
from ancfsparse.integrators.implicit.time_integration import Start, make_time_loop
from ancfsparse.nonlinear.iteration import Costs, make_inverse, make_iteration
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.initial_conditions.consistent_state import regularize, starting_state
from ancfsparse.solve.preparation.convergence_criterion import ConvergenceCriterion
from ancfsparse.system import System

NEWTON = ancf.Newton()
ROUNDING = 1e-14  # relative change of coordinates by sums of a few dozen terms


class Steps:
    """The steps of one run of a scene, all of whose states are saved."""

    def __init__(self, drawn, integrator, path):
        self.system, self.integrator, self.dt = System(drawn.scene), integrator, drawn.dt
        system, pattern = self.system, self.system.pattern
        regularize(system, integrator.scale * self.dt**2)
        self.seed = SparseSeed(pattern.indptr, pattern.indices, system.n_free)
        start, _ = starting_state(system, self.seed, integrator, self.dt)
        self.states = [(start.q, start.v, start.a, start.lam)]
        self.states += zip(path.q[1:], path.v[1:], path.a[1:], path.lam[1:], strict=True)
        self.b = [start.b]
        m, f = getattr(integrator, "alpha_m", 0.0), getattr(integrator, "alpha_f", 0.0)
        for (_, _, a0, _), (_, _, a1, _) in zip(self.states, self.states[1:], strict=False):
            self.b.append(((1.0 - f) * a1 + f * a0 - m * self.b[-1]) / (1.0 - m))
        self.loads = system.loads.amplitudes(self.dt * np.arange(len(self.states) + 1.0))
        self.criterion = ConvergenceCriterion(system, integrator, "default")

    def gain(self, k, state):
        """Return the energy that a state after step k + 1 has above the one before it [J]."""
        (q0, v0, *_), (q1, v1, *_) = self.states[k], state
        kinetic, elastic, _, contact = self.system.energies(np.stack([q0, q1]), np.stack([v0, v1]))
        energy = kinetic + elastic + contact - np.stack([q0, q1]) @ self.system.dead_load
        work = self.system.assembly.load_work(q0, self.loads[k], q1, self.loads[k + 1])
        return float(energy[1] - energy[0] - work)

    def solved_again(self, k, rng=None):
        """Return Newton's solution of step k + 1, or None; with rng, from a perturbed state."""
        system, (q, v, a, lam) = self.system, self.states[k]
        if rng is not None:
            q = q * (1.0 + ROUNDING * rng.normal(size=q.shape))
        start = Start(q, v, a, self.b[k], lam, self.loads[k])
        march = make_time_loop(system, self.dt, self.integrator, start, np.inf, 0.0, 0.0)
        march.weigh(self.criterion.mass, self.criterion.total)
        inverse = make_inverse(NEWTON, self.seed, None, self.criterion.norm, 0.0)
        tolerance = self.criterion.at(self.dt)
        loop = make_iteration(march, self.seed, inverse, NEWTON, tolerance, Costs(1.0, 0.0, 1.0))
        n, m = system.n_all, system.n_multipliers
        room = [np.empty((2, width)) for width in (n, n, n, m)]
        taken, _ = march.advance(loop, 1, self.loads[k + 1 : k + 2], 1, 0, *room)
        return march.state if taken else None


def gain_by_newton(drawn, integrator, path, last, rng=None):
    """Return the energy gain of Newton's solutions of the steps, from the states of a run [J].

    The last may be one that the run did not accept; if Newton finds no solution of it either, the
    sum is infinite.  Where Newton finds none of another step the run's own solution counts.  With
    a generator of random numbers, the states are shaken by rounding.
    """
    steps, gained = Steps(drawn, integrator, path), 0.0
    for k in range(last):
        state = steps.solved_again(k, rng)
        if state is None:
            if k + 1 == len(steps.states):
                return math.inf
            state = steps.states[k + 1]
        gained += steps.gain(k, state)
    return gained


def gain_of_run(drawn, integrator, path, last):
    """Return the energy gain of a run's states up to a step, computed independently [J].

    The last may be one that the run did not accept; then Newton's solution of it counts.
    """
    steps = Steps(drawn, integrator, path)
    states = steps.states[: last + 1]
    if len(states) == last:
        states = [*states, steps.solved_again(last - 1) or states[-1]]
    return sum(steps.gain(k, state) for k, state in enumerate(states[1:]))
