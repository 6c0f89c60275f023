"""The stable step is the longest one that runs with contact admit."""

import math

import pytest

import ancfsparse as ancf

SECTION, MATERIAL = ancf.Circle(0.01), ancf.Material(1e7, 1e3)
CENTRAL = ancf.CentralDifference()


def on_drum(stiffness, **law):
    """A cable that falls by 2.5 cm on a drum."""
    scene = ancf.Scene((0.0, -9.81))
    cable = scene.add_beam("thin", (-0.5, 0.13), (0.5, 0.13), 16, SECTION, MATERIAL)
    scene.contact(cable, ancf.Drum((0.0, 0.0), 0.1), stiffness=stiffness, **law)
    return scene


def on_cable(stiffness, **law):
    """Two cables across each other, one of which falls by 1 cm."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    lower = scene.add_beam("thin", (-0.5, 0.0, 0.0), (0.5, 0.0, 0.0), 8, SECTION, MATERIAL)
    upper = scene.add_beam("thin", (0.0, -0.5, 0.02), (0.0, 0.5, 0.02), 8, SECTION, MATERIAL)
    scene.clamp(lower.start)
    scene.clamp(lower.end)
    scene.contact(upper, lower, stiffness=stiffness, **law)
    return scene


def on_floor_and_drum(stiffness):
    """Two contacts, of which the stiffer one decides."""
    scene = on_drum(stiffness)
    floor = ancf.HalfSpace((0.0, -0.2), (0.0, 1.0))
    scene.contact(scene.beams[0], floor, stiffness=1e8)
    return scene


REFUSAL = "does not resolve the (contact|impacts)|is above the stable step"


def run_ten_steps(scene, integrator, dt):
    return ancf.simulate(scene, 10 * dt, dt, integrator=integrator)


@pytest.mark.parametrize("stiffness", [None, 1e3, 1e7, 1e9])
@pytest.mark.parametrize("build", [on_drum, on_cable, on_floor_and_drum])
def test_runs_admit_the_stable_step_and_no_longer_one(build, stiffness):
    dt = ancf.stable_step(build(stiffness), CENTRAL)
    assert run_ten_steps(build(stiffness), CENTRAL, dt).finished
    with pytest.raises(ancf.InputError, match=REFUSAL):
        run_ten_steps(build(stiffness), CENTRAL, 1.05 * dt)


@pytest.mark.parametrize("build", [on_drum, on_cable])
def test_it_resolves_impacts_with_a_restitution(build):
    method = ancf.DormandPrince()
    dt = ancf.stable_step(build(1e6, restitution=0.5), method)
    assert run_ten_steps(build(1e6, restitution=0.5), method, dt).finished
    with pytest.raises(ancf.InputError, match=REFUSAL):
        run_ten_steps(build(1e6, restitution=0.5), method, 1.05 * dt)


def test_it_is_the_one_of_a_mass_on_a_spring():
    """2 / omega, where the cable itself admits seven times as much."""
    stiffness = 1e9
    mass = MATERIAL.density * 0.25 * math.pi * SECTION.diameter**2
    expected = 2.0 * math.sqrt(mass / stiffness)
    assert ancf.stable_step(on_drum(1.0), CENTRAL) > 7.0 * expected
    assert ancf.stable_step(on_drum(stiffness), CENTRAL) == pytest.approx(expected, rel=1e-9)
