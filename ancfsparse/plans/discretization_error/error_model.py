"""Error model: errors and cost of a model on every mesh and step, predicted from trial runs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ancfsparse.plans.discretization_error.run_estimates import RunEstimates, elements_of
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.trial_runs.cost_model import CostModel
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, round_steps

# Of the tolerance, that predicted errors may use; estimates miss a comparable amount.  With 1, of
# 277 random plans one more exceeded the tolerance, 1.7 times, at .99 of the work.
SAFETY_FRACTION = 0.75
MESH_FRACTIONS = np.linspace(0.05, 0.95, 37)  # of the adjustable error, tried for the mesh
# If the fixed part of the error exceeds the tolerance, the adjustable part may add this fraction.
ADDED_FRACTION = 0.1  # of the fixed part
MAX_MESH_RATIO = 8.0  # elements over those of the finest trial run
MAX_STEP_RATIO = 64.0  # steps over those of the trial run with most
SOLVER_FRACTION = 0.01  # error by the tolerance of the solver over that of the step


@dataclass(frozen=True)
class ErrorModel:
    """Errors and cost of one model, predicted from trial runs for every mesh and step.

    Attributes
    ----------
    model : Model
        The elements.
    time : RunEstimates
        Of the steps.
    mesh : RunEstimates or None
        Of the automatic meshes.
    given_mesh_errors : tuple of float
        Error of the meshes specified by the user, for every quantity [its unit].
    tolerances : tuple of float
        Largest error of every quantity [its unit].
    cost : CostModel
        Work by steps and coordinates.
    fixed_steps : int or None
        Number of steps if the step was specified.
    effects : tuple of mapping of str to float
        Modelling errors of the elements by effect, for every quantity [its unit].
    selected : tuple of float and int, or None
        Elements on the longest beam and steps of a completed run that meets the tolerances.
    base : int
        Smallest number of steps, see `round_steps`.
    combined_errors : tuple of float, or None
        Error of the selected run by mesh and steps together, if two trial runs were enough.
    order : int
        Order of positions in the length of the elements.
    floors : tuple of float
        Difference between converged elements, for every quantity [its unit].
    is_bound : bool
        Whether errors are bounds, of slowly converging motions, see `bound`.
    """

    model: Model
    time: RunEstimates
    mesh: RunEstimates | None
    given_mesh_errors: tuple[float, ...]
    tolerances: tuple[float, ...]
    cost: CostModel
    fixed_steps: int | None
    effects: tuple[Mapping[str, float], ...] = ()
    selected: tuple[float, int] | None = None
    base: int = 1
    combined_errors: tuple[float, ...] | None = None
    order: int = 4
    floors: tuple[float, ...] = ()
    is_bound: bool = False

    def with_effects(self, effects: Sequence[Mapping[str, float]]) -> ErrorModel:
        """Return the same with modelling errors of the elements."""
        return replace(self, effects=tuple(effects))

    @property
    def reference_run(self) -> TrialRun:
        """Trial run for modelling errors: section forces need the finest mesh."""
        return self.mesh.runs[-1] if self.mesh is not None else self.time.runs[-1]

    @property
    def coarse_run(self) -> TrialRun:
        """Cheap trial run to measure responses: the coarsest, or one with the reference's steps."""
        last = self.time.runs[-1]
        if self.combined_errors is not None:
            return min(self.time.runs, key=lambda run: run.cost.work)
        return last if last.steps == self.reference_run.steps else self.reference_run

    def neglected(self, i: int) -> float:
        """Return the sum of the modelling errors of quantity i [its unit]."""
        return sum(self.effects[i].values()) if self.effects else 0.0

    def errors(self, n_longest: float, steps: float) -> list[dict[str, float]]:
        """Predict the error of every quantity by its source [its unit].

        On a mesh with `n_longest` elements on the longest automatic beam.
        """
        out = []
        for i, time in enumerate(self.time.estimates):
            mesh = self.given_mesh_errors[i]
            if self.mesh is not None:
                mesh += self.mesh.estimates[i].at(n_longest * self.density)
            of_steps = time.at(steps)
            sources = {"mesh": mesh, "time": of_steps, "solver": SOLVER_FRACTION * of_steps}
            if self.combined_errors is not None and (n_longest, steps) == self.selected:
                both = self.combined_errors[i]
                sources = {"mesh and steps": both, "solver": SOLVER_FRACTION * both}
            out.append(sources | dict(self.effects[i] if self.effects else {}))
        return out

    @property
    def density(self) -> float:
        """Elements of all automatic beams over those of the longest."""
        if self.mesh is None:
            return 1.0
        last = self.mesh.runs[-1]
        return elements_of(last) / max(last.model.counts.values())

    @property
    def is_observed(self) -> bool:
        """True if the trial runs show all orders of convergence."""
        parts = [each for each in (self.time, self.mesh) if each is not None]
        return all(each.is_observed for part in parts for each in part.estimates)

    def coordinates(self, n_longest: float) -> float:
        """Return the number of coordinates on a mesh."""
        if self.mesh is None:
            return self.time.runs[-1].cost.coordinates
        one, other = self.mesh.runs[0], self.mesh.runs[-1]
        slope = other.cost.coordinates / elements_of(other)
        if one is not other:
            slope = (other.cost.coordinates - one.cost.coordinates) / (
                elements_of(other) - elements_of(one)
            )
        more = n_longest * self.density - elements_of(other)
        return max(other.cost.coordinates + slope * more, 1.0)

    def seconds(self, n_longest: float, steps: float) -> float:
        """Predict the time of a run [s]."""
        return self.cost.seconds(steps, self.coordinates(n_longest))

    def work(self, n_longest: float, steps: float) -> float:
        """Return the work of a run, relative to a residual of one coordinate."""
        return self.cost.work(steps, self.coordinates(n_longest))

    def optimum(self) -> tuple[float, int]:
        """Return elements on the longest beam and number of steps with least work.

        Fixed parts of the error are accepted; the rest of the tolerance is divided between mesh and
        steps such that the work is least.
        """
        if self.selected is not None:
            return self.selected
        return min((self._resolution(fraction) for fraction in MESH_FRACTIONS), key=self._rank)

    def excess(self, n_longest: float, steps: float) -> float:
        """Return the largest ratio of predicted error to tolerance."""
        errors = zip(self.errors(n_longest, steps), self.tolerances, strict=True)
        return max(sum(each.values()) / tolerance for each, tolerance in errors)

    @property
    def optimal_work(self) -> float:
        """Work of the best resolution, relative to a residual of one coordinate."""
        return self.work(*self.optimum())

    @property
    def optimal_excess(self) -> float:
        """Largest ratio of predicted error to tolerance at the best resolution."""
        return self.excess(*self.optimum())

    def _rank(self, resolution: tuple[float, int]) -> tuple[float, float]:
        """Return the ratio of the error to the smallest possible one, at least 1, and the work."""
        n_longest, steps = resolution
        errors = enumerate(self.errors(n_longest, steps))
        excess = max(sum(each.values()) / self._reachable(i) for i, each in errors)
        return max(1.0, excess), self.work(n_longest, steps)

    def _reachable(self, i: int) -> float:
        """Return the tolerance of quantity i, or the smallest error that can be reached."""
        fixed = self.given_mesh_errors[i] + self.neglected(i)
        return max(self.tolerances[i], fixed + self._adjustable(i))

    def _adjustable(self, i: int) -> float:
        """Return the error that automatic meshes and steps may cause in quantity i [its unit]."""
        fixed = self.given_mesh_errors[i] + self.neglected(i)
        allowed = SAFETY_FRACTION * self.tolerances[i]
        added = ADDED_FRACTION * max(fixed, self.floors[i] if self.floors else 0.0)
        return max(allowed - fixed if allowed > fixed else allowed, added)

    def _resolution(self, mesh_fraction: float) -> tuple[float, int]:
        """Return elements and steps for a fraction of the adjustable error due to the mesh."""
        n_longest, steps = 1.0, 1.0
        for i, time in enumerate(self.time.estimates):
            adjustable = self._adjustable(i)
            if self.mesh is not None:
                of_mesh = mesh_fraction * adjustable
                count = self.mesh.estimates[i].resolution_for(of_mesh) / self.density
                n_longest = max(n_longest, math.ceil(count - 1e-9))
            else:
                mesh_fraction = 0.0
            of_steps = (1.0 - mesh_fraction) * adjustable / (1.0 + SOLVER_FRACTION)
            steps = max(steps, time.resolution_for(of_steps))
        if self.mesh is not None:
            n_longest = min(max(n_longest, self.min_longest), self.max_longest)
        if self.fixed_steps is not None:
            return n_longest, self.fixed_steps
        steps = min(steps, MAX_STEP_RATIO * self.time.runs[-1].steps)
        return n_longest, max(self.time.runs[0].steps, round_steps(steps, self.base))

    @property
    def min_longest(self) -> float:
        """Fewest elements on the longest beam with predicted errors: half of a trial run's."""
        assert self.mesh is not None
        return math.ceil(0.5 * max(self.mesh.runs[0].model.counts.values()))

    @property
    def max_longest(self) -> float:
        """Most elements on the longest beam with predicted errors."""
        assert self.mesh is not None
        return MAX_MESH_RATIO * max(self.mesh.runs[-1].model.counts.values())


def scaled(
    error_model: ErrorModel, n_longest: float, steps: int, factor: float
) -> tuple[float, int]:
    """Return elements and steps with about `factor` times the errors of given ones."""
    is_open = error_model.fixed_steps is None
    is_open = is_open and any(each.error for each in error_model.time.estimates)
    step_ratio = factor ** -(1.0 / 2.0) if is_open else 1.0
    mesh_ratio = 1.0
    if error_model.mesh is not None:
        mesh_ratio = factor ** -(1.0 / min(each.order for each in error_model.mesh.estimates))
    return (
        max(1.0, float(round(n_longest * mesh_ratio))),
        max(error_model.time.runs[0].steps, round_steps(steps * step_ratio, error_model.base)),
    )
