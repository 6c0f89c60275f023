"""Runs that leave the range of their plan state it, and are planned again."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.execution import replanning
from ancfsparse.plans.execution.validity_range import ValidityRange, validity_range
from ancfsparse.plans.trial_runs.solution_methods import Statics
from ancfsparse.problems import pendulum
from tests.beams import build_beam
from tests.plans.comparison import largest_distance


def test_a_step_that_fails_is_halved_and_what_is_done_is_kept():
    scene, rod = pendulum("thin", "auto")
    plan = ancf.plan(scene, 2.0, ancf.position(rod.end), 1e-2, integrator=ancf.Newmark())
    model = plan.model.with_counts({rod.name: 24})
    long = replace(plan, model=model, steps=50, result=None, validity_range=None)
    with pytest.raises(ancf.EnergyIncreaseError) as failure:
        ancf.simulate(long.build(), 2.0, 0.04, integrator=ancf.Newmark(), solver=plan.solver)
    with pytest.warns(ancf.PlanChangedWarning, match="the run continues with half the step"):
        run = long.run()
    assert run.plan.steps > 50
    assert np.allclose(np.diff(run.t), 0.04)
    assert len(run.t) == 51
    kept = failure.value.trajectory
    assert len(kept.t) > 10
    assert np.array_equal(run.q[: len(kept.t)], kept.q)
    assert run.stats.steps > 50
    truth = ancf.simulate(plan.build(), 2.0, 0.04, accuracy=1e-4).position(rod.end)
    assert largest_distance(run.position(rod.end), truth) < 0.5
    # A file has one run: it is made again from its start.
    with pytest.warns(ancf.PlanChangedWarning, match="continues"):
        again = long.run(save_every=1)
    assert again.t[1] < 0.04


def test_a_run_whose_steps_all_fail_names_the_selection_and_what_to_try(monkeypatch):
    monkeypatch.setattr(replanning, "MAX_CHANGES", 0)
    scene, rod = pendulum("thin", "auto")
    plan = ancf.plan(scene, 2.0, ancf.position(rod.end), 1e-2, integrator=ancf.Newmark())
    model = plan.model.with_counts({rod.name: 24})
    long = replace(plan, model=model, steps=50, result=None, validity_range=None)
    with pytest.raises(ancf.EnergyIncreaseError) as failure:
        long.run()
    message = str(failure.value)
    assert "stopped at step" in message
    assert f"The plan had selected {long.choice}, and 1 times shorter steps fail" in message
    assert "plan with integrator=GeneralizedAlpha(0.5)" in message
    assert "max_halvings" not in message
    assert "The states up to here" in message
    assert str(pickle.loads(pickle.dumps(failure.value))) == message


def test_a_run_with_larger_strains_is_refined_until_two_agree():
    scene, rod = pendulum("thin", "auto")
    plan = replace(ancf.plan(scene, 1.0, ancf.position(rod.end), 1e-2), result=None)
    run = plan.run()
    known = validity_range(run, plan.steps)
    assert known.exceeded_by(known) == ""
    assert replace(plan, validity_range=known).run().plan.steps == plan.steps
    small = replace(plan, validity_range=replace(known, strain=known.strain / 10))
    with pytest.warns(
        ancf.PlanChangedWarning, match="strains reach .* refined until two runs agree"
    ):
        finer = small.run()
    assert finer.plan.steps >= 2 * plan.steps
    exact, its = pendulum("thin", 64)
    truth = ancf.simulate(exact, 1.0, finer.t[1], accuracy=1e-5).position(its.end)
    assert largest_distance(finer.position(rod.end), truth) <= 1e-2
    # With other arguments the run cannot be made again, but states that it left its range.
    with pytest.warns(ancf.PlanChangedWarning, match="its error may exceed the prediction"):
        assert small.run(save_every=1).plan.steps == plan.steps
    # Errors that are not met are not met by finer runs either.
    unmet = tuple(replace(each, tolerance=1e-9) for each in plan.predictions)
    with (
        pytest.warns(ancf.PlanChangedWarning, match="its error may exceed the prediction"),
        pytest.warns(ancf.ErrorNotMetWarning),
    ):
        assert replace(small, predictions=unmet).run().plan.steps == plan.steps


def test_a_load_that_trial_runs_have_missed_is_found():
    """A push of 2 ms between the steps of pilots."""
    scene, rod = build_beam(
        "thin", (0, 0), (1, 0), "auto", ancf.Circle(0.02), ancf.Material(1e8, 1000), "clamp",
        gravity=(0.0, 0.0),
    )  # fmt: skip
    scene.point_force(
        rod.end, lambda t: (0.0, -0.1 * np.sin(3 * t) - 2.0 * (abs(t - 0.5031) < 1e-3))
    )
    plan = ancf.plan(scene, 1.0, ancf.position(rod.end), "3 %", dt=5e-4)
    coarse = validity_range(plan.run(), 50)
    with pytest.warns(ancf.PlanChangedWarning, match="a load reaches"):
        replace(plan, result=None, validity_range=replace(coarse, strain=1.0)).run()
    known = ValidityRange(1.0, 0.1, (1.0, 2.0))
    assert known.exceeded_by(replace(known, loads=(1.0, 4.0))).startswith("a load reaches")
    assert "rotations in a step" in known.exceeded_by(replace(known, turn=0.2))


def arch(n="auto"):
    """Two beams that lean on each other, pushed through slowly."""
    scene = ancf.Scene((0.0, 0.0))
    viscous = ancf.Material(1e7, 1000, axial_damping=0.03, bending_damping=0.03)
    left = scene.add_beam("thin", (0, 0), (1, 0.1), n, ancf.Circle(0.02), viscous)
    right = scene.add_beam("thin", (1, 0.1), (2, 0), n, ancf.Circle(0.02), viscous)
    scene.pin(left.start)
    scene.pin(right.end)
    scene.connect(left.end, right.start)
    scene.point_force(left.end, ancf.Ramp((0.0, -3.0), 2.0))
    return scene, left.end


def test_equilibria_that_cease_to_exist_are_marched():
    scene, top = arch(4)
    run = ancf.quasi_static(scene, 2.0, 0.125)
    assert run.stats.recoveries > 0
    assert Statics().neglected(run, ancf.position(top)) == {"inertia": np.inf}
    scene, top = arch()
    plan = ancf.plan(scene, 2.0, ancf.position(top), "5 %")
    assert plan.integrator == ancf.GeneralizedAlpha(0.9)
    assert "statics at all times is not applicable: neglected inertia has no bound" in str(plan)
    wrong = replace(plan, integrator=Statics(), result=None, steps=16)
    with pytest.warns(
        ancf.PlanChangedWarning, match="ceased to exist; it is planned again with time integration"
    ):
        again = wrong.run()
    assert again.plan.choice == plan.choice
    assert np.array_equal(again.position(top), plan.run().position(top))


def swinging(n="auto", wall=2.3):
    """A pendulum of rubber that a point pushes away once its end is near, after 0.4 s."""
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (1, 0), n, ancf.Circle(0.02), ancf.Material(1e7, 1000))
    scene.pin(rod.start)
    scene.spring(rod.end, (-1, -3), stiffness=lambda e: min(0.0, 2e3 * e), length=wall)
    return scene, rod


def test_contact_that_trial_runs_have_not_met_is_found():
    scene, rod = swinging()
    integrator = ancf.GeneralizedAlpha(0.9)
    plan = ancf.plan(scene, 1.2, ancf.position(rod.end), "5 %", integrator=integrator)
    missed = validity_range(ancf.simulate(swinging(8, 1e-3)[0], 1.2, 2e-3), 600)
    assert missed.forces[0][1] == 0.0
    blind = replace(missed, strain=1.0, turn=1.0)
    rough = replace(plan, model=plan.model.with_counts({rod.name: 6}), steps=400, result=None)
    met = validity_range(rough.run(), 400)
    assert replace(blind, forces=met.forces).exceeded_by(met) == ""
    with pytest.warns(
        ancf.PlanChangedWarning, match=r"the force of the spring .* reaches .*, compared with 0 in"
    ):
        run = replace(rough, validity_range=blind).run()
    exact, its = swinging(24)
    motion = ancf.simulate(exact, 1.2, run.t[1] / 4, save_every=4).position(its.end)
    assert largest_distance(run.position(rod.end), motion) <= plan.predictions[0].tolerance
    free, its = swinging(24, 1e-3)
    without = ancf.simulate(free, 1.2, run.t[1]).position(its.end)
    assert largest_distance(without, motion) > 5.0 * plan.predictions[0].tolerance
