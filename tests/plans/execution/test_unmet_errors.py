"""Requested errors that are not met, by each source: a warning, and a run that states it."""

import re
import warnings
from dataclasses import replace

import pytest

import ancfsparse as ancf
from ancfsparse.problems import pendulum

T_END = 0.5


def mesh_of_user():
    scene, rod = pendulum("thin", 10)
    return ancf.plan(scene, T_END, ancf.position(rod.end), 1e-5), "mesh", "n_elements"


def step_of_user():
    scene, rod = pendulum("thin", "auto")
    plan = ancf.plan(scene, T_END, ancf.position(rod.end), 1e-4, dt=5e-3)
    return plan, "steps", "dt"


def with_source(name, source, advice):
    """A met plan, as if a source of errors were too large."""
    scene, rod = pendulum("auto", "auto")
    plan = ancf.plan(scene, T_END, ancf.position(rod.end), 1e-2)
    large = replace(plan.predictions[0], sources={"mesh": 1e-3, name: 2e-2})
    return replace(plan, predictions=(large,)), source, advice


def shear():
    return with_source("shear", "neglected shear", "element")


def inertia():
    return with_source("inertia", "neglected inertia", "integrator")


def floor_of_elements():
    scene, rod = pendulum("auto", "auto")
    plan = ancf.plan(scene, T_END, ancf.position(rod.end), 1e-2)
    low = replace(plan.predictions[0], floor=2e-2)
    return replace(plan, predictions=(low,)), "difference between converged elements", "no element"


@pytest.mark.parametrize(
    "make",
    [mesh_of_user, step_of_user, shear, inertia, floor_of_elements],
    ids=lambda make: make.__name__,
)
def test_an_error_that_is_not_met_warns(make):
    plan, source, advice = make()
    assert not plan.is_met
    with pytest.warns(ancf.ErrorNotMetWarning) as caught:
        run = plan.run()
    (warning,) = (each.message for each in caught)
    prediction = plan.predictions[0]
    assert warning.tolerance == prediction.tolerance
    assert warning.error == run.stats.error == max(prediction.error, prediction.floor)
    assert re.search(rf"the largest source is .*{source}", str(warning))
    assert advice in warning.advice
    assert not warning.is_measured
    assert not run.finished
    assert "unfinished: the error of the" in repr(run)
    assert caught[0].filename == __file__


def test_the_run_of_simulate_warns_too():
    scene, rod = pendulum("thin", 10)
    with pytest.warns(ancf.ErrorNotMetWarning, match="predicted error of .* was requested"):
        run = ancf.simulate(scene, T_END, quantity=ancf.position(rod.end), error=1e-5)
    assert not run.finished


def test_a_measured_error_above_the_requested_one_warns():
    scene, rod = pendulum("thin", "auto")
    plan = ancf.plan(scene, T_END, ancf.position(rod.end), 1e-2)
    wrong = replace(plan.predictions[0], tolerance=1e-7, sources={"mesh": 1e-8})
    plan = replace(plan, predictions=(wrong,))
    with pytest.warns(ancf.ErrorNotMetWarning, match="differs by .* from a finer run") as caught:
        run = plan.run(verify=True)
    assert caught[0].message.is_measured
    assert run.stats.error == run.measured[0] == caught[0].message.error
    assert not run.finished
    assert "is measured to be" in repr(run)


def test_a_met_error_does_not_warn():
    scene, rod = pendulum("thin", "auto")
    plan = ancf.plan(scene, T_END, ancf.position(rod.end), 1e-2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = plan.run(verify=True)
    assert run.finished
    assert run.stats.error == max(plan.error, run.measured[0])
    assert "unfinished" not in repr(run)


SENTENCE = "here the contact of beam 0 with the half-space begins or ends, quantities are not"


def falling_pendulum(gap, stiffness=None):
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (1, 0.05), 6, ancf.Circle(0.01), ancf.Material(1e8, 5e3))
    scene.pin(rod.start)
    scene.contact(rod, ancf.HalfSpace((0, -gap), (0, 1)), stiffness=stiffness)
    return scene, ancf.position(rod.end)


@pytest.mark.parametrize("gap", [0.01, 10.0])
def test_contacts_that_keep_errors_from_decreasing_are_named(gap):
    """A pendulum that falls on a floor, and the same one high above it."""
    scene, tip = falling_pendulum(gap, 1e5)
    plan = ancf.plan(scene, 0.2, tip, 1e-3)
    assert (SENTENCE in str(plan)) == (gap < 1.0)
    assert plan.is_met == (gap > 1.0)


def test_contacts_are_named_where_motions_do_not_converge():
    scene, tip = falling_pendulum(0.02)
    with pytest.raises(ancf.PlanError, match=SENTENCE):
        ancf.plan(scene, 0.2, tip, 1e-3)
