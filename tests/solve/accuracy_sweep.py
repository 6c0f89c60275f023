"""Errors and costs of runs to an accuracy on scenes drawn at random: ``make accuracy``.

usage: python -m tests.solve.accuracy_sweep [first seed] [seed after the last]
"""

from __future__ import annotations

import math
import sys

import numpy as np

import ancfsparse as ancf
from ancfsparse.system import System
from tests.solve.accuracy_scenes import SAVED, distance, make, positions, reference

ACCURACIES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)  # [m]


def cost(stats):
    """Residuals, and factors at four of them with their solution: about what `Costs` says here."""
    return stats.residual_evaluations + 4 * stats.factorizations


def fixed_steps(case, exact):
    """Give cost and error of fixed steps by the integrators of the package, coarse ones first."""
    system = System(case.scene)

    def run(integrator, steps, **options):
        steps = SAVED * math.ceil(steps / SAVED)
        try:
            found = ancf.simulate(
                case.scene, case.t_end, case.t_end / steps, integrator=integrator,
                save_every=steps // SAVED, max_energy_gain=math.inf, **options,
            )  # fmt: skip
        except (ancf.StepFailure, ancf.InputError):
            return math.inf, math.inf
        return cost(found.stats), distance(positions(system, found.q), exact)

    if not system.damped and not system.n_multipliers:
        for order in (2, 4, 8):
            integrator = ancf.RungeKuttaNystrom(order) if order > 2 else ancf.CentralDifference()
            limit = ancf.stable_step(case.scene, integrator)
            for finer in (1.0001, 1.1, 1.3, 1.6, 2, 2.5, 3.2, 4, 5, 6.3, 8):
                spent, error = run(integrator, case.t_end / limit * finer)
                yield spent, error
                if error < ACCURACIES[-1]:
                    break
    for integrator in (ancf.GeneralizedAlpha(0.9), ancf.Newmark(0.0)):
        if system.n_multipliers and integrator == ancf.Newmark(0.0):
            continue
        steps = SAVED
        while steps < 60_000:
            spent, error = run(integrator, steps, tolerance="default" if steps < 3000 else 1e-4)
            yield spent, error
            if error < ACCURACIES[-1]:
                break
            steps = math.ceil(1.6 * steps)


def main(first, last):
    shares, ratios, failed = [], [], 0
    for seed in range(first, last):
        case = make(seed)
        exact, uncertain = reference(case)
        swept = list(fixed_steps(case, exact))
        for accuracy in ACCURACIES:
            name = f"{seed:3d} {case.kind:16s} {accuracy:.0e} m"
            try:
                run = ancf.simulate(case.scene, case.t_end, case.t_end / SAVED, accuracy=accuracy)
            except ancf.AncfError as error:
                failed += 1
                print(f"{name}: {error}", flush=True)
                continue
            share = max(distance(positions(run.system, run.q), exact) - uncertain, 0.0) / accuracy
            least = min((spent for spent, error in swept if error <= accuracy), default=math.nan)
            shares.append(share)
            ratios.append(cost(run.stats) / least)
            print(
                f"{name}: error {share:.2g}, estimate {run.stats.error / accuracy:.2g} of it, "
                f"cost {ratios[-1]:.2f} times the cheapest; {run.stats.solver}",
                flush=True,
            )
    known = np.array(ratios)[np.isfinite(ratios)]
    print(
        f"{last - first} scenes, {len(shares)} runs, {failed} failed\n"
        f"error over accuracy: largest {max(shares):.2f}, at most 1 in "
        f"{100 * np.mean(np.array(shares) <= 1):.1f} %\n"
        f"cost over that of the cheapest fixed step, where one is known ({len(known)} runs): "
        f"median {np.median(known):.2f}, largest {max(known):.2f}, at most 3 in "
        f"{100 * np.mean(known <= 3):.1f} %"
    )


if __name__ == "__main__":
    main(*(int(word) for word in (sys.argv[1:] or ("0", "100"))))
