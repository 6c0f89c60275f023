"""The whole error against its cost: elements, their number and the step, and the Pareto front."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ancfsparse.checks import check_choice, check_count
from benchmarks.accuracy.candidates import Integrator, task
from benchmarks.accuracy.comparison import Contest
from benchmarks.accuracy.models import INSTANTS, MODELS, Tips, distance, step_up_to
from benchmarks.accuracy.other_code_tasks import EXUDYN_MODEL, exudyn, installed, missing
from benchmarks.accuracy.references import converged
from benchmarks.accuracy.timed_runs import Point, Sample, Task, front, race
from benchmarks.common import paper
from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.timing import OURS
from benchmarks.other_codes import elastica as elastica_peer
from benchmarks.other_codes import exudyn as exudyn_peer
from benchmarks.other_codes.environment import environment
from benchmarks.other_codes.exudyn import Setting

MESHES = (4, 6, 8, 10, 14, 20, 28, 40, 56, 80)
DTS = (1e-2, 4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4)

INTEGRATORS = (
    Integrator("Newmark(0)", DTS, ("auto",)),
    Integrator("CentralDifference", (), (), shares=(0.98,)),
)
"""Ours; adding one is one line."""

PAPER_MODELS = ("L2T2", "Thin", "Thick")
"""The paper's elements, each of which it ran with ten elements and 5e-4 s."""

PEER_MESHES = (10, 20, 40, 80)
PEER_DTS = (4e-3, 2e-3, 1e-3, 5e-4)

# Its dense solver is the faster one up to here.
DENSE = 10

# Above it the explicit method of PyElastica is unstable: its sections turn fast [s].
ELASTICA_DT = 5e-5

ELASTICA_MODEL = "Cosserat rod"

# Finest mesh of the references, and largest step on it [s].
FINE, FINE_DT = 160, 5e-4

# Two errors within this factor are as good as equal.
EQUAL = 1.1


class TotalError(Contest):
    """Everything the study measures."""

    def ours(self, model: str | None = None) -> list[Point]:
        """Return our points with a result, of one model if it is named."""
        return [p for p in self.of(model, OURS) if p.finished]

    def front(self) -> list[Point]:
        """Return our points that none of ours beats in error at no more seconds, fastest first."""
        return front(self.ours())

    def at(self, model: str, elements: int, dt: float) -> Point | None:
        """Return our point of a choice; the fastest if several integrators have it."""
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
            apart
            for i, a in enumerate(known)
            for b in known[:i]
            if (apart := distance(a.tip, b.tip)) > a.uncertainty + b.uncertainty
        ]
        return min(pairs, default=math.nan), max(pairs, default=math.nan)

    def largest_step(self, model: str, elements: int) -> Point | None:
        """Return the point with the largest step whose error is no more than its mesh leaves.

        What the mesh leaves is taken from the smallest step that was run.
        """
        curve = [p for p in self.ours(model) if p.task.elements == elements]
        if not curve:
            return None
        mesh = min(curve, key=lambda p: p.task.value).error
        good = [p for p in curve if p.error <= EQUAL * mesh]
        return max(good, key=lambda p: p.task.value)

    def elements_for(self, model: str, error: float) -> int | None:
        """Return the smallest number of elements with which a model reaches an error, or None."""
        return min((p.task.elements for p in self.ours(model) if p.error <= error), default=None)


def element_forces(point: Point) -> float:
    """Return how many forces of elements a run evaluated, its cost without a clock."""
    return float(point.counts.get("residuals", math.nan)) * point.task.elements


def total_error(
    models: Sequence[str] = tuple(MODELS),
    meshes: Sequence[int] = MESHES,
    t_end: float = paper.T_END,
    with_peers: bool = False,
    rounds: int = 2,
    integrators: Sequence[Integrator] = INTEGRATORS,
    fine: int = FINE,
    progress: bool = False,
) -> TotalError:
    """Run all meshes and steps of each model against its motion converged on `fine` elements."""
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
    if with_peers and EXUDYN_MODEL in models:
        tasks += _peers(t_end)
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

        points = race(tasks, tip_of, rounds, bar)
    settings = {
        "scene": "the paper's pendulum, planar",
        "t_end_s": t_end,
        "error": f"largest tip distance at {INSTANTS} instants, from the converged motion of the "
        f"same model (peers: of {EXUDYN_MODEL})",
        "seconds": f"best of {rounds} rounds in turn, march or solver alone",
        **environment(),
    }
    return TotalError(points, references, missing() if with_peers else [], settings)


def _peers(t_end: float) -> list[Task]:
    tasks: list[Task] = []
    if installed(exudyn_peer.load):
        for n in PEER_MESHES:
            dense = Setting("", 0.02), PEER_DTS
            sparse = Setting("", 0.02, "EigenSparse", reuse_pattern=True), PEER_DTS
            tasks += exudyn(
                n, t_end, {("trapezoidal", "modified 0.02"): dense if n <= DENSE else sparse}
            )
    if installed(elastica_peer.load):
        tasks += [_elastica(n, t_end) for n in PEER_MESHES]
    return tasks


def _elastica(elements: int, t_end: float) -> Task:
    problem = MODELS[EXUDYN_MODEL].problem(elements)
    dt = step_up_to(ELASTICA_DT, t_end)

    def run() -> Sample:
        seconds, tip = elastica_peer.run_elastica(problem, elements, t_end, dt, INSTANTS)
        steps = round(t_end / dt)
        return Sample(seconds, tip, {"steps": steps, "residuals": steps})

    return Task("PyElastica", "Verlet", "", ELASTICA_MODEL, elements, "dt", dt, run)
