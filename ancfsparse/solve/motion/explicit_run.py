"""Runs with a fixed step of an explicit integrator."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ancfsparse.errors import AncfError
from ancfsparse.integrators import Explicit
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Trajectory
from ancfsparse.seeds.dense.block_inverse import BlockInverse
from ancfsparse.solve.motion.arguments import Request
from ancfsparse.solve.motion.fixed_step_run import FixedStepRun
from ancfsparse.solve.stepping.explicit_setup import (
    check_no_equations_options,
    count_forces,
    instability_error,
    prepare_explicit,
)
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.seeds import Seed


class ExplicitRun(FixedStepRun):
    """Fixed steps without equations; parameters as `build_run` takes them."""

    takes_rates = True

    def __init__(self, request: Request, system: System, integrator: Explicit) -> None:
        check_no_equations_options(
            integrator,
            request.solver,
            request.tolerance,
            request.max_halvings,
            request.factorization,
        )
        dt, n_steps, gain = request.clock.dt, request.n_steps, request.max_energy_gain
        time_loop, self._mass, why = prepare_explicit(
            system, dt, n_steps, integrator, gain, request.state
        )
        super().__init__(system, request, time_loop, None, time_loop.state[2], why)
        self._integrator = integrator

    @property
    def _seeds(self) -> list[Seed | BlockInverse]:
        return [self._mass]

    def _count_costs(self) -> None:
        count_forces(self._stats, self._integrator)

    def failure(self, outcome: Outcome, path: Trajectory) -> AncfError:
        """Return the error of a run that ended with an outcome."""
        steps = self._stats.steps
        return instability_error(
            self._system,
            self._time_loop,
            self._mass,
            self._integrator,
            outcome,
            steps,
            self._clock.at(steps),
            self._dt,
            path,
        )
