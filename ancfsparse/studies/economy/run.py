"""Plans for three errors in many scenes, beside a search of elements, meshes, steps, integrators.

Times are those of the processor, set-up included; those of a plan include its pilot runs.
"""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from ancfsparse.errors import AncfError
from ancfsparse.integrators import CentralDifference, Explicit, GeneralizedAlpha, Implicit, Newmark
from ancfsparse.plans import plan
from ancfsparse.plans.quantities import Quantity
from ancfsparse.solve import simulate, solve_static, stable_step
from ancfsparse.studies.common.progress import bar
from ancfsparse.studies.economy.scenes import CASES, Case, Made
from ancfsparse.studies.peers.environment import environment

Array = NDArray[np.float64]

REQUESTS = (0.03, 0.003, 0.0003)
"""Errors that are asked for, over the size of the quantity [-]."""

MESHES = (2, 3, 4, 6, 8, 12, 16, 24, 32, 48)
STEPS = tuple(25 * 2**k for k in range(9))
INTEGRATORS: tuple[Implicit | Explicit, ...] = (
    GeneralizedAlpha(0.9),
    Newmark(0.0),
    CentralDifference(),
)
# Steps of the reference, and states that are compared.
REFERENCE_STEPS, COMPARED = 12800, 400
# Runs that share the least time, of which it is taken, and how many of the cheapest are repeated.
REPEATS, FINALISTS = 3, 3
# Runs expected to take longer than the cheapest accurate one so many times are not made.
HOPELESS = 3.0
# Error below which a run follows the motion, so that one which no longer falls is that of the mesh.
FOLLOWS = 0.1


@dataclass(frozen=True)
class Outcome:
    """A plan for one error, beside the best choice of the search.

    Attributes
    ----------
    scene : str
        Its name.
    asked, predicted, reached : float
        Errors over the size of the quantity [-]; NaN where the plan failed.
    uncertain : float
        Uncertainty of the reference, likewise [-].
    choice, best : str
        What the plan took, and what the search found; empty if it found nothing.
    plan_seconds, run_seconds, best_seconds : float
        Time of the processor [s].
    reason : str
        Why the plan failed; empty if it did not.
    """

    scene: str
    asked: float
    predicted: float
    reached: float
    uncertain: float
    choice: str
    best: str
    plan_seconds: float
    run_seconds: float
    best_seconds: float
    reason: str

    @property
    def share(self) -> float:
        """Error that was reached over the one asked for."""
        return self.reached / self.asked

    @property
    def cost(self) -> float:
        """Cost of plan and run over that of the best choice; NaN if there is none."""
        return (self.plan_seconds + self.run_seconds) / self.best_seconds

    @property
    def run_cost(self) -> float:
        """Cost of the run alone over that of the best choice."""
        return self.run_seconds / self.best_seconds


@dataclass(frozen=True)
class Economy:
    """Everything ``ancfsparse study economy`` finds."""

    outcomes: list[Outcome]
    settings: dict[str, Any]

    def record(self) -> dict[str, Any]:
        """Return one JSON object; what is missing is null."""
        rows = [
            {k: None if isinstance(v, float) and not math.isfinite(v) else v
             for k, v in asdict(each).items()}
            for each in self.outcomes
        ]  # fmt: skip
        return {"settings": self.settings, "outcomes": rows}


@dataclass(frozen=True)
class _Tried:
    """A choice of the search: its error and time, and how to repeat it."""

    name: str
    error: float
    seconds: float
    again: Callable[[], Any]


class _Reference:
    """The quantity of a fine run, by a spline.

    Parameters
    ----------
    case : Case
        The scene.
    """

    def __init__(self, case: Case) -> None:
        self.t_end = case.t_end
        element, options = case.elements[0]
        meshes = Made(element, case.most, options), Made(element, case.most // 2, options)
        fine, coarse = (
            self._solved(case, each, steps)
            for each, steps in zip(meshes, (REFERENCE_STEPS, REFERENCE_STEPS // 2), strict=True)
        )
        self.size = fine[2]
        self.at = CubicSpline(fine[0], fine[1]) if case.t_end else lambda t: fine[1]
        # Half the elements and steps have at least four times the error of second order.
        self.uncertain = self.error(coarse[0], coarse[1]) / 3.0

    def _solved(self, case: Case, made: Made, steps: int) -> tuple[Array, Array, float]:
        scene, quantity = case.build(made)
        run = _run(scene, case.t_end, steps, GeneralizedAlpha(0.9))
        history = _history(quantity, run)
        return _times(run), history, _size(quantity, history, case.t_end)

    def error(self, t: Array, history: Array) -> float:
        """Return the largest error over the size of the quantity [-]."""
        return float(np.linalg.norm(history - self.at(t), axis=1).max()) / self.size


def _times(run: Any) -> Array:
    return np.asarray(getattr(run, "t", 0.0)) * np.ones(1)


def _size(quantity: Quantity, history: Array, t_end: float | None) -> float:
    return float(np.linalg.norm(history[-1])) if t_end is None else quantity.size(history)


def _run(scene: Any, t_end: float | None, steps: int, integrator: Implicit | Explicit) -> Any:
    if t_end is None:
        return solve_static(scene)
    every = max(1, steps // COMPARED)
    return simulate(scene, t_end, t_end / steps, integrator=integrator, save_every=every)


def _history(quantity: Quantity, run: Any) -> Array:
    """Return values (k, m); of an equilibrium (1, m)."""
    return np.atleast_2d(quantity.history(run))


def economy(
    scenes: Sequence[str] = tuple(CASES),
    requests: Sequence[float] = REQUESTS,
    progress: bool = False,
) -> Economy:
    """Plan every scene for every error, and search for what would have been cheapest."""
    outcomes: list[Outcome] = []
    for name in bar(scenes, "scene", progress):
        case = CASES[name]
        reference = _Reference(case)
        tried = list(_searched(case, reference, min(requests)))
        for asked in requests:
            best = _best(tried, asked)
            outcomes.append(_planned(name, case, reference, asked, best))
    settings = {"requests": list(requests), "scenes": list(scenes), **environment()}
    return Economy(outcomes, settings)


def _searched(case: Case, reference: _Reference, least: float) -> Iterator[_Tried]:
    """Run elements, meshes, steps and integrators, as far as errors fall and time is not lost."""
    hopeless = math.inf
    for element, options in case.elements:
        for integrator in INTEGRATORS if case.t_end else INTEGRATORS[:1]:
            for n in MESHES:
                best = math.inf
                for steps in _steps(case, Made(element, n, options), integrator):
                    found = _try(case, reference, Made(element, n, options), steps, integrator)
                    if found is None:
                        continue
                    yield found
                    if found.error <= least:
                        hopeless = min(hopeless, HOPELESS * found.seconds)
                    settled = found.error <= FOLLOWS and found.error > 0.8 * best
                    if settled or found.seconds > hopeless:
                        break
                    best = found.error


def _steps(case: Case, made: Made, integrator: Implicit | Explicit) -> Sequence[int]:
    """Return the numbers of steps that are tried."""
    if case.t_end is None:
        return (1,)
    if not isinstance(integrator, Explicit):
        return STEPS
    try:
        limit = stable_step(case.build(made)[0], integrator)
    except AncfError:
        return ()
    least = math.ceil(1.1 * case.t_end / limit)
    return [n for n in (least, 2 * least) if n <= STEPS[-1] * 4]


def _try(
    case: Case, reference: _Reference, made: Made, steps: int, integrator: Implicit | Explicit
) -> _Tried | None:
    """Run one choice; None if it fails."""

    def solve() -> tuple[Quantity, Any]:
        scene, quantity = case.build(made)
        return quantity, _run(scene, case.t_end, steps, integrator)

    begin = time.process_time()
    try:
        quantity, run = solve()
    except AncfError:
        return None
    seconds = time.process_time() - begin
    error = reference.error(_times(run), _history(quantity, run))
    options = "".join(f" {value}" for value in made.options.values())
    name = f"{made.n} {made.element}{options}"
    if case.t_end is not None:
        name += f", {steps} steps of {integrator!r}"
    return _Tried(name, error, seconds, solve)


def _best(tried: Sequence[_Tried], asked: float) -> _Tried | None:
    """Return the cheapest choice that is accurate enough, of a few measured again."""
    able = sorted((each for each in tried if each.error <= asked), key=lambda each: each.seconds)
    if not able:
        return None
    return min(
        (_Tried(each.name, each.error, _least_time(each.again), each.again)
         for each in able[:FINALISTS]),
        key=lambda each: each.seconds,
    )  # fmt: skip


def _least_time(call: Callable[[], Any]) -> float:
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        call()
        times.append(time.process_time() - begin)
    return min(times)


def _planned(
    name: str, case: Case, reference: _Reference, asked: float, best: _Tried | None
) -> Outcome:
    """Plan and run; what fails is an outcome too."""
    times: list[tuple[float, float]] = []
    found: Mapping[str, Any] = {"predicted": math.nan, "reached": math.nan, "choice": ""}
    reason = ""
    for _ in range(REPEATS):
        scene, quantity = case.build(Made("auto", "auto"))
        begin = time.process_time()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                made = plan(scene, case.t_end, quantity, f"{100.0 * asked:g} %")
                middle = time.process_time()
                run = made.run()
        except AncfError as failure:
            reason = f"{type(failure).__name__}: {failure}"
            times.append((time.process_time() - begin, 0.0))
            break
        times.append((middle - begin, time.process_time() - middle))
        found = {
            "predicted": made.error / reference.size,
            "reached": reference.error(_times(run), _history(quantity, run)),
            "choice": made.choice,
        }
    planned, ran = np.min(times, axis=0)
    return Outcome(
        scene=name,
        asked=asked,
        uncertain=reference.uncertain,
        best="" if best is None else best.name,
        plan_seconds=float(planned),
        run_seconds=float(ran),
        best_seconds=math.nan if best is None else best.seconds,
        reason=reason,
        **found,
    )
