"""Forces and moments of joints: hand statics, balances of bodies in motion, numbering or not."""

from __future__ import annotations

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import SingularSceneError

G = 9.81
EXACT = {"integrator": ancf.GeneralizedAlpha(0.9), "solver": ancf.Newton(), "tolerance": 1e-13}


def test_a_weld_carries_weight_and_its_moment():
    scene = ancf.Scene((0.0, 0.0, -G))
    box = scene.add_body(
        ancf.Box(length=0.4, width=0.1, height=0.2), mass=2.0, position=(1.0, 0.5, 0.0)
    )
    weld = scene.weld(scene.add_body(ancf.Sphere(0.1), mass=0.5, position=(0, 0, 0)).origin)
    arm = scene.weld(box.at((-1.0, -0.5, 0.0)), scene.bodies[1].origin)
    rest = ancf.simulate(scene, 0.01, 0.01, **EXACT)
    force = rest.joint_force(arm)
    np.testing.assert_allclose(force.force[-1], [0.0, 0.0, 2.0 * G], atol=1e-7)
    # The weight acts at (1, .5, 0) from the weld: the moment that holds it is -(r x -mg e_z).
    np.testing.assert_allclose(force.moment[-1], [0.5 * 2 * G, -2 * G, 0.0], atol=1e-7)
    whole = rest.joint_force(weld)
    np.testing.assert_allclose(whole.force[-1], [0.0, 0.0, 2.5 * G], atol=1e-7)
    np.testing.assert_allclose(whole.moment[-1], force.moment[-1], atol=1e-7)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("stretch", ["free", "fixed"])
def test_a_clamp_carries_what_the_beam_does(dim, stretch):
    down = (0.0, -1.0, 0.0)[:dim]
    scene = ancf.Scene(np.zeros(dim))
    section, material = ancf.Rectangle(0.02, 0.02), ancf.Material(2e9, 1e3)
    axis = np.array([0.8, 0.6, 0.0])[:dim]
    rod = scene.add_beam("thin", np.zeros(dim), 2.0 * axis, 8, section, material)
    clamp = scene.clamp(rod.start, stretch=stretch)
    scene.point_force(rod.end, 3.0 * np.array(down))
    rest = ancf.solve_static(scene, tolerance=1e-12)
    found = rest.joint_force(clamp)
    np.testing.assert_allclose(found.force, -3.0 * np.array(down), atol=1e-9)
    x = rest.position(rod.end)[0]
    np.testing.assert_allclose(found.moment if dim == 2 else found.moment[2], 3.0 * x, rtol=1e-9)


def double_pendulum(as_constraint=False):
    """Two boxes in space on a hinge each, the second hinge askew; the handles."""
    scene = ancf.Scene((0.3, 0.0, -G))
    one = scene.add_body(
        ancf.Box(length=1.0, width=0.1, height=0.2), mass=2.0, position=(0.5, 0, 0)
    )
    other = scene.add_body(
        ancf.Box(length=0.2, width=0.1, height=0.8), mass=1.0, position=(1.0, 0.4, 0)
    )
    first = scene.revolute(one.at((-0.5, 0, 0)), axis=(0, 1, 0))
    second = scene.revolute(one.at((0.5, 0, 0)), other.at((0, -0.4, 0)), axis=(1, 0, 0.5))
    return scene, (one, other), (first, second)


def test_forces_and_moments_balance_bodies_in_motion():
    scene, (one, other), (first, second) = double_pendulum()
    run = ancf.simulate(scene, 0.4, 2e-4, **EXACT)
    outer, inner = run.joint_force(second), run.joint_force(first)
    weight = np.array([0.3, 0.0, -G])
    k = slice(200, None, 100)
    for body, mass, forces in (
        (one, 2.0, [(first, inner, 1.0), (second, outer, 1.0)]),
        (other, 1.0, [(second, outer, -1.0)]),
    ):
        motion, centre = run.body(body), run.position(body.centre)
        pull = sum(sign * each.force for _, each, sign in forces)
        np.testing.assert_allclose(
            pull[k], mass * (run.acceleration(body.centre) - weight)[k], rtol=1e-6, atol=1e-6
        )
        spin = motion.angular_momentum - mass * np.cross(centre, motion.velocity)
        change = np.gradient(spin, run.t, axis=0, edge_order=2)
        moment = 0.0
        for joint, each, sign in forces:
            node = next(n for n in joint.nodes if n.beam is body)
            arm = run.position(node) - centre
            moment = moment + sign * (each.moment + np.cross(arm, each.force))
        np.testing.assert_allclose(moment[k], change[k], atol=2e-4 * np.abs(change).max())


def test_a_hinge_without_friction_has_no_moment_about_its_axis():
    scene, _, (first, second) = double_pendulum()
    run = ancf.simulate(scene, 0.4, 1e-3, **EXACT)
    for joint in (first, second):
        space, own = run.joint_force(joint), run.joint_force(joint, frame="joint")
        size = np.abs(own.moment).max()
        np.testing.assert_allclose(own.moment[:, 0], 0.0, atol=1e-9 * size)
        for one, other in ((space.force, own.force), (space.moment, own.moment)):
            np.testing.assert_allclose(*(np.linalg.norm(x, axis=1) for x in (one, other)))


@pytest.mark.parametrize("dim", [2, 3])
def test_pins_by_numbering_and_by_equations_pull_alike(dim):
    found = []
    for as_constraint in (False, True):
        scene = ancf.Scene((0.0, -G, 0.0)[:dim])
        rod = scene.add_body(ancf.Rod(1.0), mass=1.0, position=np.zeros(dim))
        link = scene.add_body(ancf.Rod(0.5), mass=0.3, position=np.zeros(dim), velocity=None)
        pin = scene.pin(rod.origin, as_constraint=as_constraint)
        joint = scene.connect(rod.origin, link.origin)
        run = ancf.simulate(scene, 0.3, 1e-3, **EXACT)
        both = [run.joint_force(each) for each in (pin, joint)]
        found.append([both[0].force, both[1].force, both[0].moment, both[1].moment])
        assert np.abs(both[1].force).max() > 0.3
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-6)
    np.testing.assert_allclose(found[0][2], 0.0, atol=1e-9)


def test_the_swing_of_a_rod_pulls_two_and_a_half_times_its_weight():
    # Slender rod released level: at the bottom the pin carries 5/2 m g.
    scene = ancf.Scene((0.0, -G))
    rod = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0))
    pin = scene.pin(rod.origin)
    run = ancf.simulate(scene, 0.6, 1e-3, **EXACT)
    assert run.joint_force(pin).force[:, 1].max() == pytest.approx(2.5 * G, rel=1e-5)


def test_a_weld_of_beams_carries_what_their_sections_do():
    scene = ancf.Scene((0.0, 0.0))
    section, material = ancf.Rectangle(0.02, 0.02), ancf.Material(2e9, 1e3)
    one = scene.add_beam("thin", (0, 0), (1, 0), 6, section, material)
    other = scene.add_beam("thin", (1, 0), (1, 1), 6, section, material)
    scene.clamp(one.start)
    weld = scene.weld(one.end, other.start)
    scene.point_force(other.end, (2.0, 0.0))
    rest = ancf.solve_static(scene, tolerance=1e-12)
    found = rest.joint_force(weld)  # of the second beam on the first
    np.testing.assert_allclose(found.force, [2.0, 0.0], atol=1e-9)
    lever = (rest.position(other.end) - rest.position(one.end))[1]
    np.testing.assert_allclose(found.moment, -2.0 * lever, rtol=1e-9)


def test_the_moment_of_a_drive():
    scene = ancf.Scene((0.0, -G))
    rod = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0))
    pin = scene.pin(rod.origin)
    drive = scene.drive_joint(pin, lambda t: 3.0 * t**3)
    run = ancf.simulate(scene, 0.5, 1e-3, **EXACT)
    angle = 3.0 * run.t**3
    expected = 18.0 * run.t / 3.0 + 0.5 * G * np.cos(angle)
    np.testing.assert_allclose(run.joint_force(drive).moment, expected, atol=2e-3)
    np.testing.assert_allclose(run.joint_force(drive).force, 0.0, atol=1e-9)


def test_a_distance_pulls_along_its_line():
    scene = ancf.Scene((0.0, -G))
    one = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0))
    other = scene.add_body(ancf.Rod(1.0), mass=2.0, position=(0, -1))
    pin = scene.pin(one.centre)
    link = scene.distance(one.centre, other.centre)
    rest = ancf.simulate(scene, 0.01, 0.01, **EXACT)
    np.testing.assert_allclose(rest.joint_force(link).force[-1], [0.0, -2.0 * G], atol=1e-6)
    np.testing.assert_allclose(rest.joint_force(pin).force[-1], [0.0, 3.0 * G], atol=1e-6)


def test_a_force_that_nothing_determines_is_refused():
    scene = ancf.Scene((0.0, 0.0, -G))
    boxes = [
        scene.add_body(ancf.Box(length=0.2, width=0.2, height=0.2), mass=1.0, position=(x, 0, 0))
        for x in (0, 1)
    ]
    slides = [scene.prismatic(box.origin, axis=(1, 0, 0)) for box in boxes]
    both = scene.prismatic(boxes[0].origin, boxes[1].origin, axis=(1, 0, 0))
    with pytest.warns(ancf.RedundantConstraintsWarning):
        run = ancf.simulate(scene, 0.01, 0.01, integrator=ancf.GeneralizedAlpha(0.9))
    with pytest.raises(SingularSceneError, match="not determined: other joints also fix"):
        run.joint_force(both)
    assert len(slides) == 2


def test_bad_arguments_of_joint_force():
    scene, (one, _), (first, _) = double_pendulum()
    run = ancf.simulate(scene, 0.01, 0.01)
    with pytest.raises(ancf.InputError, match="joint_force needs a joint"):
        run.joint_force(one.origin)
    with pytest.raises(ancf.InputError, match="frame of joint_force"):
        run.joint_force(first, frame="body")
    with pytest.raises(ancf.InputError, match="not part of this scene: take"):
        run.joint_force(double_pendulum()[2][0])
    assert math.isfinite(run.joint_force(first).force.sum())


def test_what_is_added_to_the_scene_after_a_run_changes_no_force():
    scene = ancf.Scene((0.0, 0.0, -9.81))
    lid = scene.add_body(ancf.Box(length=1.0, width=0.1, height=0.2), mass=1.0, position=(0, 0, 0))
    hinge = scene.revolute(lid.at((-0.5, 0, 0)), axis=(0, 1, 0))
    run = ancf.simulate(scene, 4e-3, 1e-3)
    before = run.joint_force(hinge).force
    other = scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(3, 0, 0))
    scene.pin(other.origin)
    np.testing.assert_array_equal(run.joint_force(hinge).force, before)
    with pytest.raises(ancf.InputError, match="not part of this scene: take"):
        run.joint_force(scene.revolute(other.at((0.1, 0, 0)), axis=(0, 1, 0)))
