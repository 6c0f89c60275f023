"""The error of the mesh of equilibria by corrections on finer ones, beside the truth."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.discretization_error import mesh_error
from ancfsparse.plans.discretization_error.residual_correction import (
    corrections,
    estimate_from_corrections,
)
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.selection import confirmation_run
from benchmarks.adjoints import estimates as adjoints
from tests.plans.comparison import build_trials
from tests.plans.models.test_auto_meshes import hammock


def changes(make, counts):
    scene, node = make("auto")
    trials = build_trials(scene, None, ancf.static_deflection(node), "1 %")
    name = scene.beams[0].name
    return [corrections(trials, trials.run(Model(counts={name: n}), 1)) for n in counts]


@pytest.mark.parametrize("count", [8, 12, 20])
def test_one_trial_run_shows_its_error(count):
    ((change,),) = changes(adjoints.clamped, [count])
    true, by_adjoint, *_ = adjoints.compare_equilibrium(adjoints.clamped, count)
    error = estimate_from_corrections([count], [change], 4).at(count)
    assert 0.9 < error / true < 1.1
    # A residual weighted by the adjoint solution, which is not a part of the package.
    assert error == pytest.approx(by_adjoint, rel=0.1)


def test_two_trial_runs_show_the_order():
    counts = [16, 24]
    (one,), (other,) = changes(adjoints.clamped, counts)
    error_model = estimate_from_corrections(counts, [one, other], 4)
    assert error_model.is_asymptotic
    assert error_model.order == pytest.approx(4.0, abs=0.2)
    # An error of order 2 where 4 is known: 3 C / 4 n^2 is the change.
    slow = estimate_from_corrections([8, 16], [0.75 / 64.0, 0.75 / 256.0], 4)
    assert not slow.is_asymptotic
    assert slow.at(32) == pytest.approx(1.0 / 1024.0)
    # An order that no element has shows that the error changes its sign.
    hidden = estimate_from_corrections([8, 16], [1.0, 1e-6], 2)
    assert not hidden.is_asymptotic
    assert hidden.error > 0.02


def test_corrections_that_do_not_show_the_error_are_not_believed():
    scene, net = hammock("thin", "auto")
    trials = build_trials(scene, None, ancf.static_deflection(net.node(5)), "1 %")
    assert corrections(trials, trials.run(Model(counts={net.name: 2}), 1)) is None

    # A rod that droops by its length: on eight elements forces are far from linear.
    rough, fine = changes(adjoints.droop, [8, 40])
    assert rough is None
    assert fine is not None


def test_plans_of_equilibria_need_one_trial_run_and_predict_the_error(monkeypatch):
    scene, node = adjoints.clamped("auto")
    quantity = ancf.static_deflection(node)
    exact_scene, its = adjoints.clamped(256)
    exact = ancf.solve_static(exact_scene).position(its)
    for error, runs in (("1 %", 1), ("0.1 %", 3), ("0.01 %", 4)):
        plan = ancf.plan(scene, quantity=quantity, error=error)
        true = np.linalg.norm(plan.run().position(node)[-1] - exact)
        assert plan.cost["runs"] <= runs
        assert true <= plan.predictions[0].tolerance
        assert 0.9 < plan.error / true < 1.2
    plan = ancf.plan(scene, quantity=quantity, error="1 %")
    for room in (mesh_error, confirmation_run):
        monkeypatch.setattr(room, "corrected_estimates", lambda *args: None)
    other = ancf.plan(scene, quantity=quantity, error="1 %")
    assert plan.cost["runs"] < other.cost["runs"]
    assert plan.cost["operations"] < 0.9 * other.cost["operations"]
