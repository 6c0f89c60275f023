"""Runs with a fixed step of an explicit integrator."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

from ancfsparse.errors import AncfError, RedundantConstraintsWarning
from ancfsparse.integrators import Explicit
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Trajectory
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.motion.arguments import Request
from ancfsparse.solve.motion.fixed_step_run import FixedStepRun
from ancfsparse.solve.recovery import checkpoints
from ancfsparse.solve.recovery.checkpoints import Checkpoint
from ancfsparse.solve.recovery.singular_crossing import Crossing, SingularCrossing
from ancfsparse.solve.stepping.explicit_setup import (
    check_no_equations_options,
    count_forces,
    instability_error,
    prepare_explicit,
    restart_explicit,
)
from ancfsparse.system import System


class ExplicitRun(FixedStepRun):
    """Fixed steps without equations; parameters as `build_run` takes them."""

    takes_rates = True

    def __init__(self, request: Request, system: System, integrator: Explicit) -> None:
        check_no_equations_options(
            integrator,
            request.solver,
            request.tolerance,
            request.max_halvings or 0,
            request.factorization,
        )
        dt, n_steps, gain = request.clock.dt, request.n_steps, request.max_energy_gain
        time_loop, self._mass, why = prepare_explicit(
            system, dt, n_steps, integrator, gain, request.state
        )
        super().__init__(system, request, time_loop, None, time_loop.state[2], why)
        self._integrator, self._loop, self.seeds = integrator, time_loop, [self._mass]
        self._ahead: SingularCrossing | None = None
        has_bodies = any(body.masses is not None for body in system.scene.bodies)
        if (
            has_bodies
            and not request.is_endless
            and isinstance(self._mass, SparseSeed)
            and self._mass.n > system.n_free
        ):
            self._ahead = SingularCrossing(system, request.clock, n_steps, self._mass)
            self._steps_to_pause = 1

    def _recover(self, outcome: Outcome) -> Outcome:
        if self._ahead is not None and outcome == Outcome.CONVERGED:
            self._steps_to_pause = self._cross_ahead(self._ahead)
            if self.stats.steps == self._n_steps:
                self._warn(self._ahead)
        return outcome

    def _continue(self, crossing: Crossing) -> None:
        q, v, _, _ = crossing.states
        self._time_loop = self._loop = restart_explicit(
            self.system,
            self.clock.at(crossing.step),
            self._dt,
            self._integrator,
            self._mass,
            self._request.max_energy_gain,
            (q[-1], v[-1]),
            self._time_loop,
            crossing.work,
        )

    def save(self) -> Checkpoint:
        """Return the present state with its memory."""
        return checkpoints.save(self.system, self._time_loop, None, self.stats.steps)

    def return_to(self, back: Checkpoint) -> None:
        """Return to a checkpoint of this run."""
        self._loop.move(*back.state, back.memory)
        checkpoints.restore_contributions(self.system, back)
        if self._mass.n > self.system.n_free:  # the next step begins with the factor of its start
            self._loop.refresh()
        if self._ahead is not None:
            self._ahead.begin_again()
            self._steps_to_pause = 1
        self.stats.steps, self.is_between_steps = back.step, True

    def describe_memory(self) -> dict[str, Any]:
        """Return the memory of the run that is not in a checkpoint: earlier choices."""
        return {"failed": self._ahead.failed if self._ahead else None}

    def take_memory(self, stored: Mapping[str, Any]) -> None:
        """Set the memory that `describe_memory` has returned."""
        if self._ahead:
            self._ahead.failed = stored["failed"]

    def _warn(self, ahead: SingularCrossing) -> None:
        """Warn if the path led through a singular configuration that was not crossed."""
        if ahead.failed is not None:
            warnings.warn(
                f"constraints became dependent near t = {ahead.failed:.6g} s, where explicit "
                "methods amplify rounding, and no long step across it resolves the loads and "
                "vibrations: compare with GeneralizedAlpha(0.9)",
                RedundantConstraintsWarning,
                stacklevel=8,
            )

    def _count_costs(self) -> None:
        stats = self.stats
        count_forces(stats, self._integrator)
        if self._earlier is not None:  # those are of all steps, and are added
            for name in ("residual_evaluations", "solves", "factorizations"):
                setattr(stats, name, getattr(stats, name) - getattr(self._earlier, name))
        self.stats.events = self._crossings

    def failure(self, outcome: Outcome, path: Trajectory) -> AncfError:
        """Return the error of a run that ended with an outcome."""
        steps = self.stats.steps
        return instability_error(
            self.system,
            self._time_loop,
            self._mass,
            self._integrator,
            outcome,
            steps,
            self.clock.at(steps),
            self._dt,
            path,
        )
