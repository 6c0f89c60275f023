"""Cables that fall on, slide over and close on each other, and what a contact of beams refuses."""

import math

import numpy as np
import pytest

import ancfsparse as ancf

RADIUS = 0.005
SECTION, MATERIAL = ancf.Circle(2.0 * RADIUS), ancf.Material(1e8, 5e3)
CONSERVING = ancf.EnergyMomentum()


def falling(height=0.05, stiffness=1e7, angle=1.2, n=10):
    """A cable above another one between two pins, which it crosses."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), n, SECTION, MATERIAL)
    scene.pin(lower.start)
    scene.pin(lower.end)
    along = 0.5 * np.array([math.cos(angle), math.sin(angle), 0.0])
    middle = np.array([0.013, 0.007, 2.0 * RADIUS + height])
    upper = scene.add_beam("thin", middle - along, middle + along, n, SECTION, MATERIAL)
    return scene, lower, upper, scene.contact(lower, upper, stiffness=stiffness)


@pytest.mark.parametrize("dt", [1e-4, 1e-3, 5e-3])
def test_a_cable_that_falls_on_another_one_keeps_its_energy_and_stays_on_top(dt):
    scene, lower, upper, contact = falling()
    run = ancf.simulate(scene, 0.2, dt, integrator=CONSERVING, max_halvings=6)
    force = run.contact_force(contact)
    assert (force.size > 0.0).any()
    assert np.all(force.force[:, 2] <= 0.0)  # on the lower one
    above = run.position(upper.at(0.5))[:, 2] - run.position(lower.at(0.5))[:, 2]
    assert above.min() > 1.5 * RADIUS
    assert force.penetration.max() < 0.25 * RADIUS
    assert run.energy.drift < 1e-6


def test_a_fast_cable_does_not_pass_through_another_one_in_long_steps():
    """It moves by 10 diameters in a step, and touches the other neither at its ends nor halfway."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 10, SECTION, MATERIAL)
    upper = scene.add_beam(
        "thin", (0, -0.5, 0.08), (0, 0.5, 0.08), 10, SECTION, MATERIAL, velocity=(0, 0, -20.0)
    )
    scene.contact(lower, upper, stiffness=1e9)
    run = ancf.simulate(scene, 0.01, 5e-3, integrator=CONSERVING, max_halvings=12)
    above = run.position(upper.at(0.5))[:, 2] - run.position(lower.at(0.5))[:, 2]
    assert above.min() > 0.0
    assert run.energy.drift < 1e-6
    assert any(event.cause == "passes through" for event in run.stats.events)
    with pytest.raises(ancf.StepError, match="pass through each other"):
        ancf.simulate(scene, 0.01, 5e-3, integrator=CONSERVING, max_halvings=0)


@pytest.mark.parametrize("integrator", [CONSERVING, ancf.GeneralizedAlpha(0.9)])
def test_momentum_and_moment_of_momentum_are_kept_in_a_collision(integrator):
    scene = ancf.Scene((0.0, 0.0, 0.0))
    one = scene.add_beam("thin", (-0.4, 0.05, 0), (0.6, 0.05, 0), 8, SECTION, MATERIAL)
    other = scene.add_beam(
        "thin", (0, -0.5, 0.02), (0.1, 0.5, 0.02), 8, SECTION, MATERIAL, velocity=(0.3, 0, -1.0)
    )
    contact = scene.contact(one, other, stiffness=1e7)
    run = ancf.simulate(scene, 0.03, 2e-4, integrator=integrator, tolerance=1e-10)
    assert run.contact_force(contact).size.max() > 0.0
    system = run.system
    inertia = system.assembly.inertia
    moments = []
    for q, v in ((run.q[0], run.v[0]), (run.q[-1], run.v[-1])):
        p = inertia(v)
        momentum = [p @ system.uniform(c) for c in range(3)]
        turning = np.zeros(3)
        for name in ("r", "r_x"):
            for places in system.vectors(name):
                turning += np.cross(q[places], p[places]).sum(axis=0)
        moments.append(np.array([*momentum, *turning]))
    change = np.abs(moments[1] - moments[0])
    assert change[:3].max() < 1e-8 * np.abs(moments[0]).max()
    if integrator is CONSERVING:
        assert change[3:].max() < 1e-7 * np.abs(moments[0]).max()


def ring(stiffness=1e7):
    """A turn of a helix whose ends pass each other at some distance, and approach each other."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    helix = ancf.Helix(0.1, pitch=6.0 * RADIUS, turns=1.2)
    height = 7.2 * RADIUS

    def speed(x):
        return np.outer(1.0 - 2.0 * x[:, 2] / height, (0.0, 0.0, 1.0))

    loop = scene.add_beam(
        "thin", curve=helix, rest="straight", n_elements=44, section=SECTION, material=MATERIAL,
        velocity=speed,
    )  # fmt: skip
    return scene, loop, scene.contact(loop, loop, stiffness=stiffness)


def test_a_loop_that_closes_touches_itself():
    scene, _, contact = ring()
    run = ancf.simulate(scene, 0.04, 2e-4, integrator=CONSERVING, max_halvings=6)
    force = run.contact_force(contact)
    assert force.size[0] == 0.0
    assert force.size.max() > 1.0
    assert np.allclose(force.force, 0.0, atol=1e-12 * force.size.max())
    assert force.penetration.max() < 0.3 * RADIUS
    assert run.energy.drift < 1e-6


def test_planar_cables_press_on_each_other_from_the_side():
    scene = ancf.Scene((0.0, -9.81))
    lower = scene.add_beam("thin", (0, 0), (1, 0), 8, SECTION, MATERIAL)
    for node in (lower.start, lower.end):
        scene.clamp(node)
    upper = scene.add_beam("thin", (0.3, 0.02), (0.7, 0.02), 4, SECTION, MATERIAL)
    contact = scene.contact(lower, upper, stiffness=1e7)
    run = ancf.simulate(scene, 0.15, 1e-3, integrator=CONSERVING, max_halvings=6)
    assert run.position(upper.at(0.2))[:, 1].min() > -0.1
    assert run.contact_force(contact).size.max() > 0.0
    assert np.all(run.contact_force(contact).force[:, 1] <= 0.0)
    assert run.energy.drift < 1e-6


def test_explicit_and_implicit_runs_of_a_fall_agree():
    def place(**options):
        scene, _, upper, _ = falling(height=0.01, stiffness=1e6)
        run = ancf.simulate(scene, 0.08, **options)
        return run.position(upper.at(0.5))[-1, 2]

    implicit = place(dt=1e-4, integrator=CONSERVING)
    assert place(dt=2e-6, integrator=ancf.CentralDifference()) == pytest.approx(implicit, abs=2e-5)


def pair(dim=3, gap=0.05, **options):
    scene = ancf.Scene((0.0,) * dim)
    pad = (0.0,) * (dim - 2)
    section = options.pop("section", SECTION)
    one = scene.add_beam("thin", (0, 0, *pad), (1, 0, *pad), 4, section, MATERIAL)
    two = scene.add_beam("thin", (0, gap, *pad), (1, gap, *pad), 4, section, MATERIAL)
    return scene, one, two


def test_bodies_that_begin_inside_each_other_are_refused_with_place_and_depth():
    scene, one, two = pair(gap=0.006)
    scene.contact(one, two, stiffness=1e6)
    with pytest.raises(ancf.InputError, match=r"penetration of 0.004 m at beam 0.* and beam 1"):
        ancf.simulate(scene, 0.01, 1e-3)
    scene = ancf.Scene((0.0, 0.0))
    one = scene.add_beam("thin", (0, 0), (1, 0), 4, SECTION, MATERIAL)
    two = scene.add_beam("thin", (0.45, -0.5), (0.45, 0.5), 4, SECTION, MATERIAL)
    scene.contact(one, two, stiffness=1e6)
    with pytest.raises(ancf.InputError, match=r"penetration of 0.01 m at beam 0 at s = 0.45 m"):
        ancf.solve_static(scene)


def test_wrong_arguments_are_refused_in_one_sentence():
    scene, one, two = pair()
    _, stranger, _ = pair()
    for wrong, sentence in (
        ((one, two, {"stiffness": 0.0}), "stiffness of the contact of beam 0"),
        ((one, two, {"stiffness": 1.0, "on": one}), "is for obstacles"),
        ((one, two, {"stiffness": 1e6, "radius": -1.0}), "radius of the contact of beam 0"),
        ((one, two, {"stiffness": 1e6, "friction": -0.1}), "friction of the contact of beam 0"),
        (
            (one, two, {"stiffness": 1e6, "friction": 0.1, "slip_speed": 0.0}),
            "slip_speed of the contact of beam 0",
        ),
        ((one, stranger, {"stiffness": 1e6}), "not .* of this scene|another scene"),
        ((one, "floor", {"stiffness": 1e6}), "a beam or a mesh, got"),
        ((one, one.end, {"stiffness": 1e6}), "a beam or a mesh, got"),
    ):
        body, other, options = wrong
        with pytest.raises(ancf.InputError, match=sentence):
            scene.contact(body, other, **options)
    scene.contact(one, two, stiffness=1e6)
    with pytest.raises(ancf.InputError, match="added before"):
        scene.contact(two, one, stiffness=1e6)
    scene, one, two = pair(section=ancf.Rectangle(0.01, 0.01))
    with pytest.raises(ancf.InputError, match="not round"):
        scene.contact(one, two, stiffness=1e6)
    scene.contact(one, two, stiffness=1e6, radius=RADIUS)
    auto = scene.add_beam("auto", (0, 1, 0), (1, 1, 0), "auto", SECTION, MATERIAL)
    with pytest.raises(ancf.InputError, match="instead of 'auto'"):
        scene.contact(one, auto, stiffness=1e6, radius=RADIUS)


def test_a_contact_of_beams_is_saved_and_refined(tmp_path):
    scene, lower, _, _ = falling()
    scene.contact(lower, lower, stiffness=1e7, friction=0.2, slip_speed=0.01)
    scene.save(tmp_path / "scene.json")
    again = ancf.Scene.load(tmp_path / "scene.json")
    assert again.digest() == scene.digest()
    assert again.records == scene.records
    finer = scene.refined(2)
    assert finer.attachments[0].bodies[0].n_elements == 20
    assert finer.attachments[1].friction == 0.2
    assert finer.attachments[1].slip_speed == 0.01
    assert "beam 1" in repr(finer.digest())
