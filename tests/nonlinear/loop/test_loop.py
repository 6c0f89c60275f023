"""The compiled loop on equations that can be worked out by hand."""

import numpy as np
import pytest

from ancfsparse.nonlinear import Outcome
from tests.nonlinear.formulas import UPDATES
from tests.nonlinear.loop.handmade import Equations, spring

TARGET = np.array([0.7, -0.4, 1.1])
STIFF = np.array([[4.0, 1.0, 0.0], [1.0, 3.0, -1.0], [0.0, -1.0, 5.0]])


def cubic(x):
    """Gradient of a convex function, zero at TARGET."""
    return STIFF @ (x - TARGET) + x**3 - TARGET**3


def cubic_jacobian(x):
    return STIFF + np.diag(3 * x**2)


def mild(start=(0.0, 0.0, 0.0)):
    return Equations(cubic, cubic_jacobian, start)


def test_newton_is_newton():
    equations = mild()
    x = np.zeros(3)
    steps = 0
    while np.abs(cubic(x)).max() >= 1e-10:
        x = x - np.linalg.solve(cubic_jacobian(x), cubic(x))
        steps += 1
    loop = equations.loop()
    assert loop.solve() == Outcome.CONVERGED
    np.testing.assert_allclose(equations.x, x, rtol=0, atol=1e-14)
    counts = loop.counts
    # A factor for the predictor and for each iterate that is not yet good enough.
    assert counts["iterations"] == counts["factorizations"] == counts["solves"] == steps
    assert counts["residual_evaluations"] == steps + 1
    assert equations.calls("correct") == steps
    assert equations.calls("matrix") == steps
    assert equations.calls("residual") == steps + 1


@pytest.mark.parametrize("memory", ["dense", "limited"])
@pytest.mark.parametrize("rule", UPDATES)
def test_quasi_newton_is_the_papers_algorithm(rule, memory):
    equations = mild()
    inverse = equations.dense(rule) if memory == "dense" else equations.limited(rule, 20)
    loop = equations.loop(inverse)
    assert loop.solve() == Outcome.CONVERGED
    x, h, r = np.zeros(3), np.linalg.inv(cubic_jacobian(np.zeros(3))), cubic(np.zeros(3))
    steps = 0
    while np.abs(r).max() >= 1e-10:
        s = -h @ r
        x = x + s
        r_new = cubic(x)
        h, r = UPDATES[rule](h, s, r_new - r), r_new
        steps += 1
    assert loop.counts["iterations"] == steps
    assert loop.counts["residual_evaluations"] == steps + 1
    assert loop.counts["factorizations"] == 1
    np.testing.assert_allclose(equations.x, x, rtol=0, atol=1e-13)


def test_a_predictor_that_is_good_costs_one_residual():
    equations = mild(TARGET)
    loop = equations.loop()
    assert loop.solve() == Outcome.CONVERGED
    assert loop.counts["residual_evaluations"] == 1
    assert loop.counts["iterations"] == loop.counts["factorizations"] == 0
    assert equations.trace == ["restart", "residual"]


def test_the_correction_is_judged_when_asked():
    # A linear problem: one correction is exact, and the loop cannot know without a second.
    equations = Equations(lambda x: STIFF @ (x - TARGET), lambda x: STIFF, np.zeros(3))
    loop = equations.loop(by_correction=True, correction_tolerance=1e-8)
    assert loop.solve() == Outcome.CONVERGED
    assert loop.counts["iterations"] == 2
    # The last correction is not followed by a residual.
    assert equations.trace[-1] == "correct"
    assert loop.counts["residual_evaluations"] == 2


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_the_judged_correction_bounds_the_error(tolerance):
    for rule in UPDATES:
        equations = mild()
        loop = equations.loop(equations.limited(rule, 10), by_correction=True,
                              correction_tolerance=tolerance)  # fmt: skip
        assert loop.solve() == Outcome.CONVERGED
        assert np.sqrt(np.mean((equations.x - TARGET) ** 2)) <= tolerance


def test_constraints_are_judged_apart():
    # x = (q, lam): a stiff coordinate and a constraint in other units.
    def residual(x):
        return np.array([1e6 * (x[0] - 1.0) + x[1], x[0] - 1.0])

    jacobian = np.array([[1e6, 1.0], [1.0, 0.0]])
    loose = Equations(residual, lambda x: jacobian, [1.0 + 1e-3, -1e3], n_multipliers=1)
    # At the predictor the force is in balance, the constraint is 1e-3 off.
    assert np.abs(residual(loose.start)).max() == pytest.approx(1e-3)
    loop = loose.loop(force_tolerance=1.0, constraint_tolerance=1e-2)
    assert loop.solve() == Outcome.CONVERGED
    assert loop.counts["iterations"] == 0
    tight = Equations(residual, lambda x: jacobian, loose.start, n_multipliers=1)
    loop = tight.loop(force_tolerance=1.0, constraint_tolerance=1e-6)
    assert loop.solve() == Outcome.CONVERGED
    assert loop.counts["iterations"] == 1
    assert abs(tight.x[0] - 1.0) < 1e-6


def test_not_a_number_ends_in_a_reason():
    equations = Equations(lambda x: np.full(3, np.nan), cubic_jacobian, np.zeros(3))
    assert equations.loop().solve() == Outcome.NOT_FINITE
    equations = Equations(
        lambda x: x + np.where(x > 0.5, np.inf, -1.0), lambda x: np.eye(3), [0.0] * 3
    )
    assert equations.loop().solve() == Outcome.NOT_FINITE


def test_too_few_iterations_end_in_a_reason():
    equations = mild()
    loop = equations.loop(max_iterations=1)
    assert loop.solve() == Outcome.TOO_MANY
    # Newton, then damped Newton from the predictor again: one correction each, and at last four.
    assert loop.counts["iterations"] == 6
    loop.halves = True  # the step will be divided
    assert loop.solve() == Outcome.TOO_MANY
    assert loop.counts["iterations"] == 6 + 2
    assert loop.counts["recoveries_newton"] == 0


def test_divergence_ends_in_a_reason_and_is_noticed_early():
    # No root and a wrong Jacobian: whole corrections of the chord method square the residual.
    counts = []
    for most in (25, 100):
        equations = Equations(lambda x: 1.0 + x**2, lambda x: 1e-2 * np.eye(1), np.zeros(1))
        loop = equations.loop(equations.limited("broyden", 0), max_iterations=most)
        assert loop.solve() == Outcome.DIVERGED
        counts.append(loop.counts["iterations"])
    assert counts[0] == counts[1] < 25  # all attempts together


@pytest.mark.parametrize("by_correction", [False, True])
@pytest.mark.parametrize("n_multipliers", [0, 1])
def test_damped_newton_recovers_what_newton_loses(n_multipliers, by_correction):
    # From 2, Newton on arctan jumps ever further out; halving its first step brings it home.
    # The second unknown is along for the ride, as a coordinate or as a multiplier.
    sign = -1.0 if n_multipliers else 1.0

    def residual(x):
        return np.array([np.arctan(x[0]), sign * (x[1] - 1.0)])

    equations = Equations(
        residual, lambda x: np.diag([1 / (1 + x[0] ** 2), sign]), [2.0, 1.0], n_multipliers
    )
    loop = equations.loop(max_iterations=8, by_correction=by_correction)
    assert loop.solve() == Outcome.CONVERGED
    assert abs(equations.x[0]) < 1e-10
    assert loop.counts["recoveries_newton"] == 1
    assert equations.calls("restart") == 2


def test_a_new_seed_recovers_what_an_old_one_loses():
    # The stiffness jumps by a factor between two solves: the old seed then overshoots.
    stiffness = [1.0]
    equations = spring(stiffness, 2)
    loop = equations.loop(equations.limited("broyden", 0))  # the chord method cannot learn
    assert loop.solve() == Outcome.CONVERGED
    assert loop.counts["factorizations"] == 1
    stiffness[0] = 30.0
    assert loop.solve() == Outcome.CONVERGED
    np.testing.assert_allclose(equations.x, 1.0, atol=1e-10)
    assert loop.counts["recoveries_reseed"] == 1
    assert loop.counts["recoveries_newton"] == 0
    assert loop.counts["factorizations"] == 2


def test_the_seed_outlives_a_step_and_pairs_do_so_when_carried():
    for carry in (False, True):
        equations = mild()
        loop = equations.loop(equations.limited("davidon", 20), carry=carry)
        assert loop.solve() == Outcome.CONVERGED
        first = loop.counts["iterations"]
        assert loop.solve() == Outcome.CONVERGED
        assert loop.counts["factorizations"] == 1
        # The same equations again: what was learned makes the second time shorter.
        second = loop.counts["iterations"] - first
        assert second < first if carry else second == first


def test_newton_forgets_nothing_because_it_learns_nothing():
    equations = mild()
    loop = equations.loop()
    assert loop.solve() == Outcome.CONVERGED
    first = dict(loop.counts)
    assert loop.solve() == Outcome.CONVERGED
    assert loop.counts == {key: 2 * value for key, value in first.items()}


def test_wrong_pivots_are_counted():
    jacobian = np.diag([1.0, -2.0, 3.0])
    equations = Equations(lambda x: jacobian @ (x - TARGET), lambda x: jacobian, np.zeros(3))
    loop = equations.loop()
    # The factor of an indefinite matrix is still its factor: Newton arrives.
    assert loop.solve() == Outcome.CONVERGED
    assert loop.counts["indefinite"] == 1
    np.testing.assert_allclose(equations.x, TARGET, atol=1e-12)


def test_a_singular_matrix_is_no_convergence():
    equations = Equations(
        lambda x: np.array([x[0] - 1.0, 1.0]), lambda x: np.diag([1.0, 0.0]), [0, 0]
    )
    for loop in (equations.loop(), equations.loop(equations.dense("davidon"))):
        assert loop.solve() == Outcome.DIVERGED


def test_the_economical_rule_renews_a_seed_when_waiting_costs_more():
    # Contraction 0.97 with the first seed: hundreds of corrections against one factor.
    stiffness = [1.0]
    equations = spring(stiffness, 2)
    loop = equations.loop(equations.limited("broyden", 0), economical=True)
    assert loop.solve() == Outcome.CONVERGED
    stiffness[0] = 0.03
    assert loop.solve() == Outcome.CONVERGED
    assert loop.counts["reseeds_inside"] == 1
    assert loop.counts["recoveries_reseed"] == 0
    assert loop.counts["factorizations"] == 2
    assert loop.counts["iterations"] == 3


@pytest.mark.parametrize(
    ("measured", "sudden", "is_enough"),
    [(2.0, 0, True), (1e-3, 0, False), (0.0, 0, False), (2.0, 1, False)],
)
def test_a_contraction_holds_for_the_corrections_that_it_was_measured_for(
    measured, sudden, is_enough
):
    # The first correction is 1.1 long; at a contraction of 1e-4 it would leave 1e-4.
    equations = mild()
    equations.interface.sudden = sudden
    loop = equations.loop(by_correction=True, correction_tolerance=2e-4)
    loop.rate, loop.measured = 1e-4, measured
    assert loop.solve() == Outcome.CONVERGED
    assert (loop.counts["iterations"] == 1) == is_enough
    assert (np.abs(equations.x - TARGET).max() < 2e-4) != is_enough
