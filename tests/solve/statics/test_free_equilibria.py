"""Equilibria of scenes that only their loads keep from swinging, beside formulas and minima."""

import itertools

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import ancfsparse as ancf
from ancfsparse.errors import SingularSceneError
from ancfsparse.problems import four_bar, pendulum, spatial_pendulum
from ancfsparse.problems.mechanism import upper_intersection
from tests.beams import build_beam
from tests.grids import level_grid

G = 9.81
SECTION, MATERIAL = ancf.Circle(0.01), ancf.Material(2e9, 1500.0)
SCALES = [1e-5, 1.0, 1e5]


def stretched(rod):
    """Length of a hanging rod of Biot's strain, which its own weight stretches [m]."""
    numbers = rod.parameters()
    weight = numbers["mass_per_length"] * G * rod.length
    return rod.length + 0.5 * weight * rod.length / numbers["axial_stiffness"]


@pytest.mark.parametrize("n", [1, 10, 300])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_pendulum_hangs_down_from_horizontal_rest(dim, n):
    scene, rod = pendulum("thin", n, dim=dim, strain="biot")
    rest = ancf.solve_static(scene)
    assert rest.stable
    down = np.zeros(dim)
    down[1] = -stretched(rod)
    np.testing.assert_allclose(rest.position(rod.end), down, rtol=0.0, atol=1e-7)
    weight = rod.parameters()["mass_per_length"] * rod.length * G
    np.testing.assert_allclose(rest.reaction(rod.start)[1], weight, rtol=1e-8)


@pytest.mark.parametrize("scale", SCALES)
def test_a_rod_upright_falls_to_where_it_hangs(scale):
    """In units of another length its weight has the same share of its stiffness."""
    scene = ancf.Scene((0.0, -G))
    material = ancf.Material(2e9 * scale, 1500.0)
    section = ancf.Circle(0.01 * scale)
    rod = scene.add_beam("thin", (0, 0), (0, scale), 8, section, material, strain="biot")
    scene.pin(rod.start)
    rest = ancf.solve_static(scene)
    assert rest.stable
    expected = (0.0, -stretched(rod))
    np.testing.assert_allclose(rest.position(rod.end), expected, rtol=0.0, atol=1e-9 * scale)


@pytest.mark.parametrize("length", [1.06, 1.3, 2.0])
@pytest.mark.parametrize("element", ["thin", "string"])
def test_a_slack_cable_in_space_hangs_in_a_vertical_plane(element, length):
    """As the same cable in the plane, whose ends are as far apart and as high."""

    def hung(start, end, down):
        scene, rope = build_beam(
            element, start, end, 24, SECTION, MATERIAL, "pin", "pin", gravity=down, length=length
        )
        rest = ancf.solve_static(scene)
        assert rest.stable
        return rest.position(rope.at(0.5 * length)), rest.reaction(rope.start)

    flat, pull = hung((0, 0), (1.0, 0.2), (0.0, -G))
    space, force = hung((0, 0, 0), (0.6, 0.8, 0.2), (0.0, 0.0, -G))
    across = np.array([0.6, 0.8, 0.0])
    down = np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(space, flat[0] * across + flat[1] * down, rtol=0.0, atol=1e-8)
    expected = pull[0] * across + pull[1] * down
    np.testing.assert_allclose(force, expected, rtol=0.0, atol=1e-6 * np.abs(pull).max())


def test_a_linkage_rests_where_its_potential_is_least():
    """The four-bar's bars of 1, 2 and 2.5 m have 1 kg/m, so their centres say it all."""
    linkage = four_bar()
    rest = ancf.solve_static(linkage.scene)
    assert rest.stable

    def potential(angle):
        a = np.array([np.cos(angle), np.sin(angle)])
        b = upper_intersection(a, 2.0, np.array([3.0, 0.0]), 2.5)
        return 1.0 * 0.5 * a[1] + 2.0 * 0.5 * (a[1] + b[1]) + 2.5 * 0.5 * b[1]

    least = minimize_scalar(potential, (-2.5, -1.0), tol=1e-14)
    tip = rest.position(linkage.bodies["coupler"].origin)
    np.testing.assert_allclose(tip, (np.cos(least.x), np.sin(least.x)), rtol=0.0, atol=1e-6)


def test_a_box_on_a_corner_hangs_and_keeps_its_turn_about_the_vertical():
    swing = spatial_pendulum()
    box = swing.bodies["box"]
    rest = ancf.solve_static(swing.scene)
    below = np.linalg.norm((0.5, 0.1, 0.05))
    np.testing.assert_allclose(rest.position(box.centre), (0.0, 0.0, -below), atol=1e-9)
    # The spin about the vertical takes no force.
    assert ancf.modes(rest, 1).frequencies[0] == pytest.approx(0.0, abs=1e-5)


def test_a_chain_of_hinged_cables_hangs_as_a_line():
    scene = ancf.Scene((0.0, -G))
    links = [scene.add_beam("thin", (k, 0), (k + 1, 0), 4, SECTION, MATERIAL) for k in range(5)]
    scene.pin(links[0].start)
    for one, other in itertools.pairwise(links):
        scene.connect(one.end, other.start)
    rest = ancf.solve_static(scene)
    assert rest.stable
    assert abs(rest.position(links[-1].end)[0]) < 1e-9


@pytest.mark.parametrize("factorization", ["complete", "incomplete"])
def test_a_net_on_two_corners_hangs_in_a_vertical_plane(factorization):
    n = 8
    nodes, edges, number = level_grid(n + 1, 2.0)
    scene = ancf.Scene((0.0, 0.0, -G))
    net = scene.add_mesh(nodes, edges, "thin", ancf.Circle(0.005), ancf.Material(1e8, 1100.0))
    corners = net.node(0), net.node(int(number[0, -1]))
    for corner in corners:
        scene.pin(corner)
    rest = ancf.solve_static(scene, factorization=factorization)
    assert rest.stable
    places = np.array([rest.position(net.node(k)) for k in range(net.n_nodes)])
    assert np.abs(places[:, 0]).max() < 1e-9
    weight = np.pi * 0.0025**2 * 1100.0 * net.length * G
    held = rest.reaction(corners[0]) + rest.reaction(corners[1])
    np.testing.assert_allclose(held, (0.0, 0.0, weight), rtol=0.0, atol=1e-7 * weight)


@pytest.mark.parametrize("height", [0.0, 0.5, 3.0, 30.0])
def test_a_float_rests_on_its_buoyancy(height):
    """A force that is a function of the motion restrains it, also from places where it is zero."""
    scene = ancf.Scene((0.0, -G))
    box = ancf.Box(length=20.0, width=5.0, height=10.0)
    hull = scene.add_body(box, mass=2e5, position=(0.0, height))

    def buoyancy(q, v, t):
        return np.stack([0.0 * q[:, 0], np.maximum(0.0, 1e6 * (1.0 - q[:, 1]))], axis=1)

    scene.force([hull.at((-8.0, 0.0)), hull.at((8.0, 0.0))], buoyancy)
    rest = ancf.solve_static(scene)
    np.testing.assert_allclose(
        rest.position(hull.origin), (0.0, 1.0 - 2e5 * G / 2e6), rtol=0.0, atol=1e-9
    )


@pytest.mark.parametrize("share", [-0.9, 0.1, 0.5, 0.9])
def test_a_follower_force_holds_a_pendulum_where_its_moment_balances_the_weight(share):
    stiff = ancf.Circle(0.1), ancf.Material(2e12, 1500.0)
    scene, rod = build_beam("thin", (0, 0), (1, 0), 4, *stiff, "pin")
    weight = rod.parameters()["mass_per_length"] * rod.length * G
    scene.point_force(rod.end, (0.0, 0.5 * share * weight), follow=True)
    rest = ancf.solve_static(scene)
    x, y = rest.position(rod.end)
    assert x == pytest.approx(share * rod.length, abs=1e-6)
    assert y < 0.0


def test_what_loads_do_not_restrain_is_refused():
    sinking, rod = build_beam("thin", (0, 0), (1, 0), 4, SECTION, MATERIAL)
    sinking.force([rod.start, rod.end], lambda q, v, t: -0.5 * v)
    turned, rod = build_beam("thin", (0, 0), (1, 0), 4, SECTION, MATERIAL, "pin")
    weight = rod.parameters()["mass_per_length"] * rod.length * G
    turned.point_force(rod.end, (0.0, 0.6 * weight), follow=True)
    for scene in (sinking, turned):
        with pytest.raises(SingularSceneError, match="does not come to rest under its loads"):
            ancf.solve_static(scene)
    scene, _ = build_beam("thin", (0, 0), (1, 0), 4, SECTION, MATERIAL)
    with pytest.raises(SingularSceneError, match="loads move the scene as a whole"):
        ancf.solve_static(scene)
    still, _ = build_beam("thin", (0, 0), (1, 0), 4, SECTION, MATERIAL, "pin", gravity=(0.0, 0.0))
    with pytest.raises(SingularSceneError, match=r"rotation about z .*no load restrains them"):
        ancf.solve_static(still)
    sled = ancf.Scene((0.0, -G))
    box = sled.add_body(ancf.Box(length=0.2, width=0.1, height=0.1), mass=1.0, position=(0, 0))
    sled.prismatic(box.origin, axis=(1.0, -0.5))
    with pytest.raises(SingularSceneError, match=r"does not come to rest under its loads"):
        ancf.solve_static(sled)
