"""Secant pairs on incomplete seeds: counts and modelled work against the length of the step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from ancfsparse.errors import EnergyIncreaseError, StepError
from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.nonlinear import Method
from ancfsparse.nonlinear.methods import UPDATES
from ancfsparse.problems import lattice
from ancfsparse.problems.meshes import STIFF
from ancfsparse.results import RunStats
from ancfsparse.scene import Scene
from ancfsparse.solve import simulate
from ancfsparse.solve.preparation.choose_factorization import make_seed
from ancfsparse.solve.preparation.memory_estimate import NO_MEMORY
from ancfsparse.solve.stepping.implicit_setup import iteration_costs
from ancfsparse.system import System
from benchmarks.common.charts import SMALL, new_figure, set_legend
from benchmarks.common.progress import bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.scaling.secant_pairs import ONE_TERM, TERM_COST, Key, methods
from benchmarks.scaling.secant_pairs_report import COLOURS

OMEGA = {"soft": 1.5e4, "steel": 2.5e5}
"""Highest axial frequency of an element of the lattices [1/s]."""

# Steps by their product with it.  Those of soft lattices above 250 fail: these fall too far in one.
H_OMEGA = {"soft": (15, 50, 100, 150, 250), "steel": (50, 100, 150, 250, 350, 500, 1000, 2500)}
MOTIONS = ("rest", "smooth")
LENGTHS = (2, 10)
INTEGRATOR = GeneralizedAlpha(0.9)

# Terms passed over for each pair of auto's: two when it is learnt, and two in the next correction.
PASSES = 4.0


@dataclass(frozen=True)
class Row:
    """One method on one lattice.

    Attributes
    ----------
    scene : str
        Stiffness and motion.
    h_omega : float
        Step times the highest axial frequency of an element [-].
    update : str
        ``"chord"``, ``"auto"``, or the update.
    pairs : int
        Memory length.
    carry : bool
        Whether pairs outlive their step.
    corrections, inner : float
        Corrections, and sweeps and products with the matrix, per step.
    factorizations, recoveries : int
        As in `RunStats`.
    work : float
        Modelled cost of a step, see `work_of`.
    failed : bool
        Whether a step could not be solved; the numbers are those of the steps before.
    """

    scene: str
    h_omega: float
    update: str
    pairs: int
    carry: bool
    corrections: float
    inner: float
    factorizations: int
    recoveries: int
    work: float
    failed: bool

    @property
    def name(self) -> str:
        """The method in words."""
        if not self.pairs:
            return self.update
        return f"{self.update}, {self.pairs} pairs{' carried' * self.carry}"


def entrants() -> dict[Key, Method | str]:
    """Return what is run by update, number of pairs, and whether they are carried."""
    return methods(LENGTHS) | {("auto", 0, False): "auto"}


def work_of(scene: Scene, stats: RunStats, key: Key) -> float:
    """Weigh the counts of a run, per step, as the compiled loop does.

    Passes over pairs are weighed as in `memory.run.model_cost`, those of ``"auto"`` by the pairs
    that it took.
    """
    system = System(scene)
    seed, _ = make_seed(system, "incomplete", "auto", 1, NO_MEMORY)
    prices = iteration_costs(system, INTEGRATOR, seed, None)
    sweep, steps = 0.5 * seed.solve_flops, max(stats.steps, 1)
    update, pairs, carry = key
    held = 0.5 * (pairs + 1) if carry else min(0.5 * (pairs + 1), 0.5 * stats.iterations / steps)
    terms = 0.0 if not pairs else held * (1 if update in ONE_TERM else 2)
    if update == "auto":
        terms = PASSES * stats.pairs / max(stats.iterations, 1)
    return (
        (prices.iteration - sweep) * stats.residual_evaluations
        + sweep * (stats.sweeps + stats.products)
        + prices.seed * stats.factorizations
        + TERM_COST * seed.n * terms * stats.iterations
    ) / steps


def lattices(n_nodes: int = 8, steps: int = 20, progress: bool = False) -> list[Row]:
    """Run all updates on incomplete seeds of soft and steel lattices, with longer steps in turn."""
    jobs = [
        (stiff, motion, h_omega, key, method)
        for stiff, lengths in H_OMEGA.items()
        for motion in MOTIONS
        for h_omega in lengths
        for key, method in entrants().items()
    ]
    rows = []
    for stiff, motion, h_omega, key, method in bar(jobs, "run", progress):
        scene = lattice(n_nodes, motion, *STIFF[stiff]).scene
        dt, failed = h_omega / OMEGA[stiff], False
        try:
            stats = simulate(
                scene, steps * dt, dt, integrator=INTEGRATOR, solver=method,
                factorization="incomplete", save_every=steps,
            ).stats  # fmt: skip
        except (StepError, EnergyIncreaseError) as error:
            stats, failed = error.trajectory.stats, True
        taken, (update, pairs, carry) = max(stats.steps, 1), key
        rows.append(
            Row(
                f"{stiff}, {'at rest' if motion == 'rest' else motion}",
                h_omega,
                update,
                pairs,
                carry,
                stats.iterations_per_step,
                (stats.sweeps + stats.products) / taken,
                stats.factorizations,
                stats.recoveries,
                work_of(scene, stats, key),
                failed,
            )
        )
    return rows


def beside(rows: Sequence[Row], row: Row) -> float:
    """Return the work of a run over that of the chord in the same steps; NaN where one fails."""
    chord = next(
        each for each in rows
        if (each.scene, each.h_omega, each.update) == (row.scene, row.h_omega, "chord")
    )  # fmt: skip
    if row.failed or chord.failed:
        return float("nan")
    return row.work / chord.work


def findings(rows: Sequence[Row]) -> list[str]:
    """State where pairs pay, what ``auto`` makes of them, and where they rescue or fail."""
    sentences = []
    for scene in dict.fromkeys(row.scene for row in rows):
        own = [row for row in rows if row.scene == scene]
        auto = [(beside(rows, row), row) for row in own if row.update == "auto"]
        ratios = [(ratio, row) for ratio, row in auto if ratio == ratio]
        if not ratios:
            continue
        least, most = min(ratios, key=_first), max(ratios, key=_first)
        sentences.append(
            f"{scene.capitalize()}: auto takes {least[0]:.2f} (h omega = {least[1].h_omega:g}) to "
            f"{most[0]:.2f} ({most[1].h_omega:g}) of the work of the chord"
        )
    fail = {row.h_omega: row for row in rows if row.update == "chord" and row.failed}
    rescued = [
        row for row in rows
        if not row.failed and row.update not in ("chord", "auto")
        and any(c.scene == row.scene and c.h_omega == row.h_omega for c in fail.values())
    ]  # fmt: skip
    carried = [row for row in rows if row.carry]
    sentences.append(
        f"Pairs complete {len(rescued)} runs that the chord does not; of {len(carried)} runs with "
        f"carried pairs {sum(row.failed for row in carried)} fail, of "
        f"{sum(not row.carry and row.pairs > 0 for row in rows)} with those of a step "
        f"{sum(row.failed and not row.carry and row.pairs > 0 for row in rows)}, of "
        f"{sum(row.update == 'chord' for row in rows)} by the chord "
        f"{sum(row.failed and row.update == 'chord' for row in rows)}"
    )
    return sentences


def _first(pair: tuple[float, Row]) -> float:
    return pair[0]


HEAD = ("corrections", "sweeps and products", "seeds", "work beside the chord")


def _best(rows: Sequence[Row], scene: str, h_omega: float, carry: bool) -> Row | None:
    """Return the run with pairs of least work, None where all fail."""
    own = [
        row for row in rows
        if (row.scene, row.h_omega, row.carry) == (scene, h_omega, carry) and row.pairs
    ]  # fmt: skip
    return min((row for row in own if not row.failed), key=lambda row: row.work, default=None)


def _chosen(rows: Sequence[Row]) -> list[Row]:
    """Return for each scene and step the chord, auto, and the best of both kinds of pairs."""
    chosen = []
    for scene, h_omega in dict.fromkeys((row.scene, row.h_omega) for row in rows):
        for row in rows:
            if (row.scene, row.h_omega) == (scene, h_omega) and not row.pairs:
                chosen.append(row)
        best = [_best(rows, scene, h_omega, carry) for carry in (False, True)]
        chosen += [row for row in best if row is not None]
    return chosen


def _cells(rows: Sequence[Row], row: Row) -> list[str]:
    if row.failed:
        return ["fails", "", "", ""]
    ratio = beside(rows, row)
    return [
        f"{row.corrections:.2f}",
        f"{row.inner:.1f}",
        f"{row.factorizations}",
        f"{ratio:.2f}" if ratio == ratio else "",
    ]


def table(rows: Sequence[Row], shown: Sequence[Row]) -> Table:
    """Set some of the rows, beside the chord among all."""
    lines = [[row.scene, f"{row.h_omega:g}", row.name, *_cells(rows, row)] for row in shown]
    return Table(["", "h omega", "", *HEAD], lines, left=(0, 2))


def chart(rows: Sequence[Row]) -> Figure:
    """Draw the work beside the chord against the step, by scene; a gap is a run that fails."""
    scenes = list(dict.fromkeys(row.scene for row in rows))
    figure = new_figure(6.4, "Work of secant pairs on incomplete seeds")
    axes = figure.subplots(2, -(-len(scenes) // 2), sharey=True, squeeze=False)
    shown: dict[str, Any] = {}
    for ax, scene in zip(axes.ravel(), scenes, strict=False):
        _panel(ax, rows, scene, shown)
    for ax in axes[:, 0]:
        ax.set_ylabel("work beside the chord", fontsize=SMALL)
    for ax in axes[-1]:
        ax.set_xlabel("step times highest frequency of an element", fontsize=SMALL)
    set_legend(figure, shown, 3, "two pairs; the black line is auto, gaps are runs that fail")
    return figure


def _panel(ax: Axes, rows: Sequence[Row], scene: str, shown: dict[str, Any]) -> None:
    least = min(row.pairs for row in rows if row.pairs)
    own = [row for row in rows if row.scene == scene and row.pairs in (0, least)]
    steps = list(dict.fromkeys(row.h_omega for row in own))
    for update in (*UPDATES, "auto"):
        for carry in (False, True) if update != "auto" else (False,):
            line = [row for row in own if (row.update, row.carry) == (update, carry)]
            label = f"{update}, {'carried' if carry else 'this step'}"
            (shown[label if update != "auto" else "auto"],) = ax.plot(
                steps,
                [beside(rows, row) for row in line],
                "--" if carry else "-",
                color=COLOURS.get(update, "black"),
                linewidth=2.0 if update == "auto" else 1.0,
                marker=".",
            )
    ax.axhline(1.0, color="grey", linewidth=0.8)
    ax.set_xscale("log")
    ax.set_xticks(steps, [f"{each:g}" if each not in (100, 350) else "" for each in steps])
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_ylim(0.4, 3.0)
    ax.set_title(scene, fontsize=SMALL)
    ax.tick_params(labelsize=SMALL)
    ax.grid(alpha=0.3)


STUDY = Study(
    "memory-lattices",
    run=lattices,
    tables=lambda rows: [table(rows, rows)],
    rows=lambda rows: [asdict(row) for row in rows],
    findings=findings,
    charts={"memory-lattices": chart},
    regions={"memory-lattices": lambda rows: table(rows, _chosen(rows))},
)
