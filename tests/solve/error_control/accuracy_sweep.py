"""Errors and costs of runs to an accuracy on scenes drawn at random: ``make accuracy``.

Each scene leaves a reference, the errors and costs of fixed steps, and a file of its results in
``results/accuracy``, so that a sweep that was interrupted goes on where it was; ``--again`` repeats
the runs to an accuracy alone.  Kinds of scenes take turns, so any first few are a fair sample.
"""

import argparse
import contextlib
import json
import math
import signal
import sys
from pathlib import Path

import numpy as np

import ancfsparse as ancf
from ancfsparse.system import System
from tests.solve.error_control.accuracy_scenes import SAVED, distance, make, positions, reference

ACCURACIES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)  # [m]
# Longest time of a processor for a reference [s].
LONGEST = 120.0
# Forces of a fixed run beyond which nothing is compared with it.
DEAREST = 150_000


def cost(stats):
    """Residuals, and factors at four of them with their solution: about what `Costs` says here."""
    return stats.residual_evaluations + 4 * stats.factorizations


def fixed_steps(case, exact):
    """Give name, cost and error of fixed steps by the integrators of the package."""
    system = System(case.scene)

    def run(integrator, steps, **options):
        steps = SAVED * math.ceil(steps / SAVED)
        try:
            found = ancf.simulate(
                case.scene, case.t_end, case.t_end / steps, integrator=integrator,
                save_every=steps // SAVED, max_energy_gain=math.inf, **options,
            )  # fmt: skip
        except (ancf.StepError, ancf.InputError):
            return repr(integrator), math.inf, math.inf
        return repr(integrator), cost(found.stats), distance(positions(system, found.q), exact)

    explicit = [ancf.DormandPrince()]
    if not system.damped and not system.n_multipliers:
        explicit += [ancf.CentralDifference(), *(ancf.RungeKuttaNystrom(k) for k in (4, 8))]
    for integrator in explicit:
        limit = ancf.stable_step(case.scene, integrator)
        for finer in (1.0001, 1.1, 1.3, 1.6, 2, 2.5, 3.2, 4, 5, 6.3, 8):
            steps = case.t_end / limit * finer
            if steps * integrator.tableau.forces > DEAREST:
                break
            yield (found := run(integrator, steps))
            if found[2] < ACCURACIES[-1]:
                break
    for integrator in (ancf.GeneralizedAlpha(0.9), ancf.Newmark(0.0)):
        if system.n_multipliers and integrator == ancf.Newmark(0.0):
            continue
        steps = SAVED
        while steps < 60_000:
            yield (found := run(integrator, steps, tolerance="default" if steps < 3000 else 1e-4))
            if found[2] < ACCURACIES[-1]:
                break
            steps = math.ceil(1.6 * steps)


class TooLongError(Exception):
    """A reference takes longer than it may."""


@contextlib.contextmanager
def at_most(seconds):
    """End what takes longer on the processor."""

    def end(*_):
        raise TooLongError

    before = signal.signal(signal.SIGVTALRM, end)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def known(case, folder):
    """Return positions at the saved times and how far they may be off [m]."""
    path = folder / f"{case.seed}.npz"
    if not path.exists():
        with at_most(LONGEST):
            exact, uncertain = reference(case)
        np.savez(path, exact=exact, uncertain=uncertain)
    with np.load(path) as found:
        return found["exact"], float(found["uncertain"])


def known_fixed_steps(case, exact, folder):
    """Return names, costs and errors of fixed steps."""
    path = folder / f"{case.seed}-fixed.json"
    if not path.exists():
        path.write_text(json.dumps(list(fixed_steps(case, exact))))
    return json.loads(path.read_text())


def measured(case, folder):
    """Return the results of a scene, made of lists and numbers."""
    try:
        exact, uncertain = known(case, folder)
    except TooLongError:
        return {"seed": case.seed, "kind": case.kind, "skipped": True, "runs": []}
    swept, runs = known_fixed_steps(case, exact, folder), []
    for accuracy in ACCURACIES:
        try:
            run = ancf.simulate(case.scene, case.t_end, case.t_end / SAVED, accuracy=accuracy)
        except ancf.AncfError as error:
            runs.append({"accuracy": accuracy, "failed": str(error)})
            continue
        off = max(distance(positions(run.system, run.q), exact) - uncertain, 0.0)
        enough = [(spent, name) for name, spent, error in swept if error <= accuracy]
        least, best = min(enough, default=(None, None))
        runs.append(
            {
                "accuracy": accuracy,
                "error": off / accuracy,
                "estimate": run.stats.error / accuracy,
                "cost": cost(run.stats),
                "runs": run.stats.runs,
                "least": least,
                "best": best,
                "solver": run.stats.solver,
            }
        )
    return {"seed": case.seed, "kind": case.kind, "uncertain": uncertain, "runs": runs}


def line(found, run):
    """Say in one line how a run went."""
    name = f"{found['seed']:3d} {found['kind']:16s} {run['accuracy']:.0e} m"
    if "failed" in run:
        return f"{name}: {run['failed']}"
    words = "no fixed step is as exact"
    if run["least"] is not None:
        words = f"cost {run['cost'] / run['least']:.2f} times that of {run['best']}"
    return (
        f"{name}: error {run['error']:.2g}, estimate {run['estimate']:.2g} of it, {words}; "
        f"{run['solver']}"
    )


def summary(results):
    """Say in a few lines how all runs went."""
    runs = [run for found in results for run in found["runs"]]
    done = [run for run in runs if "failed" not in run]
    if not done:
        return "no runs"
    errors = np.array([run["error"] for run in done])
    ratios = np.array([run["cost"] / run["least"] for run in done if run["least"] is not None])
    skipped = sum("skipped" in found for found in results)
    return (
        f"{len(results)} scenes, {skipped} skipped, {len(done)} runs, "
        f"{len(runs) - len(done)} failed\n"
        f"error over accuracy: largest {errors.max():.2f}, at most 1 in "
        f"{100 * np.mean(errors <= 1):.1f} %\n"
        f"cost over that of the cheapest fixed step, where one is known ({len(ratios)} runs): "
        f"median {np.median(ratios):.2f}, largest {ratios.max():.2f}, at most 3 in "
        f"{100 * np.mean(ratios <= 3):.1f} %"
    )


def main(words=None):
    parser = argparse.ArgumentParser(prog="make accuracy", description=__doc__.split("\n")[0])
    parser.add_argument("first", type=int, nargs="?", default=0, help="first seed")
    parser.add_argument("last", type=int, nargs="?", default=100, help="seed after the last")
    parser.add_argument("--again", action="store_true", help="repeat runs to an accuracy")
    parser.add_argument("--folder", type=Path, default=Path("results/accuracy"))
    given = parser.parse_args(words)
    given.folder.mkdir(parents=True, exist_ok=True)
    results = []
    for seed in range(given.first, given.last):
        path = given.folder / f"{seed}.json"
        if given.again or not path.exists():
            path.write_text(json.dumps(measured(make(seed), given.folder), indent=1))
        found = json.loads(path.read_text())
        results.append(found)
        for run in found["runs"]:
            print(line(found, run), flush=True)
    print(summary(results))
    return 0


if __name__ == "__main__":
    sys.exit(main())
