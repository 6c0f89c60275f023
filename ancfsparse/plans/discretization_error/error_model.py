"""What pilot runs have shown of one model, from which every mesh and step is predicted."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ancfsparse.plans.discretization_error.mesh_error import MeshError, elements_of
from ancfsparse.plans.discretization_error.time_error import TimeError
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.trial_runs import cost_model
from ancfsparse.plans.trial_runs.trial_runs import Pilot, rounded

# Share of the error asked for that predictions may add up to: what they miss is about as large.
SURE, UNSURE = 0.75, 0.5
# Shares of it that the mesh may have, of which the cheapest is taken.
SHARES = np.linspace(0.05, 0.95, 37)
# Where the rest of the error is larger than what was asked for, or models differ by more, what is
# open may add this share.
BESIDE = 0.1
# Errors are continued to so many times the elements or steps of the finest pilots, no further; to
# fewer steps by an order that is not that of the method.
REACH_MESH, REACH_STEPS, REACH_ROUGH = 8.0, 64.0, 16.0
# What the tolerance of the solver leaves, over the error of the step (see `simulate`).
SOLVER = 0.01


@dataclass(frozen=True)
class Found:
    """What pilot runs have shown of one model, from which every mesh and step is predicted.

    Attributes
    ----------
    model : Model
        The elements.
    time : TimeError
        Of the steps.
    mesh : MeshError or None
        Of the open meshes.
    given : tuple of float
        Error of the meshes that were given, for every quantity [its unit].
    asked : tuple of float
        Largest error of every quantity [its unit].
    cost : CostModel
        Work by steps and coordinates.
    fixed_steps : int or None
        Number of steps if the step was given.
    effects : tuple of mapping of str to float
        What the chosen elements neglect, for every quantity [its unit].
    sure : float or None
        Share of the errors asked for that predictions may add up to; None: by the estimates.
    chosen : tuple of float and int, or None
        Elements on the longest beam and steps of a run that was made and is exact enough.
    base : int
        Steps of the longest kind, see `rounded`.
    pair : tuple of float, or None
        The error of the choice, of mesh and steps together, where two pilots were enough.
    is_short : bool
        Whether mesh and steps were refined together, see `ladder`.
    order : int
        Order of positions in the length of the elements.
    floors : tuple of float
        By how much converged elements differ, for every quantity [its unit].
    is_bound : bool
        Whether errors are bounds, of motions that approach each other slowly, see `rugged`.
    """

    model: Model
    time: TimeError
    mesh: MeshError | None
    given: tuple[float, ...]
    asked: tuple[float, ...]
    cost: cost_model.CostModel
    fixed_steps: int | None
    effects: tuple[Mapping[str, float], ...] = ()
    sure: float | None = None
    chosen: tuple[float, int] | None = None
    base: int = 1
    pair: tuple[float, ...] | None = None
    is_short: bool = False
    order: int = 4
    floors: tuple[float, ...] = ()
    is_bound: bool = False

    def with_effects(self, effects: Sequence[Mapping[str, float]]) -> Found:
        """Return the same with what the elements neglect."""
        return replace(self, effects=tuple(effects))

    @property
    def judge(self) -> Pilot:
        """The pilot that effects are judged by: forces in sections need the finest mesh."""
        return self.mesh.runs[-1] if self.mesh is not None else self.time.runs[-1]

    @property
    def rough(self) -> Pilot:
        """The pilot that responses are measured with: the coarse mesh with the same steps.

        Of two that are alike, the cheaper.
        """
        last = self.time.runs[-1]
        if self.pair is not None:
            alike = [run for run in self.time.runs if run.integrator == last.integrator]
            return min(alike, key=lambda run: run.cost.amount)
        return last if last.steps == self.judge.steps else self.judge

    def neglected(self, i: int) -> float:
        """Return the sum of the neglected effects on a quantity [its unit]."""
        return sum(self.effects[i].values()) if self.effects else 0.0

    def errors(self, finest: float, steps: float) -> list[dict[str, float]]:
        """Predict the error of every quantity by its source [its unit].

        Parameters
        ----------
        finest : float
            Number of elements on the longest open beam.
        steps : float
            Number of steps.
        """
        out = []
        for i, time in enumerate(self.time.estimates):
            mesh = self.given[i]
            if self.mesh is not None:
                mesh += self.mesh.estimates[i].at(finest * self.density)
            of_steps = time.at(steps)
            sources = {"mesh": mesh, "time": of_steps, "solver": SOLVER * of_steps}
            if self.pair is not None and (finest, steps) == self.chosen:
                sources = {"mesh and steps": self.pair[i], "solver": SOLVER * self.pair[i]}
            out.append(sources | dict(self.effects[i] if self.effects else {}))
        return out

    @property
    def density(self) -> float:
        """Elements of all open beams for each on the longest."""
        if self.mesh is None:
            return 1.0
        last = self.mesh.runs[-1]
        return elements_of(last) / max(last.model.counts.values())

    @property
    def share(self) -> float:
        """Share of the error asked for that predictions may add up to."""
        if self.sure is not None:
            return self.sure
        every = [*self.time.estimates, *(self.mesh.estimates if self.mesh else ())]
        return SURE if all(each.settled for each in every) else UNSURE

    def coordinates(self, finest: float) -> float:
        """Return the number of coordinates on a mesh."""
        if self.mesh is None:
            return self.time.runs[-1].cost.coordinates
        one, other = self.mesh.runs[0], self.mesh.runs[-1]
        slope = other.cost.coordinates / elements_of(other)
        if one is not other:
            slope = (other.cost.coordinates - one.cost.coordinates) / (
                elements_of(other) - elements_of(one)
            )
        more = finest * self.density - elements_of(other)
        return max(other.cost.coordinates + slope * more, 1.0)

    def seconds(self, finest: float, steps: float) -> float:
        """Predict what a run takes [s]."""
        return self.cost.seconds(steps, self.coordinates(finest))

    def work(self, finest: float, steps: float) -> float:
        """Return the work of a run, in that of a residual of one coordinate."""
        return self.cost.amount(steps, self.coordinates(finest))

    def choice(self) -> tuple[float, int]:
        """Return elements on the longest beam and number of steps, at least cost.

        Parts of the error that nothing open can change are taken as they are: what is left of the
        error asked for is divided between mesh and steps, so that the work is least.
        """
        if self.chosen is not None:
            return self.chosen
        return min((self._for(share) for share in SHARES), key=self._price)

    def missed(self, finest: float, steps: float) -> float:
        """Return the largest predicted error over the one asked for."""
        errors = zip(self.errors(finest, steps), self.asked, strict=True)
        return max(sum(each.values()) / most for each, most in errors)

    def _price(self, choice: tuple[float, int]) -> tuple[float, float]:
        """Return by how much a choice misses what can be reached, and its work."""
        finest, steps = choice
        errors = enumerate(self.errors(finest, steps))
        excess = max(sum(each.values()) / self._within_reach(i) for i, each in errors)
        return max(1.0, excess), self.work(finest, steps)

    def _within_reach(self, i: int) -> float:
        """Return the error asked for; or what is left of it and what is open may add."""
        rest = self.given[i] + self.neglected(i)
        return max(self.asked[i], rest + self._free(i))

    def _free(self, i: int) -> float:
        """Return the error of a quantity that what is open may have [its unit]."""
        rest, most = self.given[i] + self.neglected(i), self.share * self.asked[i]
        beside = BESIDE * max(rest, self.floors[i] if self.floors else 0.0)
        return max(most - rest if most > rest else most, beside)

    def _for(self, share: float) -> tuple[float, int]:
        finest, steps = 1.0, 1.0
        for i, time in enumerate(self.time.estimates):
            free = self._free(i)
            if self.mesh is not None:
                of_mesh = share * free
                needed = self.mesh.estimates[i].needed(of_mesh) / self.density
                finest = max(finest, math.ceil(needed - 1e-9))
            else:
                share = 0.0
            needed = time.needed((1.0 - share) * free / (1.0 + SOLVER))
            steps = max(steps, needed)
        if self.mesh is not None:
            finest = min(max(finest, self.nearest), self.farthest)
        if self.fixed_steps is not None:
            return finest, self.fixed_steps
        firm = all(each.settled for each in self.time.estimates)
        steps = min(steps, (REACH_STEPS if firm else REACH_ROUGH) * self.time.runs[-1].steps)
        return finest, max(self.time.runs[0].steps, rounded(steps, self.base))

    @property
    def nearest(self) -> float:
        """Fewest elements on the longest beam for which errors are predicted: half of a pilot's."""
        assert self.mesh is not None
        return math.ceil(0.5 * max(self.mesh.runs[0].model.counts.values()))

    @property
    def farthest(self) -> float:
        """Most elements on the longest beam for which errors are predicted."""
        assert self.mesh is not None
        return REACH_MESH * max(self.mesh.runs[-1].model.counts.values())


def scaled(found: Found, finest: float, steps: int, factor: float) -> tuple[float, int]:
    """Return a choice whose errors are about `factor` times those of another one."""
    moves = found.fixed_steps is None and any(each.error for each in found.time.estimates)
    more = factor ** -(1.0 / 2.0) if moves else 1.0
    finer = 1.0
    if found.mesh is not None:
        finer = factor ** -(1.0 / min(each.order for each in found.mesh.estimates))
    chosen = found.time.runs[0].steps
    return max(1.0, float(round(finest * finer))), max(chosen, rounded(steps * more, found.base))


def neighbours(found: Found, finest: float, steps: int) -> Sequence[tuple[float, int]]:
    """Return the next cheaper and the next dearer choice: four times and a quarter of the error."""
    return scaled(found, finest, steps, 4.0), scaled(found, finest, steps, 0.25)
