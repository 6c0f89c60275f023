"""What begins to push on the way, beside its law evaluated by hand."""

import numpy as np
import pytest

import ancfsparse as ancf


def swung(attach):
    """A pendulum of 0.5 s, what is attached to it, and what begins to push."""
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (1, 0), 4, ancf.Circle(0.02), ancf.Material(1e8, 1000))
    made = attach(scene, rod)
    run = ancf.simulate(scene, 0.5, 5e-3)
    amplitudes = run.system.loads.amplitudes(run.t)
    found = [
        pair
        for each in run.system.contributions
        for pair in each.unilateral_forces(run.q, run.v, amplitudes)
    ]
    return run, rod, made, found


def held(scene, rod):
    scene.pin(rod.start)


def push(elongation):
    return min(0.0, 200.0 * elongation)


def test_springs_with_laws():
    def attach(scene, rod):
        held(scene, rod)
        scene.spring(rod.at(0.5), rod.start, stiffness=10.0)
        scene.spring(rod.end, (1.0, -1.0), stiffness=push, length=0.6)

    run, rod, _, found = swung(attach)
    [(name, values)] = found
    assert name.startswith("the force of the spring between beam 0")
    apart = np.linalg.norm(run.position(rod.end) - [1.0, -1.0], axis=1)
    assert np.allclose(values, [push(each - 0.6) for each in apart], rtol=1e-12, atol=1e-12)
    assert values[0] == 0.0
    assert values.min() < -1.0


def test_ropes():
    def attach(scene, rod):
        held(scene, rod)
        return scene.rope([rod.end, (1.5, 0.0)], stiffness=50.0, length=1.0)

    run, _, rope, found = swung(attach)
    [(name, values)] = found
    assert name.startswith("the tension of the rope over")
    assert np.array_equal(values, run.tension(rope))
    assert values[0] == 0.0
    assert values.max() > 1.0


def test_stops_count_from_their_range():
    """Of a range that is left, and of one that is not."""

    def attach(scene, rod):
        link = scene.add_body(position=(0, 0), mass=1.0, inertia=0.1)
        hinge = scene.pin(link.at((0.0, 0.0)))
        held(scene, rod)
        scene.point_moment(link.at((0.0, 0.0)), -1.0)
        scene.joint_stop(hinge, -0.5, 3.0, stiffness=20.0)
        scene.joint_stop(hinge, -3.0, 3.0, stiffness=20.0)
        return link

    run, _, link, found = swung(attach)
    (name, passed), (_, never) = found
    assert name.startswith("the penetration of the stop at the angle of the")
    assert name.endswith("[rad]")
    e_x = run.body(link).vectors[:, 1]
    angle = np.unwrap(np.arctan2(e_x[:, 1], e_x[:, 0]))
    assert np.allclose(passed, np.maximum(-0.5 - angle, 0.0), atol=1e-9)
    assert passed.max() > 0.01
    assert not never.any()


@pytest.mark.parametrize("reach", [0.6, 2.0])
def test_forces_of_the_motion_count_by_their_power(reach):
    def wall(q, v, t):
        out = np.zeros_like(q)
        out[:, 1] = 100.0 * np.maximum(0.0, -reach - q[:, 1])
        return out

    def attach(scene, rod):
        held(scene, rod)
        scene.force(rod.end, wall)

    run, rod, _, [(name, values)] = swung(attach)
    assert name.startswith("the power of the force on")
    by_hand = [
        float(np.sum(wall(q[None], None, 0.0) * v))
        for q, v in zip(run.position(rod.end), run.velocity(rod.end), strict=True)
    ]
    assert np.allclose(values, by_hand, rtol=1e-12, atol=1e-12)
    assert values.any() == (reach < 1.0)
