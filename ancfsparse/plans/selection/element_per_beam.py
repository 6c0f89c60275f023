"""Modelling errors of all beams together and of single beams, for every quantity."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ancfsparse.plans.model_error.effects import NEGLIGIBLE_FRACTION, Effects
from ancfsparse.plans.model_error.neglected_energies import bending_effect, neglected_effects
from ancfsparse.plans.model_error.section_energies import (
    loaded_nodes,
    rotary_energy,
    section_energies,
    torsion_energy,
)
from ancfsparse.plans.quantities.tolerances import Goal
from ancfsparse.plans.selection.element_hierarchy import BENDING
from ancfsparse.plans.trial_runs.run_differences import absolute_tolerances
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, TrialRuns
from ancfsparse.results import Trajectory
from ancfsparse.scene import ElasticBody, Scene


def estimate_effects(
    trials: TrialRuns, trial: TrialRun, coarse_run: TrialRun | None = None
) -> Effects:
    """Estimate the modelling errors of a trial run by effect.

    Where the response of quantities may matter, it is measured by a cheaper, coarse run, repeated
    with changed compliance and density.
    """
    scene = trial.run.system.scene
    solve = None if coarse_run is None else _solver_like(trials, coarse_run)

    def estimate(goal: Goal, tolerance: float) -> dict[str, float]:
        quantity, coarse = goal.quantity.in_scene(scene), None
        if coarse_run is not None:
            run = coarse_run.run
            coarse = run, goal.quantity.in_scene(run.system.scene)
        limit = NEGLIGIBLE_FRACTION * tolerance
        effects = neglected_effects(trial.run, quantity, solve, limit, coarse)
        if isinstance(trials.integrator, SolutionMethod):
            effects |= trials.integrator.neglected(trial.run, quantity)
        return effects

    return Effects(map(estimate, trials.goals, absolute_tolerances(trials.goals, trial)))


def _solver_like(trials: TrialRuns, trial: TrialRun) -> Callable[[Scene], Trajectory]:
    """Return a function that solves changed scenes with the settings of a trial run."""
    runs = trials.with_integrator(trial.integrator)
    return lambda scene: runs.solve(scene, trial.steps, coarser=trial.run, solver=trial.solver)


def estimate_bending(trials: TrialRuns, trial: TrialRun, names: Sequence[str]) -> Effects:
    """Estimate the modelling error of some beams as strings, from a run with bending."""
    scene = trial.run.system.scene
    bodies = [body for body in map(scene.body, names) if isinstance(body, ElasticBody)]
    loaded = loaded_nodes(scene)
    return Effects(
        {BENDING: bending_effect(trial.run, bodies, each.quantity.in_scene(scene), loaded)}
        for each in trials.goals
    )


def divide_among_beams(
    trial: TrialRun, names: Sequence[str], effects: Effects
) -> dict[str, Effects]:
    """Divide effects among beams that are cables in a run, in proportion to neglected energies."""
    run, scene = trial.run, trial.run.system.scene
    energies: dict[str, dict[str, float]] = {}
    for name in names:
        body = scene.body(name)
        assert isinstance(body, ElasticBody)
        energies[name] = {
            "shear": float(section_energies(run, body).shear.max()),
            "rotary inertia": float(rotary_energy(run, body).max()),
            "torsion": float(torsion_energy(run, body).max()),
        }

    def fraction(name: str, effect: str) -> float:
        # At rest without stress, as for frequencies, the beams cannot be distinguished.
        total = sum(each.get(effect, 0.0) for each in energies.values())
        return energies[name][effect] / total if total > 0.0 else 1.0

    return {
        name: Effects({k: fraction(name, k) * v for k, v in each.items()} for each in effects)
        for name in names
    }
