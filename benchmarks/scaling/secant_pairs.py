"""Value of secant pairs: counts, modelled cost and seconds against memory length."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from itertools import cycle
from statistics import median
from typing import Annotated, Any

import typer
from matplotlib.figure import Figure

from ancfsparse.dispatch import instruction_set
from ancfsparse.integrators import Newmark
from ancfsparse.nonlinear import Method, ModifiedNewton, QuasiNewton
from ancfsparse.nonlinear.iteration import Costs
from ancfsparse.nonlinear.methods import UPDATES
from ancfsparse.problems import chain, net
from ancfsparse.results import RunStats
from ancfsparse.scene import Scene
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve import simulate
from ancfsparse.system import System
from benchmarks.common.charts import LETTER_SIZE, draw_lines, new_figure, panels, set_legend
from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.common.timing import in_turn

DT = 5e-4  # time step [s]
LENGTHS = (1, 2, 5, 10, 20)  # pairs
MOTIONS = ("smooth", "rough")

Key = tuple[str, int, bool]
"""Update, number of pairs, and True if they are carried."""

# Products with a term of an inverse stream through memory like the sweeps, whose operations weigh
# this much in the cost model; a term takes a dot product and an addition.
TERM_COST = 0.5 * 4.0
ONE_TERM = ("broyden", "davidon")
"""Updates whose pairs make one term; those of others make two."""

EQUAL_COST = 0.02  # relative difference of costs that counts as none

COLOURS = dict(zip(UPDATES, cycle(["#e69f00", "#0072b2", "#009e73", "#cc79a7"]), strict=False))
"""Colours of updates, in turn, so that a new update has one."""


@dataclass
class PairRun:
    """One memory length of one update on one scene."""

    scene: str
    update: str  # or "chord", which keeps no pair
    pairs: int  # memory length
    carry: bool  # pairs outlive their step
    iterations_per_step: float  # corrections
    # as in `RunStats`
    factorizations: int
    recoveries: int
    skipped_pairs: int
    model_cost: float  # of a step, in operations of the sweeps, see `model_cost`
    rounds: list[float] = field(default_factory=list)  # time of each round [s]

    @property
    def seconds(self) -> float:
        """Median time [s]."""
        return median(self.rounds)

    @property
    def name(self) -> str:
        """The method in words."""
        if not self.pairs:
            return self.update
        return f"{self.update}, {self.pairs} pairs{' carried' * self.carry}"


@dataclass(frozen=True)
class SecantPairs:
    """Runs, scene by scene, the chord first."""

    runs: list[PairRun]
    settings: dict[str, Any]

    @property
    def scenes(self) -> list[str]:
        """Names of the scenes, in order."""
        return list(dict.fromkeys(run.scene for run in self.runs))

    def of(self, scene: str) -> list[PairRun]:
        """Return the runs of a scene, the chord first."""
        return [run for run in self.runs if run.scene == scene]

    def best(self, scene: str, carry: bool) -> PairRun:
        """Return the quasi-Newton run of least modelled cost."""
        own = [run for run in self.of(scene) if run.pairs > 0 and run.carry is carry]
        return min(own, key=lambda run: run.model_cost)

    def findings(self) -> list[str]:
        """State for each scene the gain of pairs, and of carried ones."""
        return [self._finding(scene) for scene in self.scenes]

    def _finding(self, scene: str) -> str:
        chord, own, carried = self.of(scene)[0], self.best(scene, False), self.best(scene, True)
        least = min(run.iterations_per_step for run in self.of(scene) if run.carry)
        return (
            f"{scene}: this step's pairs {_gain(own, chord)} relative to the chord "
            f"({own.update}, {own.pairs}), carried pairs {_gain(carried, own)} relative to them "
            f"({carried.update}, {carried.pairs}), though iterations fall from "
            f"{chord.iterations_per_step:.2f} (chord) and {own.iterations_per_step:.2f} to "
            f"{least:.2f} per step"
        )


def _gain(run: PairRun, other: PairRun) -> str:
    """Compare two costs, modelled and measured, in words."""
    model, clock = run.model_cost / other.model_cost, run.seconds / other.seconds
    word = "change nothing"
    if abs(model - 1.0) > EQUAL_COST:
        word = "pay" if model < 1.0 else "do not pay"
    return f"{word}: {model:.2f} of the cost, {clock:.2f} of the seconds"


def model_cost(
    costs: Costs, n: int, steps: int, iterations: int, factorizations: int, method: Method | str
) -> float:
    """Weigh the counts of a run over `n` unknowns, per step, as the compiled loop does.

    Pairs add `TERM_COST` operations per unknown, term and product.  A carried memory holds from one
    pair to all, and is then dropped; this step's pairs are at most as many as the corrections
    before.
    """
    products = 0.0
    if isinstance(method, QuasiNewton):
        mean = 0.5 * (int(method.memory) + 1)
        if not method.carry:
            mean = min(mean, 0.5 * max(iterations / steps - 1.0, 0.0))
        products = terms_of(method.update) * mean * iterations
    work = iterations * costs.iteration + factorizations * costs.factor + TERM_COST * n * products
    return work / steps


def terms_of(update: str) -> int:
    """Return the number of terms of a pair."""
    return 1 if update in ONE_TERM else 2


def secant_pairs(
    elements: Annotated[int, typer.Option("--chain", help="Elements of the chain.")] = 1000,
    nodes: Annotated[int, typer.Option("--net", help="Nodes along a side of the net.")] = 20,
    steps: Annotated[int, typer.Option(min=1, help=f"Time steps of {DT:g} s.")] = 200,
    rounds: Annotated[int, typer.Option(min=1, help="Interleaved runs of each method.")] = 3,
    progress: bool = False,
) -> SecantPairs:
    """Measure the value of secant pairs: all updates, memory lengths, carried or not."""
    scenes = {f"chain of {elements}, {m}": chain(elements, m).scene for m in MOTIONS}
    scenes |= {f"net {nodes} x {nodes}, {m}": net(nodes, m).scene for m in MOTIONS}
    runs = []
    total = rounds * len(scenes) * len(methods(LENGTHS))
    with progress_bar(total, "run", progress) as bar:
        for name, scene in scenes.items():
            bar.set_description(name)
            runs += _run_in_turn(name, scene, steps, rounds, bar)
    settings = {
        "dt_s": DT,
        "steps": steps,
        "rounds": rounds,
        "tolerance": "default",
        "instruction_set": instruction_set(),
    }
    return SecantPairs(runs, settings)


def methods(lengths: Sequence[int]) -> dict[Key, Method | str]:
    """Return the chord, and each update with each memory length, carried or not."""
    entries: dict[Key, Method | str] = {("chord", 0, False): ModifiedNewton()}
    for update in UPDATES:
        for carry in (False, True):
            for pairs in lengths:
                entries[update, pairs, carry] = QuasiNewton(update, memory=pairs, carry=carry)
    return entries


def _run_in_turn(name: str, scene: Scene, steps: int, rounds: int, bar: Any) -> list[PairRun]:
    """Run all methods on a scene in turn."""
    system = System(scene)
    seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
    costs = Costs.from_counts(system.operations("residual"), system.operations("tangent"), seed)
    candidates = methods(LENGTHS)

    def run(method: Method | str) -> RunStats:
        return simulate(
            scene, steps * DT, DT, integrator=Newmark(0.0), solver=method, save_every=steps
        ).stats

    entries = in_turn(list(candidates.values()), run, rounds, bar)
    return [
        PairRun(
            name, *key, stats[0].iterations_per_step, stats[0].factorizations,
            stats[0].recoveries, stats[0].skipped_pairs,
            model_cost(
                costs, seed.n, steps, stats[0].iterations, stats[0].factorizations, method
            ),
            [each.march_seconds for each in stats],
        )
        for (key, method), stats in zip(candidates.items(), entries, strict=True)
    ]  # fmt: skip


COLUMNS: dict[str, Callable[[PairRun, PairRun], float]] = {
    "corrections per step": lambda run, chord: run.iterations_per_step,
    "seeds": lambda run, chord: run.factorizations,
    "cost by counts": lambda run, chord: run.model_cost / chord.model_cost,
    "seconds": lambda run, chord: run.seconds / chord.seconds,
}
"""Columns of a run and the chord on its scene; cost and seconds relative to the chord."""


def table(result: SecantPairs, keys: Callable[[str], Sequence[PairRun]]) -> Table:
    """Set the chord of each scene and the runs that are shown of it."""
    rows = []
    for scene in result.scenes:
        chord = result.of(scene)[0]
        for run in (chord, *keys(scene)):
            cells = [value(run, chord) for value in COLUMNS.values()]
            text = [f"{each}" if isinstance(each, int) else f"{each:.2f}" for each in cells]
            rows.append([scene, run.name, *text])
    return Table(["", "", *COLUMNS], rows, left=(0, 1))


def chart(result: SecantPairs) -> Figure:
    """Draw corrections, seeds, modelled cost and seconds against memory length, by scene."""
    scenes = result.scenes
    figure = new_figure(8.6, "Counts and cost of secant pairs against their number")
    axes = iter(panels(figure, len(COLUMNS) * len(scenes), len(scenes), sharex=True))
    keys: dict[str, Any] = {}
    for row, (name, value) in enumerate(COLUMNS.items()):
        for column, scene in enumerate(scenes):
            ax, (chord, *others) = next(axes), result.of(scene)
            # Each line begins at the chord, which has no pair.
            lines = [(run.update, run.carry, run) for run in others]
            starts = dict.fromkeys((update, carry) for update, carry, _ in lines)
            lines = [(*key, chord) for key in starts] + lines
            keys |= draw_lines(
                ax, lines, lambda line: line[:2], lambda line: line[2].pairs,
                lambda line, value=value, chord=chord: value(line[2], chord),  # type: ignore[misc]
                lambda key: style_of(*key),
            )  # fmt: skip
            ax.set_xscale("symlog", linthresh=1.0)
            ax.set_xticks([0, 1, 2, 5, 10, 20], ["0", "1", "2", "5", "10", "20"])
            ax.minorticks_off()
            ax.tick_params(labelsize=LETTER_SIZE)
            ax.grid(alpha=0.3)
            if column == 0:
                over = "\nrelative to the chord" if row > 1 else ""
                ax.set_ylabel(name.replace(" per", "\nper") + over, fontsize=LETTER_SIZE)
            if row == 0:
                ax.set_title(scene, fontsize=LETTER_SIZE)
            if row > 1:
                ax.axhline(1.0, color="black", linewidth=0.8)
            if row == len(COLUMNS) - 1:
                ax.set_xlabel("pairs", fontsize=LETTER_SIZE)
    set_legend(figure, keys, 4)
    return figure


def style_of(update: str, carry: bool) -> dict[str, Any]:
    """Return label, colour and line of an update."""
    label = f"{update}, {'carried' if carry else 'this step'}"
    return {"label": label, "color": COLOURS[update], "linestyle": "--" if carry else "-"}


STUDY = Study(
    "memory",
    run=secant_pairs,
    heading=lambda result: (
        f"Memory length, dt = {DT:g} s, {result.settings['steps']} steps, medians of "
        f"{result.settings['rounds']} interleaved rounds; cost and seconds relative to the chord"
    ),
    tables=lambda result: [table(result, lambda scene: result.of(scene)[1:])],
    rows=lambda result: [
        {key: value for key, value in asdict(run).items() if key != "rounds"}
        | {"median_seconds": run.seconds}
        for run in result.runs
    ],
    findings=SecantPairs.findings,
    charts={"memory": chart},
    regions={
        "memory": lambda result: table(
            result, lambda scene: [result.best(scene, False), result.best(scene, True)]
        )
    },
)
