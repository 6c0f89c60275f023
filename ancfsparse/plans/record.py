"""The record of a plan: what was chosen, what it is predicted to do, and why."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, PlanChanged, StepFailure
from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.plans.models import RIGID, Model, Rung, built, refined
from ancfsparse.plans.pilots import at_rest, distance
from ancfsparse.plans.planar import InPlane
from ancfsparse.plans.wanted import Wanted
from ancfsparse.plans.ways import Way
from ancfsparse.results import Trajectory
from ancfsparse.scene import Node, Scene
from ancfsparse.solve import simulate, solve_static
from ancfsparse.solve.request import DEFAULT

Array = NDArray[np.float64]

MEGABYTE = 1e6
SPATIAL = 3
# Steps and elements of the run that proves a plan, over those of the plan.
FINER_STEPS, FINER_MESH = 2, 1.5
# Elements in place of a rigid rod in that run.
LINK = 4
# Intervals between saved states at least, unless they are chosen by save_every.
SAVED = 1000
# How often a run that fails is planned again with half the step.
MOST_REPLANS = 4


@dataclass(frozen=True)
class Prediction:
    """The error of one quantity.

    Attributes
    ----------
    wanted : Wanted
        The quantity and the error that was asked for.
    asked : float
        That error, absolute [unit of the quantity].
    sources : mapping of str to float
        Predicted error by source: ``"mesh"``, ``"time"``, ``"solver"``, and every effect that the
        model neglects [unit of the quantity].
    """

    wanted: Wanted
    asked: float
    sources: Mapping[str, float]

    @property
    def error(self) -> float:
        """Sum of all sources [unit of the quantity]."""
        return sum(self.sources.values())

    @property
    def is_met(self) -> bool:
        """Whether it is at most the error that was asked for."""
        return self.error <= self.asked

    def __str__(self) -> str:
        """Write it in one line."""
        unit = self.wanted.quantity.unit
        parts = ", ".join(f"{name} {value:.1e}" for name, value in self.sources.items() if value)
        return f"{self.error:.1e} {unit}".rstrip() + f" ({parts})"


@dataclass(frozen=True)
class Alternative:
    """Another choice, with what it is predicted to do.

    Attributes
    ----------
    choice : str
        Elements, mesh and step.
    errors : tuple of float
        Predicted error of every quantity [its unit].
    seconds : float
        Predicted time of the run [s].
    """

    choice: str
    errors: tuple[float, ...]
    seconds: float

    def __str__(self) -> str:
        """Write it in one line."""
        errors = ", ".join(f"{each:.1e}" for each in self.errors)
        return f"{self.choice}: error {errors} in {self.seconds:.2g} s"


@dataclass(frozen=True, eq=False)
class Plan:
    """How a scene is to be run, as `plan` returns it.

    Attributes
    ----------
    scene : Scene
        The scene, with what is open.
    t_end : float or None
        Time at the end [s]; None: the equilibrium is asked for.
    model : Model
        Element and number of elements of every beam of which they are open, by its name.
    steps : int
        Number of steps.
    integrator : Implicit, Explicit or Way
        How it is marched; or, as a `Way`, found without steps of an integrator.
    solver : str
        How equations are solved.
    predictions : tuple of Prediction
        The error of every quantity, by source.
    seconds : float
        Predicted time of the run, set-up included [s].
    memory : float
        Predicted memory [bytes].
    cheaper, dearer : Alternative
        The next cheaper and the next dearer choice.
    reasons : tuple of str
        Why, in sentences.
    cost : Mapping of str to float
        What the plan itself took: ``"seconds"``, ``"runs"``, its counted work, ``"counted"``, in
        that of a residual of one coordinate, and ``"work"``, the same over that of the planned run.
    flat : InPlane or None
        The planar scene that is solved where one in space moves in a plane.
    answer : Trajectory or None
        The run that was planned, if it was made as a pilot: `run` returns it.
    """

    scene: Scene
    t_end: float | None
    model: Model
    steps: int
    integrator: Implicit | Explicit | Way
    solver: str
    predictions: tuple[Prediction, ...]
    seconds: float
    memory: float
    cheaper: Alternative
    dearer: Alternative
    reasons: tuple[str, ...]
    cost: Mapping[str, float] = field(default_factory=dict)
    flat: InPlane | None = None
    answer: Trajectory | None = None

    @property
    def dt(self) -> float | None:
        """Time step [s]; None in statics."""
        return None if self.t_end is None else self.t_end / self.steps

    @property
    def choice(self) -> str:
        """Elements, mesh, step and integrator in one line."""
        return described(self.model, self.steps, self.t_end, self.integrator)

    @property
    def error(self) -> float:
        """Predicted error of the first quantity [its unit]."""
        return self.predictions[0].error

    @property
    def is_met(self) -> bool:
        """Whether all errors are predicted to be at most those that were asked for."""
        return all(each.is_met for each in self.predictions)

    def build(self) -> Scene:
        """Return the scene with the chosen elements and meshes."""
        return built(self._source, self.model)

    @property
    def _source(self) -> Scene:
        """The scene that is solved, with open beams."""
        return self.scene if self.flat is None else self.flat.scene

    def __repr__(self) -> str:
        """Write the choice."""
        return f"Plan: {self.choice}"

    def __str__(self) -> str:
        """Write everything for a reader."""
        span = "the equilibrium" if self.t_end is None else f"{self.t_end:g} s"
        lines = [f"Plan for {span}: {self.choice}, solver {self.solver}"]
        for each in self.predictions:
            lines += [f"  {each.wanted}", f"    predicted error {each}"]
        lines.append(f"  predicted {self.seconds:.2g} s, {self.memory / MEGABYTE:.2g} MB")
        lines.append(f"  cheaper: {self.cheaper}")
        lines.append(f"  dearer:  {self.dearer}")
        return "\n".join([*lines, *(f"  - {reason}" for reason in self.reasons)])

    def run(self, verify: bool = False, **options: Any) -> PlannedRun:
        """March the scene as planned.

        Parameters
        ----------
        verify : bool, optional
            Also run with finer meshes, given ones too, and half the step, and report the difference
            beside the prediction.
        **options
            Other arguments of `simulate`, such as ``output`` or ``progress``.  By default every
            step is saved up to 2000, and of more steps at least every 1000th part.

        Returns
        -------
        PlannedRun
            A `Trajectory` that also has the plan, and what was measured.  Handles of the scene that
            was planned may be used with it.

        Raises
        ------
        StepFailure
            If a step cannot be solved, even with steps 16 times shorter.

        Warns
        -----
        PlanChanged
            If a step fails that pilots had passed: the step is halved.
        """
        plan = self
        for _ in range(MOST_REPLANS):
            try:
                run = plan._made(options) or plan._march(plan.build(), **options)
                break
            except StepFailure as failure:
                warnings.warn(
                    PlanChanged(
                        f"the run left the range of its plan at t = {failure.time:.6g} s, where a "
                        f"step of {plan.dt or 0.0:.3g} s failed: it is run again with half the step"
                    ),
                    stacklevel=2,
                )
                plan = replace(plan, steps=2 * plan.steps, answer=None)
        else:
            run = plan._march(plan.build(), **options)
        measured = plan._measured(run) if verify else ()
        return PlannedRun(**{name: getattr(run, name) for name in Trajectory.__dataclass_fields__},
                          plan=plan, measured=measured)  # fmt: skip

    def _made(self, options: Mapping[str, Any]) -> Trajectory | None:
        """Return the run if it was made as a pilot, with as many states as would be saved."""
        if self.answer is None or options:
            return None
        saved = self.answer.settings.get("save_every", 1)
        return self.answer if saved <= self._save_every else None

    @property
    def _save_every(self) -> int:
        return max(1, self.steps // SAVED)

    def _march(self, scene: Scene, **options: Any) -> Trajectory:
        if self.t_end is None or self.dt is None:
            return at_rest(solve_static(scene, **options))
        if isinstance(self.integrator, Way):
            for name in options.keys() - self.integrator.options:
                raise InputError(
                    f"{name} belongs to motions that are marched, and this plan has "
                    f"{self.integrator!r}: leave it out, or plan with integrator=GeneralizedAlpha()"
                )
            return self.integrator.march(scene, self.t_end, self.steps, **options)
        given = {"integrator": self.integrator, "save_every": self._save_every, **options}
        return simulate(scene, self.t_end, self.dt, **given)

    def _measured(self, run: Trajectory) -> tuple[float, ...]:
        """Return by how much every quantity changes with finer meshes and half the step."""
        finer = built(refined(self._source) or self._source, self._richer_model())
        other = self._richer(finer, run)
        scenes = run.system.scene, other.system.scene
        return tuple(
            distance(
                each.wanted,
                each.wanted.quantity.on(scenes[0]).history(run),
                each.wanted.quantity.on(scenes[1]).history(other),
            )
            for each in self.predictions
        )

    def _richer_model(self) -> Model:
        """Return finer meshes, and elements in place of rigid rods."""
        counts = {name: round(FINER_MESH * n + 0.5) for name, n in self.model.counts.items()}
        rigid = [name for name, rung in self.model.rungs.items() if rung == RIGID]
        rung = Rung("thin" if self._source.dim != SPATIAL else "thick")
        return replace(
            self.model,
            rungs={**self.model.rungs, **dict.fromkeys(rigid, rung)},
            counts={**counts, **dict.fromkeys(rigid, LINK)},
        )

    def _richer(self, finer: Scene, run: Trajectory) -> Trajectory:
        """Return the motion on finer meshes: by half the step, or by steps where none were."""
        if self.dt is None or self.t_end is None:
            return self._march(finer)
        if isinstance(self.integrator, Way):
            share = min(
                each.asked
                / each.wanted.quantity.size(each.wanted.quantity.on(run.system.scene).history(run))
                for each in self.predictions
            )
            needed = self.integrator.steps_to_verify(run, share)
            more = max(1, math.ceil(needed / self.steps))
            dt = self.t_end / (more * self.steps)
            return simulate(finer, self.t_end, dt, integrator=DEFAULT, save_every=more)
        every = FINER_STEPS * run.settings["save_every"]
        return replace(self, steps=FINER_STEPS * self.steps)._march(finer, save_every=every)


@dataclass(frozen=True, eq=False, repr=False)
class PlannedRun(Trajectory):
    """A motion that was run as planned.

    Attributes
    ----------
    plan : Plan
        The plan, with shorter steps if the first one failed.
    measured : tuple of float
        With ``verify``, by how much each quantity differs from the run one rung up [its unit];
        empty otherwise.
    """

    plan: Plan | None = None
    measured: tuple[float, ...] = ()

    def _lifted(self, values: Array, node: Node, point: bool = False) -> Array:
        """Return vectors of a planar run in the space of a scene that moves in a plane."""
        flat = self.plan.flat if self.plan else None
        if flat is None or node.beam.dim != SPATIAL:
            return values
        return flat.plane.place(values) if point else flat.plane.lift(values)

    def position(self, node: Node) -> Array:
        """Give the position of a point over time, see `Trajectory.position`."""
        return self._lifted(super().position(node), node, point=True)

    def velocity(self, node: Node) -> Array:
        """Give the velocity of a point over time, see `Trajectory.velocity`."""
        return self._lifted(super().velocity(node), node)

    def acceleration(self, node: Node) -> Array:
        """Give the acceleration of a point over time, see `Trajectory.acceleration`."""
        return self._lifted(super().acceleration(node), node)

    def slope(self, node: Node) -> Array:
        """Give the slope r' over time, see `Trajectory.slope`."""
        return self._lifted(super().slope(node), node)

    def reaction(self, node: Node) -> Array:
        """Give the force of joints at a node over time, see `Trajectory.reaction`."""
        return self._lifted(super().reaction(node), node)

    def __repr__(self) -> str:
        """Sum the run up, with what was predicted and measured."""
        lines = [super().__repr__()]
        predictions = self.plan.predictions if self.plan else ()
        for i, each in enumerate(predictions):
            line = f"  {each.wanted.quantity!r}: predicted error {each.error:.1e}"
            if self.measured:
                line += f", measured {self.measured[i]:.1e}"
            lines.append(f"{line} {each.wanted.quantity.unit}".rstrip())
        return "\n".join(lines)


def described(
    model: Model, steps: int, t_end: float | None, integrator: Implicit | Explicit | Way
) -> str:
    """Write elements, mesh, step and integrator in one line."""
    alike: dict[str, list[str]] = {}
    for name in dict.fromkeys([*model.rungs, *model.counts]):
        words = [f"{model.counts[name]} elements"] if name in model.counts else []
        words += [str(model.rungs[name])] if name in model.rungs else []
        alike.setdefault(" ".join(words), []).append(name)
    parts = [
        f"{names[0]} {words}" if len(names) == 1 else f"{len(names)} beams of {words}"
        for words, names in alike.items()
    ]
    if t_end is None:
        return ", ".join([*parts, "statics"])
    return ", ".join([*parts, f"dt = {t_end / steps:.3g} s ({steps} steps)", repr(integrator)])
