"""Rigid bodies as they are given: what they become, and what is refused in one sentence."""

import copy
import pickle

import numpy as np
import pytest

import ancfsparse as ancf


def spatial():
    return ancf.Scene((0.0, 0.0, -9.81))


def planar():
    return ancf.Scene((0.0, -9.81))


def test_moments_of_shapes():
    """Against the formulas of textbooks, each about the centre, in the order x, y, z [kg m2]."""
    m = 3.0
    shapes = {
        ancf.Box(length=1.0, width=0.1, height=0.2): m
        / 12
        * np.array([0.2**2 + 0.1**2, 1 + 0.1**2, 1 + 0.2**2]),
        ancf.Cylinder(0.3, 0.8): m / 12 * np.array([3 * 0.09 + 0.64, 3 * 0.09 + 0.64, 6 * 0.09]),
        ancf.Cylinder(0.3, 0.8, "x"): m / 12 * np.array([6 * 0.09, 0.91, 0.91]),
        ancf.Sphere(0.5): np.full(3, 0.4 * m * 0.25),
    }
    for shape, moments in shapes.items():
        scene = spatial()
        one = scene.add_body(shape, mass=m, position=(1, 2, 3))
        two = scene.add_body(inertia=moments, mass=m, position=(1, 2, 3))
        np.testing.assert_allclose(one.masses, two.masses, rtol=1e-13, atol=1e-15)
        dense = scene.add_body(shape, density=m / shape.volume, position=(1, 2, 3))
        np.testing.assert_allclose(dense.masses, one.masses, rtol=1e-14)


def test_a_tensor_is_that_of_its_principal_moments():
    scene, turn = spatial(), np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
    tensor = turn @ np.diag([2.0, 3.0, 4.0]) @ turn.T
    body = scene.add_body(inertia=tensor, mass=2.0, position=(0, 0, 0))
    second = body.masses[1:, 1:]
    np.testing.assert_allclose(np.trace(second) * np.eye(3) - second, tensor, atol=1e-14)


def test_orientations_agree():
    angle, quaternion = 0.7, (np.cos(0.35), 0.0, 0.0, np.sin(0.35))
    matrix = [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    bodies = [
        spatial().add_body(ancf.Sphere(1.0), mass=1.0, position=(0, 0, 0), orientation=each)
        for each in (quaternion, matrix)
    ]
    flat = planar().add_body(ancf.Sphere(1.0), mass=1.0, position=(0, 0), orientation=angle)
    np.testing.assert_allclose(bodies[0].vectors, bodies[1].vectors, atol=1e-15)
    np.testing.assert_allclose(bodies[0].vectors[0, :2, :2], flat.vectors[0], atol=1e-15)
    place = bodies[0].at((1.0, 2.0, 3.0)).position
    np.testing.assert_allclose(place, np.array(matrix) @ (1.0, 2.0, 3.0), atol=1e-15)


def test_a_body_is_copied_and_pickled():
    scene = planar()
    body = scene.add_body(ancf.Rod(2.0), mass=1.0, position=(0, 0), angular_velocity=1.0)
    scene.pin(body.origin)
    scene.connect(body.end, scene.add_body(ancf.Rod(1.0), mass=1.0, position=(2, 0)).origin)
    for other in (copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        assert other.digest() == scene.digest()


@pytest.mark.parametrize(
    ("give", "message"),
    [
        (dict(inertia=(1, 2, 3.5), mass=1.0), "violates the triangle inequality.*1, 2, 3.5 kg m2"),
        (dict(inertia=(0, 2, 2), mass=1.0), "must be positive; a thin rod.*Rod"),
        (dict(inertia=(1, 2), mass=1.0), "3 principal moments or a 3 x 3 tensor"),
        (dict(inertia=[[1, 1, 0], [0, 1, 0], [0, 0, 1]], mass=1.0), "must be symmetric"),
        (dict(inertia=(1, 1, 1)), "needs its mass or its density, got neither"),
        (dict(inertia=(1, 1, 1), density=1.0), "has a density and no volume"),
        (dict(shape=ancf.Rod(1.0), density=1.0), "has a density and no volume"),
        (dict(inertia=(1, 1, 1), mass=-1.0), "mass of body 0 .*positive.* -1 kg"),
        (dict(inertia=(1, 1, 1), mass=5e-324), r"mass of body 0 must lie between 1e-100 and .* kg"),
        (
            dict(inertia=(1e308, 1e308, 1e308), mass=1.0),
            "largest moment of the inertia .* must lie",
        ),
        (dict(inertia=(1, 1, 1), mass=1.0, centre=(1e300, 0, 0)), "centre of body 0 lies beyond"),
        (dict(shape="box", mass=1.0), "must be a Box, Cylinder, Sphere or Rod, got 'box'"),
        (dict(mass=1.0), "needs a shape or its inertia about its centre, got neither"),
        (dict(shape=ancf.Rod(1.0), mass=1.0, centre=(0, 1, 0)), "off the line of its rod"),
        (
            dict(shape=ancf.Sphere(1.0), mass=1.0, orientation=(1, 0, 0, 0.1)),
            "unit quaternion, got one of length 1.00498756",
        ),
        (dict(shape=ancf.Sphere(1.0), mass=1.0, orientation=np.diag([1, 1, -1])), "left-handed"),
        (
            dict(shape=ancf.Sphere(1.0), mass=1.0, orientation=np.diag([1, 1, 1.1])),
            "orthonormal columns, but they are off by 0.21",
        ),
        (dict(shape=ancf.Sphere(1.0), mass=1.0, orientation=0.3), "unit quaternion .* or a rot"),
        (dict(shape=ancf.Sphere(1.0), mass=1.0, angular_velocity=3.0), "angular velocity of body"),
        (dict(shape=ancf.Sphere(1.0), mass=1.0, position=(0, 0)), "position of body 0"),
    ],
)
def test_bad_bodies(give, message):
    with pytest.raises(ancf.InputError, match=message):
        spatial().add_body(**({"position": (0, 0, 0)} | give))


@pytest.mark.parametrize(
    "make",
    [
        lambda x: ancf.Box(length=1.0, width=1.0, height=x),
        lambda x: ancf.Cylinder(x, 1.0),
        ancf.Sphere,
        ancf.Rod,
    ],
)
def test_shapes_stay_in_the_range_of_numbers(make):
    for length in (1e200, 1e-200):
        with pytest.raises(ancf.InputError, match=r"must lie between 1e-100 and 1e\+100 m"):
            make(length)


def test_bad_points():
    scene = spatial()
    rod = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0, 0))
    ball = scene.add_body(ancf.Sphere(1.0), mass=1.0, position=(0, 0, 0), name="ball")
    with pytest.raises(ancf.InputError, match="is off its line: a thin rod has only points along"):
        rod.at((0.5, 0.1, 0.0))
    for far in (rod, ball):
        with pytest.raises(ancf.InputError, match=r"the point of .* lies beyond 1e\+150 m"):
            far.at((1e300, 0.0, 0.0))
        with pytest.raises(ancf.InputError, match="the point of"):
            far.at([[1, 2], [3]])
    with pytest.raises(ancf.InputError, match="ball is not a rod and has no end"):
        _ = ball.end
    with pytest.raises(ancf.InputError, match="of another scene"):
        spatial().pin(ball.origin)
    with pytest.raises(ancf.InputError, match="a distributed force needs a beam"):
        scene.distributed_force(ball, (0, 0, 1))


@pytest.mark.parametrize(
    "join",
    [
        lambda scene, a, b: scene.revolute(a, b, axis=(0, 0, 1)),
        lambda scene, a, b: scene.cylindrical(a, b, axis=(1, 0, 0)),
        lambda scene, a, b: scene.prismatic(a, b, axis=(1, 0, 0)),
        lambda scene, a, b: scene.weld(a, b),
        lambda scene, a, b: scene.distance(a, b),
        lambda scene, a, b: scene.connect(a, b),
    ],
)
@pytest.mark.parametrize("gap", [1.0, 1e-12])
def test_no_joint_is_between_a_body_and_itself(join, gap):
    scene = spatial()
    ball = scene.add_body(ancf.Sphere(1.0), mass=1.0, position=(0, 0, 0), name="ball")
    with pytest.raises(ancf.InputError, match="both are points of the rigid body ball"):
        join(scene, ball.at((0.5, 0, 0)), ball.at((0.5 - gap, 0, 0)))
    assert not scene.joints


def test_what_is_named_in_a_sentence_is_the_argument():
    scene = spatial()
    ball = scene.add_body(ancf.Sphere(1.0), mass=1.0, position=(0, 0, 0), name="ball")
    with pytest.raises(ancf.InputError, match=r"what depends on time alone is a point_force"):
        scene.force(ball.origin, ancf.Ramp((0, 0, 1.0), 1.0))
    with pytest.raises(ancf.InputError, match=r"^at must be a state such as run\.last"):
        ancf.modes(scene, 1, at=ball)


@pytest.mark.parametrize("joint", ["revolute", "universal", "cylindrical"])
def test_a_joint_about_an_axis_asks_for_it_in_space_and_is_refused_in_the_plane(joint):
    for scene, sentence in (
        (planar(), f"a {joint} joint needs a spatial scene; in a planar one use"),
        (spatial(), rf"a {joint} joint needs axis(_a)?, its direction"),
    ):
        body = scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(0, 0, 0)[: scene.dim])
        with pytest.raises(ancf.InputError, match=sentence):
            getattr(scene, joint)(body.origin)
