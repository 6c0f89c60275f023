"""Total error against its cost over elements, their number and the step, and the Pareto front."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated

import typer

from ancfsparse.checks import check_choice, check_count
from benchmarks.accuracy.candidates import Integrator, task
from benchmarks.accuracy.comparison import Comparison
from benchmarks.accuracy.models import MODELS, OUTPUTS, Tips, distance, step_up_to
from benchmarks.accuracy.other_code_tasks import EXUDYN_MODEL, exudyn_tasks, installed, missing
from benchmarks.accuracy.references import converged
from benchmarks.accuracy.timed_runs import Point, Sample, Task, front, measure
from benchmarks.common import paper
from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.timing import OURS
from benchmarks.other_codes import elastica as elastica_code, exudyn as exudyn_code
from benchmarks.other_codes.environment import environment
from benchmarks.other_codes.exudyn import Setting

MESHES = (4, 6, 8, 10, 14, 20, 28, 40, 56, 80)
DTS = (1e-2, 4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4)

INTEGRATORS = (
    Integrator("Newmark(0)", DTS, ("auto",)),
    Integrator("CentralDifference", (), (), stable_fractions=(0.98,)),
)
"""Integrators of ancfsparse; adding one is one line."""

PAPER_MODELS = ("L2T2", "Thin", "Thick")
"""The paper's elements, run there with ten elements and 5e-4 s."""

OTHER_MESHES = (10, 20, 40, 80)  # elements of the other codes
OTHER_DTS = (4e-3, 2e-3, 1e-3, 5e-4)  # their time steps [s]
MAX_DENSE = 10  # elements up to which Exudyn's dense solver is the faster one
ELASTICA_DT = 5e-5  # largest stable step of PyElastica, whose sections rotate fast [s]

ELASTICA_MODEL = "Cosserat rod"

FINE = 160  # elements of the finest reference
FINE_DT = 5e-4  # its largest step [s]
EQUAL_ERROR = 1.1  # ratio of errors that count as equal


class TotalError(Comparison):
    """Runs against the converged motions of the models."""

    def ours(self, model: str | None = None) -> list[Point]:
        """Return the points of ancfsparse with a result, of one model if it is named."""
        return [p for p in self.of(model, OURS) if p.finished]

    def front(self) -> list[Point]:
        """Return the Pareto front of ancfsparse in error and seconds, fastest first."""
        return front(self.ours())

    def at(self, model: str, elements: int, dt: float) -> Point | None:
        """Return the point of ancfsparse of a choice; the fastest of several integrators."""
        found = [p for p in self.ours(model) if (p.task.elements, p.task.value) == (elements, dt)]
        return min(found, key=lambda p: p.seconds, default=None)

    def paper_choices(self) -> list[Point]:
        """Return the paper's choices, as far as they were run."""
        found = [self.at(model, paper.ELEMENTS, paper.DT) for model in PAPER_MODELS]
        return [p for p in found if p is not None]

    def model_spread(self) -> tuple[float, float]:
        """Return the least and the largest distance between converged models [m].

        Pairs that are closer than their references are known are left out.
        """
        known = list(self.references.values())
        pairs = [
            difference
            for i, a in enumerate(known)
            for b in known[:i]
            if (difference := distance(a.tip, b.tip)) > a.uncertainty + b.uncertainty
        ]
        return min(pairs, default=math.nan), max(pairs, default=math.nan)

    def largest_step(self, model: str, elements: int) -> Point | None:
        """Return the point with the largest step whose error is that of its mesh.

        The error of the mesh is taken from the smallest step that was run.
        """
        curve = [p for p in self.ours(model) if p.task.elements == elements]
        if not curve:
            return None
        mesh = min(curve, key=lambda p: p.task.value).error
        good = [p for p in curve if p.error <= EQUAL_ERROR * mesh]
        return max(good, key=lambda p: p.task.value)

    def elements_for(self, model: str, error: float) -> int | None:
        """Return the smallest number of elements with which a model reaches an error, or None."""
        return min((p.task.elements for p in self.ours(model) if p.error <= error), default=None)


def element_forces(point: Point) -> float:
    """Return the number of element forces of a run, its cost without a clock."""
    return float(point.counts.get("residuals", math.nan)) * point.task.elements


def total_error(
    models: Sequence[str] = tuple(MODELS),
    meshes: Sequence[int] = MESHES,
    t_end: float = paper.T_END,
    peers: Annotated[bool, typer.Option("--peers", help="Run Exudyn and PyElastica too.")] = False,
    rounds: Annotated[int, typer.Option(help="Interleaved runs, of which the best counts.")] = 2,
    integrators: Sequence[Integrator] = INTEGRATORS,
    fine: int = FINE,
    progress: bool = False,
) -> TotalError:
    """Measure the total error against its cost over elements, their number and the step."""
    for model in models:
        check_choice("model", model, MODELS)
    for n in meshes:
        check_count("elements", n)
    check_count("rounds", rounds)
    tasks = [
        task(model, n, t_end, integrator, dt, "".join(integrator.solvers[:1]))
        for model in models
        for n in meshes
        for integrator in integrators
        for dt in integrator.steps(model, n, t_end)
    ]
    if peers and EXUDYN_MODEL in models:
        tasks += _other_tasks(t_end)
    total = len(models) + rounds * len(tasks)
    with progress_bar(total, "run", progress) as bar:
        references = {}
        for model in models:
            bar.set_description(f"{model}, converged")
            references[model] = converged(model, fine, t_end, step_up_to(FINE_DT, t_end))
            bar.update()

        def tip_of(task: Task) -> Tips:
            model = task.model if task.model in references else EXUDYN_MODEL
            return references[model].tip

        points = measure(tasks, tip_of, rounds, bar)
    settings = {
        "scene": "the paper's pendulum, planar",
        "t_end_s": t_end,
        "error": f"largest tip distance at {OUTPUTS} times, from the converged motion of the same "
        f"model (other codes: of {EXUDYN_MODEL})",
        "seconds": f"best of {rounds} rounds in turn, time loop or solver alone",
        **environment(),
    }
    return TotalError(points, references, missing() if peers else [], settings)


def _other_tasks(t_end: float) -> list[Task]:
    tasks: list[Task] = []
    if installed(exudyn_code.load):
        for n in OTHER_MESHES:
            dense = Setting("", 0.02), OTHER_DTS
            sparse = Setting("", 0.02, "EigenSparse", reuse_pattern=True), OTHER_DTS
            tasks += exudyn_tasks(
                n, t_end, {("trapezoidal", "modified 0.02"): dense if n <= MAX_DENSE else sparse}
            )
    if installed(elastica_code.load):
        tasks += [_elastica(n, t_end) for n in OTHER_MESHES]
    return tasks


def _elastica(elements: int, t_end: float) -> Task:
    problem = MODELS[EXUDYN_MODEL].problem(elements)
    dt = step_up_to(ELASTICA_DT, t_end)

    def run() -> Sample:
        seconds, tip = elastica_code.run_elastica(problem, elements, t_end, dt, OUTPUTS)
        steps = round(t_end / dt)
        return Sample(seconds, tip, {"steps": steps, "residuals": steps})

    return Task("PyElastica", "Verlet", "", ELASTICA_MODEL, elements, "dt", dt, run)
