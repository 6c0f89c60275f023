"""Effects of the thresholds of plans: the economy scenes without each of them, one at a time."""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from typing import Annotated, Any

import numpy as np
import typer

from ancfsparse.checks import check_choice
from ancfsparse.errors import AncfError
from ancfsparse.plans import plan
from benchmarks.common.progress import bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.economy.reference import Reference, times_of, values_of
from benchmarks.economy.scenes import CASES, Case, Discretization

PACKAGE = "ancfsparse.plans."
TOLERANCES = (0.03, 0.003)  # over the size of the quantity [-]
MAX_SECONDS = 5.0  # of the run of a plan, predicted

# Values without a threshold, or with a far looser one, by module and name.
WITHOUT: tuple[tuple[str, str, Any], ...] = (
    ("discretization_error.run_series", "UNOBSERVED_FRACTION", 1.0),
    ("discretization_error.run_series", "UNEVEN_FRACTION", 0.75),
    ("discretization_error.run_series", "MAX_BOUND_ORDER", 2.0),
    ("discretization_error.run_series", "MAX_NEAR_EXCESS", math.inf),
    ("discretization_error.run_series", "MAX_REDUCTION", 1.0),
    ("discretization_error.run_series", "MAX_EARLIER_REDUCTION", 2.0),
    ("discretization_error.run_series", "MIN_REQUESTED_RATIO", 0.0),
    ("discretization_error.refinement", "SHORT_RATIO", 0.99),
    ("discretization_error.refinement", "MAX_UNOBSERVED_RATIO", 16.0),
    ("discretization_error.refinement", "MAX_DAMPING_FRACTION", math.inf),
    ("discretization_error.vibrations", "MAX_PHASE_ERROR", math.inf),
    ("discretization_error.vibrations", "SWING_FRACTION", 0.0),
    ("discretization_error.mesh_error", "MAX_GROWTH", 1.5),
    ("discretization_error.mesh_grading", "MIN_GRADING_GAIN", math.inf),
    ("discretization_error.residual_correction", "MAX_SECOND_CHANGE", math.inf),
    ("discretization_error.richardson", "MIN_ORDER", 0.1),
    ("discretization_error.richardson", "ASYMPTOTIC_RANGE", (0.6, math.inf)),
    ("discretization_error.run_estimates", "MAX_DIFFERENCE", math.inf),
    ("discretization_error.error_model", "SAFETY_FRACTION", 1.0),
    ("discretization_error.error_model", "ADDED_FRACTION", 0.0),
    ("discretization_error.error_model", "MAX_MESH_RATIO", math.inf),
    ("discretization_error.error_model", "MAX_STEP_RATIO", math.inf),
    ("discretization_error.error_model", "SOLVER_FRACTION", 0.0),
    ("discretization_error.initial_singularity", "MIN_GROWTH_POWER", math.inf),
    ("discretization_error.initial_singularity", "MAX_REFINEMENTS", 1),
    ("selection.confirmation_run", "MAX_SELECTIONS", 3),
    ("selection.confirmation_run", "MAX_COST", 0.0),
    ("selection.confirmation_run", "AGREEMENT_FACTOR", 1.0),
    ("selection.confirmation_run", "AGREEMENT_FRACTION", 0.0),
    ("selection.confirmation_run", "OWN_FRACTION", 0.75),
    ("selection.confirmation_run", "MIN_RATIO", 1.0),
    ("selection.confirmation_run", "MAX_REFINEMENT", 1e9),
    ("selection.method_selection", "VIBRATION_FRACTION", math.inf),
    ("selection.explicit_alternative", "STABLE_FRACTION", 1.0),
    ("model_error.effects", "NEGLIGIBLE_FRACTION", 1.0),
    ("trial_runs.trial_runs", "COARSE_TOLERANCE", 0.0),
    ("trial_runs.trial_runs", "TRIAL_FRACTION", 0.5),
    ("trial_runs.trial_runs", "MAX_EXPENSIVE_INTERVALS", 2000),
    ("trial_runs.choose_solver", "MIN_PAIRS_WORK", math.inf),
    ("trial_runs.load_resolution", "MAX_NONLINEARITY", math.inf),
)


@dataclass(frozen=True)
class Effect:
    """Plans with one threshold changed, against those with all of them."""

    threshold: str
    value: str
    changed: int  # plans with other trial runs
    met: int  # plans that promise their tolerance
    exceeded: int  # of these, with a larger error
    worst: float  # error over tolerance of these
    work: float  # counted work over that with all thresholds, geometric mean
    max_work: float  # largest ratio


@dataclass(frozen=True)
class _Plan:
    work: float
    is_met: bool
    error: float  # over the tolerance; 0 if it was not run


def thresholds(
    names: Annotated[
        list[str] | None, typer.Option("--threshold", help="Only this one; repeatable.")
    ] = None,
    progress: bool = False,
) -> list[Effect]:
    """Plan the scenes of the economy study without each threshold; a quarter of an hour."""
    for each in names or ():
        check_choice("threshold", each, [name for _, name, _ in WITHOUT])
    references = {name: Reference(case, min(TOLERANCES)) for name, case in CASES.items()}
    base = list(_plans(references))
    out = [_effect("all thresholds", "", base, base)]
    chosen = [each for each in WITHOUT if names is None or each[1] in names]
    for module, name, value in bar(chosen, "threshold", progress):
        with _changed(module, name, value):
            out.append(_effect(name, str(value), list(_plans(references)), base))
    return out


def _plans(references: dict[str, Reference]) -> Iterator[_Plan | None]:
    """Yield plans of all scenes and tolerances; None where there is none."""
    for name, case in CASES.items():
        for tolerance in TOLERANCES:
            yield _plan(case, references[name], tolerance)


def _plan(case: Case, reference: Reference, tolerance: float) -> _Plan | None:
    scene, quantity = case.build(Discretization("auto", "auto"))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            chosen = plan(scene, case.t_end, quantity, f"{100.0 * tolerance:g} %")
            if chosen.seconds > MAX_SECONDS:
                return _Plan(chosen.cost["operations"], chosen.is_met, 0.0)
            run = chosen.run()
    except AncfError:
        return None
    error = reference.error(times_of(run), values_of(quantity, run)) / tolerance
    return _Plan(chosen.cost["operations"], chosen.is_met, error)


@contextmanager
def _changed(module: str, name: str, value: Any) -> Iterator[None]:
    """Change a constant in its module and in those that have imported it."""
    present = getattr(import_module(PACKAGE + module), name)
    holders = [
        each
        for key, each in sys.modules.items()
        if key.startswith(PACKAGE) and getattr(each, name, None) is present
    ]
    try:
        for each in holders:
            setattr(each, name, value)
        yield
    finally:
        for each in holders:
            setattr(each, name, present)


def _effect(
    name: str, value: str, plans: Sequence[_Plan | None], base: Sequence[_Plan | None]
) -> Effect:
    """Compare plans with those of all thresholds."""
    pairs = [(one, other) for one, other in zip(plans, base, strict=True) if one and other]
    ratios = np.array([one.work / other.work for one, other in pairs])
    errors = np.array([each.error for each in plans if each and each.is_met])
    both = zip(plans, base, strict=True)
    return Effect(
        name,
        value,
        sum((one and one.work) != (other and other.work) for one, other in both),
        len(errors),
        int((errors > 1.0).sum()),
        float(errors.max()),
        float(np.exp(np.log(ratios).mean())),
        float(ratios.max()),
    )


COLUMNS: dict[str, Callable[[Effect], str]] = {
    "changed": lambda each: each.threshold,
    "to": lambda each: each.value,
    "other plans": lambda each: str(each.changed),
    "met": lambda each: str(each.met),
    "exceeded": lambda each: str(each.exceeded),
    "worst error / tolerance": lambda each: f"{each.worst:.3g}",
    "work": lambda each: f"{each.work:.3f}",
    "largest": lambda each: f"{each.max_work:.3g}",
}


def table(result: Sequence[Effect]) -> Table:
    """Set a line for each threshold."""
    return Table.of(result, COLUMNS, (0, 1))


STUDY = Study(
    "plan_thresholds",
    thresholds,
    tables=lambda result: [table(result)],
    rows=lambda result: result,
    regions={"thresholds": table},
)
