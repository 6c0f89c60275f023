"""Plans for three tolerances in many scenes, and a search of elements, meshes, steps, integrators.

Times are those of the processor, set-up included; those of a plan include its trial runs, of which
the last is the run itself where that is short.
"""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context
from typing import Annotated, Any

import numpy as np
import typer

from ancfsparse.checks import check_choice
from ancfsparse.errors import AncfError
from ancfsparse.integrators import CentralDifference, Explicit, GeneralizedAlpha, Implicit, Newmark
from ancfsparse.plans import plan
from ancfsparse.plans.quantities.quantity import Quantity
from ancfsparse.plans.trial_runs.cost_model import cost_of_run
from ancfsparse.solve import stable_step
from benchmarks.common.progress import bar
from benchmarks.economy.reference import Reference, run_in, times_of, values_of
from benchmarks.economy.scenes import CASES, RICHEST, Case, Discretization
from benchmarks.other_codes.environment import environment

REQUESTS = (0.03, 0.003, 0.0003)
"""Tolerances over the size of the quantity [-]."""

MIN_STEPS = 25  # of the search
MAX_STEPS = 51200  # of the search, which doubles them
INTEGRATORS: tuple[Implicit | Explicit, ...] = (
    GeneralizedAlpha(0.9),
    Newmark(0.0),
    CentralDifference(),
)
REPEATS = 3  # runs of which the least time counts
FINALISTS = 3  # cheapest accurate runs that are repeated
MAX_REPEATED = 2.0  # time of repeated runs [s]
MAX_TIME_RATIO = 3.0  # expected time of a run over the cheapest accurate one
MAX_RESOLVED_ERROR = 0.1  # above it the motion is not resolved, and errors show no trend
SETTLED_RATIO = 0.8  # of errors with half the steps, above which the error is that of the mesh


@dataclass(frozen=True)
class Outcome:
    """A plan for one tolerance, and the best choice of the search."""

    scene: str
    # tolerance and errors over the size of the quantity [-]; NaN where the plan failed
    tolerance: float
    predicted: float
    reached: float
    uncertain: float  # uncertainty of the reference, likewise [-]
    # discretization of the plan, and of the search; empty if there is none
    choice: str
    best: str
    # time of the processor [s]; that of a plan includes a run that was its last trial run
    plan_seconds: float
    run_seconds: float
    best_seconds: float
    # counted work, likewise, in that of a residual of one coordinate [-]
    plan_work: float
    run_work: float
    best_work: float
    is_made: bool  # the run was the last trial run, so that it costs nothing more
    reason: str  # reason of a failed plan

    @property
    def error_ratio(self) -> float:
        """Error over the tolerance."""
        return self.reached / self.tolerance

    @property
    def cost(self) -> float:
        """Cost of plan and run over that of the best choice; NaN if there is none."""
        return (self.trial_seconds + self.run_seconds) / self.best_seconds

    @property
    def trial_seconds(self) -> float:
        """Time of the plan without the run [s]."""
        return self.plan_seconds - (self.run_seconds if self.is_made else 0.0)

    @property
    def work(self) -> float:
        """Counted work of plan and run over that of the best choice; NaN if there is none."""
        return (self.plan_work + (0.0 if self.is_made else self.run_work)) / self.best_work

    @property
    def run_cost(self) -> float:
        """Cost of the run alone over that of the best choice."""
        return self.run_seconds / self.best_seconds


@dataclass(frozen=True)
class Economy:
    """All outcomes."""

    outcomes: list[Outcome]
    settings: dict[str, Any]


@dataclass(frozen=True)
class _Tried:
    """A choice of the search: its error and time, and how to repeat it."""

    name: str
    error: float
    seconds: float
    work: float
    again: Callable[[], Any]


def economy(
    scenes: Annotated[
        list[str] | None, typer.Option("--scene", help="Only this scene; repeatable.")
    ] = None,
    requests: Sequence[float] = REQUESTS,
    jobs: Annotated[int, typer.Option(min=1, help="Scenes at once, in processes.")] = 1,
    progress: bool = False,
) -> Economy:
    """Compare plans with the best choice of a search: tolerances, errors and cost."""
    scenes = scenes or list(CASES)
    for name in scenes:
        check_choice("scene", name, CASES)
    study = partial(_scene, requests=tuple(requests))
    if jobs == 1:
        found = [study(name) for name in bar(scenes, "scene", progress)]
    else:
        with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
            tasks = [pool.submit(study, name) for name in scenes]
            with bar(len(tasks), "scene", progress) as shown:
                for _ in as_completed(tasks):
                    shown.update()
            found = [each.result() for each in tasks]
    settings = {"requests": list(requests), "scenes": list(scenes), "jobs": jobs, **environment()}
    return Economy([each for some in found for each in some], settings)


def _scene(name: str, requests: Sequence[float]) -> list[Outcome]:
    """Return the outcomes of one scene."""
    case = CASES[name]
    reference = Reference(case, min(requests))
    tried = list(_searched(case, reference, min(requests)))
    return [_planned(name, case, reference, each, _best(tried, each)) for each in requests]


def _searched(case: Case, reference: Reference, least: float) -> Iterator[_Tried]:
    """Run elements, meshes, steps and integrators, as far as errors fall and time is not lost."""
    hopeless = math.inf
    thick = (RICHEST,) if reference.is_thick and RICHEST not in case.elements else ()
    for element, options in (*case.elements, *thick):
        for integrator in INTEGRATORS if case.t_end else INTEGRATORS[:1]:
            for n in case.meshes:
                best = math.inf
                for steps in _steps(case, Discretization(element, n, options), integrator):
                    found = _try(
                        case, reference, Discretization(element, n, options), steps, integrator
                    )
                    if found is None:
                        continue
                    yield found
                    if found.error <= least:
                        hopeless = min(hopeless, MAX_TIME_RATIO * found.seconds)
                    settled = (
                        found.error <= MAX_RESOLVED_ERROR and found.error > SETTLED_RATIO * best
                    )
                    if settled or found.seconds > hopeless:
                        break
                    best = found.error


def _steps(
    case: Case, discretization: Discretization, integrator: Implicit | Explicit
) -> Sequence[int]:
    """Return the numbers of steps that are tried."""
    if case.t_end is None:
        return (1,)
    steps = [
        MIN_STEPS << k for k in range((min(case.steps // 2, MAX_STEPS) // MIN_STEPS).bit_length())
    ]
    if not isinstance(integrator, Explicit):
        return steps
    try:
        limit = stable_step(case.build(discretization)[0], integrator)
    except AncfError:
        return ()
    least = math.ceil(1.1 * case.t_end / limit)
    return [n for n in (least, 2 * least) if n <= 2 * case.steps]


def _try(
    case: Case,
    reference: Reference,
    discretization: Discretization,
    steps: int,
    integrator: Implicit | Explicit,
) -> _Tried | None:
    """Run one choice; None if it fails."""

    def solve() -> tuple[Quantity, Any]:
        scene, quantity = case.build(discretization)
        return quantity, run_in(scene, case.t_end, steps, integrator)

    begin = time.process_time()
    try:
        quantity, run = solve()
    except AncfError:
        return None
    seconds = time.process_time() - begin
    error = reference.error(times_of(run), values_of(quantity, run))
    options = "".join(f" {value}" for value in discretization.options.values())
    name = f"{discretization.n} {discretization.element}{options}"
    if case.t_end is not None:
        name += f", {steps} steps of {integrator!r}"
    work = cost_of_run(run.stats, steps, len(run.system.q0)).work
    return _Tried(name, error, seconds, work, solve)


def _best(tried: Sequence[_Tried], tolerance: float) -> _Tried | None:
    """Return the cheapest choice that is accurate enough, of a few measured again."""
    able = sorted(
        (each for each in tried if each.error <= tolerance), key=lambda each: each.seconds
    )
    if not able:
        return None
    return min(
        (replace(each, seconds=_least_time(each.again)) for each in able[:FINALISTS]),
        key=lambda each: each.seconds,
    )  # fmt: skip


def _least_time(call: Callable[[], Any]) -> float:
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        call()
        times.append(time.process_time() - begin)
        if sum(times) > MAX_REPEATED:
            break
    return min(times)


def _planned(
    name: str, case: Case, reference: Reference, tolerance: float, best: _Tried | None
) -> Outcome:
    """Plan and run; what fails is an outcome too."""
    times: list[tuple[float, float]] = []
    found: dict[str, Any] = {"predicted": math.nan, "reached": math.nan, "choice": ""}
    found |= {"plan_work": math.nan, "run_work": math.nan, "is_made": False}
    reason = ""
    for _ in range(REPEATS):
        scene, quantity = case.build(Discretization("auto", "auto"))
        begin = time.process_time()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                chosen = plan(scene, case.t_end, quantity, f"{100.0 * tolerance:g} %")
                middle = time.process_time()
                run = replace(chosen, result=None).run()
        except AncfError as failure:
            reason = f"{type(failure).__name__}: {failure}"
            times.append((time.process_time() - begin, 0.0))
            break
        times.append((middle - begin, time.process_time() - middle))
        found = {
            "predicted": chosen.error / reference.size,
            "reached": reference.error(times_of(run), values_of(quantity, run)),
            "choice": chosen.choice,
            "plan_work": chosen.cost["operations"],
            "run_work": cost_of_run(run.stats, chosen.steps, run.q.shape[1]).work,
            "is_made": chosen.result is not None,
        }
        if sum(map(sum, times)) > MAX_REPEATED:
            break
    planned, ran = np.min(times, axis=0)
    return Outcome(
        scene=name,
        tolerance=tolerance,
        uncertain=reference.uncertain,
        best="" if best is None else best.name,
        plan_seconds=float(planned),
        run_seconds=float(ran),
        best_seconds=math.nan if best is None else best.seconds,
        best_work=math.nan if best is None else best.work,
        reason=reason,
        **found,
    )
