"""Steps of the first pilot follow loads and drives, and nothing that is rounding."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.trial_runs.load_resolution import (
    amplitudes_over_time,
    jumps_inside_steps,
    steps_resolving_loads,
)
from ancfsparse.system import System
from tests.beams import build_beam
from tests.plans.comparison import distance_from_shorter_steps

STEEL = ancf.Material(1e8, 1000)


def heated(element, dim, force=None, n=4, **eigen):
    """A cantilever with an eigenstrain, and perhaps a force at its end."""
    end, made = np.eye(dim)[0], (ancf.Circle(0.02), STEEL)
    scene, rod = build_beam(element, 0 * end, end, n, *made, "clamp", gravity=0 * end, **eigen)
    if force is not None:
        scene.point_force(rod.end, force)
    return scene, rod


@pytest.mark.parametrize(("element", "dim"), [("thin", 2), ("thick", 2), ("thick", 3)])
def test_parameters_that_an_eigenstrain_does_not_change_set_no_pace(element, dim):
    system = System(heated(element, dim, eigenstrain=ancf.Ramp(1e-3, 1.0))[0])
    table = amplitudes_over_time(system, np.linspace(0.0, 2.0, 50))[0]
    largest = np.abs(table).max(axis=0)
    assert ((0.0 < largest) & (largest < 1e-15)).any()
    assert steps_resolving_loads(system, 2.0, 100) == 100


def test_a_small_load_next_to_large_parameters_is_followed():
    """What is rounding depends on the source alone: this force is of 1e-14 N."""
    quick = ancf.Sine((0.0, 1e-14), frequency=50.0)
    made = heated("thin", 2, quick), heated("thin", 2, quick, eigenstrain=ancf.Ramp(1e-3, 1.0))
    alone, beside = (steps_resolving_loads(System(scene), 2.0, 100) for scene, _ in made)
    assert beside == alone >= 2.0 * 50.0 * 8


def test_rounding_in_a_drive_sets_no_pace():
    """A straight drive along an oblique line, of which a component beside it is rounding."""
    scene, rod = build_beam("thin", (0, 0), (1, 0), 4, ancf.Circle(0.02), STEEL, gravity=(0.0, 0.0))
    end = np.array([1.0, 0.0])
    scene.drive(rod.end, lambda t: end + 0.01 * t * np.array([1.0, np.sin(1e5 * t) * 1e-16]))
    assert steps_resolving_loads(System(scene), 2.0, 100) == 100


def test_a_heated_cantilever_is_planned_in_few_steps():
    scene, rod = heated("thin", 2, n="auto", eigenstrain=ancf.Ramp(1e-3, 1.0))
    plan = ancf.plan(scene, 2.0, ancf.position(rod.end), "1 %")
    assert plan.is_met
    assert plan.steps <= 3200
    fine, its = heated("thin", 2, n=8, eigenstrain=ancf.Ramp(1e-3, 1.0))
    run = plan.run()
    off = distance_from_shorter_steps(run, rod.end, fine, its.end, round(run.t[1] / 1e-4))
    assert off <= plan.predictions[0].tolerance


@pytest.mark.parametrize(
    ("signal", "jumps"),
    [
        (ancf.Pulse(1.0, 0.4, 1.0), False),
        (ancf.Pulse(1.0, 0.4, 1.0171), True),
        (ancf.Pulse(1.0, 0.4, 1.0171, rise=0.1), False),
        (ancf.Ramp(2.0, 1.0171, 0.3) + ancf.Sine(1.0, 3.0), False),
        (ancf.Table([0.0, 0.7071, 0.7071 + 1e-15, 9.0], [0.0, 1.0, 3.0, 3.0]), True),
        (lambda t: t, False),
    ],
)
def test_jumps_inside_steps(signal, jumps):
    """Errors of the steps are then of order 1, whatever the trial runs show."""
    scene, rod = build_beam("thin", (0, 0), (1, 0), 4, ancf.Circle(0.02), STEEL, "clamp")
    scene.point_moment(rod.end, signal)
    assert jumps_inside_steps(System(scene), 2.0, 50) is jumps
