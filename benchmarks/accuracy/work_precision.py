"""Seconds against error in time: elements, integrators, solvers and steps, and other codes.

The reference of every run is the motion of the same mesh converged in time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from typing import Annotated, Any

import typer

from ancfsparse.checks import check_choice, check_count, check_positive
from benchmarks.accuracy.candidates import INTEGRATORS, SOLVERS, Integrator, candidates
from benchmarks.accuracy.comparison import Comparison
from benchmarks.accuracy.models import MODELS, OUTPUTS, step_up_to
from benchmarks.accuracy.other_code_tasks import EXUDYN_MODEL, missing, other_code_tasks
from benchmarks.accuracy.references import Reference, converged_in_time
from benchmarks.accuracy.timed_runs import Task, fastest, measure
from benchmarks.common import paper
from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.tables import group_by
from benchmarks.common.target import Target
from benchmarks.common.timing import OURS
from benchmarks.other_codes.environment import environment

LEVELS = (*(a * 10.0**-k for k in range(2, 9) for a in (1.0, 0.3)), 1e-9)
"""Errors at which the fastest runs are compared [m]: from 1e-2 down to 1e-9, two a decade."""

REFERENCE_DT = 3.125e-5  # largest step of the extrapolated trapezoidal rule [s]

SOLVERS_OF = {"Thick": ("BFGS", "modified Newton")}
"""Solvers of elements whose steps are expensive."""

MIN_IMPLICIT_RATIO = 5.0  # time of Exudyn's implicit methods over that of ancfsparse
MIN_ERROR = 1e-5  # least error at which this ratio is required [m]


class WorkPrecision(Comparison):
    """Runs against the error in time."""

    def programs(self, model: str) -> list[str]:
        """Return the other codes of a model."""
        names = dict.fromkeys(p.task.program for p in self.of(model))
        return [name for name in names if name != OURS]

    def ratio(
        self, model: str, program: str, error: float, implicit: bool = False, alike: bool = False
    ) -> float:
        """Return the time of another code over that of ancfsparse at an error [m].

        0 where only the other code reaches the error, infinite where only ancfsparse does, NaN
        where neither does.  With `implicit` only implicit runs of the other code count, with
        `alike` only those of ancfsparse too.
        """
        others = [p for p in self.of(model, program) if p.task.solver or not implicit]
        ours = [p for p in self.of(model, OURS) if p.task.solver or not alike]
        a, b = fastest(ours, error), fastest(others, error)
        if a is None:
            return math.nan if b is None else 0.0
        return math.inf if b is None else b.seconds / a.seconds

    def worst(
        self, model: str, program: str, implicit: bool = False, low: float = 0.0
    ) -> tuple[float, float]:
        """Return the smallest ratio over `LEVELS` from `low` on, and the error where it is."""
        entries = [
            (ratio, level)
            for level in LEVELS
            if level >= low * 0.999
            and not math.isnan(ratio := self.ratio(model, program, level, implicit))
        ]
        return min(entries, default=(math.nan, math.nan))

    def targets(self) -> list[Target]:
        """Return the targets relative to the other codes that ran."""
        model = EXUDYN_MODEL
        targets = []
        for program in self.programs(model):
            ratio, level = self.worst(model, program)
            if math.isfinite(ratio):
                what = f"smallest speed-up over {program}, at an error of {level:.0e} m"
                targets.append(Target(what, ratio, 1.0))
        if "Exudyn" in self.programs(model):
            ratio, level = self.worst(model, "Exudyn", implicit=True, low=MIN_ERROR)
            what = f"smallest speed-up over Exudyn's implicit methods, at an error of {level:.0e} m"
            targets.append(Target(what, ratio, MIN_IMPLICIT_RATIO))
        return targets

    def orders(self) -> dict[str, float]:
        """Return the observed order of each curve of ancfsparse at its fine end.

        Taken between neighbouring steps whose errors are well above the reference's uncertainty;
        the median of the last three of them.
        """
        orders = {}
        for model, reference in self.references.items():
            known = [
                p for p in self.of(model, OURS)
                if p.finished and p.error > 10.0 * reference.uncertainty
            ]  # fmt: skip
            for name, curve in group_by(known, lambda p: p.task.name).items():
                powers = [
                    math.log(a.error / b.error) / math.log(a.task.value / b.task.value)
                    for a, b in pairwise(curve)
                ][-3:]
                if powers:
                    orders[f"{model}: {name}"] = sorted(powers)[len(powers) // 2]
        return orders


def work_precision(
    models: Sequence[str] = (EXUDYN_MODEL, "L2T2", "Thick"),
    elements: Annotated[int, typer.Option(help="Number of elements.")] = paper.ELEMENTS,
    t_end: Annotated[float, typer.Option("--time", help="Simulated time [s].")] = paper.T_END,
    peers: Annotated[bool, typer.Option("--peers", help="Run all other codes too.")] = False,
    rounds: Annotated[int, typer.Option(help="Interleaved runs, of which the best counts.")] = 3,
    cap: Annotated[float, typer.Option(help="Time limit of SciPy and SUNDIALS [s].")] = 8.0,
    integrators: Sequence[Integrator] = INTEGRATORS,
    progress: bool = False,
) -> WorkPrecision:
    """Measure seconds against the error in time of all methods, on the mesh of each model."""
    for model in models:
        check_choice("model", model, MODELS)
    check_count("elements", elements)
    check_count("rounds", rounds)
    check_positive("cap", cap, "s")
    check_positive("t_end", t_end, "s")
    tasks: list[Task] = []
    for model in models:
        solvers = SOLVERS_OF.get(model, tuple(SOLVERS))
        tasks += candidates(model, elements, t_end, integrators, solvers)
        if peers and model == EXUDYN_MODEL:
            tasks += other_code_tasks(model, elements, t_end, cap)
    total = len(models) + rounds * len(tasks)
    with progress_bar(total, "run", progress) as bar:
        references = {}
        for model in models:
            bar.set_description(f"{model}, reference")
            dt = step_up_to(REFERENCE_DT, t_end)
            references[model] = converged_in_time(model, elements, t_end, dt)
            bar.update()
        points = measure(tasks, partial(_tip_of, references), rounds, bar)
    settings = {
        "scene": "the paper's pendulum, planar",
        "elements": elements,
        "t_end_s": t_end,
        "error": f"largest tip distance at {OUTPUTS} times, from the same mesh solved exactly",
        "seconds": f"best of {rounds} rounds in turn, time loop or solver alone",
        "cap_s": cap,
        **environment(),
    }
    return WorkPrecision(points, references, missing() if peers else [], settings)


def _tip_of(references: dict[str, Reference], task: Task) -> Any:
    return references[task.model].tip
