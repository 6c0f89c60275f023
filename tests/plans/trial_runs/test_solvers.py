"""How pilots and planned runs solve their steps: by pairs where they take many corrections."""

from dataclasses import replace

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.trial_runs.choose_solver import MIN_PAIRS_WORK, PAIRS, select_solver
from ancfsparse.plans.trial_runs.cost_model import RunCost, cost_of_run
from ancfsparse.plans.trial_runs.solution_methods import Statics
from ancfsparse.problems import pendulum
from tests.beams import build_beam

DAMPED = ancf.GeneralizedAlpha(0.9)
BAR, STEEL = ancf.Rectangle(0.01, 0.01), ancf.Material(2.1e11, 7850.0, 0.3)


def stiff_rod(n_elements="auto"):
    scene, rod = build_beam("thin", (0, 0), (2, 0), n_elements, BAR, STEEL, "pin")
    return scene, rod.end


def cost(steps, work):
    return RunCost(steps, 20, work, 0.0, 0.0)


def test_the_next_longer_steps_tell_whether_pairs_pay():
    scene, _ = stiff_rod()
    assert select_solver(scene, DAMPED, [], 100) == PAIRS
    run_costs = [
        cost(100, 3.0 * MIN_PAIRS_WORK),
        cost(400, 0.9 * MIN_PAIRS_WORK),
        cost(200, MIN_PAIRS_WORK),
    ]
    assert select_solver(scene, DAMPED, run_costs, 400) == PAIRS
    assert select_solver(scene, DAMPED, run_costs, 401) == "auto"
    assert select_solver(scene, DAMPED, run_costs, 100) == PAIRS


@pytest.mark.parametrize("steps", [200, 400])
def test_pairs_save_work_where_steps_are_long(steps):
    works = []
    for solver in ("auto", PAIRS):
        scene, _ = stiff_rod(6)
        run = ancf.simulate(scene, 2.0, 2.0 / steps, integrator=DAMPED, solver=solver)
        works.append(cost_of_run(run.stats, steps, run.q.shape[1]).unit_work)
    assert works[0] > MIN_PAIRS_WORK
    assert works[1] < 0.8 * works[0]


def test_what_has_no_factor_to_save_keeps_its_own_solver():
    scene, end = stiff_rod()
    for integrator in (ancf.CentralDifference(), Statics()):
        assert select_solver(scene, integrator, [], 100) == "auto"
    other = scene.add_beam("thin", (2, 0), (0, 0), "auto", BAR, STEEL)
    scene.connect(end, other.start)
    assert select_solver(scene, DAMPED, [], 100) == PAIRS
    scene.connect(other.end, scene.bodies[0].start)  # a loop
    assert select_solver(scene, DAMPED, [], 100) == "auto"
    rigid = ancf.Scene()
    rigid.add_body(mass=1.0, inertia=1.0, position=(0.0, 0.0))
    assert select_solver(rigid, DAMPED, [], 100) == "auto"


def test_the_run_of_a_plan_has_the_solver_of_its_trial_run():
    scene, rod = pendulum("thin", "auto")
    plan = ancf.plan(scene, 2.0, ancf.position(rod.end), "10 %")
    assert plan.result is not None
    assert plan.solver == PAIRS
    assert "solver quasi-Newton (bfgs, 2 pairs)" in str(plan)
    again = replace(plan, result=None).run()
    for name in ("t", "q", "v", "a", "lam"):
        assert np.array_equal(getattr(again, name), getattr(plan.result, name))
    other = plan.run(solver="auto")
    assert not np.array_equal(other.q, again.q)
    assert np.allclose(other.q, again.q, atol=1e-3)
