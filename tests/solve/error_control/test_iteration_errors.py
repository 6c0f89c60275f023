"""Errors of the iteration in all steps of a run to an accuracy, which differ in length."""

import math
from itertools import pairwise

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.solve.error_control import implicit_candidate
from ancfsparse.solve.error_control.implicit_candidate import (
    ELASTIC_ITERATIONS_RATIO,
    ITERATIONS_RATIO,
    ImplicitCandidate,
)
from ancfsparse.solve.error_control.motion_task import MotionTask
from ancfsparse.solve.stepping.sampled_states import distance
from ancfsparse.system import System

LENGTH, T_END, ACCURACY = 0.4, 0.08, 1.5e-6
GROWTH = 2.0 ** np.arange(7)  # steps as they grow from the first
STEPS_OF_A_LENGTH = 600


def beam(hold):
    """A soft beam in space under its weight and an oscillating force."""
    scene = ancf.Scene((0.0, -9.81, 0.0))
    section, material = ancf.Rectangle(1e-3, 1e-3), ancf.Material(9e6, 570.0, 0.45)
    made = scene.add_beam("thin", (0, 0, 0), (LENGTH, 0, 0), 9, section, material)
    hold(scene, made)
    scene.point_force(made.end, ancf.Sine((-0.002, -0.01, 0.001), 12.0))
    return scene


def body(_):
    """A box that swings about a corner."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    made = scene.add_body(ancf.Box(length=0.4, width=0.1, height=0.2), mass=1.0, position=(0, 0, 0))
    scene.pin(made.at((-0.2, 0.05, 0.1)))
    return scene


@pytest.mark.parametrize(
    ("make", "hold"),
    [
        (beam, lambda scene, made: (scene.pin(made.start), scene.rod(made.end, (0.3, -0.4, 0.1)))),
        (beam, lambda scene, made: scene.pin(made.start)),
        (beam, lambda scene, made: scene.clamp(made.start)),
        (beam, lambda scene, made: None),
        (body, None),
    ],
    ids=["rod", "pin", "clamp", "free", "rigid"],
)
def test_iterations_cause_a_small_fraction_of_the_accuracy_in_steps_of_any_length(
    monkeypatch, make, hold
):
    def states(factor):
        monkeypatch.setattr(implicit_candidate, "ITERATIONS_RATIO", factor * ITERATIONS_RATIO)
        elastic_ratio = factor * ELASTIC_ITERATIONS_RATIO
        monkeypatch.setattr(implicit_candidate, "ELASTIC_ITERATIONS_RATIO", elastic_ratio)
        system, t = System(make(hold)), np.linspace(0.0, T_END, 21)
        task = MotionTask(system, t, ACCURACY, math.inf, lambda states: None)
        candidate = ImplicitCandidate(task, ancf.HHT(0.05), "auto", 1)
        ends = np.append(0.0, T_END * np.cumsum(GROWTH) / GROWTH.sum()).tolist()
        monkeypatch.setattr(MotionTask, "spans", list(pairwise(ends)))
        return system, candidate._integration([STEPS_OF_A_LENGTH] * len(GROWTH)).run()

    system, found = states(1.0)
    _, exact = states(1e-3)
    assert distance(system, found, exact) < ELASTIC_ITERATIONS_RATIO * ACCURACY


def positions(run):
    return np.concatenate([run.q[:, nodes[:, :3]] for nodes in run.system.places], axis=1)


def error_ratios(scene, end, accuracy, integrator):
    """Error of a run to an accuracy, and its estimate, over the accuracy."""
    saved, steps = 20, 3200
    run = ancf.simulate(scene, end, end / saved, accuracy=accuracy, integrator=integrator)
    explicit = ancf.RungeKuttaNystrom(8)
    exact = ancf.simulate(scene, end, end / steps, save_every=steps // saved, integrator=explicit)
    off = np.linalg.norm(positions(run) - positions(exact), axis=2).max()
    return off / accuracy, run.stats.error / accuracy


@pytest.mark.parametrize("accuracy", [1e-5, 2.4e-5, 8e-5])
@pytest.mark.parametrize("integrator", [ancf.HHT(0.05), ancf.GeneralizedAlpha(0.9)], ids=repr)
def test_iteration_errors_that_a_motion_amplifies_are_reduced(integrator, accuracy):
    # A cable falls from a straight line between its pins.  Later it leaves its plane, by what
    # iterations and rounding have left there.
    scene = ancf.Scene((0.0, -9.81, 0.0))
    section, material = ancf.Rectangle(2e-3, 2e-3), ancf.Material(1.2e5, 5500.0, 0.3)
    ends = (0, 0, 0), (0.335, 0.046, 0.324)
    cable = scene.add_beam("thick", *ends, 6, section, material, curvature="section")
    scene.pin(cable.start)
    scene.pin(cable.end)
    assert max(error_ratios(scene, 0.128, accuracy, integrator)) <= 1.0


@pytest.mark.parametrize("accuracy", [8e-6, 1.1e-5, 1.7e-5])
@pytest.mark.parametrize("integrator", [ancf.HHT(0.05), ancf.GeneralizedAlpha(0.9)], ids=repr)
def test_iteration_errors_that_twist_a_beam_are_reduced(integrator, accuracy):
    # Pushed at its end, a straight beam begins to twist.  In the positions of two runs errors of
    # the steps in the plane of the push hide it.
    scene = ancf.Scene((0.0, -9.81, 0.0))
    section, material = ancf.Rectangle(1.5e-3, 1.5e-3), ancf.Material(6e6, 660.0, 0.3)
    beam = scene.add_beam("thick", (0, 0, 0), (-0.235, 0.361, -0.112), 6, section, material)
    scene.point_force(beam.end, (-0.002, -0.001, 0.0))
    assert max(error_ratios(scene, 0.018, accuracy, integrator)) <= 1.0
