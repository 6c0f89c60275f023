"""Errors and costs of runs to an accuracy on scenes drawn at random: ``make error-control``.

Each scene leaves a reference, the errors and costs of fixed steps, and a file of its results in
``results/accuracy``, so that a sweep that was interrupted goes on where it was; ``--again`` repeats
the runs to an accuracy alone.  Kinds of scenes alternate, so any first few are a fair sample.
"""

import argparse
import contextlib
import json
import math
import signal
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import ancfsparse as ancf
from ancfsparse.system import System
from benchmarks.random_scenes.scenes import SAVED, Case, distance, make, positions, reference

ACCURACIES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)  # [m]
MAX_REFERENCE_TIME = 120.0  # of a processor [s]
MAX_FORCES = 150_000  # evaluations of a fixed run


def cost(stats: Any) -> int:
    """Count residuals, and a factor with its solution as four of them, about as `Costs` does."""
    return int(stats.residual_evaluations + 4 * stats.factorizations)


def fixed_steps(case: Case, exact: Any) -> Iterator[tuple[str, float, float]]:
    """Yield name, cost and error of runs with fixed steps by the integrators of the package."""
    system = System(case.scene)

    def run(integrator: Any, steps: float, **options: Any) -> tuple[str, float, float]:
        steps = SAVED * math.ceil(steps / SAVED)
        try:
            result = ancf.simulate(
                case.scene, case.t_end, case.t_end / steps, integrator=integrator,
                save_every=steps // SAVED, max_energy_gain=math.inf, **options,
            )  # fmt: skip
        except (ancf.StepError, ancf.InputError):
            return repr(integrator), math.inf, math.inf
        return repr(integrator), cost(result.stats), distance(positions(system, result.q), exact)

    explicit: list[Any] = [ancf.DormandPrince()]
    if not system.damped and not system.n_multipliers:
        explicit += [ancf.CentralDifference(), *(ancf.RungeKuttaNystrom(k) for k in (4, 8))]
    for integrator in explicit:
        limit = ancf.stable_step(case.scene, integrator)
        for ratio in (1.0001, 1.1, 1.3, 1.6, 2, 2.5, 3.2, 4, 5, 6.3, 8):
            steps = case.t_end / limit * ratio
            if steps * integrator.tableau.forces > MAX_FORCES:
                break
            yield (result := run(integrator, steps))
            if result[2] < ACCURACIES[-1]:
                break
    implicit: tuple[Any, ...] = (ancf.GeneralizedAlpha(0.9), ancf.Newmark(0.0))
    for integrator in implicit:
        if system.n_multipliers and integrator == ancf.Newmark(0.0):
            continue
        steps = SAVED
        while steps < 60_000:
            tolerance = "default" if steps < 3000 else 1e-4
            yield (result := run(integrator, steps, tolerance=tolerance))
            if result[2] < ACCURACIES[-1]:
                break
            steps = math.ceil(1.6 * steps)


class TooLongError(Exception):
    """A reference takes longer than it may."""


@contextlib.contextmanager
def limit_time(seconds: float) -> Iterator[None]:
    """Raise an error where the body takes longer on the processor."""

    def end(*_: Any) -> None:
        raise TooLongError

    before = signal.signal(signal.SIGVTALRM, end)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def known(case: Case, folder: Path) -> tuple[Any, float]:
    """Return positions at the saved times and how far they may be off [m]."""
    path = folder / f"{case.seed}.npz"
    if not path.exists():
        with limit_time(MAX_REFERENCE_TIME):
            exact, uncertain = reference(case)
        np.savez(path, exact=exact, uncertain=uncertain)
    with np.load(path) as stored:
        return stored["exact"], float(stored["uncertain"])


def known_fixed_steps(case: Case, exact: Any, folder: Path) -> Any:
    """Return names, costs and errors of fixed steps."""
    path = folder / f"{case.seed}-fixed.json"
    if not path.exists():
        path.write_text(json.dumps(list(fixed_steps(case, exact))))
    return json.loads(path.read_text())


def measure(case: Case, folder: Path) -> dict[str, Any]:
    """Return the results of a scene as lists and numbers."""
    try:
        exact, uncertain = known(case, folder)
    except TooLongError:
        return {"seed": case.seed, "kind": case.kind, "skipped": True, "runs": []}
    swept = known_fixed_steps(case, exact, folder)
    runs: list[dict[str, Any]] = []
    for accuracy in ACCURACIES:
        try:
            run = ancf.simulate(case.scene, case.t_end, case.t_end / SAVED, accuracy=accuracy)
        except ancf.AncfError as error:
            runs.append({"accuracy": accuracy, "failed": str(error)})
            continue
        off = max(distance(positions(run.system, run.q), exact) - uncertain, 0.0)
        enough = [(work, name) for name, work, error in swept if error <= accuracy]
        lowest, best = min(enough, default=(None, None))
        runs.append(
            {
                "accuracy": accuracy,
                "error": off / accuracy,
                "estimate": run.stats.error / accuracy,
                "cost": cost(run.stats),
                "runs": run.stats.runs,
                "lowest": lowest,
                "best": best,
                "solver": run.stats.solver,
            }
        )
    return {"seed": case.seed, "kind": case.kind, "uncertain": uncertain, "runs": runs}


def line(scene: dict[str, Any], run: dict[str, Any]) -> str:
    """Return a line about a run."""
    name = f"{scene['seed']:3d} {scene['kind']:16s} {run['accuracy']:.0e} m"
    if "failed" in run:
        return f"{name}: {run['failed']}"
    words = "no fixed step is as exact"
    if run["lowest"] is not None:
        words = f"cost {run['cost'] / run['lowest']:.2f} times that of {run['best']}"
    return (
        f"{name}: error {run['error']:.2g}, estimate {run['estimate']:.2g} of it, {words}; "
        f"{run['solver']}"
    )


def summary(results: Sequence[dict[str, Any]]) -> str:
    """Return a few lines about all runs."""
    runs = [run for scene in results for run in scene["runs"]]
    done = [run for run in runs if "failed" not in run]
    if not done:
        return "no runs"
    errors = np.array([run["error"] for run in done])
    ratios = np.array([run["cost"] / run["lowest"] for run in done if run["lowest"] is not None])
    skipped = sum("skipped" in scene for scene in results)
    return (
        f"{len(results)} scenes, {skipped} skipped, {len(done)} runs, "
        f"{len(runs) - len(done)} failed\n"
        f"error over accuracy: largest {errors.max():.2f}, at most 1 in "
        f"{100 * np.mean(errors <= 1):.1f} %\n"
        f"cost over that of the cheapest fixed step, where one is known ({len(ratios)} runs): "
        f"median {np.median(ratios):.2f}, largest {ratios.max():.2f}, at most 3 in "
        f"{100 * np.mean(ratios <= 3):.1f} %"
    )


def main(words: Sequence[str] | None = None) -> int:
    """Measure errors and costs of runs to an accuracy on random scenes."""
    parser = argparse.ArgumentParser(
        prog="make error-control",
        description="Errors and costs of runs to an accuracy on random scenes.",
    )
    parser.add_argument("first", type=int, nargs="?", default=0, help="first seed")
    parser.add_argument("last", type=int, nargs="?", default=100, help="seed after the last")
    parser.add_argument("--again", action="store_true", help="repeat runs to an accuracy")
    parser.add_argument("--folder", type=Path, default=Path("results/accuracy"))
    options = parser.parse_args(words)
    options.folder.mkdir(parents=True, exist_ok=True)
    results = []
    for seed in range(options.first, options.last):
        path = options.folder / f"{seed}.json"
        if options.again or not path.exists():
            path.write_text(json.dumps(measure(make(seed), options.folder), indent=1))
        results.append(scene := json.loads(path.read_text()))
        for run in scene["runs"]:
            print(line(scene, run), flush=True)
    print(summary(results))
    return 0


if __name__ == "__main__":
    sys.exit(main())
