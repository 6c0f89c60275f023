"""The interface of a run, and the choice of its kind."""

from __future__ import annotations

import math
from typing import Protocol

from ancfsparse.errors import AncfError
from ancfsparse.integrators import Implicit
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Trajectory
from ancfsparse.solve import motion
from ancfsparse.solve.motion.arguments import Request
from ancfsparse.solve.preparation.memory_estimate import MemoryEstimate
from ancfsparse.solve.stepping.state_recorder import StateRecorder
from ancfsparse.system import System


class Run(Protocol):
    """A run that is set up and ready to integrate."""

    def integrate(self, recorder: StateRecorder) -> Outcome:
        """March to the end and pass all states to a recorder; return the outcome."""

    def failure(self, outcome: Outcome, path: Trajectory) -> AncfError:
        """Return the error for a run whose outcome is not convergence."""


def build_run(request: Request, system: System, needed: MemoryEstimate) -> Run:
    """Set a run up.

    Parameters
    ----------
    request : Request
        The checked arguments.
    system : System
        The moving system at its start.
    needed : MemoryEstimate
        Memory of the run without factors.

    Raises
    ------
    InputError
        If the integrator cannot handle the scene, or a factor does not fit.
    """
    if request.accuracy is not None:
        return motion.ErrorControlledRun(request, system, request.accuracy)
    integrator = request.integrator
    phase = math.inf if isinstance(integrator, Implicit) else integrator.tableau.interval
    for contribution in system.contributions:
        contribution.check_step(request.clock.dt, phase)
    if isinstance(request.integrator, Implicit):
        return motion.ImplicitRun(request, system, request.integrator, needed)
    return motion.ExplicitRun(request, system, request.integrator)
