"""The number of accepted steps in which points of contacts touch or separate."""

import numpy as np
import pytest

import ancfsparse as ancf

SECTION, MATERIAL = ancf.Circle(0.01), ancf.Material(1e8, 2e3)
FLOOR = ancf.HalfSpace((0.0, 0.0), (0.0, 1.0))
RADIUS, STIFFNESS = 0.005, 1e6
FALL = 0.06  # [s]
HEIGHT = 0.5 * 9.81 * FALL**2
INTEGRATORS = [ancf.EnergyMomentum(), ancf.GeneralizedAlpha(0.9), ancf.DormandPrince()]


def falling(height=HEIGHT, slope=0.0, n=2, **options):
    """A cable above a floor, level or with one end lower."""
    scene = ancf.Scene((0.0, -9.81))
    ends = (0.0, height + RADIUS), (0.5, height + RADIUS + slope)
    scene.contact(
        scene.add_beam("thin", *ends, n, SECTION, MATERIAL), FLOOR, stiffness=STIFFNESS, **options
    )
    return scene


def changes_of(run):
    """The saved states at which other points are in contact than one state before."""
    (part,) = (each for each in run.system.contributions if hasattr(each, "contact"))
    depths = np.array([part.motion(q, np.zeros(len(q)))[1] for q in run.q])
    return int(np.any(np.diff(depths > 0.0, axis=0), axis=1).sum())


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_a_level_cable_changes_twice_in_a_bounce(integrator):
    """With these steps all points touch in one step, and separate in another one."""
    run = ancf.simulate(falling(), 2.0 * FALL, 3e-4, integrator=integrator)
    assert run.stats.contact_changes == changes_of(run) == 2


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_points_of_a_tilted_cable_change_in_the_steps_of_its_states(integrator):
    options = {"slip_speed": 0.01, "friction": 0.3}
    scene = falling(0.002, slope=0.02, n=6, **options)
    run = ancf.simulate(scene, 0.1, 1e-4, integrator=integrator)
    assert run.stats.contact_changes == changes_of(run) > 4


def test_a_cable_at_rest_changes_no_more():
    scene = falling(1e-4, n=6)
    run = ancf.simulate(scene, 0.2, 1e-3, integrator=ancf.GeneralizedAlpha(0.0))
    assert run.stats.contact_changes == changes_of(run) > 0
    settled = ancf.simulate(scene, 0.3, 1e-3, integrator=ancf.GeneralizedAlpha(0.0), start=run.last)
    assert settled.stats.contact_changes == 0
    resting = ancf.simulate(
        scene, 0.1, 1e-3, start=ancf.solve_static(falling(1e-4, n=6, push_out=True))
    )
    assert resting.stats.contact_changes == 0


def test_parts_of_divided_steps_are_counted():
    """Each step of 5 ms, as long as an impact, that is not solved in one iteration is divided."""
    solver = ancf.QuasiNewton("bfgs", 5, max_iterations=1)
    run = ancf.simulate(
        falling(),
        2.0 * FALL,
        5e-3,
        integrator=ancf.EnergyMomentum(),
        solver=solver,
        max_halvings=8,
    )
    assert run.stats.short_steps > 0
    assert run.stats.contact_changes == 2


def crossing(height):
    """A cable above another one that is held at its ends."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    lower = scene.add_beam("thin", (-0.2, 0, 0), (0.2, 0, 0), 4, SECTION, MATERIAL)
    scene.clamp(lower.start)
    scene.clamp(lower.end)
    z = 2.0 * RADIUS + height
    ends = (0.03, -0.2, z), (0.06, 0.2, z)
    upper = scene.add_beam("thin", *ends, 4, SECTION, MATERIAL, velocity=(0.0, 0.0, -0.5))
    scene.contact(lower, upper, stiffness=STIFFNESS)
    return scene


def test_numbers_of_points_between_beams_change():
    run = ancf.simulate(crossing(0.002), 0.04, 2e-4, integrator=ancf.EnergyMomentum())
    (part,) = (each for each in run.system.contributions if hasattr(each, "contact"))
    numbers = [len(part.compiled.touches(q)[0]) for q in run.q]
    assert run.stats.contact_changes == np.count_nonzero(np.diff(numbers)) > 1
    away = ancf.simulate(crossing(0.1), 0.02, 1e-3)
    assert away.stats.contact_changes == 0


@pytest.mark.parametrize("integrator", [ancf.EnergyMomentum(), "auto"], ids=str)
def test_runs_to_an_accuracy_count_all_their_runs(integrator):
    run = ancf.simulate(falling(), 1.5 * FALL, accuracy=1e-5, integrator=integrator)
    assert run.stats.contact_changes >= 2 * run.stats.runs > 2
    again = ancf.simulate(falling(), 1.5 * FALL, 1e-3, integrator=ancf.EnergyMomentum())
    assert again.stats.contact_changes == 2
