"""Joints between rigid bodies, beams and the ground: freedoms, motions, redundancy, bad input."""

import itertools

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from tests.beams import build_beam
from tests.solve.refusals import assert_refused

TIGHT = 1e-12
G = 9.81
Z = np.array([0.0, 0.0, 1.0])
TURNED = np.array([0.5, 0.5, -0.1, 0.7])  # a quaternion
TURNED /= np.linalg.norm(TURNED)
AXIS = np.array([0.6, 0.0, 0.8])


BOX = ancf.Box(length=0.4, width=0.3, height=0.2)


def two_boxes(shape=BOX, **options):
    """Two boxes at one place, the frame of the first along those of space."""
    scene = ancf.Scene((0.0, 0.0, -G))
    one = scene.add_body(ancf.Box(length=0.5, width=0.2, height=0.3), mass=2.0, position=(0, 0, 0))
    return scene, one, scene.add_body(shape, mass=1.0, position=(0, 0, 0), **options)


def freedom(scene):
    """Free coordinates less the rank of the gradients of the constraints."""
    system = System(scene)
    phi_q = system.constraints.jacobian(system.q0)[:, : system.n_free].toarray()
    return system.n_free - np.linalg.matrix_rank(phi_q, tol=1e-9), len(phi_q)


JOINTS = {
    "connect": (lambda s, a, b, x: s.connect(a, b), 3),
    "revolute": (lambda s, a, b, x: s.revolute(a, b, axis=x), 1),
    "universal": (lambda s, a, b, x: s.universal(a, b, axis_a=x, axis_b=(x[2], 0, -x[0])), 2),
    "cylindrical": (lambda s, a, b, x: s.cylindrical(a, b, axis=x), 2),
    "prismatic": (lambda s, a, b, x: s.prismatic(a, b, axis=x), 1),
    "weld": (lambda s, a, b, x: s.weld(a, b), 0),
}


@pytest.mark.parametrize("skew", [False, True])
@pytest.mark.parametrize("name", JOINTS)
def test_freedoms_of_two_bodies(name, skew):
    """Six of the pair and those of the joint, with no equation too many."""
    join, own = JOINTS[name]
    scene, one, two = two_boxes(**({"orientation": TURNED} if skew else {}))
    join(scene, one.origin, two.origin, AXIS if skew else Z)
    free, equations = freedom(scene)
    assert free == 6 + own
    assert equations == System(scene).n_free - free


@pytest.mark.parametrize("name", [each for each in JOINTS if each != "connect"])
def test_freedoms_beside_the_ground(name):
    scene = ancf.Scene((0.0, 0.0, -G))
    body = scene.add_body(ancf.Box(length=0.5, width=0.2, height=0.3), mass=2.0, position=(0, 0, 0))
    join, own = JOINTS[name]
    if name == "weld":
        scene.weld(body.origin)
        assert_refused("nothing can move", System, scene)
        return
    join(scene, body.origin, None, Z)
    assert freedom(scene)[0] == own


@pytest.mark.parametrize("name", JOINTS)
def test_motions_with_any_frames_agree(name):
    """By shared vectors, and by equations where the frame of one body is turned at will.

    They are two schemes of second order, 6e-7 apart at this step.
    """
    join, _ = JOINTS[name]
    ends = []
    for skew in (False, True):
        scene, one, two = two_boxes()
        if skew:
            w, v = TURNED[0], TURNED[1:]
            cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
            turn = (w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * cross
            moments = 1.0 / 12 * np.array([0.2**2 + 0.3**2, 0.4**2 + 0.3**2, 0.4**2 + 0.2**2])
            inertia = turn.T @ np.diag(moments) @ turn
            scene, one, two = two_boxes(None, inertia=inertia, orientation=TURNED)
        join(scene, one.origin, two.origin, Z)
        scene.point_moment(one.origin, (0.3, -0.2, 0.5))
        scene.point_moment(two.origin, (-0.1, 0.4, -0.3))
        scene.point_force(two.origin, (0.5, 0.2, 1.0))
        run = ancf.simulate(scene, 0.5, 1e-3, integrator=ancf.EnergyMomentum(), tolerance=TIGHT)
        ends.append([run.body(each).centre[-1] for each in (one, two)])
        ends[-1].append(run.body(one).rotation[-1].ravel())
    for one, two in zip(*ends, strict=True):
        np.testing.assert_allclose(one, two, atol=2e-6)


def test_welded_boxes_are_one_body():
    """A free dumbbell of two spheres, welded to one another, turns as one body does."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    omega, way = np.array([0.5, 1.0, 2.0]), np.array([1.0, 0.0, 0.0])
    one = scene.add_body(ancf.Sphere(0.2), mass=1.0, position=(0, 0, 0), angular_velocity=omega)
    two = scene.add_body(
        ancf.Sphere(0.1), mass=2.0, position=way, angular_velocity=omega,
        velocity=np.cross(omega, way), orientation=(0.0, 0.6, 0.8, 0.0),
    )  # fmt: skip
    scene.weld(one.at(0.5 * way), two.at((0.5 * 0.28, -0.5 * 0.96, 0.0)))
    spheres = 0.4 * (1.0 * 0.2**2 + 2.0 * 0.1**2)
    reduced = 1.0 * 2.0 / 3.0
    single = ancf.Scene((0.0, 0.0, 0.0))
    body = single.add_body(
        inertia=(spheres, spheres + reduced, spheres + reduced), mass=3.0, centre=(2 / 3, 0, 0),
        position=(0, 0, 0), angular_velocity=omega,
    )  # fmt: skip
    runs = [
        ancf.simulate(each, 1.0, 5e-3, integrator=ancf.EnergyMomentum(), tolerance=TIGHT)
        for each in (scene, single)
    ]
    np.testing.assert_allclose(
        runs[0].position(one.origin)[-1], runs[1].position(body.origin)[-1], atol=1e-9
    )


def test_a_distance_is_kept():
    """To a body that the ground holds it is the rod to a fixed point; between two it stays."""
    ends = []
    for tied in (False, True):
        scene = ancf.Scene((0.0, -G))
        body = scene.add_body(
            ancf.Box(length=0.4, width=0.1, height=0.2), mass=1.0, position=(1, 0)
        )
        corner = body.at((0.1, 0.05))
        if tied:
            wall = scene.add_body(
                ancf.Box(length=1, width=1, height=1), mass=1.0, position=(-0.5, 0.2)
            )
            scene.weld(wall.origin)
            scene.distance(corner, wall.at((0.5, 0.1)))
        else:
            scene.rod(corner, (0.0, 0.3))
        run = ancf.simulate(scene, 1.0, 2e-3, integrator=ancf.EnergyMomentum(), tolerance=TIGHT)
        ends.append(run.position(corner))
        lengths = np.linalg.norm(run.position(corner) - (0.0, 0.3), axis=1)
        assert np.ptp(lengths) < 1e-11
    np.testing.assert_allclose(*ends, atol=1e-9)


def bricard():
    """Five bars of a cube, hinged about y, z, x, y, z and x; the first and the last to the ground.

    IFToMM benchmark A04: bars of 1 m and 1 kg with square sections of 0.1 m, gravity along -y.
    """
    scene = ancf.Scene((0.0, -G, 0.0))
    joints = np.array(
        [(0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1)], dtype=float
    )
    axes, bodies = np.eye(3)[[1, 2, 0, 1, 2, 0]], []
    for start, end in itertools.pairwise(joints):
        along = np.abs(end - start) > 0.5
        moments = np.where(along, 2 * 0.1**2, 1.0 + 0.1**2) / 12.0
        bodies.append(
            scene.add_body(inertia=moments, mass=1.0, centre=(end - start) / 2, position=start)
        )
    scene.revolute(bodies[0].origin, axis=axes[0])
    for k in range(1, 5):
        before = bodies[k - 1].at(joints[k] - joints[k - 1])
        scene.revolute(before, bodies[k].origin, axis=axes[k])
    scene.revolute(bodies[4].at(joints[5] - joints[4]), axis=axes[5])
    return scene, bodies


def test_bricards_mechanism():
    """P3 at 0.5, 1 and 5 s, to 1e-8 m: natural coordinates and minimal ones by DOP853.

    It moves although constraints outnumber its freedoms, and the run says so.
    """
    reference = [
        (0.968283679, -1.224625159, 0.750146609),
        (0.510501461, -1.649167599, 0.140123115),
        (0.9999999976, -1.0000672576, 0.9999327399),
    ]
    off = []
    for dt in (2e-3, 1e-3):
        scene, bodies = bricard()
        with pytest.warns(
            ancf.RedundantConstraintsWarning, match="1 of 39 constraints repeat others"
        ):
            run = ancf.simulate(scene, 5.0, dt, integrator=ancf.EnergyMomentum(), tolerance=1e-11)
        at = [round(t / dt) for t in (0.5, 1.0, 5.0)]
        off.append(np.max(np.abs(run.position(bodies[3].origin)[at] - reference), axis=1))
        energy = run.energy.total
        assert np.max(np.abs(energy[1:] - energy[1])) < 1e-9 * np.max(run.energy.kinetic)
    assert np.all(off[1] < 1e-6)
    assert 3.8 < off[0][1] / off[1][1] < 4.2


@pytest.mark.filterwarnings("ignore::ancfsparse.RedundantConstraintsWarning")
@pytest.mark.parametrize("integrator", [ancf.EnergyMomentum(), ancf.GeneralizedAlpha(0.9)])
def test_multipliers_of_repeated_constraints_do_not_grow(integrator):
    """They grew to 4e6 N, and 25 corrections did not solve a step of EnergyMomentum() at 3.5 s."""
    scene, _ = bricard()
    run = ancf.simulate(scene, 4.0, 4e-3, integrator=integrator, tolerance=1e-12)
    assert np.abs(run.lam).max() < 1e4
    assert run.stats.iterations < 13 * run.stats.steps


def test_what_repeats_is_named():
    """A bar in two guides of one line: the second repeats the height, by numbering the angle."""
    scene = ancf.Scene((1.0, -G))
    bar = scene.add_body(
        ancf.Box(length=1.0, width=0.1, height=0.1), mass=1.0, position=(0, 0), name="bar"
    )
    for x in (-0.5, 0.5):
        scene.prismatic(bar.at((x, 0.0)), axis=(1, 0))
    message = r"1 of 2 constraints .* the prismatic joint of bar at \(0.5, 0\) m .* which follows"
    with pytest.warns(ancf.RedundantConstraintsWarning, match=message):
        run = ancf.simulate(scene, 1.0, 1e-2)
    np.testing.assert_allclose(run.position(bar.origin)[-1], (0.5, 0.0), atol=1e-8)


def two_rods():
    scene = ancf.Scene((0.0, -G))
    bar = (ancf.Rectangle(0.01, 0.01), ancf.Material(1e7, 1e3))
    rods = [scene.add_beam("thin", (0, y), (1, y), 2, *bar) for y in (0, 1)]
    return scene, *rods


@pytest.mark.parametrize("swap", [False, True])
def test_a_point_at_a_distance_may_be_held_otherwise(swap):
    """Beside a pin, a rod, or a second distance, whichever of its points is held."""
    scene, low, high = two_rods()
    scene.pin(low.start)
    scene.rod(low.end, (1.0, -1.0))
    for pair in ((low.start, high.start), (low.end, high.end), (low.start, high.end)):
        scene.distance(*(pair[::-1] if swap else pair))
    run = ancf.simulate(scene, 0.02, 1e-3)
    for joint in scene.joints[2:]:
        apart = np.linalg.norm(run.position(joint.a) - run.position(joint.b), axis=1)
        np.testing.assert_allclose(apart, joint.length, rtol=1e-9)


def test_distances_that_repeat_or_hold_nothing_are_named():
    scene, low, high = two_rods()
    scene.distance(low.end, high.end)
    scene.distance(high.end, low.end)
    with pytest.warns(ancf.RedundantConstraintsWarning, match="1 of 2 constraints repeat others"):
        ancf.simulate(scene, 0.01, 1e-3)
    scene, low, high = two_rods()
    scene.pin(low.start)
    scene.pin(high.start)
    scene.distance(low.start, high.start)
    with pytest.raises(ancf.InputError, match=r"the distance of beam 0 .* no free coordinate"):
        ancf.simulate(scene, 0.01, 1e-3)


def test_contradictions_are_refused():
    scene = ancf.Scene((0.0, -G))
    bar = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0), name="bar", velocity=(0.0, 1.0))
    scene.pin(bar.end)
    assert_refused(r"velocities violate the pin at bar at \(1\) m", ancf.simulate, scene, 0.1, 1e-3)


@pytest.mark.parametrize(
    ("join", "message"),
    [
        (lambda s, a, b: s.revolute(a.origin, b.at((1, 0, 0)), axis=Z), "are 1 m apart"),
        (lambda s, a, b: s.revolute(a.origin, b.origin, axis=(0, 0, 0)), "has no direction"),
        (lambda s, a, b: s.revolute(a.origin, b.origin, axis=(0, 1)), "axis of a revolute joint"),
        (lambda s, a, b: s.revolute(a.origin, a.origin, axis=Z), "needs two points"),
        (lambda s, a, b: s.revolute("a", axis=Z), "a revolute joint needs a point"),
        (
            lambda s, a, b: s.universal(a.origin, b.origin, axis_a=Z, axis_b=(0, 1, 1)),
            "at a right angle, got 45 degrees",
        ),
        (
            lambda s, a, b: s.cylindrical(a.origin, b.at((1, 0, 0)), axis=Z),
            "on the line .* but it is 1 m off",
        ),
        (lambda s, a, b: s.distance(a.origin, b.origin), "coincide: to keep them together"),
        (
            lambda s, a, b: s.revolute(
                s.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0, 0)).origin, a.origin, axis=Z
            ),
            "needs directions of body 2 at its origin that it does not have",
        ),
    ],
)
def test_bad_joints(join, message):
    scene, one, two = two_boxes()
    assert_refused(message, join, scene, one, two)
    assert not scene.joints


def test_planar_scenes_have_pins():
    scene = ancf.Scene((0.0, -G))
    body = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0))
    with pytest.raises(ancf.InputError, match="in a planar one use connect, or pin"):
        scene.revolute(body.origin, axis=(0, 0, 1))


def test_cables_in_space_are_not_welded():
    scene = ancf.Scene((0.0, 0.0, -G))
    section, material = ancf.Circle(0.01), ancf.Material(1e8, 1e3)
    one = scene.add_beam("thin", (0, 0, 0), (1, 0, 0), 2, section, material)
    two = scene.add_beam("thin", (1, 0, 0), (1, 1, 0), 2, section, material)
    assert_refused("coordinates of cables in space do not include", scene.weld, one.end, two.start)


def frame(element):
    """A clamped beam with a short one at its end, at a right angle, and a load."""
    section, material = ancf.Rectangle(0.02, 0.02), ancf.Material(1e9, 1e3, 0.0)
    scene, one = build_beam(element, (0, 0), (1, 0), 4, section, material, gravity=(0.0, 0.0))
    two = scene.add_beam(element, (1, 0), (1.0, 0.5), 2, section, material)
    scene.clamp(one.start)
    scene.weld(one.end, two.start)
    scene.point_force(two.end, (0.02, -0.01))
    return scene, two


@pytest.mark.parametrize("element", ["thin", "thick"])
def test_a_welded_frame_bends_as_formulas_say(element):
    """Small displacements of an L-frame under forces at its end: unit loads, to first order.

    The column of h = 0.5 m carries Fx at its top and Fy along it; the arm of a = 1 m bends under
    Fy and the moment Fx h.
    """
    scene, column = frame(element)
    found = ancf.solve_static(scene).displacement(column.end)
    bending, stretching = 1e9 * 0.02**4 / 12, 1e9 * 0.02**2
    a, h, (fx, fy) = 1.0, 0.5, (0.02, -0.01)
    turn = (fy * a**2 / 2 - fx * h * a) / bending
    down = (fy * a**3 / 3 - fx * h * a**2 / 2) / bending
    expected = (fx * h**3 / 3 / bending - turn * h + fx * a / stretching, down)
    np.testing.assert_allclose(found, expected, rtol=0.01)


def test_two_cables_in_line_in_space_are_welded_to_one():
    def hanging(split):
        scene = ancf.Scene((0.0, -1.0, -G))
        section, material = ancf.Circle(0.02), ancf.Material(1e8, 1e3)
        way = np.array([0.6, 0.0, 0.8])
        if not split:
            rod = scene.add_beam("thin", (0, 0, 0), 2.0 * way, 8, section, material)
            scene.clamp(rod.start)
            return scene, rod.node(4), rod.end
        one = scene.add_beam("thin", (0, 0, 0), way, 4, section, material)
        two = scene.add_beam("thin", way, 2.0 * way, 4, section, material)
        scene.clamp(one.start)
        scene.weld(one.end, two.start, stretch="fixed")
        return scene, one.end, two.end

    (whole, *nodes), (parts, *others) = hanging(False), hanging(True)
    rest, welded = (ancf.solve_static(each, tolerance=1e-12) for each in (whole, parts))
    for node, other in zip(nodes, others, strict=True):
        np.testing.assert_allclose(welded.position(other), rest.position(node), atol=1e-8)


def test_a_weld_with_fixed_stretch_is_a_clamp_with_fixed_stretch():
    found = []
    for join in ("clamp", "weld"):
        section, material = ancf.Circle(0.02), ancf.Material(1e6, 1e3)
        scene, rod = build_beam("thin", (0, 0), (0.8, 0.6), 4, section, material, gravity=(0.0, -G))
        getattr(scene, join)(rod.start, stretch="fixed")
        found.append(ancf.solve_static(scene, tolerance=1e-12).position(rod.end))
    np.testing.assert_allclose(*found, atol=1e-9)


def test_strings_have_no_angle_to_drive():
    scene = ancf.Scene((0.0, -G))
    material = ancf.Material(1e7, 1e3)
    line = scene.add_beam("string", (0, 0), (1, 0), 4, ancf.Circle(0.02), material)
    assert_refused("has none: take a revolute", scene.drive_joint, scene.pin(line.start), 0.0)
