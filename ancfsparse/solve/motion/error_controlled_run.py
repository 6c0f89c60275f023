"""Runs that meet an accuracy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ancfsparse.errors import AncfError
from ancfsparse.integrators import Explicit
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Trajectory
from ancfsparse.solve.error_control.best_solution import BestSolution
from ancfsparse.solve.error_control.check_accuracy import check_accuracy
from ancfsparse.solve.error_control.select_solution import solve_accurately
from ancfsparse.solve.motion.arguments import Request
from ancfsparse.solve.preparation.threads import usable_threads
from ancfsparse.solve.stepping.state_recorder import StateRecorder
from ancfsparse.system import System


class ErrorControlledRun:
    """Whole motions, until the error of one is small enough; otherwise raises an error.

    Parameters
    ----------
    request, system
        As `build_run` takes them.
    accuracy : float
        Largest error of a position [m].
    """

    def __init__(self, request: Request, system: System, accuracy: float) -> None:
        self._request, self._system, self._accuracy = request, system, accuracy
        self._threads = 1
        if not isinstance(request.integrator, Explicit):
            self._threads = usable_threads(system, request.threads)
        check_accuracy(
            system,
            accuracy,
            request.tolerance,
            request.named,
            request.solver,
            request.max_halvings or 0,
        )

    def integrate(
        self, recorder: StateRecorder, resumed: Mapping[str, Any] | None = None
    ) -> Outcome:
        """Integrate until the error is small enough; runs to an accuracy have no checkpoints."""
        assert resumed is None
        request = self._request
        solve_accurately(
            self._system,
            request.saved_times,
            self._accuracy,
            request.named,
            request.solver,
            request.max_energy_gain,
            request.progress,
            BestSolution(recorder, self._threads),
        )
        return Outcome.CONVERGED

    def failure(self, outcome: Outcome, path: Trajectory) -> AncfError:
        """Unreachable: runs to an accuracy raise their errors in `integrate`."""
        raise AssertionError(outcome)
