"""Stiffnesses between beams that follow from loads and speeds: what they let bodies sink in by."""

import math
import re

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from ancfsparse.system.contributions.force_elements.contact_stiffness import (
    default_stiffness_between,
)

RADIUS = 0.005
ROPE, RUBBER = ancf.Circle(2.0 * RADIUS), ancf.Material(1e8, 5e3)
DAMPED = ancf.Material(1e7, 1e3, axial_damping=0.02, bending_damping=0.02, rayleigh=(5.0, 0.0))


def crossing(height, angle=90.0, gravity=9.81, velocity=None, material=RUBBER):
    """A cable above one that is pinned at both ends, without a stiffness."""
    scene = ancf.Scene((0.0, 0.0, -gravity))
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 10, ROPE, RUBBER)
    scene.pin(lower.start)
    scene.pin(lower.end)
    x, y = 0.5 * math.cos(math.radians(angle)), 0.5 * math.sin(math.radians(angle))
    upper = scene.add_beam(
        "thin", (-x, -y, height), (x, y, height), 10, ROPE, material, velocity=velocity
    )
    return scene, scene.contact(lower, upper)


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0])
@pytest.mark.parametrize("height", [0.03, 0.5])
def test_a_cable_that_falls_on_another_one_sinks_in_by_a_hundredth_of_its_radius(height, angle):
    scene, contact = crossing(height, angle)
    run = ancf.simulate(
        scene, round(math.sqrt(0.2 * height) + 0.05, 3), 5e-4, integrator=ancf.EnergyMomentum()
    )
    assert 5e-4 < run.contact_force(contact).penetration.max() / RADIUS < 0.01


@pytest.mark.parametrize("speed", [1.0, 10.0])
@pytest.mark.parametrize("material", [RUBBER, ancf.Material(2e11, 7800.0)], ids=["rubber", "steel"])
def test_a_cable_that_is_thrown_at_another_one(speed, material):
    """A part of its mass meets the other one: what bending waves reach during the impact."""
    scene, contact = crossing(0.0101, 90.0, 0.0, (0.0, 0.0, -speed), material)
    run = ancf.simulate(scene, 0.01, 5e-5, integrator=ancf.EnergyMomentum())
    assert 1e-3 < run.contact_force(contact).penetration.max() / RADIUS < 0.01


def test_a_force_on_a_long_beam_accelerates_the_length_that_bending_waves_reach():
    """It moves with F sqrt(t) / sqrt(2 pi sqrt(E I mu^3)), as if this mass had the speed."""
    scene = ancf.Scene((0.0, 0.0))
    beam = scene.add_beam("thin", (0, 0), (2, 0), 200, ROPE, RUBBER)
    scene.point_force(beam.at(1.0), (0.0, 1.0))
    run = ancf.simulate(scene, 0.01, 1e-5, save_every=100)
    given = beam.parameters()
    mass, bending = given["mass_per_length"], given["bending_stiffness"]
    expected = np.sqrt(run.t / (2.0 * math.pi * math.sqrt(bending * mass**3)))
    assert run.velocity(beam.at(1.0))[3:, 1] == pytest.approx(expected[3:], rel=0.01)


def test_cables_of_a_heap_sink_in_by_less_than_one_percent():
    scene, cables = ancf.Scene((0.0, 0.0, -9.81)), []
    for k in range(20):
        layer, rank = divmod(k, 5)
        ends = np.array([(-0.2, 0.075 * (rank - 2), 0.007 + 0.012 * layer)] * 2)
        ends[1, 0] = 0.2
        cables.append(
            scene.add_beam(
                "thin", *ends[:, [1, 0, 2] if layer % 2 else [0, 1, 2]], 10, ROPE, DAMPED
            )
        )
    scene.contact(cables, ancf.HalfSpace((0, 0, 0), (0, 0, 1)), friction=0.3)
    among = scene.contact(cables, cables, friction=0.3)
    run = ancf.simulate(scene, 0.3, 1e-3, integrator=ancf.GeneralizedAlpha(0.5))
    depth = run.contact_force(among).penetration / RADIUS
    assert 1e-4 < depth[-1] < 0.01
    assert depth.max() < 0.01
    assert run.stats.iterations < 5 * run.stats.steps


def test_tension_presses_a_rope_on_what_it_crosses():
    """Ten times the force need at least ten times the stiffness, once it exceeds the weight."""

    def stiffness(force):
        scene, contact = crossing(0.0101, gravity=0.0, velocity=(0.0, 0.0, -1e-6))
        scene.point_force(contact.bodies[1].end, (0.0, force, 0.0))
        return default_stiffness_between(System(scene), contact)

    assert stiffness(100.0) == pytest.approx(10.0 * stiffness(10.0))
    # At rest a crossing under twice this force sinks in by 1 % of the radius.
    e, d = 0.01 * RADIUS, 2.0 * RADIUS
    assert 4.0 / 3.0 * math.sqrt(2.0 * d) * stiffness(10.0) * e**1.5 == pytest.approx(20.0)


def test_bodies_that_nothing_known_presses_together_need_a_stiffness():
    scene, _ = crossing(0.02, gravity=0.0)
    sentence = "the stiffness of the contact of beam 0 with beam 1 is needed: neither weight nor"
    with pytest.raises(ancf.InputError, match=sentence):
        ancf.simulate(scene, 0.01, 1e-3)


def test_a_force_that_is_not_known_is_reported_with_a_stiffness_that_suffices():
    def build(stiffness=None):
        scene = ancf.Scene((0.0, 0.0, -0.01))
        lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 10, ROPE, RUBBER)
        scene.clamp(lower.start)
        scene.clamp(lower.end)
        upper = scene.add_beam("thin", (0, -0.5, 0.0102), (0, 0.5, 0.0102), 10, ROPE, RUBBER)
        scene.force([upper.at(0.5)], lambda x, v, t: np.array([[0.0, 0.0, -400.0 * min(t, 0.02)]]))
        return scene, scene.contact(lower, upper, stiffness=stiffness)

    scene, contact = build()
    with pytest.warns(ancf.PenetrationWarning, match="the default stiffness of") as caught:
        ancf.simulate(scene, 0.04, 5e-4)
    enough = float(re.search(r"stiffness=(\S+)$", str(caught[0].message)).group(1))
    scene, contact = build(enough)
    run = ancf.simulate(scene, 0.04, 5e-4)
    assert run.contact_force(contact).penetration.max() < 0.15 * RADIUS
