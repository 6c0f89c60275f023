"""Small rules of the loop, each on equations where it decides."""

import numpy as np
import pytest

from ancfsparse.nonlinear import Outcome
from tests.nonlinear.loop.handmade import Equations, nonlinear_of, spring


def test_a_damped_step_is_halved_more_than_once():
    # From 3, Newton's step on arctan leads to -9.5, half of it to -3.2, a quarter to -0.1.
    equations = Equations(np.arctan, lambda x: np.diag(1.0 / (1.0 + x**2)), [3.0])
    loop = equations.loop(max_iterations=8)
    assert loop.solve() == Outcome.CONVERGED
    assert abs(equations.x[0]) < 1e-10
    assert loop.counts["recoveries_newton"] == 1


@pytest.mark.parametrize("rule", ["broyden", "dfp", "bfgs"])
def test_the_last_pair_of_a_step_is_carried_to_the_next(rule):
    seen = []

    def residual(x):
        seen.append((x.copy(), np.array([4.0, 3.0]) * (x - 1.0) + 0.3 * x**3))
        return seen[-1][1]

    equations = Equations(residual, lambda x: np.diag([5.0, 5.0]), np.zeros(2))
    inverse = equations.limited(rule, 20)
    assert equations.loop(inverse, carry=True, force_tolerance=1e-5).solve() == Outcome.CONVERGED
    (x0, r0), (x1, r1) = seen[-2:]
    np.testing.assert_allclose(inverse.apply(r1 - r0), x1 - x0, rtol=1e-6)


def test_a_last_correction_that_is_longer_than_the_one_before_is_not_made():
    # The inverse is a million times too large in the second direction, where little is to do; what
    # the first correction leaves there is a tenth of the tolerance, and calls for a last one.
    equations = Equations(
        lambda x: x - np.array([1e-2, 1e-10]), lambda x: np.diag([1.0, 1e-6]), np.zeros(2)
    )
    loop = equations.loop(
        equations.limited("broyden", 0), polishes=True, by_correction=True,
        correction_tolerance=1e-3,
    )  # fmt: skip
    assert loop.solve() == Outcome.CONVERGED
    assert loop.counts["last_corrections"] == 0
    assert abs(equations.x[1]) < 1e-3


@pytest.mark.parametrize(
    "options", [{}, {"sparing": True}, {"learns": False}], ids=["pairs", "sparing", "no pairs"]
)
def test_a_step_that_counts_on_a_last_correction_goes_on_where_it_is_not_made(options):
    # The stiff direction is corrected at once, by 1e-6, and leaves 1e-5 of the first residual of
    # 1e-2 in the soft one: a tenth of that is allowed, and the last correction is 1e-5.
    seen = []

    def residual(x):
        seen.append((x.copy(), np.array([1e4 * (x[0] - 1e-6), x[1] - 10.0 * x[0], x[2]])))
        return seen[-1][1]

    equations = Equations(residual, lambda x: np.diag([1e4, 1.0, 1.0]), np.zeros(3), 1)
    inverse = equations.limited("broyden", 2)
    loop = equations.loop(
        inverse, polishes=True, by_correction=True, correction_tolerance=2e-6, **options
    )
    assert loop.solve() == Outcome.CONVERGED
    assert abs(equations.x[1] - 1e-5) < 2e-6
    if loop.counts["pairs"]:
        (x0, r0), (x1, r1) = seen[:2]
        np.testing.assert_allclose(inverse.apply(r1 - r0), x1 - x0, rtol=1e-6, atol=1e-18)


def test_a_step_is_compared_with_the_mean_since_the_seed_and_its_cost():
    stiffness = [1.0]
    equations = spring(stiffness)
    loop = equations.loop(equations.limited("broyden", 0), economical=True, cost_seed=10.0)
    assert loop.solve() == Outcome.CONVERGED
    stiffness[0] = 1.05  # eight corrections on the old seed, for the ten that it cost
    assert loop.solve() == Outcome.CONVERGED
    assert 5 < loop.counts["iterations"] - 1 < 10
    assert loop.counts["reseeds_between"] == loop.counts["reseeds_inside"] == 0
    stiffness[0] = 1.2  # fifteen
    assert loop.solve() == Outcome.CONVERGED
    assert loop.counts["reseeds_between"] + loop.counts["reseeds_inside"] == 1


@pytest.mark.parametrize(("cost_seed", "renewed"), [(10.0, 1), (100.0, 0)])
def test_a_seed_is_renewed_inside_a_step_where_it_costs_less_than_to_wait(cost_seed, renewed):
    # A contraction by a half: 34 corrections in all, and after two of them 31 are left.
    stiffness = [1.0]
    equations = spring(stiffness)
    loop = equations.loop(
        equations.limited("broyden", 0), economical=True, cost_seed=cost_seed, max_iterations=50
    )
    assert loop.solve() == Outcome.CONVERGED
    stiffness[0] = 1.5
    assert loop.solve() == Outcome.CONVERGED
    assert loop.counts["reseeds_inside"] == renewed


@pytest.mark.parametrize(("cost_seed", "renewed"), [(1.0, 2), (200.0, 1)])
def test_a_step_begins_with_a_new_seed_where_the_last_one_renewed_it_twice(cost_seed, renewed):
    # A hardening spring: from far away, several seeds become outdated on the way to equilibrium.
    equations = Equations(
        lambda x: 50.0 * x**3 + x - 0.1, lambda x: np.diag(150.0 * x**2 + 1.0), [1.0]
    )
    loop = equations.loop(
        equations.limited("broyden", 0), learns=False, economical=True, cost_seed=cost_seed,
        max_iterations=200,
    )  # fmt: skip
    assert loop.solve() == Outcome.CONVERGED
    assert min(loop.counts["reseeds_inside"], 2) == renewed
    before = len(equations.trace)
    assert loop.solve() == Outcome.CONVERGED
    second = equations.trace[before:]
    begins = "matrix" in second[: second.index("correct")]
    assert begins == (renewed > 1)


def test_a_step_that_is_solved_again_counts_for_the_rung_that_solved_it_last():
    stiffness = [1.0]
    equations = spring(stiffness)
    loop = equations.loop(equations.limited("broyden", 0))
    solver = nonlinear_of(loop)
    assert loop.solve() == Outcome.CONVERGED
    stiffness[0] = 30.0
    assert loop.solve() == Outcome.CONVERGED
    assert (loop.counts["recoveries_reseed"], loop.counts["recoveries_newton"]) == (1, 0)
    assert solver.again(solver.context, Outcome.GAINED_ENERGY) == Outcome.CONVERGED
    assert (loop.counts["recoveries_reseed"], loop.counts["recoveries_newton"]) == (0, 1)
