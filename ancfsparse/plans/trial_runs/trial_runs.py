"""Pilot runs: whole motions on coarse meshes with long steps, each run once."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, StepError
from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.nonlinear import Method
from ancfsparse.plans.models.model import FEWEST_ELEMENTS, Model, built, coarsest
from ancfsparse.plans.models.prolongation import prolonged
from ancfsparse.plans.quantities.quantity import Quantity
from ancfsparse.plans.quantities.tolerances import Wanted
from ancfsparse.plans.trial_runs.choose_solver import solver_of
from ancfsparse.plans.trial_runs.cost_model import Counted, counted
from ancfsparse.plans.trial_runs.solution_methods import Way
from ancfsparse.results import Equilibrium, Trajectory
from ancfsparse.scene import ElasticBody, Scene
from ancfsparse.solve import solve_static
from ancfsparse.solve.motion.arguments import Request, check_request
from ancfsparse.solve.motion.simulate import at_start, marched, system_at_start
from ancfsparse.system import System

Array = NDArray[np.float64]

# Steps of the first pilot.
FEWEST = 100
# Work that pilots may cost in any case, about a tenth of a second; it is counted, so that plans do
# not depend on what else a machine does.
FREE = 1.5e7
# Share of the planned run that they may cost.
SHARE = 0.15
# Intervals between saved states at most: those of a planned run, which a pilot may become.
MOST_STATES = 2000
# The first pilot has the fewest elements and the longest steps where this share of the quantity is
# asked for or more; for less, elements grow with this power of it, and steps are half as long.
ROUGH, POWER, HALF = 0.01, 1.0 / 8.0, 2
# Numbers of steps that were chosen are multiples of half the fewest, and have so many units of a
# power of two times that: motions are compared at the times that both have.
UNITS = 8
# The same for a quantity that is slow to evaluate.
MOST_SLOW = 128


@dataclass(frozen=True)
class Pilot:
    """What one pilot run has given.

    Attributes
    ----------
    model : Model
        Elements and mesh.
    steps : int
        Number of steps.
    histories : tuple of ndarray, each (k, m)
        Every quantity at the saved times [its unit].
    cost : Counted
        What it has cost.
    run : Trajectory
        The motion.
    integrator : Implicit, Explicit or Way
        By which it was run.
    solver : Method or str
        By which its steps were solved.
    """

    model: Model
    steps: int
    histories: tuple[Array, ...]
    cost: Counted
    run: Trajectory
    integrator: Implicit | Explicit | Way
    solver: Method | str


@dataclass
class Pilots:
    """Runs of one scene, kept so that none is repeated.

    Parameters
    ----------
    scene : Scene
        With what is open.
    t_end : float or None
        Time at the end [s]; None: the equilibrium is asked for.
    wanted : sequence of Wanted
        Quantities and errors.
    integrator : Implicit, Explicit or Way
        Of the runs.
    base : int
        Steps of the longest kind.
    start : str or None
        ``"equilibrium"`` if motions begin there.
    done, seconds, failure : dict, float, StepError or None
        Runs by model and steps, their time [s], and what ended the last that failed.
    systems, scenes, bill, changes : dict, dict, list of Counted, dict
        Systems and scenes by model, and what all runs have cost that came to their end, those of
        other integrators and of changed scenes included; what `corrections` have shown, by pilot.
    """

    scene: Scene
    t_end: float | None
    wanted: Sequence[Wanted]
    integrator: Implicit | Explicit | Way
    base: int = FEWEST
    start: str | None = None
    done: dict[tuple[object, ...], Pilot | None] = field(default_factory=dict)
    seconds: float = 0.0
    failure: StepError | None = None
    systems: dict[tuple[object, ...], System] = field(default_factory=dict)
    bill: list[Counted] = field(default_factory=list)
    scenes: dict[tuple[object, ...], Scene | InputError] = field(default_factory=dict)
    changes: dict[int, list[float] | None] = field(default_factory=dict)

    @property
    def first(self) -> tuple[float, int]:
        """Elements on the longest beam and steps of the first pilot of a motion."""
        least = min((each.error for each in self.wanted if each.relative), default=ROUGH)
        if least >= ROUGH:
            return coarsest(self.scene, FEWEST_ELEMENTS), self.base
        finest = float(round(FEWEST_ELEMENTS * (ROUGH / least) ** POWER))
        return coarsest(self.scene, finest), HALF * self.base

    def built(self, model: Model) -> Scene:
        """Return the scene with a model; none is built twice.

        Raises
        ------
        InputError
            If the scene does not take the model.
        """
        key = _asked(model)
        if key not in self.scenes:
            try:
                scene = built(self.scene, model)
                self.scenes[key] = self.scenes.setdefault(_made(model, scene), scene)
            except InputError as error:
                self.scenes[key] = error
        found = self.scenes[key]
        if isinstance(found, InputError):
            raise found
        return found

    def with_integrator(self, integrator: Implicit | Explicit | Way) -> Pilots:
        """Return runs of the same scene by another integrator or way."""
        return replace(self, integrator=integrator, done={}, seconds=0.0, failure=None, changes={})

    def run(self, model: Model, steps: int) -> Pilot | None:
        """Return a pilot run; None if a step of it fails, or it gains energy.

        Raises
        ------
        InputError
            If the scene does not take the model.
        """
        key = (*self._key(model), steps)
        if key not in self.done:
            begin = time.perf_counter()
            self.done[key] = self._run(model, steps)
            self.seconds += time.perf_counter() - begin
        return self.done[key]

    def _run(self, model: Model, steps: int) -> Pilot | None:
        system = self.systems.get(self._key(model))
        scene = self.built(model)
        solver = self.solver(scene, steps)
        try:
            run = self.march(scene, steps, system, self._coarser(model), solver)
        except StepError as failure:
            failure.trajectory = None
            self.failure = failure
            return None
        if self.t_end is not None and not isinstance(self.integrator, Way):
            own = run.system
            if not own.prescribed:  # what prescribes a motion is made for a step
                self.systems[self._key(model)] = own
        histories = tuple(_history(each.quantity.on(scene), run) for each in self.wanted)
        cost = counted(run.stats, steps, run.q.shape[1])
        if isinstance(self.integrator, Way):
            more = self.integrator.calls(run.stats, cost.coordinates)
            cost = replace(cost, work=cost.work * (1.0 + more / cost.amount))
        return Pilot(model, steps, histories, cost, run, self.integrator, solver)

    def _coarser(self, model: Model) -> Trajectory | None:
        """Return the last equilibrium that was found with the same elements, None if none was."""
        if self.t_end is not None:
            return None
        alike = (each.run for each in reversed(self.done.values()) if each is not None
                 and each.model.rungs == model.rungs)  # fmt: skip
        return next(alike, None)

    def march(
        self,
        scene: Scene,
        steps: int,
        system: System | None = None,
        coarser: Trajectory | None = None,
        solver: Method | str | None = None,
    ) -> Trajectory:
        """Run a scene that was built, in so many steps; or find its equilibrium.

        A `system` of the scene that was marched before is not made again, and the equilibrium on a
        `coarser` mesh is where that of a finer one is sought.  The solver is that of the bill,
        unless one is given.
        """
        run = self._marched(scene, steps, system, coarser, solver or self.solver(scene, steps))
        self.charge(run, steps)
        return run

    def solver(self, scene: Scene, steps: int) -> Method | str:
        """Return how so many steps are solved, by what others took."""
        return "auto" if self.t_end is None else solver_of(scene, self.integrator, self.bill, steps)

    def charge(self, run: Trajectory, steps: int) -> None:
        """Put a run on the bill."""
        self.bill.append(counted(run.stats, steps, run.q.shape[1]))

    def _marched(
        self, scene: Scene, steps: int, system: System | None, coarser: Trajectory | None,
        solver: Method | str) -> Trajectory:  # fmt: skip
        if self.t_end is None:
            start = None if coarser is None else prolonged(coarser, scene)
            return at_rest(solve_static(scene, start=start))
        if isinstance(self.integrator, Way):
            return self.integrator.march(scene, self.t_end, steps)
        request = self._request(scene, steps, system, solver)
        return marched(request, system_at_start(request) if system is None else system)

    def system_of(self, model: Model) -> System:
        """Return the stress-free system of a model, which its pilots take up if nothing drives it.

        Raises
        ------
        InputError
            If the scene does not take the model, or cannot begin there.
        """
        key = self._key(model)
        if key in self.systems:
            return self.systems[key]
        system = System(self.built(model))
        if self.start is None and not system.prescribed:
            self.systems[key] = at_start(self._request(system.scene, self.base, None), system)
        return system

    def _request(self, scene: Scene, steps: int, system: System | None,
                 solver: Method | str = "auto") -> Request:  # fmt: skip
        """Return what a run by an integrator needs, checked."""
        assert self.t_end is not None
        assert not isinstance(self.integrator, Way)
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
        """Most steps with which a run has failed, on whatever mesh; 0 if none has."""
        steps = (key[-1] for key, run in self.done.items() if run is None)
        return max((cast(int, each) for each in steps), default=0)

    def find(self, model: Model, steps: int) -> Pilot | None:
        """Return a run that was made, None if there is none."""
        return self.done.get((*self._key(model), steps))

    def _key(self, model: Model) -> tuple[object, ...]:
        """Return what runs of a model are known by."""
        return _made(model, self.built(model))

    def _save_every(self, steps: int) -> int:
        """Return a divisor of the steps by which runs with other steps save the same times."""
        coarse = max(1, 2 * self.base // MOST_STATES)
        grid = self.base // next(each for each in range(coarse, 0, -1) if self.base % each == 0)
        intervals = steps // math.gcd(steps, grid)
        most = max(1, 2 * steps // MOST_STATES)
        return next(each for each in range(most, 0, -1) if intervals % each == 0)

    @property
    def spent(self) -> float:
        """Work of all runs so far, in that of a residual of one coordinate."""
        return sum(run.amount for run in self.costs)

    @property
    def costs(self) -> list[Counted]:
        """Counts of all runs that came to their end."""
        return [each.cost for each in self.done.values() if each is not None]


def rounded(steps: float, base: int) -> int:
    """Return the next number of steps whose run can be compared with those of `base` times 2^k."""
    unit = least = base // 2 if base % 2 == 0 else base
    while unit * UNITS < steps:
        unit *= 2
    unit = max(least, unit // UNITS)
    return unit * math.ceil(steps / unit - 1e-9)


def _asked(model: Model) -> tuple[object, ...]:
    """Return what a model is known by, as it was asked for."""
    grades = sorted((name, grade.below) for name, grade in model.grades.items())
    return (*_rungs(model), *sorted(model.counts.items()), *grades)


def _made(model: Model, scene: Scene) -> tuple[object, ...]:
    """Return what the scene that a model makes is known by: its elements and meshes.

    Nodes at places on a beam may make one mesh of several numbers of elements.
    """
    bodies = {name: cast(ElasticBody, scene.body(name)) for name in sorted(model.counts)}
    counts = ((name, body.n_elements) for name, body in bodies.items())
    return (*_rungs(model), *counts, *(body.lengths.tobytes() for body in bodies.values()))


def _rungs(model: Model) -> list[tuple[str, str]]:
    return sorted((name, str(rung)) for name, rung in model.rungs.items())


def at_rest(equilibrium: Equilibrium) -> Trajectory:
    """Return an equilibrium as a trajectory of one state."""
    q = np.asarray(equilibrium.q)[None]
    none, lam = np.zeros_like(q), np.asarray(equilibrium.lam)[None]
    t = np.array([equilibrium.t])
    stats = equilibrium.stats
    return Trajectory(equilibrium.system, t, q, none, none, lam, stats, ending=equilibrium.state)


def _history(quantity: Quantity, run: Trajectory) -> Array:
    """Return a quantity at the saved times, or at some of them if it is slow."""
    every, intervals = 1, len(run.t) - 1
    while quantity.slow and intervals // every > MOST_SLOW and intervals % (2 * every) == 0:
        every *= 2
    if every > 1:
        t, q, v, a, lam = (np.asarray(x)[::every] for x in (run.t, run.q, run.v, run.a, run.lam))
        run = replace(run, t=t, q=q, v=v, a=a, lam=lam)
    return quantity.history(run)


def tolerances(wanted: Sequence[Wanted], pilot: Pilot) -> list[float]:
    """Return the largest error of every quantity, relative ones by their size in a run [unit].

    Raises
    ------
    InputError
        If a quantity whose relative error is asked for is zero or does not change.
    """
    out = [each.tolerance(h) for each, h in zip(wanted, pilot.histories, strict=True)]
    for each, tolerance in zip(wanted, out, strict=True):
        if tolerance == 0.0 or (each.relative and not each.quantity.varies(pilot.run)):
            raise InputError(
                f"the {each.quantity.name} does not change, so it has no relative error: give an "
                f"absolute one, such as error=1e-3 [{each.quantity.unit or '-'}]"
            )
    return out


def distance(wanted: Wanted, mine: Array, its: Array) -> float:
    """Return by how much two histories of a quantity differ, at the times asked for [unit]."""
    quantity = wanted.quantity
    apart = quantity.difference(*map(quantity.chosen, _common(mine, its)))
    return float(np.linalg.norm(apart, axis=1).max())


def distances(wanted: Sequence[Wanted], one: Pilot, other: Pilot) -> list[float]:
    """Return by how much every quantity of two runs differs at the times asked for [unit]."""
    return list(map(distance, wanted, one.histories, other.histories))


def farthest(wanted: Sequence[Wanted], one: Pilot, other: Pilot) -> list[float]:
    """Return by how much every quantity of two runs differs at any saved time [unit]."""
    pairs = zip(wanted, one.histories, other.histories, strict=True)
    apart = (each.quantity.difference(*_common(mine, its)) for each, mine, its in pairs)
    return [float(np.linalg.norm(each, axis=1).max()) for each in apart]


def _common(one: Array, other: Array) -> tuple[Array, Array]:
    """Return two histories at the times that both have."""
    intervals = [len(each) - 1 for each in (one, other)]
    both = max(1, math.gcd(*intervals))
    strides = [max(1, each // both) for each in intervals]
    return one[:: strides[0]], other[:: strides[1]]
