"""Quasi-Newton methods complete every named scene that Newton's method completes."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems.named import MECHANISMS
from ancfsparse.system import System

UPDATES = "broyden", "davidon", "dfp", "bfgs"
LIMITED = {
    "auto": "auto",
    "modified": ancf.ModifiedNewton(),
    **{f"{update}, 10 pairs": ancf.QuasiNewton(update, 10) for update in UPDATES},
}
# Their dense inverse takes minutes beyond a thousand unknowns.
DENSE = {update: ancf.QuasiNewton(update) for update in UPDATES}
MOST = 1000
STEPS = 200
LARGE = 500  # coordinates from which half as many steps are taken
# Longer than the steps that give the digits of the table, for all.
COARSER = 2.0


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ancfsparse.RedundantConstraintsWarning")
@pytest.mark.parametrize("name", MECHANISMS)
def test_all_methods_complete_what_newton_completes(name):
    case = MECHANISMS[name]
    problem, dt = case.make(), COARSER * case.dt
    start = ancf.solve_static(problem.scene) if problem.settles else None
    n = System(problem.scene).n_all
    steps = STEPS if n < LARGE else STEPS // 2

    def run_by(solver):
        return ancf.simulate(
            problem.scene, steps * dt, dt, integrator=case.integrator, solver=solver, start=start,
            save_every=steps,
        )  # fmt: skip

    newton = run_by(ancf.Newton())
    size = np.abs(newton.q).max()
    methods = LIMITED | (DENSE if n < MOST else {})
    for label, solver in methods.items():
        run = run_by(solver)
        assert run.t[-1] == newton.t[-1], label
        # At the default tolerance of the iteration.
        assert np.abs(run.q[-1] - newton.q[-1]).max() < 1e-3 * size, label
