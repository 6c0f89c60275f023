"""``solver="auto"`` costs at most 1.2 times the best method, by counts, on all named mechanisms."""

import warnings

import pytest

import ancfsparse as ancf
from ancfsparse.problems.named import MECHANISMS
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.stepping.implicit_setup import iteration_costs

NAMES = (
    "planar_rod", "spatial_pendulum", "heavy_top", "dzhanibekov", "four_bar", "slider_crank",
    "n_four_bar", "andrews", "bricard", "spin_up", "elastic_slider_crank", "double_pendulum_bob",
    "elastic_four_bar", "spaghetti", "moving_supports",
)  # fmt: skip
UPDATES = "broyden", "davidon", "dfp", "bfgs"
FIXED = {
    "newton": ancf.Newton(),
    "modified": ancf.ModifiedNewton(),
    **{f"{update}, 10 pairs": ancf.QuasiNewton(update, 10) for update in UPDATES},
    **{update: ancf.QuasiNewton(update) for update in UPDATES},
}
STEPS, WORST = 300, 1.2
# In the unit of `Costs`, from processor times of six of these scenes by five methods, which these
# weights give to 25 % in each scene: what an evaluation takes besides its elements, and a product
# with a dense inverse and its update for each number.
CALL = 170.0
DENSE = {"davidon": 0.1, "dfp": 0.13, "bfgs": 0.13, "broyden": 0.2}


def work(run, integrator):
    """Return what a run has cost, in the unit of `Costs`."""
    system, stats = run.system, run.stats
    seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
    price = iteration_costs(system, integrator, seed, None)
    total = (price.residual + CALL) * stats.residual_evaluations
    total += price.factor * stats.factorizations
    if "full memory" not in stats.solver:
        return total + price.solve * stats.solves
    number = next(weight for update, weight in DENSE.items() if update in stats.solver)
    first = seed.n * stats.factorizations  # solves for the columns of an inverse
    return total + price.solve * first + number * seed.n**2 * (stats.solves - first)


@pytest.mark.parametrize("finer", [2, 1])
@pytest.mark.parametrize("name", NAMES)
def test_auto_costs_little_more_than_the_best_method(name, finer):
    case = MECHANISMS[name]
    problem, dt = case.make(), case.dt / finer
    found = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ancf.RedundantConstraintsWarning)
        start = ancf.solve_static(problem.scene) if problem.settles else None
        for label, solver in {"auto": "auto", **FIXED}.items():
            run = ancf.simulate(
                problem.scene, STEPS * dt, dt, integrator=case.integrator, solver=solver,
                start=start, save_every=STEPS,
            )  # fmt: skip
            assert run.t[-1] == pytest.approx(STEPS * dt), label
            found[label] = work(run, case.integrator)
    best = min(FIXED, key=found.get)
    assert found["auto"] <= WORST * found[best], best
