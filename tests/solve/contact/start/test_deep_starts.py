"""Motions that begin deeper in an obstacle than known loads, tensions and speeds press a body."""

import math
import warnings

import pytest

import ancfsparse as ancf

RADIUS, GRAVITY = 0.005, 9.81
SECTION, MATERIAL = ancf.Circle(2.0 * RADIUS), ancf.Material(1e8, 5e3)
MASS = MATERIAL.density * 0.25 * math.pi * SECTION.diameter**2  # per length
FLOOR = ancf.HalfSpace((0.0, 0.0), (0.0, 1.0))


def on_floor(depth, stiffness, gravity=GRAVITY, speed=0.0, **law):
    """A level cable whose surface is below the floor by a depth over its radius."""
    scene = ancf.Scene((0.0, -gravity))
    y = (1.0 - depth) * RADIUS
    cable = scene.add_beam(
        "thin", (0.0, y), (1.0, y), 10, SECTION, MATERIAL, velocity=(0.0, -speed)
    )
    scene.contact(cable, FLOOR, stiffness=stiffness, **law)
    return scene, cable


def around_drum(tension, stiffness, depth):
    """Half a turn around a drum of 0.1 m, with a depth over the radius and forces at both ends."""
    scene = ancf.Scene((0.0, 0.0))
    r = 0.1 + (1.0 - depth) * RADIUS
    arc = ancf.Arc((0.0, 0.0), (r, 0.0), math.pi)
    cable = scene.add_beam("string", curve=arc, n_elements=60, section=SECTION, material=MATERIAL)
    for end in cable.start, cable.end:
        scene.point_force(end, (0.0, -tension))
    scene.contact(cable, ancf.Drum((0.0, 0.0), 0.1), stiffness=stiffness)
    return scene


def run_silently(scene, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return ancf.simulate(scene, **{"t_end": 2e-3, "dt": 1e-3} | options)


@pytest.mark.parametrize("depth", [0.04, 0.1, 0.4, 0.96])
@pytest.mark.parametrize("stiffness", [1e2, 1e3, 1e4, 1e5, 1e7, 1e9])
def test_a_cable_that_its_start_throws_up_by_half_a_radius_is_warned_of(depth, stiffness):
    """With 1e9 N/m2 and .96 radii it begins with 11.5 kJ, and rises by a thousand radii."""
    scene, cable = on_floor(depth, stiffness)
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        run = ancf.simulate(scene, 0.3, 1e-3)
    rise = run.position(cable.at(0.5))[:, 1].max() - cable.at(0.5).position[1]
    # Up to 5 % of the radius all stiffnesses are allowed, as the default one is.
    assert bool(found) == (rise > 0.5 * RADIUS and depth > 0.05)
    if found:
        (warning,) = found
        assert warning.category is ancf.PenetrationWarning
        assert warning.filename == __file__
        known = 2.0 * MASS * GRAVITY / stiffness
        assert f"begins with a penetration of {depth * RADIUS:.3g} m at beam 0 at s = " in str(
            warning.message
        )
        assert f"cause at most {known:.2g} m" in str(warning.message)


def test_the_remedies_of_the_warning():
    scene, _ = on_floor(0.96, 1e9)
    with pytest.warns(
        ancf.PenetrationWarning, match=r"push_out=True, or .*, such as start=solve_static"
    ):
        ancf.simulate(scene, 1e-3, 1e-3)
    run = run_silently(scene, start=ancf.solve_static(scene))
    assert run.energy.contact[0] < 1e-5  # in place of 11.5 kJ
    pushed, cable = on_floor(0.96, 1e9, push_out=True)
    assert abs(run_silently(pushed).velocity(cable.at(0.5))).max() < 0.1


def test_a_simulation_warns_as_well():
    with pytest.warns(ancf.PenetrationWarning, match="begins with a penetration"):
        ancf.Simulation(on_floor(0.5, 1e7)[0], 1e-3)


def test_a_run_that_continues_in_an_impact_does_not_warn():
    """A fall of 3 m/s reaches half a radius, from where a second run goes on."""
    stiffness = MASS * (3.0 / (0.5 * RADIUS)) ** 2
    scene, cable = on_floor(0.0, stiffness, speed=3.0)
    run = run_silently(scene, t_end=1.2e-3, dt=1e-4)
    assert run.position(cable.at(0.5))[-1, 1] < 0.6 * RADIUS
    run_silently(scene, start=run.last, t_end=1.4e-3, dt=1e-4)


@pytest.mark.parametrize(("factor", "warns"), [(1.9, False), (2.1, True)])
def test_a_tension_balances_the_pressure_of_a_drum(factor, warns):
    """T/(R k) with the sum of the forces at both ends, and a largest pressure of twice its mean."""
    tension, depth = 10.0, 0.3
    radius = 0.1 + RADIUS
    stiffness = factor * 2.0 * tension / radius / (depth * RADIUS)
    scene = around_drum(tension, stiffness, depth)
    if warns:
        with pytest.warns(ancf.PenetrationWarning, match="begins with a penetration"):
            ancf.simulate(scene, 1e-4, 1e-4)
    else:
        run_silently(scene, t_end=1e-4, dt=1e-4)


@pytest.mark.parametrize(("factor", "warns"), [(0.9, False), (1.1, True)])
def test_a_speed_explains_the_depth_of_its_impact(factor, warns):
    """Five times v sqrt(m/k), the factor of the default stiffness for whips."""
    depth, speed = 0.3, 1.0
    stiffness = factor * MASS * (5.0 * speed / (depth * RADIUS)) ** 2
    scene, _ = on_floor(depth, stiffness, gravity=0.0, speed=speed)
    if warns:
        with pytest.warns(ancf.PenetrationWarning, match="begins with a penetration"):
            ancf.simulate(scene, 1e-4, 1e-4)
    else:
        run_silently(scene, t_end=1e-4, dt=1e-4)
