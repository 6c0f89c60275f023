"""Mechanisms of cables, by this package and by Exudyn: time discretization error, and time.

Both use generalised-alpha with the same damping on the same elements, so that their errors at a
step are the same and their times can be compared directly.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import numpy as np
import typer
from matplotlib.figure import Figure

from ancfsparse import problems
from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice
from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.nonlinear import Outcome
from ancfsparse.problems import Mechanism
from ancfsparse.results import Equilibrium
from ancfsparse.scene import Beam
from ancfsparse.solve import solve_static
from ancfsparse.solve.motion.arguments import check_request
from ancfsparse.solve.motion.simulate import build_run, build_system_at_start
from ancfsparse.solve.stepping.state_recorder import RunStorage
from benchmarks.common.charts import draw_lines, new_figure, panels, set_axes, set_legend
from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table, bullets
from benchmarks.common.target import Target
from benchmarks.common.timing import OURS, in_turn
from benchmarks.other_codes import exudyn_mechanisms as exudyn
from benchmarks.other_codes.environment import environment
from benchmarks.other_codes.exudyn import ExudynError, Setting

INTEGRATOR = GeneralizedAlpha(exudyn.SPECTRAL_RADIUS)
OUTPUTS = 20  # compared states, evenly over the run
DIVISORS = (1, 2, 4)  # of the longest step
REFERENCE_DIVISORS = (16, 32)  # of the longest step in the extrapolated reference
MIN_RATIO = 8.0  # time of Exudyn over that of ancfsparse
EQUAL_ERROR = 0.05  # relative difference of errors that count as equal


@dataclass(frozen=True)
class Case:
    """Run and comparison of a mechanism."""

    # simulated time and longest step [s]
    t_end: float
    dt: float
    watched: tuple[tuple[str, int], ...]  # nodes of cables whose positions are compared
    build: Callable[[exudyn.Builder], None]  # adds it to a scene of Exudyn


TURN = 2.0 * math.pi / 150.0
CASES = {
    "spin_up": Case(10.0, 2e-2, (("rod", 16),), exudyn.spin_up),
    "elastic_slider_crank": Case(TURN, TURN / 1000, (("rod", 8),), exudyn.elastic_slider_crank),
    "double_pendulum_bob": Case(
        1.0, 2e-3, (("lower", 0), ("lower", 16)), exudyn.double_pendulum_bob
    ),
    "elastic_four_bar": Case(2.0, 2e-3, (("coupler", 8), ("coupler", 16)), exudyn.elastic_four_bar),
    "spaghetti": Case(5.0, 1e-2, (("rod", 0), ("rod", 32)), exudyn.spaghetti),
    "moving_supports": Case(1.0, 2e-3, (("rope", 8),), exudyn.moving_supports),
}
"""Mechanisms by name; each runs while its motion is smooth, or one revolution."""


@dataclass(frozen=True)
class Row:
    """One program and setting on a mechanism with one step."""

    scene: str  # key of `CASES`
    dt: float  # time step [s]
    # who solves its steps, and how
    program: str
    newton: str
    # least processor time of the solver alone [s], which does not depend on what else runs; not a
    # number if it failed
    seconds: float
    error: float  # largest distance from the reference in any coordinate [m]
    iterations: float  # per step


@dataclass(frozen=True)
class Comparison:
    """All runs."""

    rows: list[Row]  # by mechanism, step and program, ours first
    settings: dict[str, Any]  # how, and on what

    def pairs(self) -> list[tuple[Row, Row]]:
        """Return for each mechanism and step our row, and Exudyn's fastest of equal error."""
        result = []
        for ours in (row for row in self.rows if row.program == OURS):
            others = [
                row
                for row in self.rows
                if (row.scene, row.dt) == (ours.scene, ours.dt)
                and row.program != OURS
                and row.error <= (1.0 + EQUAL_ERROR) * ours.error
            ]
            if others:
                result.append((ours, min(others, key=lambda row: row.seconds)))
        return result

    def findings(self) -> list[str]:
        """Return sentences worked out from the numbers."""
        pairs = self.pairs()
        ratios = [other.seconds / ours.seconds for ours, other in pairs]
        difference = max(abs(other.error / ours.error - 1.0) for ours, other in pairs)
        worst, best = int(np.argmin(ratios)), int(np.argmax(ratios))
        fewer = [other.iterations / ours.iterations for ours, other in pairs]
        slowest, fastest = pairs[worst][0], pairs[best][0].scene
        return [
            f"On the same elements, with the same integrator and step, both programs have the same "
            f"error to {100.0 * difference:.1g} %.",
            f"Ours takes {ratios[worst]:.1f} times less processor time ({slowest.scene}, step "
            f"{slowest.dt:.2g} s) to {ratios[best]:.0f} times ({fastest}), "
            f"{math.exp(float(np.mean(np.log(ratios)))):.0f} times in the geometric mean, than the "
            "fastest of Exudyn's settings that has that error.",
            f"Exudyn's takes {min(fewer):.1f} to {max(fewer):.1f} times as many iterations.",
        ]

    def targets(self) -> list[Target]:
        """Return the ratio of times, by mechanism."""
        out = []
        for scene in dict.fromkeys(row.scene for row in self.rows):
            ratios = [b.seconds / a.seconds for a, b in self.pairs() if a.scene == scene]
            if ratios:
                out.append(Target(f"Exudyn / ours at equal error: {scene}", min(ratios), MIN_RATIO))
        return out


def mechanisms(
    names: Annotated[
        list[str] | None, typer.Option("--scene", help="Only this mechanism; repeatable.")
    ] = None,
    rounds: Annotated[int, typer.Option(min=1, help="Interleaved runs of each program.")] = 9,
    progress: bool = False,
) -> Comparison:
    """Run mechanisms of cables by ancfsparse and by Exudyn: time against error; some minutes."""
    names = names or list(CASES)
    rows: list[Row] = []
    with progress_bar(len(names) * len(DIVISORS), "step", progress) as bar:
        for name in names:
            check_choice("mechanism", name, CASES)
            reference = _reference(name)
            for finer in DIVISORS:
                rows += _run_in_turn(name, finer, reference, rounds)
                bar.update()
    settings = {"rounds": rounds, "integrator": repr(INTEGRATOR), **environment()}
    return Comparison(rows, settings)


def _run_in_turn(name: str, finer: int, reference: Vector, rounds: int) -> list[Row]:
    case = CASES[name]
    steps = finer * round(case.t_end / case.dt)
    dt = case.t_end / steps

    def ours() -> tuple[float, Vector, float]:
        return _ours(name, steps)

    def exudyns(how: Setting) -> tuple[float, Vector, float]:
        problem, rest = _set_up(name)
        start = None if rest is None else rest.state
        args = (case.watched, how, case.t_end, dt, OUTPUTS)
        run = exudyn.run_mechanism(problem, case.build, start, *args)
        return run.seconds, run.tip, run.iterations_per_step

    def timed(run: Callable[[], tuple[float, Vector, float]]) -> tuple[float, float, float]:
        try:
            seconds, places, iterations = run()
        except ExudynError:
            return math.nan, math.nan, math.nan
        return seconds, float(np.max(np.abs(places - reference))), iterations

    candidates = {(OURS, "auto"): ours}
    candidates |= {("Exudyn", key): partial(exudyns, how) for key, how in exudyn.NEWTON.items()}
    result = in_turn(list(candidates.values()), timed, rounds)
    return [Row(name, dt, *key, *min(runs)) for key, runs in zip(candidates, result, strict=True)]


def _set_up(name: str) -> tuple[Mechanism, Equilibrium | None]:
    problem = getattr(problems, name)()
    return problem, solve_static(problem.scene) if problem.settles else None


def _ours(name: str, steps: int, tolerance: str | float = "default") -> tuple[float, Vector, float]:
    """Return processor time of the time loop, positions over time and iterations per step."""
    case = CASES[name]
    problem, start = _set_up(name)
    request = check_request(
        problem.scene,
        case.t_end,
        case.t_end / steps,
        accuracy=None,
        integrator=INTEGRATOR,
        solver="auto",
        factorization="auto",
        tolerance=tolerance,
        max_energy_gain=0.01,
        max_halvings=0,
        threads=1,
        save_every=steps // OUTPUTS,
        save_nodes=None,
        output=None,
        progress=False,
        start=start,
    )
    system = build_system_at_start(request)
    record = RunStorage(system, request.rows, None, None, request.settings)
    run = build_run(request, system, request.memory())
    with record.open() as recorder:
        begin = time.process_time()
        outcome = run.integrate(recorder)
        seconds = time.process_time() - begin
    trajectory = record.trajectory()
    if outcome != Outcome.CONVERGED:
        raise run.failure(outcome, trajectory)
    places = []
    for body, index in case.watched:
        beam = problem.bodies[body]
        assert isinstance(beam, Beam)
        places.append(trajectory.position(beam.node(index))[1:])
    return (
        seconds,
        np.concatenate(places, axis=1),
        trajectory.stats.iterations / trajectory.stats.steps,
    )


def _reference(name: str) -> Vector:
    """Return positions extrapolated from two fine steps."""
    case = CASES[name]
    steps = round(case.t_end / case.dt)
    coarse, fine = (_ours(name, by * steps, 1e-12)[1] for by in REFERENCE_DIVISORS)
    return np.asarray(fine + (fine - coarse) / 3.0)


COLUMNS: dict[str, Callable[[tuple[Row, Row]], str]] = {
    "mechanism": lambda pair: pair[0].scene,
    "step [s]": lambda pair: f"{pair[0].dt:.2g}",
    "error [m]": lambda pair: ", ".join(f"{each.error:.1e}" for each in pair),
    "ours [ms]": lambda pair: f"{1e3 * pair[0].seconds:.1f}",
    "Exudyn [ms]": lambda pair: f"{1e3 * pair[1].seconds:.0f}",
    "how": lambda pair: pair[1].newton,
    "ratio": lambda pair: f"{pair[1].seconds / pair[0].seconds:.1f}",
}
"""Columns of our row and the fastest of Exudyn's."""


def comparison(result: Comparison) -> Table:
    """Set a line for each mechanism and step."""
    return Table.of(result.pairs(), COLUMNS, left=(0, 5))


def as_markdown(result: Comparison) -> str:
    """Set the table for a page."""
    lines = [*comparison(result).markdown(), "", *bullets([*result.findings(), _reached(result)])]
    return "\n".join(lines)


def _reached(result: Comparison) -> str:
    """State the number of mechanisms that reach the target, and the least ratio of the others."""
    targets = result.targets()
    missed = [f"{each.what.split(': ')[1]} {each.value:.1f}" for each in targets if not each.is_met]
    reached = len(targets) - len(missed)
    text = (
        f"The target, {MIN_RATIO:g} times at every step, is reached by {reached} of {len(targets)}"
    )
    return text + (f" and missed by {', '.join(missed)}." if missed else ".")


COLOURS = ("#0072b2", "#e69f00", "#d55e00", "#b15928", "#cc79a7", "#999999", "#666666")


def chart(result: Comparison) -> Figure:
    """Draw the error against the time, a panel for each mechanism."""
    scenes = list(dict.fromkeys(row.scene for row in result.rows))
    figure = new_figure(1.2 + 2.6 * -(-len(scenes) // 3), "Error of the steps against time")
    settings = dict.fromkeys((row.program, row.newton) for row in result.rows)
    colours = dict(zip(settings, COLOURS, strict=False))

    def style_of(key: tuple[str, str]) -> dict[str, Any]:
        shape = {"color": colours[key], "markersize": 4, "linewidth": 1.2}
        if key[0] == OURS:
            return {"label": OURS, "marker": "o", **shape}
        return {"label": f"Exudyn, {key[1]}", "marker": "s", "linestyle": "--", **shape}

    keys: dict[str, Any] = {}
    for ax, scene in zip(panels(figure, len(scenes), 3), scenes, strict=True):
        rows = [row for row in result.rows if row.scene == scene]
        keys |= draw_lines(
            ax, rows, lambda row: (row.program, row.newton), lambda row: 1e3 * row.seconds,
            lambda row: row.error, style_of,
        )  # fmt: skip
        title = scene.replace("_", " ")
        set_axes(ax, "processor time of the solver [ms]", "error [m]", title=title)
    set_legend(figure, keys, 2)
    return figure


STUDY = Study(
    "mechanisms",
    run=mechanisms,
    tables=lambda result: [comparison(result)],
    rows=lambda result: result.rows,
    findings=Comparison.findings,
    targets=Comparison.targets,
    charts={"mechanisms": chart},
    regions={"mechanisms": as_markdown},
)
