"""Each estimate alone, beside the truth: the error of steps, of the mesh, and the cost."""

import pytest

import ancfsparse as ancf
from ancfsparse.plans.discretization_error.mesh_error import mesh_error
from ancfsparse.plans.discretization_error.time_error import time_error
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.quantities.functions import checked
from ancfsparse.plans.quantities.tolerances import wanted
from ancfsparse.plans.trial_runs import cost_model
from ancfsparse.plans.trial_runs.trial_runs import Pilots, distances
from ancfsparse.problems import pendulum

T_END, STEPS, MESH = 1.0, 400, 8


@pytest.fixture(scope="module")
def pilots():
    scene, rod = pendulum("thin", "auto")
    asked = wanted(checked(ancf.position(rod.end), scene), 1e-3)
    return Pilots(scene, T_END, asked, ancf.GeneralizedAlpha(0.9), base=50)


def model(count):
    return Model(counts={"beam 0": count})


def test_the_error_of_steps_is_that_beside_many_steps(pilots):
    found = time_error(pilots, model(MESH), order=2)
    exact = pilots.run(model(MESH), pilots.base << 8)
    for run in found.runs[-2:]:
        (true,) = distances(pilots.wanted, run, exact)
        assert found.estimates[0].at(run.steps) == pytest.approx(true, rel=0.6)


def test_the_error_of_the_mesh_is_that_beside_a_fine_mesh(pilots):
    found = mesh_error(pilots, Model(), float(MESH), STEPS, 4, lambda last: True)
    exact = pilots.run(model(64), STEPS)
    for count in (16, 24):
        (true,) = distances(pilots.wanted, pilots.run(model(count), STEPS), exact)
        assert true / 2.0 < found.estimates[0].at(count) < 5.0 * true


def test_the_work_of_a_longer_run_on_a_finer_mesh_is_foreseen(pilots):
    for count, steps in ((MESH, 100), (MESH, 200), (MESH, 400), (12, 200)):
        pilots.run(model(count), steps)
    known = [run for run in pilots.costs if run.steps <= STEPS and run.coordinates < 60]
    larger = pilots.run(model(32), 1600).cost
    foreseen = cost_model.model(known).amount(larger.steps, larger.coordinates)
    # Longer steps take more iterations: work for each step is at most that of the pilots.
    assert 0.7 < foreseen / larger.amount < 3.0
    assert cost_model.model(known).seconds(1600, 132) > 0.0
