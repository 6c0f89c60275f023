"""Pilot runs: whole motions on coarse meshes with long steps, each run once."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, StepFailure
from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.plans.costs import Counted, counted
from ancfsparse.plans.models import Model, built
from ancfsparse.plans.quantities import Quantity
from ancfsparse.plans.wanted import Wanted
from ancfsparse.plans.ways import Way
from ancfsparse.results import Equilibrium, Trajectory
from ancfsparse.scene import Scene
from ancfsparse.solve import simulate, solve_static

Array = NDArray[np.float64]

# Steps of the first pilot.
FEWEST = 50
# Work that pilots may cost in any case, about a tenth of a second; it is counted, so that plans do
# not depend on what else a machine does.
FREE = 1.5e7
# States of a pilot at which motions are compared; vibrations between them would be missed.
MOST_STATES = 1024
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
    """

    model: Model
    steps: int
    histories: tuple[Array, ...]
    cost: Counted
    run: Trajectory


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
        Steps of the longest kind; all runs have a power of two times as many.
    """

    scene: Scene
    t_end: float | None
    wanted: Sequence[Wanted]
    integrator: Implicit | Explicit | Way
    base: int = FEWEST
    done: dict[tuple[object, ...], Pilot | None] = field(default_factory=dict)
    seconds: float = 0.0
    failure: StepFailure | None = None

    def with_integrator(self, integrator: Implicit | Explicit | Way) -> Pilots:
        """Return runs of the same scene by another integrator or way."""
        return replace(self, integrator=integrator, done={}, seconds=0.0, failure=None)

    def run(self, model: Model, steps: int) -> Pilot | None:
        """Return a pilot run; None if a step of it fails, or it gains energy.

        Raises
        ------
        InputError
            If the scene does not take the model.
        """
        key = (*sorted((name, str(rung)) for name, rung in model.rungs.items()),
               *sorted(model.counts.items()), steps)  # fmt: skip
        if key not in self.done:
            begin = time.perf_counter()
            self.done[key] = self._run(model, steps)
            self.seconds += time.perf_counter() - begin
        return self.done[key]

    def _run(self, model: Model, steps: int) -> Pilot | None:
        scene = built(self.scene, model)
        try:
            run = self.march(scene, steps)
        except StepFailure as failure:
            failure.trajectory = None
            self.failure = failure
            return None
        histories = tuple(_history(each.quantity.on(scene), run) for each in self.wanted)
        cost = counted(run.stats, steps, run.q.shape[1])
        return Pilot(model, steps, histories, cost, run)

    def march(self, scene: Scene, steps: int) -> Trajectory:
        """Run a scene that was built, in so many steps; or find its equilibrium."""
        if self.t_end is None:
            return at_rest(solve_static(scene))
        if isinstance(self.integrator, Way):
            return self.integrator.march(scene, self.t_end, steps)
        return simulate(
            scene,
            self.t_end,
            self.t_end / steps,
            integrator=self.integrator,
            save_every=self._save_every(steps),
        )

    def _save_every(self, steps: int) -> int:
        """Return a divisor of the steps, such that runs with more of them save the same times."""
        coarse = max(1, self.base // MOST_STATES)
        every = next(each for each in range(coarse, 0, -1) if self.base % each == 0)
        while steps // every > MOST_STATES and steps // every > self.base:
            every *= 2
        return every

    @property
    def spent(self) -> float:
        """Work of all runs so far, in that of a residual of one coordinate."""
        return sum(run.amount for run in self.costs)

    @property
    def costs(self) -> list[Counted]:
        """Counts of all runs that came to their end."""
        return [each.cost for each in self.done.values() if each is not None]


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
        if tolerance == 0.0:
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
    """Return two histories at the times that both have: those of the one with fewer."""
    fewer = max(1, min(len(one), len(other)) - 1)
    strides = [max(1, (len(each) - 1) // fewer) for each in (one, other)]
    return one[:: strides[0]], other[:: strides[1]]
