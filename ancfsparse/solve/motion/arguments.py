"""The arguments of `simulate`, checked."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse import integrators
from ancfsparse.checks import check_choice, check_count, check_finite, check_flag, check_positive
from ancfsparse.errors import InputError
from ancfsparse.integrators import EnergyMomentum, GeneralizedAlpha, Implicit
from ancfsparse.integrators.interface.time_grid import (
    MAX_STEPS,
    TimeGrid,
    as_double,
    count_steps_from,
)
from ancfsparse.messages import format_value
from ancfsparse.nonlinear import Method
from ancfsparse.results import Equilibrium
from ancfsparse.scene import Point, Scene, check_scene
from ancfsparse.solve import statics
from ancfsparse.solve.initial_conditions.restart import check_start
from ancfsparse.solve.preparation.choose_factorization import check_factorization
from ancfsparse.solve.preparation.memory_estimate import MemoryEstimate, estimate_memory
from ancfsparse.solve.preparation.solver_settings import (
    check_max_energy_gain,
    check_solver,
    check_tolerance,
)
from ancfsparse.solve.preparation.threads import check_threads
from ancfsparse.solve.stepping.state_recorder import check_nodes, check_output
from ancfsparse.system import System
from ancfsparse.system.coordinates.state import State

if TYPE_CHECKING:
    from ancfsparse.integrators import Explicit
    from ancfsparse.solve.preparation.checkpoint_schedule import Schedule

# Second order, and unresolved vibrations are damped (docs/accuracy.md, docs/stability.md): as
# accurate as the trapezoidal rule, and stable where that is not.
DEFAULT_INTEGRATOR = GeneralizedAlpha(0.9)
EQUILIBRIUM = "equilibrium"  # start from statics
# Of steps in scenes with contact.  Of 247 random scenes with the default stiffness six fail with 6
# and none with 10 (docs/contact.md).
CONTACT_HALVINGS = 10
MAX_ROTATION = 0.07  # rotation of a rigid body in a step, beyond which its energy grows [rad]
N_SAVED = 200  # states of a run to an accuracy without dt
N_CHECKED_STEPS = 1000  # of a run without end in which functions of time are checked
ENDLESS = int(MAX_STEPS)  # number of steps of such a run
N_COMPARED_RUNS = 4  # motions that a run to an accuracy stores in addition to the result


@dataclass(frozen=True)
class Request:
    """Checked arguments of `simulate`, which describes them.

    Attributes
    ----------
    state : State or None
        Initial state; None for the stress-free shape at t = 0.
    clock : TimeGrid
        Times of the steps.
    n_steps : int
        Number of steps.
    named : Implicit, Explicit or None
        The integrator, if the caller has named one.
    moved : str
        A sentence if contacts move the initial state.
    checkpoint : Schedule or None
        When checkpoints are due.
    begun : float
        Begin of the set-up, by `time.perf_counter` [s].
    """

    scene: Scene
    state: State | None
    clock: TimeGrid
    t_end: float
    n_steps: int
    accuracy: float | None
    integrator: Implicit | Explicit
    named: Implicit | Explicit | None
    solver: Method | str
    factorization: str
    tolerance: str | float
    max_energy_gain: float
    max_halvings: int | None
    threads: int
    save_every: int
    save_nodes: Sequence[Point] | None
    output: str | Path | None
    progress: bool
    moved: str = ""
    checkpoint: Schedule | None = None
    begun: float = field(default_factory=time.perf_counter)

    @property
    def is_endless(self) -> bool:
        """True if the number of steps is not known."""
        return self.n_steps == ENDLESS

    @property
    def rows(self) -> int:
        """Number of states to be saved."""
        return -(-self.n_steps // self.save_every) + 1

    @property
    def saved_times(self) -> NDArray[np.float64]:
        """Times of these states [s]."""
        steps = np.append(np.arange(0.0, self.n_steps, self.save_every), self.n_steps)
        return np.asarray(self.clock.at(steps))

    def memory(self) -> MemoryEstimate:
        """Estimate the memory of the run."""
        return estimate_memory(
            self.scene,
            self.rows,
            None if self.save_nodes is None else len(self.save_nodes),
            self.output is not None,
            self.solver,
            whole_runs=0 if self.accuracy is None else N_COMPARED_RUNS,
            matrices=self.integrator.matrices,
            incomplete=self.factorization != "complete"
            and self.accuracy is None
            and isinstance(self.integrator, Implicit),
        )

    @property
    def settings(self) -> dict[str, Any]:
        """The settings that files store."""
        return {
            "t_start": None if self.state is None else self.state.t,
            "dt": self.clock.dt,
            "accuracy": self.accuracy,
            "t_end": self.t_end,
            "integrator": repr(self.integrator),
            "solver": repr(self.solver),
            "factorization": self.factorization,
            "tolerance": self.tolerance,
            "max_energy_gain": self.max_energy_gain,
            "max_halvings": self.max_halvings,
            "threads": self.threads,
            "save_every": self.save_every,
            **({"moved": self.moved} if self.moved else {}),
        }


def check_request(
    scene: Scene,
    t_end: float | None,
    dt: float | None,
    *,
    accuracy: float | None = None,
    integrator: Implicit | Explicit | str,
    solver: Method | str,
    factorization: str,
    tolerance: str | float,
    max_energy_gain: float,
    max_halvings: int | None,
    threads: int,
    save_every: int = 1,
    save_nodes: Sequence[Point] | None = None,
    output: str | Path | None = None,
    progress: bool = False,
    start: State | Equilibrium | str | None,
) -> Request:
    """Return the arguments of `simulate`, or of `Simulation` without an end, as a request.

    Raises
    ------
    InputError
        If one of them is invalid.
    """
    check_scene(scene)
    state = check_start(find_start_equilibrium(scene, start) if isinstance(start, str) else start)
    moved = ""
    if state is None and any(each.separates for each in scene.attachments):
        state, moved = statics.separate_bodies(scene)
    t_start = 0.0 if state is None else state.t
    if accuracy is not None:
        accuracy = check_positive("accuracy", accuracy, "m")
        dt = (check_positive("t_end", t_end, "s") - t_start) / N_SAVED if dt is None else dt
    if dt is None:
        raise InputError(
            "simulate needs a time step or an accuracy: give dt=1e-3 [s], or accuracy=1e-4 [m]"
        )
    if t_end is None:
        t_end = t_start + N_CHECKED_STEPS * check_positive("dt", dt, "s")
    n_steps = count_steps_from(t_start, t_end, dt)
    t_end, clock = check_finite("t_end", t_end, "s"), TimeGrid(t_start, as_double("dt", dt))
    save_every = min(check_count("save_every", save_every), n_steps)
    named = check_integrator(integrator)
    check_solver(solver)
    check_factorization(factorization, solver, accuracy)
    tolerance, max_energy_gain = check_tolerance(tolerance), check_max_energy_gain(max_energy_gain)
    progress = check_flag("progress", progress)
    if max_halvings is not None:
        max_halvings = check_count("max_halvings", max_halvings, 0)
    threads = check_threads(threads)
    check_nodes(save_nodes)
    check_output(output)
    return Request(
        scene,
        state,
        clock,
        t_end,
        n_steps,
        accuracy,
        DEFAULT_INTEGRATOR if named is None else named,
        named,
        solver,
        factorization,
        tolerance,
        max_energy_gain,
        max_halvings,
        threads,
        save_every,
        save_nodes,
        output,
        progress,
        moved,
    )


def find_start_equilibrium(scene: Scene, start: str) -> Equilibrium:
    """Return the equilibrium of a scene at t = 0 for ``start="equilibrium"``.

    Raises
    ------
    InputError
        If `start` is another word, or the scene has initial velocities.
    EquilibriumError
        If no equilibrium is found.
    """
    check_choice("start", start, (EQUILIBRIUM,))
    equilibrium = statics.solve_static(scene)
    if System(scene).v0.any():
        raise InputError(
            "start='equilibrium' begins at rest, but the scene has initial velocities: leave out "
            "one of them"
        )
    return equilibrium


def select_integrator(request: Request, system: System) -> Request:
    """Return the request with the integrator for "auto".

    Rotation of rigid bodies moves a root of generalised-alpha out of the unit circle, so that
    energy grows (docs/theory.md); rotation of the frame of the scene does too.  `EnergyMomentum`
    has no such root.
    """
    if request.named is not None or request.accuracy is not None:
        return request
    spin = 0.0
    for body, indices in zip(system.scene.bodies, system.places, strict=True):
        if body.masses is not None:
            vectors = [indices[:, body.kind.columns(name)] for name in body.kind.vectors[1:]]
            rates = np.linalg.norm(system.v0[np.array(vectors)], axis=-1)
            spin = max(spin, float(np.max(rates)) + system.scene.turning)
    if spin * request.clock.dt <= MAX_ROTATION:
        return request
    return replace(request, integrator=EnergyMomentum())


def select_halvings(request: Request, system: System) -> Request:
    """Return the request with the number of halvings, if the caller has named none.

    Bodies begin to touch within a step, which a shorter one resolves.
    """
    if request.max_halvings is not None:
        return request
    touches = any(each.is_contact for each in system.contributions)
    is_fixed = request.accuracy is None and isinstance(request.integrator, Implicit)
    return replace(request, max_halvings=CONTACT_HALVINGS if touches and is_fixed else 0)


def check_integrator(integrator: object) -> Implicit | Explicit | None:
    """Return an integrator after checking it, None for "auto"."""
    if isinstance(integrator, str) and integrator == "auto":
        return None
    if isinstance(integrator, Implicit):
        return integrator
    if isinstance(integrator, integrators.Explicit):
        return integrator
    *others, last = integrators.EXAMPLES
    raise InputError(
        f"integrator must be {', '.join(others)} or {last}, got {format_value(integrator)}"
    )
