"""Ends that a joint fixes to the body, or on the obstacle, that they touch."""

import numpy as np
import pytest

import ancfsparse as ancf

RADIUS = 0.005
SECTION, MATERIAL = ancf.Circle(2.0 * RADIUS), ancf.Material(1e7, 5e3)
SETTINGS = {"t_end": 0.06, "dt": 5e-4, "integrator": ancf.EnergyMomentum()}
LAWS = [{}, {"friction": 0.3}, {"friction": 0.3, "static_friction": 0.5}, {"restitution": 0.5}]


def tied(law=None, joint="weld"):
    """A cable that hangs from the lower face of a box which swings about its upper face."""
    scene = ancf.Scene((0.0, -9.81))
    box = scene.add_body(mass=0.5, inertia=1e-3, position=(0.0, 0.0))
    scene.pin(box.at((0.0, 0.05)))
    scene.point_force(box.origin, (3.0, 0.0))
    cable = scene.add_beam("thin", (0.01, -0.05), (0.01, -0.45), 16, SECTION, MATERIAL)
    getattr(scene, joint)(box.at((0.01, -0.05)), cable.start)
    contact = None
    if law is not None:
        shape = ancf.Block((0.0, 0.0), (0.2, 0.1))
        contact = scene.contact(cable, shape, on=box, stiffness=1e4, **law)
    return scene, cable, contact


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("joint", ["weld", "connect"])
def test_a_cable_tied_to_a_body_hangs_from_it_as_without_contact(law, joint):
    scene, cable, contact = tied(law, joint)
    free = ancf.simulate(tied(joint=joint)[0], **SETTINGS)
    run = ancf.simulate(scene, **SETTINGS)
    np.testing.assert_allclose(run.q, free.q, rtol=1e-9, atol=1e-9)
    assert not run.contact_force(contact).force.any()
    assert np.isfinite(run.energy.friction).all()
    assert run.energy.impact_damping[-1] == 0.0
    sentence = f"{contact.what} leaves out 0.01 m along the axis from the joint at {cable.start!r}"
    assert sentence in str(scene)
    assert repr(run.contacts(0.01)) == f"no contacts\n{sentence}"


def test_a_joint_must_be_known_when_the_contact_is_added():
    scene = ancf.Scene((0.0, -9.81))
    cable = scene.add_beam("thin", (0.0, 0.0), (0.0, 0.4), 16, SECTION, MATERIAL)
    floor = ancf.HalfSpace((0.0, 0.0), (0.0, 1.0))
    with pytest.raises(ancf.InputError, match="add the joint first"):
        scene.contact(cable, floor)
    scene.clamp(cable.start)
    scene.contact(cable, floor)


@pytest.mark.parametrize("height", [0.2, 0.8])
def test_the_length_is_that_of_the_depth_and_the_radius(height):
    """A clamped cable parallel to a floor, inside it everywhere, is free over this length alone."""
    scene = ancf.Scene((0.0, 0.0))
    y = height * RADIUS
    cable = scene.add_beam("thin", (0.0, y), (0.06, y), 24, SECTION, MATERIAL)
    scene.clamp(cable.start)
    contact = scene.contact(cable, ancf.HalfSpace((0.0, 0.0), (0.0, 1.0)), stiffness=1e2)
    with pytest.warns(ancf.PenetrationWarning, match="begins with a penetration of"):
        force = ancf.simulate(scene, 1e-4, 1e-4).contact_force(contact)
    np.testing.assert_array_equal(force.pressure[0] > 0.0, force.s >= (2.0 - height) * RADIUS)


def test_a_cable_that_is_held_at_a_bump_touches_the_rest_of_it():
    """It is fixed on the top of a ball and falls over its side, where friction slows it down."""
    scene = ancf.Scene((0.0, -9.81))
    cable = scene.add_beam("thin", (0.0, 0.1), (0.0, 0.3), 24, SECTION, MATERIAL)
    scene.pin(cable.start)
    scene.point_force(cable.end, (0.3, 0.0))
    ball = ancf.Ball((0.0, 0.0), 0.1)
    contact = scene.contact(cable, ball, stiffness=1e5, friction=0.2)
    with pytest.warns(
        ancf.PenetrationWarning,
        match="1.4 times the radius .* t = 0.* s = 0.19",
    ):
        run = ancf.simulate(scene, 0.4, 5e-4, integrator=ancf.EnergyMomentum(), max_halvings=5)
    force = run.contact_force(contact)
    assert np.linalg.norm(force.force, axis=1).max() > 0.1
    assert not force.pressure[:, force.s < 2.0 * RADIUS].any()
    assert run.energy.drift < 1e-5
    outside = np.linalg.norm(run.position(cable.at(0.1)), axis=1)
    assert outside.min() > 0.1


def branch(with_contact):
    scene = ancf.Scene((0.0, 0.0, -9.81))
    trunk = scene.add_beam("thin", (0, 0, 0), (0.4, 0, 0), 20, SECTION, MATERIAL)
    scene.clamp(trunk.start)
    twig = scene.add_beam("thin", (0.2, 0, 0), (0.3, 0.2, 0), 12, SECTION, MATERIAL)
    scene.connect(twig.start, trunk.at(0.2))
    contact = scene.contact(trunk, twig, stiffness=1e5, friction=0.3) if with_contact else None
    return scene, contact


def test_cables_that_are_joined_do_not_press_at_the_joint():
    scene, contact = branch(True)
    assert "leaves out 0.02 m along the axis from the joint at beam 0 at s = 0.2 m" in str(scene)
    run, free = (ancf.simulate(each, **SETTINGS) for each in (scene, branch(False)[0]))
    np.testing.assert_allclose(run.q, free.q, rtol=1e-9, atol=1e-9)
    assert not run.contact_force(contact).size.any()


def test_a_loop_that_a_joint_closes_does_not_press_there():
    scenes = []
    for with_contact in (False, True):
        scene = ancf.Scene((0.0, 0.0))
        circle = ancf.Arc((0.0, 0.0), (0.1, 0.0), 2.0 * np.pi)
        loop = scene.add_beam(
            "thin", curve=circle, n_elements=40, section=SECTION, material=MATERIAL,
            velocity=lambda x: x * (2.0, -2.0),
        )  # fmt: skip
        scene.connect(loop.start, loop.end)
        if with_contact:
            scene.contact(loop, loop, stiffness=1e5)
        scenes.append(scene)
    free, run = (ancf.simulate(each, 0.02, 5e-4) for each in scenes)
    np.testing.assert_allclose(run.q, free.q, rtol=1e-9, atol=1e-9)
