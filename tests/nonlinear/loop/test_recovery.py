"""The loop within a run: what it costs, how it recovers, how it gives up."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.nonlinear import Outcome
from ancfsparse.nonlinear.methods import UPDATES
from ancfsparse.problems import pendulum
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.system import System

STEPS, DT = 200, 5e-4


def counts_of(solver, tolerance="paper", dt=DT, steps=STEPS, **options):
    """Counts by name, of which the statistics of a run are a part."""
    system = System(pendulum("l2t2", **options).scene)
    march, iteration, *_ = prepare_implicit(system, dt, ancf.Newmark(), solver, tolerance, math.inf)
    saved = [np.zeros((steps + 1, system.n_all)) for _ in range(3)]
    saved.append(np.zeros((steps + 1, system.n_multipliers)))
    taken, outcome = march.advance(iteration, steps, np.zeros((steps, 0)), 1, 0, *saved)
    assert (taken, outcome) == (steps, Outcome.CONVERGED)
    return iteration.counts, system.n_free + system.n_multipliers


@pytest.mark.parametrize(
    "solver",
    [
        ancf.Newton(),
        ancf.ModifiedNewton(),
        *map(ancf.QuasiNewton, UPDATES),
        ancf.QuasiNewton("broyden", 10),
        ancf.QuasiNewton("davidon", 10, carry=True),
        ancf.QuasiNewton("davidon", seed="finite-difference"),
    ],
    ids=str,
)
def test_one_residual_more_than_corrections_in_each_step(solver):
    for constraint in (False, True):
        counts, _ = counts_of(solver, as_constraint=constraint)
        assert counts["recoveries_reseed"] == counts["recoveries_newton"] == 0
        assert counts["residual_evaluations"] == counts["iterations"] + STEPS


def test_newton_factors_once_for_each_correction():
    # At the predictor if that is not good enough, then at each iterate that is not.
    counts, _ = counts_of(ancf.Newton())
    assert counts["factorizations"] == counts["solves"] == counts["iterations"]
    # Judged by corrections, a step ends with one and needs no residual after it.
    counts, _ = counts_of(ancf.Newton(), 1e-3)
    assert counts["factorizations"] == counts["solves"] == counts["iterations"]
    assert counts["residual_evaluations"] == counts["iterations"]


@pytest.mark.parametrize("update", UPDATES)
def test_full_memory_factors_once(update):
    counts, n = counts_of(ancf.QuasiNewton(update))
    assert counts["factorizations"] == 1
    # n to fill the inverse; in each step one product at the predictor, one in each lesson.
    assert counts["solves"] == n + STEPS + counts["iterations"]
    # Judged by corrections too, the residual that makes a small one believed is learned from.
    counts, n = counts_of(ancf.QuasiNewton(update), 1e-3)
    assert counts["residual_evaluations"] == counts["iterations"] + STEPS
    assert counts["solves"] == n + STEPS + counts["iterations"]


@pytest.mark.parametrize("update", UPDATES)
def test_a_finite_difference_seed_needs_no_tangent(update):
    counts, _ = counts_of(ancf.QuasiNewton(update, seed="finite-difference"))
    assert counts["factorizations"] == 0
    assert counts["solves"] == STEPS + counts["iterations"]


@pytest.mark.parametrize(
    "solver",
    [ancf.ModifiedNewton(), *(ancf.QuasiNewton(update, 10) for update in UPDATES)],
    ids=str,
)
def test_every_new_seed_has_its_reason(solver):
    counts, _ = counts_of(solver, steps=400, dt=2e-3)
    reasons = 1 + counts["reseeds_between"] + counts["reseeds_inside"]
    due_at_the_end = reasons - counts["factorizations"]
    assert due_at_the_end in (0, 1)
    # All but Davidon's correct once more by the residual that ended the step.
    last = 0 if solver == ancf.QuasiNewton("davidon", 10) else 400
    assert counts["solves"] == counts["iterations"] + last


def test_statistics_are_the_counts():
    scene, _ = pendulum("l2t2")
    run = ancf.simulate(scene, STEPS * DT, DT, solver=ancf.Newton(), tolerance="paper")
    counts, _ = counts_of(ancf.Newton())
    for name in ("iterations", "residual_evaluations", "factorizations", "solves", "skipped_pairs"):
        assert getattr(run.stats, name) == counts[name]
    assert run.stats.steps == STEPS
    assert run.stats.iterations_per_step == counts["iterations"] / STEPS
    assert run.stats.recoveries == 0


@pytest.mark.parametrize("tolerance", ["paper", "default"])
@pytest.mark.parametrize("update", ["davidon", "bfgs"])
def test_a_step_far_too_large_recovers(update, tolerance):
    # At 0.02 s quasi-Newton on an old seed is lost, while Newton needs five corrections: the ladder
    # must find what Newton finds.
    scene, rod = pendulum("l2t2")
    path = ancf.simulate(scene, 0.8, 0.02, solver=ancf.Newton(), tolerance=tolerance)
    run = ancf.simulate(scene, 0.8, 0.02, solver=ancf.QuasiNewton(update), tolerance=tolerance)
    assert run.stats.recoveries > 0
    apart = np.abs(run.position(rod.end) - path.position(rod.end)).max()
    assert apart < (1e-6 if tolerance == "paper" else 1e-3)


@pytest.mark.parametrize(
    "solver", [ancf.Newton(), ancf.QuasiNewton("davidon", max_iterations=7)], ids=str
)
def test_a_hopeless_step_says_where_and_keeps_what_was(solver):
    scene, rod = pendulum("l2t2")
    with pytest.raises(ancf.StepError) as caught:
        ancf.simulate(scene, 2.0, 0.05, solver=solver, tolerance="paper", max_energy_gain=math.inf)
    failure = caught.value
    assert failure.dt == 0.05
    assert failure.time == pytest.approx(failure.step * 0.05)
    path = failure.trajectory
    assert len(path.t) == failure.step == path.stats.steps + 1
    assert path.t[-1] == pytest.approx((failure.step - 1) * 0.05)
    assert np.isfinite(path.position(rod.end)).all()
    # The states kept are those of a run that stops in time.
    short = ancf.simulate(
        scene, path.t[-1], 0.05, solver=solver, tolerance="paper", max_energy_gain=math.inf
    )
    np.testing.assert_array_equal(path.q, short.q)
    # Above the paper's tolerance, at a coordinate that exists.
    assert abs(failure.residual) > 1e-6
    beam, node, coordinate = failure.where.split(", ")
    assert beam == rod.name
    assert node.startswith("node ")
    assert 0 <= int(node[5:]) <= rod.n_elements
    assert coordinate in ("r_1", "r_2", "r_x1", "r_x2")
    for part in (f"step {failure.step} ", "t = ", "dt = 0.05 s", failure.where, "smaller dt"):
        assert part in str(failure)


def test_a_failure_in_a_constraint_names_the_joint():
    scene, rod = pendulum("l2t2", n_elements=2)
    scene.rod(rod.end, (2.0, 1.0))
    with pytest.raises(ancf.StepError) as caught:
        ancf.simulate(scene, 40.0, 2.0, solver=ancf.Newton(max_iterations=1), tolerance="paper")
    failure = caught.value
    assert failure.where.startswith((rod.name, "rod at"))
    assert failure.trajectory.lam.shape == (failure.step, 1)


def test_saving_seldom_keeps_the_last_state_before_a_failure():
    scene, _ = pendulum("l2t2")
    with pytest.raises(ancf.StepError) as caught:
        ancf.simulate(
            scene, 2.0, 0.05, solver=ancf.Newton(), tolerance="paper", save_every=4,
            max_energy_gain=math.inf,
        )  # fmt: skip
    path = caught.value.trajectory
    last = caught.value.step - 1
    steps = [*range(0, last + 1, 4)]
    steps += [last] * (steps[-1] != last)
    np.testing.assert_allclose(path.t, 0.05 * np.array(steps))


def test_skipped_pairs_are_counted():
    # Below rounding there is nothing left to learn from.
    scene, _ = pendulum("l2t2")
    run = ancf.simulate(scene, 0.2, 5e-4, solver=ancf.QuasiNewton("bfgs"), tolerance=1e-9)
    assert run.stats.skipped_pairs > 0
    run = ancf.simulate(scene, 0.2, 5e-4, solver=ancf.QuasiNewton("bfgs"), tolerance="paper")
    assert run.stats.skipped_pairs == 0
