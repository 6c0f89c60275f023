"""Joints and loads: what is kept, and what is refused."""

import numpy as np
import pytest

from ancfsparse.errors import InputError, LoadError, SingularSceneError
from ancfsparse.scene import Clamp, Connect, Material, Pin, Rectangle, RigidRod, Scene


def two_beams(scene=None):
    """Give a scene with two beams of 1 m that meet at (1, 0)."""
    scene = scene or Scene()
    pad = (0.0,) * (scene.dim - 2)
    shared = (Rectangle(0.01, 0.01), Material(1e8, 4000.0))
    left = scene.add_beam("thin", (0, 0, *pad), (1, 0, *pad), 4, *shared)
    right = scene.add_beam("thin", (1, 0, *pad), (1, 1, *pad), 5, *shared)
    return scene, left, right


def test_joints_are_kept_in_order():
    scene, left, right = two_beams()
    pin = scene.pin(left.start, as_constraint=True)
    joint = scene.connect(left.end, right.start)
    clamp = scene.clamp(right.end, stretch="fixed")
    rod = scene.rod(left.node(2), (0.5, -2.0))
    assert scene.joints == [pin, joint, clamp, rod]
    assert isinstance(pin, Pin)
    assert pin.as_constraint
    assert isinstance(joint, Connect)
    assert (joint.a, joint.b) == (left.end, right.start)
    assert isinstance(clamp, Clamp)
    assert clamp.stretch == "fixed"
    assert isinstance(rod, RigidRod)
    assert rod.length == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("say", "message"),
    [
        (lambda s, a, b: s.pin(a), "a pin needs a point on a beam such as rod.start"),
        (lambda s, a, b: s.pin(a.start, as_constraint=lambda t: (0, t)),
         "as_constraint of a pin must be True or False, got <function"),
        (lambda s, a, b: s.pin(a.start, as_constraint="no"), "must be True or False, got 'no'"),
        (lambda s, a, b: s.point_moment(a.start, [[1, 2], [3]]), "must be one number about [+]z"),
        (lambda s, a, b: s.clamp(a.at(0.3)),
         r"a clamp needs a node, but beam 0 at s = 0.3 m lies inside element 1: the nodes are "
         r"0.25 m apart, take rod.node\(1\)"),
        (lambda s, a, b: s.weld(a.at(0.3)), "a weld needs a node"),
        (lambda s, a, b: s.point_moment(b.at(0.1), 1.0), "a moment needs a node"),
        (lambda s, a, b: s.clamp(a.start, "half"), "unknown stretch of a clamp 'half': valid are"),
        (lambda s, a, b: s.rod(a.end, (0, 1, 0)), "anchor of the rod at beam 0 at s = 1 m has 3"),
        (lambda s, a, b: s.rod(a.end, (np.nan, 1)), "anchor .* must be finite"),
        (lambda s, a, b: s.rod(a.end, (1e300, 1)), r"lies beyond 1e\+150 m, at \(1e\+300, 1\) m"),
        (lambda s, a, b: s.rod(a.end, (0, 1), second_rate=5.0),
         "has a rate and is constant: give it as a function"),
        (lambda s, a, b: s.rod(a.end, (1, 0)),
         r"would have zero length: its anchor \(1, 0\) m is the node itself; .* use pin"),
        (lambda s, a, b: s.connect(a.start, b.end),
         r"they are 1.41421 m apart, at \(0, 0\) m and \(1, 1\) m; move one beam"),
        (lambda s, a, b: s.connect(a.end, a.end), "a connection needs two points, got beam 0"),
        (lambda s, a, b: s.point_force("tip", (0, 1)), "a force needs a point .* got 'tip'"),
        (lambda s, a, b: s.distributed_force(a.end, (0, 1)), "needs a beam of the scene, got beam"),
    ],
)  # fmt: skip
def test_joints_and_loads_in_the_wrong_place(say, message):
    scene, left, right = two_beams()
    with pytest.raises(InputError, match=message):
        say(scene, left, right)
    assert scene.joints == []
    assert scene.loads == []


@pytest.mark.parametrize(
    "say",
    [
        lambda s, other: s.pin(other.start),
        lambda s, other: s.clamp(other.start),
        lambda s, other: s.rod(other.start, (5, 5)),
        lambda s, other: s.connect(s.beams[0].start, other.start),
        lambda s, other: s.point_force(other.start, (1, 0)),
        lambda s, other: s.point_moment(other.start, 1.0),
        lambda s, other: s.distributed_force(other, (1, 0)),
    ],
)
def test_handles_of_another_scene(say):
    scene, _, _ = two_beams()
    _, stranger, _ = two_beams()
    with pytest.raises(InputError, match="was given beam 0 of another scene: use a handle"):
        say(scene, stranger)


@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        (lambda s, a, b: s.pin(a.start), lambda s, a, b: s.pin(a.start),
         "beam 0 at s = 0 m is constrained twice: the pin at .* its position, leave out the pin$"),
        (lambda s, a, b: s.pin(a.start), lambda s, a, b: s.clamp(a.start), "leave out the clamp"),
        (lambda s, a, b: s.pin(a.start), lambda s, a, b: s.rod(a.start, (0, 1)),
         "its position is fixed by a pin, so the rod is redundant"),
        (lambda s, a, b: s.rod(a.start, (0, 1)), lambda s, a, b: s.clamp(a.start), "by a clamp"),
        (lambda s, a, b: s.rod(a.end, (0, 1)), lambda s, a, b: s.rod(a.end, (2, -1)),
         "its 2 rods point in dependent directions"),
        (lambda s, a, b: s.connect(a.end, b.start), lambda s, a, b: s.connect(b.start, a.end),
         "already coincide by other connections"),
        (lambda s, a, b: (s.connect(a.end, b.start), s.pin(a.end)), lambda s, a, b: s.pin(b.start),
         "beam 1 at s = 0 m is constrained twice: the pin at beam 0 at .* or the connection"),
        (lambda s, a, b: (s.pin(a.end), s.pin(b.start)),
         lambda s, a, b: s.connect(a.end, b.start), "is constrained twice"),
    ],
)  # fmt: skip
def test_nothing_is_held_twice(first, second, message):
    scene, left, right = two_beams()
    first(scene, left, right)
    held = len(scene.joints)
    with pytest.raises(SingularSceneError, match=message):
        second(scene, left, right)
    assert len(scene.joints) == held


def test_two_rods_may_hold_one_node():
    scene, left, _ = two_beams()
    scene.rod(left.end, (1, 1))
    scene.rod(left.end, (2, 0))
    assert len(scene.joints) == 2


def test_constant_loads_are_kept_as_vectors():
    scene, left, right = two_beams()
    force = scene.point_force(left.at(0.3), (1, -2))
    moment = scene.point_moment(right.end, 3)
    gale = scene.distributed_force(right, [0.5, 0.0])
    assert scene.loads == [force, moment, gale]
    np.testing.assert_array_equal(force.value, [1.0, -2.0])
    np.testing.assert_array_equal(force.at(7.0), [1.0, -2.0])
    assert moment.value == 3.0
    np.testing.assert_array_equal(moment.at(7.0), [3.0])
    np.testing.assert_array_equal(gale.at(7.0), [0.5, 0.0])


def test_loads_may_be_functions_of_time():
    scene, left, right = two_beams()
    force = scene.point_force(left.end, lambda t: (0.0, np.sin(t)))
    moment = scene.point_moment(right.end, lambda t: 2.0 * t)
    np.testing.assert_allclose(force.at(0.5), [0.0, np.sin(0.5)])
    np.testing.assert_allclose(moment.at(0.5), [1.0])
    with pytest.raises(LoadError, match="a function of time, at t = 2 s, must be finite, but its"):
        scene.point_force(left.end, lambda t: (0.0, np.nan if t > 1 else 0.0)).at(2.0)


def test_moments_in_space_have_three_components():
    scene, left, _ = two_beams(Scene((0, 0, -9.81)))
    np.testing.assert_array_equal(scene.point_moment(left.end, (0, 0, 1)).at(0.0), [0.0, 0.0, 1.0])
    with pytest.raises(InputError, match="the moment on beam 0 at s = 1 m has shape"):
        scene.point_moment(left.end, 1.0)


@pytest.mark.parametrize(
    ("say", "message"),
    [
        (lambda s, a: s.point_force(a.end, (0, 0, 1)),
         "the force on beam 0 at s = 1 m has 3 components, but the scene is planar"),
        (lambda s, a: s.point_force(a.end, (0, np.nan)), "its y component is nan N"),
        (lambda s, a: s.point_force(a.end, lambda t: (0, 0, t)),
         "a function of time, at t = 0 s, has 3 components"),
        (lambda s, a: s.point_force(a.end, lambda t: None), "must be|has shape"),
        (lambda s, a: s.point_moment(a.end, (0, 0, 1)),
         "the moment on beam 0 at s = 1 m must be one number about .z because the scene is planar"),
        (lambda s, a: s.point_moment(a.end, np.inf), "moment .* must be finite, got inf N m"),
        (lambda s, a: s.point_moment(a.end, lambda t: np.nan), "at t = 0 s, must be finite"),
        (lambda s, a: s.distributed_force(a, (0, np.nan)),
         "the distributed force on beam 0 must be finite, but its y component is nan N/m"),
        (lambda s, a: s.distributed_force(a, 3.0), "the distributed force on beam 0 has shape"),
    ],
)  # fmt: skip
def test_impossible_loads(say, message):
    scene, left, _ = two_beams()
    with pytest.raises(InputError, match=message):
        say(scene, left)
    assert scene.loads == []


def test_a_cable_cannot_be_twisted():
    scene = Scene((0.0, -9.81, 0.0))
    section, material = Rectangle(0.01, 0.01), Material(1e8, 4000.0)
    cable = scene.add_beam("thin", (0, 0, 0), (1, 0, 0), 2, section, material)
    with pytest.raises(InputError, match="along the axis of a cable"):
        scene.point_moment(cable.end, (5.0, 0.0, 0.0))
    scene.point_moment(cable.end, (5.0, 1.0, 0.0))
    beam = scene.add_beam("thick", (0, 1, 0), (1, 1, 0), 2, section, material)
    scene.point_moment(beam.end, (5.0, 0.0, 0.0))


def test_a_pin_takes_no_motion_in_the_place_of_a_switch():
    scene, left, _ = two_beams()
    for motion in (lambda t: (0.0, t), (0.0, 1.0)):
        with pytest.raises(TypeError):
            scene.pin(left.start, motion)
    assert scene.joints == []
