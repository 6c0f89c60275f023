"""Trial runs: complete motions or equilibria on coarse meshes, with long steps, each run once."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError, PlanError, StepError
from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.nonlinear import Method
from ancfsparse.plans.models.model import (
    MIN_LONGEST_COUNT,
    Model,
    build_model,
    built_key,
    coarse_count,
    element_counts,
    requested_key,
)
from ancfsparse.plans.models.prolongation import prolongate
from ancfsparse.plans.quantities.quantity import Quantity
from ancfsparse.plans.quantities.tolerances import Goal
from ancfsparse.plans.trial_runs.choose_solver import select_solver
from ancfsparse.plans.trial_runs.cost_model import RunCost, cost_of_run
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.results import Equilibrium, Trajectory
from ancfsparse.results.solutions.selected_states import select_states
from ancfsparse.scene import Scene
from ancfsparse.solve import solve_static
from ancfsparse.solve.motion.arguments import Request, check_request
from ancfsparse.solve.motion.simulate import build_system_at_start, prepare_start, run_request
from ancfsparse.system import System

MIN_STEPS = 100  # of the first trial run
# Work is counted, not timed, so that plans do not depend on the load of the machine.
BASE_BUDGET = 1.5e7  # residuals of one coordinate, about a tenth of a second of trial runs
# Without it, planning the motion of a slack beam on a support took two minutes, and found no plan.
SEARCH_BUDGET = 100.0 * BASE_BUDGET  # of all trial runs while steps are halved
MAX_WORK_RATIO = 1000.0  # of all trial runs over the first, if that is more
TRIAL_FRACTION = 0.15  # of the work of the planned run, for a trial run beyond the base budget
MAX_INTERVALS = 2000  # between saved states, as in planned runs, which a trial run may become
MAX_EXPENSIVE_INTERVALS = 128  # for a quantity that is expensive to evaluate
COARSE_TOLERANCE = 0.01  # relative tolerance from which the coarsest mesh and step are tried first
COUNT_POWER = 1.0 / 8.0  # power of a smaller tolerance with which the first mesh is refined
STEP_FACTOR = 2  # by which its steps are shorter
SMOOTH_ORDER = 4  # in the length of the elements, of quantities that are continuous between them
STEP_UNITS = 8  # minimum number of units of a power of two in a selected number of steps


@dataclass(frozen=True)
class TrialRun:
    """Result of one trial run.

    Attributes
    ----------
    model : Model
        Elements and mesh.
    steps : int
        Number of steps.
    histories : tuple of ndarray, each (k, m)
        Every quantity at the saved times [its unit].
    cost : RunCost
        Its operation counts.
    run : Trajectory
        The motion.
    integrator : Implicit, Explicit or SolutionMethod
        Its integrator, or method without time steps.
    solver : Method or str
        Nonlinear solver of its steps.
    """

    model: Model
    steps: int
    histories: tuple[Vector, ...]
    cost: RunCost
    run: Trajectory
    integrator: Implicit | Explicit | SolutionMethod
    solver: Method | str


@dataclass
class TrialRuns:
    """Trial runs of one scene, stored so that none is repeated.

    Parameters
    ----------
    scene : Scene
        The scene, with automatic elements and meshes.
    t_end : float or None
        Time at the end [s]; None for an equilibrium.
    goals : sequence of Goal
        Quantities and errors.
    integrator : Implicit, Explicit or SolutionMethod
        Of the runs.
    base : int
        Smallest number of steps.
    start : str or None
        ``"equilibrium"`` if motions begin there.
    max_step_order : int
        Largest order of convergence in the steps; 1 if a load jumps inside a step.
    done, seconds, failure : dict, float, StepError or None
        Runs by model and steps, None for failed ones; their time [s]; the last failure.
    systems, scenes : dict
        Systems and scenes by model.
    run_costs : list of RunCost
        Costs of all completed runs, by other integrators and of changed scenes included.
    changes : dict
        Results of `corrections` by trial run.
    """

    scene: Scene
    t_end: float | None
    goals: Sequence[Goal]
    integrator: Implicit | Explicit | SolutionMethod
    base: int = MIN_STEPS
    start: str | None = None
    max_step_order: int = 2
    done: dict[tuple[object, ...], TrialRun | None] = field(default_factory=dict)
    seconds: float = 0.0
    failure: StepError | None = None
    systems: dict[tuple[object, ...], System] = field(default_factory=dict)
    run_costs: list[RunCost] = field(default_factory=list)
    scenes: dict[tuple[object, ...], Scene | InputError] = field(default_factory=dict)
    changes: dict[int, list[float] | None] = field(default_factory=dict)

    @property
    def first(self) -> tuple[float, int]:
        """Elements on the longest beam and steps of the first trial run of a motion."""
        error = min((each.error for each in self.goals if each.relative), default=COARSE_TOLERANCE)
        if error >= COARSE_TOLERANCE:
            return coarse_count(self.scene, MIN_LONGEST_COUNT), self.base
        n_longest = float(round(MIN_LONGEST_COUNT * (COARSE_TOLERANCE / error) ** COUNT_POWER))
        return coarse_count(self.scene, n_longest), STEP_FACTOR * self.base

    def with_mesh(self, model: Model, n_longest: float) -> Model:
        """Return a model with a number of elements on the longest automatic beam."""
        meshed = model.with_counts(element_counts(self.scene, n_longest))
        return replace(meshed, nodes=self.nodes)

    @property
    def step_order(self) -> int:
        """Order of convergence in the steps of an integrator."""
        assert not isinstance(self.integrator, SolutionMethod)
        return min(self.integrator.order, self.max_step_order)

    @property
    def nodes(self) -> dict[str, tuple[float, ...]]:
        """Relative positions on beams of nodes for quantities that jump between elements.

        Where a place changes within the elements from mesh to mesh, the error changes its sign: a
        bending moment was off by .2, 1.5 and .06 tolerances with 18, 20 and 22 elements.
        """
        out: dict[str, tuple[float, ...]] = {}
        for quantity in (each.quantity for each in self.goals):
            point = quantity.point
            if point is not None and quantity.order(SMOOTH_ORDER) < SMOOTH_ORDER:
                size = point.beam.size
                out[point.beam.name] = (*out.get(point.beam.name, ()), point.s / size)
        return out

    def build(self, model: Model) -> Scene:
        """Return the scene with a model, built only once.

        Raises
        ------
        InputError
            If the scene does not admit the model.
        """
        key = requested_key(model)
        if key not in self.scenes:
            try:
                scene = build_model(self.scene, model)
                self.scenes[key] = self.scenes.setdefault(built_key(model, scene), scene)
            except InputError as error:
                self.scenes[key] = error
        result = self.scenes[key]
        if isinstance(result, InputError):
            raise result
        return result

    def with_integrator(self, integrator: Implicit | Explicit | SolutionMethod) -> TrialRuns:
        """Return runs of the same scene by another integrator or method."""
        return replace(self, integrator=integrator, done={}, seconds=0.0, failure=None, changes={})

    def run(self, model: Model, steps: int) -> TrialRun | None:
        """Return a trial run; None if a step fails, or its energy increases spuriously.

        Raises
        ------
        InputError
            If the scene does not admit the model.
        """
        key = (*self._key(model), steps)
        if key not in self.done:
            begin = time.perf_counter()
            self.done[key] = self._run(model, steps)
            self.seconds += time.perf_counter() - begin
        return self.done[key]

    @property
    def budget(self) -> float:
        """Largest work of all runs, relative to a residual of one coordinate."""
        return max(SEARCH_BUDGET, MAX_WORK_RATIO * self.run_costs[0].work)

    def check_budget(self) -> None:
        """Refuse further runs if the present ones have taken too much work.

        Raises
        ------
        PlanError
            If so.
        """
        work = [each.work for each in self.run_costs]
        if work and sum(work) > self.budget:
            quantity, steps = self.goals[0].quantity, max(each.steps for each in self.run_costs)
            raise PlanError(quantity.name, 0.0, 0.0, quantity.unit, len(work), steps=steps)

    def without_damping(self) -> TrialRuns:
        """Return runs by the same integrator without numerical damping; itself if it has none."""
        assert isinstance(self.integrator, Implicit)
        undamped = self.integrator.without_damping()
        return self if undamped == self.integrator else self.with_integrator(undamped)

    def _run(self, model: Model, steps: int) -> TrialRun | None:
        system = self.systems.get(self._key(model))
        scene = self.build(model)
        solver = self.solver(scene, steps)
        try:
            run = self.solve(scene, steps, system, self._coarser(model), solver)
        except StepError as failure:
            failure.trajectory = None
            self.failure = failure
            return None
        if self.t_end is not None and not isinstance(self.integrator, SolutionMethod):
            system = run.system
            if not system.prescribed:  # prescribed motions are tabulated for one step size
                self.systems[self._key(model)] = system
        histories = tuple(_history(each.quantity.in_scene(scene), run) for each in self.goals)
        cost = cost_of_run(run.stats, steps, run.q.shape[1])
        if isinstance(self.integrator, SolutionMethod):
            overhead = self.integrator.overhead(run.stats, cost.coordinates)
            cost = replace(cost, unit_work=cost.unit_work * (1.0 + overhead / cost.work))
        return TrialRun(model, steps, histories, cost, run, self.integrator, solver)

    def _coarser(self, model: Model) -> Trajectory | None:
        """Return the last equilibrium with the same elements, None if there is none."""
        if self.t_end is not None:
            return None
        runs = (each.run for each in reversed(self.done.values()) if each is not None
                and each.model.elements == model.elements)  # fmt: skip
        return next(runs, None)

    def solve(
        self,
        scene: Scene,
        steps: int,
        system: System | None = None,
        coarser: Trajectory | None = None,
        solver: Method | str | None = None,
    ) -> Trajectory:
        """Return the motion of a scene in a number of steps, or its equilibrium.

        A `system` of the scene from an earlier run is used again, and the equilibrium on a
        `coarser` mesh is the initial guess on a finer one.  The solver is selected from the costs
        of earlier runs, unless one is given.
        """
        solver = solver or self.solver(scene, steps)
        if self.t_end is None:
            start = None if coarser is None else prolongate(coarser, scene)
            run = as_trajectory(solve_static(scene, start=start))
        elif isinstance(self.integrator, SolutionMethod):
            run = self.integrator.solve(scene, self.t_end, steps)
        else:
            request = self._request(scene, steps, system, solver)
            run = run_request(request, system or build_system_at_start(request))
        self.charge(run, steps)
        return run

    def solver(self, scene: Scene, steps: int) -> Method | str:
        """Return the solver of a number of steps, selected from the costs of earlier runs."""
        if self.t_end is None:
            return "auto"
        return select_solver(scene, self.integrator, self.run_costs, steps)

    def charge(self, run: Trajectory, steps: int) -> None:
        """Add the cost of a run."""
        self.run_costs.append(cost_of_run(run.stats, steps, run.q.shape[1]))

    def system_of(self, model: Model) -> System:
        """Return the stress-free system of a model; trial runs use it without prescribed motions.

        Raises
        ------
        InputError
            If the scene does not admit the model, or cannot start there.
        """
        key = self._key(model)
        if key in self.systems:
            return self.systems[key]
        system = System(self.build(model))
        separates = any(term.separates for term in system.contributions)
        if self.start is None and not system.prescribed and not separates:
            self.systems[key] = prepare_start(self._request(system.scene, self.base, None), system)
        return system

    def _request(self, scene: Scene, steps: int, system: System | None,
                 solver: Method | str = "auto") -> Request:  # fmt: skip
        """Return the checked arguments of a run by an integrator."""
        assert self.t_end is not None
        assert not isinstance(self.integrator, SolutionMethod)
        return check_request(
            scene,
            self.t_end,
            self.t_end / steps,
            accuracy=None,
            integrator=self.integrator,
            solver=solver,
            factorization="auto",
            tolerance="default",
            max_energy_gain=0.01,
            max_halvings=0,
            threads=1,
            save_every=self._save_every(steps),
            save_nodes=None,
            output=None,
            progress=False,
            start=self.start if system is None else None,
        )

    @property
    def failed(self) -> int:
        """Largest number of steps of a failed run on any mesh; 0 if none has failed."""
        steps = (key[-1] for key, run in self.done.items() if run is None)
        return max((cast(int, each) for each in steps), default=0)

    def find(self, model: Model, steps: int) -> TrialRun | None:
        """Return a stored run, None if there is none."""
        return self.done.get((*self._key(model), steps))

    def _key(self, model: Model) -> tuple[object, ...]:
        """Return the key of the runs of a model."""
        return built_key(model, self.build(model))

    def _save_every(self, steps: int) -> int:
        """Return a divisor of the steps with which runs with other steps save the same times."""
        coarse = max(1, 2 * self.base // MAX_INTERVALS)
        grid = self.base // next(each for each in range(coarse, 0, -1) if self.base % each == 0)
        intervals = steps // math.gcd(steps, grid)
        largest = max(1, 2 * steps // MAX_INTERVALS)
        return next(each for each in range(largest, 0, -1) if intervals % each == 0)

    @property
    def total_work(self) -> float:
        """Work of all runs so far, relative to a residual of one coordinate."""
        return sum(run.work for run in self.costs)

    @property
    def costs(self) -> list[RunCost]:
        """Costs of all completed runs by this integrator."""
        return [each.cost for each in self.done.values() if each is not None]


def round_steps(steps: float, base: int) -> int:
    """Return the next number of steps with many saved times in common with `base` times 2^k."""
    unit = smallest = base // 2 if base % 2 == 0 else base
    while unit * STEP_UNITS < steps:
        unit *= 2
    unit = max(smallest, unit // STEP_UNITS)
    return unit * math.ceil(steps / unit - 1e-9)


def as_trajectory(equilibrium: Equilibrium) -> Trajectory:
    """Return an equilibrium as a trajectory of one state."""
    q = np.asarray(equilibrium.q)[None]
    rest, lam = np.zeros_like(q), np.asarray(equilibrium.lam)[None]
    t = np.array([equilibrium.t])
    stats = equilibrium.stats
    return Trajectory(equilibrium.system, t, q, rest, rest, lam, stats, ending=equilibrium.state)


def _history(quantity: Quantity, run: Trajectory) -> Vector:
    """Return a quantity at the saved times, or at some of them if it is expensive."""
    every, intervals = 1, len(run.t) - 1
    if quantity.is_expensive and quantity.at != "largest":
        while intervals // every > MAX_EXPENSIVE_INTERVALS and intervals % (2 * every) == 0:
            every *= 2
    return quantity.history(run if every == 1 else select_states(run, slice(None, None, every)))
