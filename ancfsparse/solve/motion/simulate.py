"""Motion in time: check the arguments, build the run, integrate it, return its trajectory."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ancfsparse.errors import AncfError, InputError
from ancfsparse.integrators import Implicit
from ancfsparse.nonlinear import Method, Outcome
from ancfsparse.results import Equilibrium, Trajectory
from ancfsparse.scene import Point, Scene
from ancfsparse.solve import initial_conditions, motion, preparation
from ancfsparse.solve.error_models.signal_resolution import warn_of_unresolved_signals
from ancfsparse.solve.initial_conditions.consistent_state import check_constraints, check_energy
from ancfsparse.solve.initial_conditions.restart import restore_contributions
from ancfsparse.solve.motion.arguments import (
    Request,
    check_request,
    select_halvings,
    select_integrator,
)
from ancfsparse.solve.preparation.memory_estimate import MemoryEstimate, check_memory
from ancfsparse.solve.stepping.state_recorder import RunStorage, StateRecorder
from ancfsparse.system import System
from ancfsparse.system.coordinates.state import State

if TYPE_CHECKING:
    from ancfsparse.integrators import Explicit


def simulate(
    scene: Scene,
    t_end: float,
    dt: float | None = None,
    *,
    accuracy: float | None = None,
    integrator: Implicit | Explicit | str = "auto",
    solver: Method | str = "auto",
    factorization: str = "auto",
    tolerance: str | float = "default",
    max_energy_gain: float = 0.01,
    max_halvings: int | None = None,
    threads: int = 1,
    save_every: int = 1,
    save_nodes: Sequence[Point] | None = None,
    output: str | Path | None = None,
    progress: bool = False,
    start: State | Equilibrium | str | None = None,
    checkpoint: int | str | Sequence[int] | None = None,
) -> Trajectory:
    """Integrate a scene in time, with a fixed step or to an accuracy.

    Parameters, results, errors and notes are described in `ancfsparse.simulate`, which also takes a
    quantity of interest and its error.
    """
    request = check_request(
        scene,
        t_end,
        dt,
        accuracy=accuracy,
        integrator=integrator,
        solver=solver,
        factorization=factorization,
        tolerance=tolerance,
        max_energy_gain=max_energy_gain,
        max_halvings=max_halvings,
        threads=threads,
        save_every=save_every,
        save_nodes=save_nodes,
        output=output,
        progress=progress,
        start=start,
    )
    if checkpoint is not None:
        if accuracy is not None:
            raise InputError(
                "a run to an accuracy computes several motions and has no checkpoints: take dt in "
                "place of accuracy, or leave out checkpoint"
            )
        if output is None:
            raise InputError(
                "checkpoint needs the file of the run: give output='run.h5', or leave it out"
            )
        request = replace(request, checkpoint=preparation.Schedule(checkpoint))
    check_memory(request.memory())
    system = build_system_at_start(request)
    warn_of_penetrations(request, system, stacklevel=4)
    if accuracy is None:
        warn_of_unresolved_signals(system, request.clock, request.n_steps, stacklevel=4)
    return run_request(request, system)


class Run(Protocol):
    """A run that is set up and ready to integrate."""

    def integrate(
        self, recorder: StateRecorder, resumed: Mapping[str, Any] | None = None
    ) -> Outcome:
        """March to the end and pass all states to a recorder; return the outcome.

        A run that is `resumed` continues from the data of a checkpoint.
        """

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


def run_request(
    request: Request, system: System, resumed: Mapping[str, Any] | None = None
) -> Trajectory:
    """Integrate a system from its start, or from the data of a checkpoint.

    A system can be integrated several times.

    Raises
    ------
    AncfError
        As in `simulate`.
    """
    request = select_halvings(select_integrator(request, system), system)
    needed = request.memory()
    check_memory(needed)
    settings, head, records = request.settings, None, None
    if request.checkpoint is not None:
        description = motion.describe_request(request, system)
        head, records = motion.pack(description), description["records"]
    storage = RunStorage(
        system,
        request.rows,
        request.save_nodes,
        request.output,
        settings,
        head,
        records,
        is_resumed=resumed is not None,
    )
    run = build_run(request, system, needed)
    with storage.open() as recorder:
        outcome = run.integrate(recorder, resumed)
    path = storage.trajectory()
    if outcome != Outcome.CONVERGED:
        raise run.failure(outcome, path)
    storage.remove_checkpoint()
    for contribution in system.contributions:
        for warning in contribution.run_warnings(path.t, path.q):
            warnings.warn(warning, stacklevel=4)
    return path


def may_be_redundant(system: System) -> bool:
    """Return whether some constraints may be redundant.

    Joints of points at one position were compared as they were added.  Beams deform in every
    coordinate, so constraints of one joint alone, or of joints at different nodes, are independent.
    """
    constraints = system.constraints
    if not system.n_multipliers:
        return False
    if any(constraints.mass) or any(
        len(joint.nodes) == 2 and not joint.joins for joint in system.joints
    ):
        return True
    # Several constraints of one coordinate, by rods, ropes, gears and prescribed angles.
    gradients = constraints.reach(system.q0)
    gradients.data[:] = 1.0
    return bool(np.max(gradients.sum(axis=0)) > 1.0)


def build_system_at_start(request: Request) -> System:
    """Return the system of a request after checking its start.

    Raises
    ------
    InputError
        If the start violates a constraint or a prescribed motion, or leaves the range of numbers.

    Warns
    -----
    RedundantConstraintsWarning
        If constraints are redundant.
    """
    return prepare_start(request, System(request.scene, request.state))


def warn_of_penetrations(request: Request, system: System, stacklevel: int) -> None:
    """Warn of penetrations that known loads do not cause in a motion without a `start`."""
    if request.state is not None:  # of an equilibrium, an assembly or an earlier run
        return
    for contribution in system.contributions:
        for warning in contribution.start_warnings(system.q0):
            warnings.warn(warning, stacklevel=stacklevel)


def prepare_start(request: Request, system: System) -> System:
    """Check the start of a system that was built for a request, as `build_system_at_start` does."""
    restore_contributions(request.state, system)
    if system.prescribed:
        initial_conditions.start_prescribed_motions(
            system, request.state, request.clock.dt, request.t_end
        )
    check_energy(system)
    check_constraints(system, request.state)
    if may_be_redundant(system):
        initial_conditions.warn_of_redundant_constraints(system)
    return system
