"""Each estimate alone, beside the truth: the error of steps, of the mesh, and the cost."""

import pytest

import ancfsparse as ancf
from ancfsparse.plans.discretization_error.mesh_error import mesh_error
from ancfsparse.plans.discretization_error.refinement import refine_steps
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.trial_runs import cost_model
from ancfsparse.plans.trial_runs.run_differences import goal_differences
from ancfsparse.problems import pendulum
from tests.plans.comparison import build_trials

T_END, STEPS, MESH = 1.0, 400, 8


@pytest.fixture(scope="module")
def trials():
    scene, rod = pendulum("thin", "auto")
    return build_trials(scene, T_END, ancf.position(rod.end), 1e-3, base=50)


def model(count):
    return Model(counts={"beam 0": count})


def test_the_error_of_steps_agrees_with_many_steps(trials):
    error_model = refine_steps(trials, [trials.run(model(MESH), trials.base)])
    exact = trials.run(model(MESH), trials.base << 8)
    for run in error_model.runs[-2:]:
        (true,) = goal_differences(trials.goals, run, exact)
        assert error_model.estimates[0].at(run.steps) == pytest.approx(true, rel=0.6)


def test_the_error_of_the_mesh_agrees_with_a_fine_mesh(trials):
    error_model = mesh_error(trials, Model(), float(MESH), STEPS, 4, lambda last: True)
    exact = trials.run(model(64), STEPS)
    for count in (16, 24):
        (true,) = goal_differences(trials.goals, trials.run(model(count), STEPS), exact)
        assert true / 2.0 < error_model.estimates[0].at(count) < 5.0 * true


def test_errors_of_strains_are_not_hidden_by_elements_of_different_lengths():
    """Strains at nodes have an error by their difference, opposite to that of bending: 8.6 times.

    Axial strains of a bent cantilever are of second order in its deflection.
    """
    length, force = 0.6685, ancf.Ramp((0.0, -1.745e-3), 0.082)
    material = ancf.Material(1.122e11, 1226.6, axial_damping=1e-3, bending_damping=1e-3)
    scene = ancf.Scene(gravity=(0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (length, 0), "auto", ancf.Circle(1.5425e-3), material)
    scene.clamp(rod.start)
    scene.point_force(rod.at(0.1339), force)
    trials = build_trials(scene, 0.1513, ancf.strain(rod.at(0.4723)), "0.575 %")
    error_model = mesh_error(trials, Model(), 8.0, 100, 4, lambda last: True)
    last = error_model.runs[-1]
    exact = trials.run(trials.with_mesh(Model(), 400), 100)
    (true,) = goal_differences(trials.goals, last, exact)
    assert 0.2 * error_model.estimates[0].error < true < 1.2 * error_model.estimates[0].error


def test_the_work_of_a_longer_run_on_a_finer_mesh_is_foreseen(trials):
    for count, steps in ((MESH, 100), (MESH, 200), (MESH, 400), (12, 200)):
        trials.run(model(count), steps)
    known = [run for run in trials.costs if run.steps <= STEPS and run.coordinates < 60]
    larger = trials.run(model(32), 1600).cost
    foreseen = cost_model.fit_cost_model(known).work(larger.steps, larger.coordinates)
    # Longer steps take more iterations: work for each step is at most that of the pilots.
    assert 0.7 < foreseen / larger.work < 3.0
    assert cost_model.fit_cost_model(known).seconds(1600, 132) > 0.0
