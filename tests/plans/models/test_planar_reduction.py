"""Scenes in space that are planar: the same motion, and what is not planar."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.models.planar_reduction import reduce_to_plane
from tests.beams import build_beam

SECTION = ancf.Rectangle(0.01, 0.01)
STIFF = ancf.Material(youngs_modulus=1e10, density=1000.0)
SOFT = ancf.Material(youngs_modulus=1e8, density=4000.0)


def in_space(planar, solved, point):
    """Return positions of a point of the scene in space from a solution of the planar scene."""
    return planar.plane.place(solved.position(planar.counterpart(point)))


def turned(seed):
    """A rotation: of no axis, about x by 90 degrees, or at random."""
    if seed == "flat":
        return np.eye(3)
    if seed == "vertical":
        return np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]


def mechanism(turn, element="thin", off=0.0, at=(0.3, -0.2, 0.7)):
    """Two rods with a hinge, a spring, a mass, a rod to the ground, and loads of many kinds."""
    at = np.array(at)

    def vector(x, y):
        return turn @ np.array([x, y, 0.0])

    scene = ancf.Scene(gravity=vector(0.0, -9.81))
    up = None if element != "thick" else turn @ np.array([0.0, 1.0, 0.0])
    given = {"section": SECTION, "material": SOFT, "up": up}
    spin = 0.3 * turn @ np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]) @ turn.T
    hinge, end = at + vector(1, 0.2), at + vector(1.5, -0.4)
    one = scene.add_beam(element, at, hinge, 4, velocity=lambda x: (x - at) @ spin.T, **given)
    two = scene.add_beam(element, hinge, end, 3, velocity=vector(-0.06, 0.3), **given)
    scene.pin(one.start)
    scene.connect(one.end, two.start)
    scene.spring(two.end, at + vector(2, 0), stiffness=30.0, damping=0.1)
    scene.add_mass(two.end, 0.05)
    scene.point_force(two.node(1), ancf.Ramp(vector(0.5, 1.0), 0.1))
    scene.point_force(one.at(0.3), lambda t: 0.2 * vector(np.cos(9.0 * t), np.sin(9.0 * t)))
    scene.distributed_force(one, vector(0.2, 0.1) + off * turn[:, 2])
    scene.changing_gravity(ancf.Sine(vector(1.0, 2.0), 3.0) + vector(0.0, 0.5))
    scene.point_moment(two.end, 1e-3 * turn[:, 2])
    return scene, (one.end, one.at(0.4), two.end)


@pytest.mark.parametrize("element", ["thin", "thick"])
@pytest.mark.parametrize("seed", ["flat", "vertical", 7])
def test_the_motion_is_the_same(seed, element):
    scene, points = mechanism(turned(seed), element)
    planar = reduce_to_plane(scene)
    assert planar.scene.dim == 2
    given = {"solver": ancf.Newton(), "tolerance": 1e-8}
    space = ancf.simulate(scene, 0.3, dt=1e-3, **given)
    plane = ancf.simulate(planar.scene, 0.3, dt=1e-3, **given)
    assert plane.q.shape[1] < space.q.shape[1]
    for point in points:
        moved = np.ptp(space.position(point), axis=0).max()
        off = np.abs(space.position(point) - in_space(planar, plane, point)).max()
        assert moved > 0.01
        assert off < 1e-9 * 2.0


def test_strings_nets_drives_and_rods_in_a_tilted_plane():
    turn = turned(3)
    scene = ancf.Scene(gravity=turn @ (0.0, -9.81, 0.0))
    nodes = np.array([(x, y, 0.0) for x in (0.0, 0.5, 1.0) for y in (0.0, -0.4)]) @ turn.T
    edges = [(0, 2), (2, 4), (1, 3), (3, 5), (0, 1), (2, 3), (4, 5)]
    net = scene.add_mesh(nodes, edges, "string", ancf.Circle(0.01), SOFT, n_elements=2, slack=1e-3)
    end = nodes[4] + turn @ (1.0, 0.0, 0.0)
    line = scene.add_beam("string", nodes[4], end, 6, ancf.Circle(0.01), SOFT, length=1.2)
    scene.connect(net.node(4), line.start)
    scene.pin(net.node(0))
    scene.drive(line.end, ancf.Ramp(turn @ (0.1, 0.1, 0.0), 0.2, smooth=True) + line.end.position)
    scene.rod(net.node(1), turn @ (-0.5, -0.4, 0.0))
    scene.distance(net.node(1), net.node(3))
    planar = reduce_to_plane(scene)
    assert planar.scene == reduce_to_plane(scene).scene
    given = {"solver": ancf.Newton(), "tolerance": 1e-8, "integrator": ancf.GeneralizedAlpha(0.5)}
    space = ancf.simulate(scene, 0.2, dt=1e-3, **given)
    plane = ancf.simulate(planar.scene, 0.2, dt=1e-3, **given)
    for point in (net.node(5), line.at(0.7), line.end):
        off = np.abs(space.position(point) - in_space(planar, plane, point)).max()
        assert off < 1e-9 * 2.0


def test_a_flat_section_is_turned_with_the_plane():
    """In the plane y = 0 the width of a section bends, which a planar scene has along its y."""
    scene, beam = build_beam(
        "thick", (0, 0, 0), (1, 0, 0), 8, ancf.Rectangle(width=0.02, height=0.005), STIFF, "clamp",
        gravity=(0.0, 0.0, -9.81),
    )  # fmt: skip
    planar = reduce_to_plane(scene)
    assert planar.scene.bodies[0].section == ancf.Rectangle(width=0.005, height=0.02)
    sag = ancf.solve_static(scene).position(beam.end)
    flat = in_space(planar, ancf.solve_static(planar.scene), beam.end)
    np.testing.assert_allclose(flat, sag, atol=1e-9)


@pytest.mark.parametrize(
    "section",
    [
        ancf.Tube(0.02, 0.002),
        ancf.Taper(ancf.Rectangle(width=0.02, height=0.005), ancf.Rectangle(0.01, 0.004)),
        ancf.Section(1e-4, inertia_y=2e-10, inertia_z=1e-10, torsion_constant=2e-10),
    ],
)
def test_sections_are_turned_with_the_plane(section):
    scene, beam = build_beam(
        "thick", (0, 0, 0), (1, 0, 0), 8, section, STIFF, "clamp", gravity=(0.0, 0.0, -9.81)
    )
    planar = reduce_to_plane(scene)
    sag = ancf.solve_static(scene).position(beam.end)
    flat = in_space(planar, ancf.solve_static(planar.scene), beam.end)
    assert sag[2] < -1e-3
    np.testing.assert_allclose(flat, sag, atol=1e-9)


def test_an_upright_shape_without_a_rotated_form_stays_in_space():
    section = ancf.IBeam(width=0.05, height=0.1, web=0.005, flange=0.008)
    for gravity, is_planar in (((0, 0, -9.81), False), ((0, -9.81, 0), True)):
        scene, _ = build_beam(
            "thick", (0, 0, 0), (1, 0, 0), 2, section, STIFF, "clamp", gravity=gravity
        )
        assert (reduce_to_plane(scene) is not None) == is_planar


def test_a_hinge_about_the_normal_is_a_shared_position():
    def scene_with(axis):
        scene = ancf.Scene(gravity=(0.0, 0.0, -9.81))
        given = {"section": SECTION, "material": SOFT}
        one = scene.add_beam("thick", (0, 0, 0), (1, 0, 0), 3, **given)
        two = scene.add_beam("thick", (1, 0, 0), (1, 0, -1), 3, **given)
        scene.clamp(one.start)
        scene.revolute(one.end, two.start, axis=axis)
        return scene, two.end

    scene, end = scene_with((0, 1, 0))
    planar = reduce_to_plane(scene)
    given = {"solver": ancf.Newton(), "tolerance": 1e-8}
    runs = [ancf.simulate(each, 0.2, dt=1e-3, **given) for each in (scene, planar.scene)]
    off = np.abs(runs[0].position(end) - in_space(planar, runs[1], end))
    assert off.max() < 2e-9
    assert reduce_to_plane(scene_with((0, 0, 1))[0]) is None


@pytest.mark.parametrize("seed", ["flat", "vertical", 7])
def test_a_load_that_leaves_the_plane_by_1e_12_is_noticed(seed):
    assert reduce_to_plane(mechanism(turned(seed), off=1e-12)[0]) is None
    assert reduce_to_plane(mechanism(turned(seed), off=1e-16)[0]) is not None


def test_far_from_the_origin_of_space_positions_are_rounded_and_still_planar():
    scene, points = mechanism(turned(5), at=(30.0, -20.0, 10.0))
    planar = reduce_to_plane(scene)
    assert np.abs(planar.scene.bodies[0].positions).max() < 3.0
    place = planar.plane.place(planar.counterpart(points[0]).position)
    np.testing.assert_allclose(place, points[0].position, atol=1e-12)


def spoiled(change):
    along = (0, 0, 0), (1, 0, 0)
    scene, beam = build_beam("thin", *along, 2, SECTION, SOFT, "pin", gravity=(0.0, 0.0, -9.81))
    change(scene, beam)
    return scene


@pytest.mark.parametrize(
    "change",
    [
        lambda scene, beam: scene.point_force(beam.end, (1.0, 1e-11, 0.0)),
        lambda scene, beam: scene.point_force(beam.end, ancf.Sine((1.0, 1.0, 0.0), 2.0)),
        lambda scene, beam: scene.point_force(beam.end, lambda t: (1.0, 1.0, 0.0)),
        lambda scene, beam: scene.point_force(beam.end, 1.0, follow=True),
        lambda scene, beam: scene.point_moment(beam.end, (0.0, 1.0, 1.0)),
        lambda scene, beam: scene.rod(beam.end, (1.0, 0.5, 1.0)),
        lambda scene, beam: scene.force(beam.end, lambda q, v, t: -v),
        lambda scene, beam: scene.add_beam(
            "thin", (1, 0, 0), (2, 0, -1), 2, SECTION, SOFT, velocity=(0, 1, 0)
        ),
        lambda scene, beam: scene.add_beam("thin", (0, 0, 1), (1, 0.1, 1), 2, SECTION, SOFT),
        lambda scene, beam: scene.add_beam(
            "thick", (0, 0, 1), (1, 0, 1), 2, SECTION, SOFT, velocity=lambda x: 0.1 * x
        ),
        lambda scene, beam: scene.add_body(mass=1.0, inertia=np.eye(3), position=(0, 0, 2)),
    ],
)
def test_what_leaves_the_plane_is_not_planar(change):
    assert reduce_to_plane(spoiled(lambda scene, beam: None)) is not None
    assert reduce_to_plane(spoiled(change)) is None


def test_a_function_that_leaves_the_plane_later_stops_the_run():
    scene = spoiled(
        lambda scene, beam: scene.point_force(beam.end, lambda t: (1.0, max(0.0, t - 0.1), 0.0))
    )
    planar = reduce_to_plane(scene)
    with pytest.raises(ancf.LoadError, match="leaves the plane of the scene: solve the scene in"):
        ancf.simulate(planar.scene, 0.2, dt=1e-2)


def test_gravity_across_the_plane_of_a_motion_leaves_it():
    scene = ancf.Scene(gravity=(0.0, 0.0, -9.81))
    scene.add_beam("thin", (0, 0, 0), (1, 0, 0), 2, SECTION, SOFT, velocity=(0, 1, 0))
    assert reduce_to_plane(scene) is None


def test_planar_scenes_and_empty_ones_are_not_rebuilt():
    assert reduce_to_plane(ancf.Scene(gravity=(0.0, -9.81))) is None
    assert reduce_to_plane(ancf.Scene(gravity=(0.0, 0.0, -9.81))) is None


def test_a_line_along_gravity_has_a_plane():
    along = (0, 0, 0), (0, 0, -1)
    scene, cord = build_beam("thin", *along, 4, SECTION, SOFT, "pin", gravity=(0.0, 0.0, -9.81))
    planar = reduce_to_plane(scene)
    rest = in_space(planar, ancf.simulate(planar.scene, 0.01, dt=1e-3), cord.end)
    np.testing.assert_allclose(rest[0], (0, 0, -1), atol=1e-15)


def test_gravity_across_the_plane_of_a_net_leaves_it():
    """Ten thousand points in a plane, for which no square matrix of as many rows is needed."""
    scene = ancf.Scene(gravity=(0.0, 0.0, -9.81))
    for x in range(3):
        ends = (x, 0.0, 0.0), (x, 1.0, 0.0)
        scene.add_beam("thin", *ends, 4000, SECTION, SOFT)
    assert reduce_to_plane(scene) is None
    resting = scene.replaced(gravity=(0.0, -9.81, 0.0))
    assert reduce_to_plane(resting) is not None


def test_points_off_the_axis_are_planned_in_space():
    square = ancf.Rectangle(0.05, 0.05)
    scene = ancf.Scene((0.0, -9.81, 0.0))
    arm = scene.add_beam(
        "thick", (0, 0, 0), (1, 0, 0), 3, square, ancf.Material(2e9, 7800.0), curvature="section"
    )
    rod = scene.add_beam("auto", (1, 0, 0), (1, -1, 0), "auto", square, ancf.Material(2e9, 7800.0))
    scene.clamp(arm.start)
    scene.connect(arm.end, rod.start)
    plan = ancf.plan(scene, 0.02, ancf.position(arm.at(1.0, y=0.2)), 1e-2)
    assert plan.error < 1e-2
