"""Secant pairs on incomplete seeds: counts and modelled work against the length of the step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Annotated, Any

import typer
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from ancfsparse.errors import EnergyIncreaseError, StepError
from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.nonlinear import Method
from ancfsparse.problems import lattice
from ancfsparse.problems.meshes import LATTICE_MATERIALS
from ancfsparse.results import RunStats
from ancfsparse.scene import Scene
from ancfsparse.solve import simulate
from ancfsparse.solve.preparation.choose_factorization import make_seed
from ancfsparse.solve.preparation.memory_estimate import NO_MEMORY
from ancfsparse.solve.stepping.implicit_setup import iteration_costs
from ancfsparse.system import System
from benchmarks.common.charts import LETTER_SIZE, draw_lines, new_figure, panels, set_legend
from benchmarks.common.progress import bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.scaling.secant_pairs import TERM_COST, Key, methods, style_of, terms_of

OMEGA = {"soft": 1.5e4, "steel": 2.5e5}
"""Highest axial frequency of an element of the lattices [1/s]."""

# Steps by their product with it.  Those of soft lattices above 250 fail: these fall too far in one.
H_OMEGA = {"soft": (15, 50, 100, 150, 250), "steel": (50, 100, 150, 250, 350, 500, 1000, 2500)}
MOTIONS = ("rest", "smooth")
LENGTHS = (2, 10)  # pairs
INTEGRATOR = GeneralizedAlpha(0.9)
PASSES = 4.0  # over terms for each pair of auto: two when it is learnt, two in the next correction
UNLABELLED = (100, 350)  # values of h omega whose labels would overlap others


@dataclass(frozen=True)
class PairRow:
    """One method on one lattice."""

    scene: str  # stiffness and motion
    h_omega: float  # step times the highest axial frequency of an element [-]
    update: str  # "chord", "auto", or the update
    pairs: int  # memory length
    carry: bool  # pairs outlive their step
    corrections: float  # per step
    inner: float  # sweeps and products with the matrix per step
    # as in `RunStats`
    factorizations: int
    recoveries: int
    work: float  # modelled cost of a step, see `work_of`
    failed: bool  # a step could not be solved; the numbers are those of the steps before

    @property
    def name(self) -> str:
        """The method in words."""
        if not self.pairs:
            return self.update
        return f"{self.update}, {self.pairs} pairs{' carried' * self.carry}"


def candidates() -> dict[Key, Method | str]:
    """Return the methods by update, number of pairs, and carry."""
    return methods(LENGTHS) | {("auto", 0, False): "auto"}


def work_of(scene: Scene, stats: RunStats, key: Key) -> float:
    """Weigh the counts of a run, per step, as the compiled loop does.

    Passes over pairs are weighed as in `secant_pairs.model_cost`, those of ``"auto"`` by the pairs
    that it took.
    """
    system = System(scene)
    seed, _ = make_seed(system, "incomplete", "auto", 1, NO_MEMORY)
    prices = iteration_costs(system, INTEGRATOR, seed, None)
    sweep, steps = 0.5 * seed.solve_flops, max(stats.steps, 1)
    update, pairs, carry = key
    mean = 0.5 * (pairs + 1) if carry else min(0.5 * (pairs + 1), 0.5 * stats.iterations / steps)
    terms = 0.0 if not pairs else mean * terms_of(update)
    if update == "auto":
        terms = PASSES * stats.pairs / max(stats.iterations, 1)
    return (
        (prices.iteration - sweep) * stats.residual_evaluations
        + sweep * (stats.sweeps + stats.products)
        + prices.factor * stats.factorizations
        + TERM_COST * seed.n * terms * stats.iterations
    ) / steps


def lattice_pairs(
    nodes: Annotated[int, typer.Option(min=2, help="Nodes along a side of the lattice.")] = 8,
    steps: Annotated[int, typer.Option(min=1, help="Time steps.")] = 20,
    progress: bool = False,
) -> list[PairRow]:
    """Measure secant pairs on incomplete seeds of lattices, with increasing steps."""
    jobs = [
        (stiff, motion, h_omega, key, method)
        for stiff, lengths in H_OMEGA.items()
        for motion in MOTIONS
        for h_omega in lengths
        for key, method in candidates().items()
    ]
    rows = []
    for stiff, motion, h_omega, key, method in bar(jobs, "run", progress):
        scene = lattice(nodes, motion, *LATTICE_MATERIALS[stiff]).scene
        dt, failed = h_omega / OMEGA[stiff], False
        try:
            stats = simulate(
                scene, steps * dt, dt, integrator=INTEGRATOR, solver=method,
                factorization="incomplete", save_every=steps,
            ).stats  # fmt: skip
        except (StepError, EnergyIncreaseError) as error:
            stats, failed = error.trajectory.stats, True
        name = f"{stiff}, {'at rest' if motion == 'rest' else motion}"
        inner = (stats.sweeps + stats.products) / max(stats.steps, 1)
        update, pairs, carry = key
        rows.append(
            PairRow(
                name, h_omega, update, pairs, carry, stats.iterations_per_step, inner,
                stats.factorizations, stats.recoveries, work_of(scene, stats, key), failed,
            )
        )  # fmt: skip
    return rows


def relative_work(rows: Sequence[PairRow], row: PairRow) -> float:
    """Return the work of a run over that of the chord in the same steps; NaN where one fails."""
    point = (row.scene, row.h_omega, "chord")
    chord = next(each for each in rows if (each.scene, each.h_omega, each.update) == point)
    return float("nan") if row.failed or chord.failed else row.work / chord.work


def findings(rows: Sequence[PairRow]) -> list[str]:
    """State the work of auto by scene, and the runs that pairs complete or fail."""
    sentences = []
    for scene in dict.fromkeys(row.scene for row in rows):
        autos = [row for row in rows if (row.scene, row.update) == (scene, "auto")]
        known = [(w, row.h_omega) for row in autos if (w := relative_work(rows, row)) == w]
        if known:
            least, at_least = min(known, key=itemgetter(0))
            most, at_most = max(known, key=itemgetter(0))
            sentences.append(
                f"{scene.capitalize()}: auto takes {least:.2f} (h omega = {at_least:g}) to "
                f"{most:.2f} ({at_most:g}) of the work of the chord"
            )
    chords = [row for row in rows if row.update == "chord"]
    carried = [row for row in rows if row.carry]
    own = [row for row in rows if row.pairs > 0 and not row.carry]
    lost = {(row.scene, row.h_omega) for row in chords if row.failed}
    completed = [row for row in own + carried if not row.failed if (row.scene, row.h_omega) in lost]
    fails = [sum(row.failed for row in group) for group in (carried, own, chords)]
    sentences.append(
        f"Pairs complete {len(completed)} runs that the chord does not; of {len(carried)} runs "
        f"with carried pairs {fails[0]} fail, of {len(own)} with those of a step {fails[1]}, of "
        f"{len(chords)} by the chord {fails[2]}"
    )
    return sentences


def _selected(rows: Sequence[PairRow]) -> list[PairRow]:
    """Return for each scene and step the chord, auto, and the best of both kinds of pairs."""
    selected = []
    for point in dict.fromkeys((row.scene, row.h_omega) for row in rows):
        here = [row for row in rows if (row.scene, row.h_omega) == point]
        selected += [row for row in here if not row.pairs]
        for carry in (False, True):
            done = [r for r in here if r.pairs and r.carry is carry and not r.failed]
            selected += [min(done, key=lambda row: row.work)] if done else []
    return selected


def table(rows: Sequence[PairRow], keys: Sequence[PairRow]) -> Table:
    """Set some of the rows, with their work relative to the chord of all."""
    columns: dict[str, Callable[[PairRow], str]] = {
        "corrections": lambda row: f"{row.corrections:.2f}",
        "sweeps and products": lambda row: f"{row.inner:.1f}",
        "seeds": lambda row: f"{row.factorizations}",
        "work over the chord": lambda row: (
            f"{work:.2f}" if (work := relative_work(rows, row)) == work else ""
        ),
    }
    failure = ["fails", "", "", ""]
    lines = [
        [row.scene, f"{row.h_omega:g}", row.name]
        + (failure if row.failed else [cell(row) for cell in columns.values()])
        for row in keys
    ]
    return Table(["", "h omega", "", *columns], lines, left=(0, 2))


def chart(rows: Sequence[PairRow]) -> Figure:
    """Draw the work over that of the chord against the step, by scene; a gap is a failed run."""
    scenes = list(dict.fromkeys(row.scene for row in rows))
    figure = new_figure(6.4, "Work of secant pairs on incomplete seeds")
    columns = -(-len(scenes) // 2)
    axes = panels(figure, len(scenes), columns, sharey=True)
    least = min(row.pairs for row in rows if row.pairs)
    keys: dict[str, Any] = {}
    for k, (ax, scene) in enumerate(zip(axes, scenes, strict=True)):
        here = [row for row in rows if row.scene == scene]
        own = [row for row in here if row.pairs == least or row.update == "auto"]
        keys |= draw_lines(
            ax, own, lambda row: (row.update, row.carry), lambda row: row.h_omega,
            lambda row: relative_work(rows, row), _style_of,
        )  # fmt: skip
        steps = sorted({row.h_omega for row in own})
        ax.axhline(1.0, color="grey", linewidth=0.8)
        ax.set_xscale("log")
        ax.set_xticks(steps, ["" if each in UNLABELLED else f"{each:g}" for each in steps])
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.set_ylim(0.4, 3.0)
        ax.set_title(scene, fontsize=LETTER_SIZE)
        ax.tick_params(labelsize=LETTER_SIZE)
        ax.grid(alpha=0.3)
        if k % columns == 0:
            ax.set_ylabel("work over that of the chord", fontsize=LETTER_SIZE)
        if k >= len(scenes) - columns:
            ax.set_xlabel("step times highest frequency of an element", fontsize=LETTER_SIZE)
    set_legend(figure, keys, 3, "two pairs; the black line is auto, gaps are runs that fail")
    return figure


def _style_of(key: tuple[str, bool]) -> dict[str, Any]:
    if key[0] == "auto":
        return {"label": "auto", "color": "black", "linewidth": 2.0}
    return style_of(*key) | {"linewidth": 1.0}


STUDY = Study(
    "memory-lattices",
    run=lattice_pairs,
    tables=lambda rows: [table(rows, rows)],
    rows=lambda rows: rows,
    findings=findings,
    charts={"memory-lattices": chart},
    regions={"memory-lattices": lambda rows: table(rows, _selected(rows))},
)
