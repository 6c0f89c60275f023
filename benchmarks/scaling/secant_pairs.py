"""What secant pairs are worth: counts, modelled cost and seconds against memory length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from statistics import median
from typing import Any

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
from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.timing import in_turn

DT = 5e-4
LENGTHS = (1, 2, 5, 10, 20)
MOTIONS = ("smooth", "rough")

Key = tuple[str, int, bool]
"""Update, number of pairs, and whether they are carried."""

# Products with a term of an inverse stream through memory like the sweeps, whose operations weigh
# this much in the cost model; a term takes a dot product and an addition.
TERM_COST = 0.5 * 4.0
ONE_TERM = ("broyden", "davidon")
"""Updates whose pairs make one term; those of others make two."""

# Costs that differ by less than this are the same.
SAME = 0.02


@dataclass
class Run:
    """One memory length of one update on one scene.

    Attributes
    ----------
    scene : str
        For the table.
    update : str
        Or ``"chord"``, which keeps no pair.
    pairs : int
        Memory length.
    carry : bool
        Whether pairs outlive their step.
    iterations_per_step : float
        Corrections per time step.
    factorizations, recoveries, skipped_pairs : int
        As in `RunStats`.
    model_cost : float
        Of a step, from counts, in operations of the seed's sweeps; see `model_cost`.
    rounds : list of float
        March of each round [s].
    """

    scene: str
    update: str
    pairs: int
    carry: bool
    iterations_per_step: float
    factorizations: int
    recoveries: int
    skipped_pairs: int
    model_cost: float
    rounds: list[float] = field(default_factory=list)

    @property
    def seconds(self) -> float:
        """Median time of the march [s]."""
        return median(self.rounds)


@dataclass(frozen=True)
class MemoryStudy:
    """Everything `python -m benchmarks memory` measures.

    Attributes
    ----------
    runs : list of Run
        Scene by scene, the chord first.
    settings : dict
        What was run, and on what.
    """

    runs: list[Run]
    settings: dict[str, Any]

    @property
    def scenes(self) -> list[str]:
        """Names of the scenes, in order."""
        return list(dict.fromkeys(run.scene for run in self.runs))

    def of(self, scene: str) -> list[Run]:
        """Return the runs of a scene, the chord first."""
        return [run for run in self.runs if run.scene == scene]

    def best(self, scene: str, carry: bool) -> Run:
        """Return the quasi-Newton run of least modelled cost."""
        wanted = [r for r in self.of(scene) if r.pairs > 0 and r.carry is carry]
        return min(wanted, key=lambda run: run.model_cost)

    def findings(self) -> list[str]:
        """State for each scene whether pairs pay, and whether carried ones do."""
        return [self._finding(scene) for scene in self.scenes]

    def _finding(self, scene: str) -> str:
        chord, own, carried = self.of(scene)[0], self.best(scene, False), self.best(scene, True)
        fewest = min(r.iterations_per_step for r in self.of(scene) if r.carry)
        return (
            f"{scene}: this step's pairs {_verdict(own, chord)} beside the chord "
            f"({_name(own)}), carried pairs {_verdict(carried, own)} beside them "
            f"({_name(carried)}), though iterations fall from {chord.iterations_per_step:.2f} "
            f"(chord) and {own.iterations_per_step:.2f} to {fewest:.2f} per step"
        )


def _name(run: Run) -> str:
    return f"{run.update}, {run.pairs}"


def _verdict(run: Run, other: Run) -> str:
    """Compare two costs, modelled and measured, in words."""
    model, clock = run.model_cost / other.model_cost, run.seconds / other.seconds
    word = "pay" if model < 1.0 - SAME else "do not pay" if model > 1.0 + SAME else "change nothing"
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
        capacity = int(method.memory)
        held = 0.5 * (capacity + 1)
        if not method.carry:
            held = min(held, 0.5 * max(iterations / steps - 1.0, 0.0))
        products = (1 if method.update in ONE_TERM else 2) * held * iterations
    return (
        iterations * costs.iteration + factorizations * costs.seed + TERM_COST * n * products
    ) / steps


def memory(
    chain_elements: int = 1000,
    net_nodes: int = 20,
    steps: int = 200,
    rounds: int = 3,
    progress: bool = False,
) -> MemoryStudy:
    """Run all four updates with growing memory on a chain and a net, in smooth and rough motion."""
    scenes = {f"chain of {chain_elements}, {m}": chain(chain_elements, m).scene for m in MOTIONS}
    scenes |= {f"net {net_nodes} x {net_nodes}, {m}": net(net_nodes, m).scene for m in MOTIONS}
    runs = []
    total = rounds * len(scenes) * len(methods(LENGTHS))
    with progress_bar(total, "run", progress) as bar:
        for name, scene in scenes.items():
            bar.set_description(name)
            runs += _race(name, scene, steps, rounds, bar)
    settings = {
        "dt_s": DT,
        "steps": steps,
        "rounds": rounds,
        "tolerance": "default",
        "instruction_set": instruction_set(),
    }
    return MemoryStudy(runs, settings)


def methods(lengths: Sequence[int]) -> dict[Key, Method | str]:
    """Return the chord, and each update with each memory length, carried or not."""
    found: dict[Key, Method | str] = {("chord", 0, False): ModifiedNewton()}
    for update in UPDATES:
        for carry in (False, True):
            for pairs in lengths:
                found[update, pairs, carry] = QuasiNewton(update, memory=pairs, carry=carry)
    return found


def _race(name: str, scene: Scene, steps: int, rounds: int, bar: Any) -> list[Run]:
    """Run all methods on a scene in turn."""
    system = System(scene)
    seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
    costs = Costs.of(system.operations("residual"), system.operations("tangent"), seed)
    entrants = methods(LENGTHS)

    def run(method: Method | str) -> RunStats:
        return simulate(
            scene, steps * DT, DT, integrator=Newmark(0.0), solver=method, save_every=steps
        ).stats

    runs = []
    found = in_turn(list(entrants.values()), run, rounds, bar)
    for (key, method), (stats, *others) in zip(entrants.items(), found, strict=True):
        counts = stats.iterations, stats.factorizations
        runs.append(
            Run(
                name,
                *key,
                stats.iterations_per_step,
                stats.factorizations,
                stats.recoveries,
                stats.skipped_pairs,
                model_cost(costs, seed.n, steps, *counts, method),
                [each.march_seconds for each in (stats, *others)],
            )
        )
    return runs
