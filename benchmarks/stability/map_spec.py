"""Scope of a map of outcomes: scenes at any stiffness, time steps, integrators and solvers.

The product of all would be large and show little more: every integrator is run with some solvers,
and every solver with some integrators.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from ancfsparse.errors import EnergyIncreaseError, StepError
from ancfsparse.integrators import Implicit
from ancfsparse.nonlinear import Method
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene
from ancfsparse.solve import simulate
from benchmarks.stability.cells import (
    FAILED,
    FINISHED,
    GAINED,
    RECOVERED,
    MapPoint,
    Run,
    recovered_fractions,
)

PERTURBATION = 1e-9  # relative change of the stiffness between neighbouring runs
PERTURBATIONS = 10  # neighbouring runs on either side
MIN_COMPLETION_RATIO = 0.5  # complete neighbours over Newton's; 0.67 to 0.93 of the map's four runs


class Case(Protocol):
    """A scene of a map, with more that its measures need."""

    @property
    def scene(self) -> Scene:
        """The scene, ready to simulate."""


@dataclass(frozen=True)
class MapSpec:
    """The scenes of a map, the cut through its product, and the measures of its runs."""

    command: str  # words after ``python -m benchmarks``
    varied: str  # name of the stiffness in findings
    unit: str  # of the stiffness
    scenes: Mapping[str, Callable[[float], Case]]  # by the stiffness
    stiffnesses: Sequence[float]
    steps: Sequence[float]  # [s]
    integrators: Mapping[str, Implicit]
    solvers: Mapping[str, Method | str]
    for_all_integrators: Sequence[str]  # solvers that every integrator is run with
    for_all_solvers: Sequence[str]  # integrators that every solver is run with
    t_end: float  # of a run [s], or
    max_steps: int  # if these are shorter
    # columns of the stored states, one is "gain" and one is "loss"
    measures: Sequence[str]
    measure: Callable[[Trajectory, Any], Iterable[float]]

    def n_steps(self, dt: float) -> int:
        """Return the number of steps of a full run."""
        return min(self.max_steps, round(self.t_end / dt))

    def pairs(self) -> list[tuple[str, str]]:
        """Return the integrators and solvers of the cut."""
        return [
            (integrator, solver)
            for integrator in self.integrators
            for solver in self.solvers
            if solver in self.for_all_integrators or integrator in self.for_all_solvers
        ]

    def map_points(
        self,
        scenes: Sequence[str] = (),
        stiffnesses: Sequence[float] = (),
        steps: Sequence[float] = (),
        integrators: Sequence[str] = (),
        solvers: Sequence[str] = (),
    ) -> list[MapPoint]:
        """Return the points of the cut with these values, where none are specified with all."""
        return [
            MapPoint(scene, stiffness, dt, integrator, solver)
            for scene in scenes or self.scenes
            for integrator, solver in self.pairs()
            if integrator in (integrators or self.integrators)
            if solver in (solvers or self.solvers)
            for stiffness in stiffnesses or self.stiffnesses
            for dt in steps or self.steps
        ]

    def run_at(self, map_point: MapPoint) -> Run:
        """Run a point of the map; an early end is a result."""
        case = self.scenes[map_point.scene](map_point.stiffness)
        dt, reason = map_point.dt, ""
        try:
            path = simulate(
                case.scene, self.n_steps(dt) * dt, dt,
                integrator=self.integrators[map_point.integrator],
                solver=self.solvers[map_point.solver], max_halvings=0,
            )  # fmt: skip
            outcome = RECOVERED if path.stats.recoveries else FINISHED
        except EnergyIncreaseError as stop:
            path, outcome, reason = stop.trajectory, GAINED, "energy"
        except StepError as stop:
            path, outcome = stop.trajectory, FAILED
            reason = path.stats.events[-1].cause if path.stats.events else str(stop.reason)
        measures = dict(zip(self.measures, self.measure(path, case), strict=True))
        return Run(
            map_point, outcome, path.stats.steps, reason, path.stats.iterations_per_step,
            *recovered_fractions(path), measures,
        )  # fmt: skip

    def finishes(self, map_point: MapPoint) -> bool:
        """Return True if the run at a point comes to its end."""
        return self.run_at(map_point).is_complete

    def ends_by_chance(
        self, map_point: MapPoint, finishes: Callable[[MapPoint], bool] | None = None
    ) -> bool:
        """Return True if it finishes half as many neighbours as Newton, and Newton not all.

        Neighbouring runs differ by billionths of the stiffness.  Near its limit a motion is
        chaotic, and the outcome of one run is not a property of the solver; the fraction of its
        neighbours is.  `finishes` can store the runs.
        """
        finishes = finishes or self.finishes
        neighbours = [
            map_point._replace(stiffness=map_point.stiffness * (1.0 + k * PERTURBATION))
            for k in range(-PERTURBATIONS, PERTURBATIONS + 1) if k
        ]  # fmt: skip
        newton = sum(finishes(each._replace(solver="Newton")) for each in neighbours)
        if newton == len(neighbours):
            return False
        return sum(map(finishes, neighbours)) >= MIN_COMPLETION_RATIO * newton

    def repeat(self, map_point: MapPoint) -> str:
        """Return the command that repeats a run, and Newton's at the same place."""
        return (
            f"python -m benchmarks {self.command} --scene '{map_point.scene}' "
            f"--stiffness {map_point.stiffness:g} --step {map_point.dt:g} --integrator "
            f"'{map_point.integrator}' --solver Newton --solver '{map_point.solver}'"
        )
