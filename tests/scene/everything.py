"""A scene with one of everything that can be added, for what must hold of all of it."""

import numpy as np

import ancfsparse as ancf

SECTION, MATERIAL = ancf.Circle(0.02), ancf.Material(1e7, 1e3)


def gust(t):
    return (t, 0.0, 0.0)


def bulge(x):
    return np.outer((x[:, 0] * (2.0 - x[:, 0])) ** 2, [0.0, 1.0, 0.0])


def law(elongation):
    return 100.0 * elongation + elongation**3


def drag(q, v, t):
    return -0.1 * v


def length(t):
    return 1.0 + 0.1 * t**3


def still(t):
    return 0.0


def everything(fine=1):
    """Return the scene, in which every method has been called that adds something.

    With every element in `fine` elements, by hand.
    """
    scene = ancf.Scene((0.0, -9.81, 0.5))
    rod = scene.add_beam(
        "thick", (0, 0, 0), (2, 0, 0), 4 * fine, SECTION, MATERIAL,
        curvature="section", up=(0, 1, 0.5), velocity=bulge, name="rod",
    )  # fmt: skip
    rope = scene.add_beam("thin", (2, 0, 0), (3, 1, 0), 3 * fine, SECTION, MATERIAL, strain="biot")
    net = scene.add_mesh(
        [(5, 0, 0), (6, 0, 0), (7, 0, 0), (6, 1, 0)], [(0, 1), (2, 1), (1, 3)],
        "thin", SECTION, MATERIAL, n_elements=fine, velocity=(0.0, 0.0, 0.0),
    )  # fmt: skip
    box = scene.add_body(
        ancf.Box(length=0.4, width=0.1, height=0.2), density=500.0, position=(1, 3, 0),
        orientation=(0.6, 0.0, 0.0, 0.8), angular_velocity=(0.0, 0.0, 1.0), name="box",
    )  # fmt: skip
    link = scene.add_body(ancf.Rod(1.0), mass=0.5, position=(1, 3, 0))
    scene.connect(box.origin, link.origin)
    lid, leaf, slide = (
        scene.add_body(ancf.Box(length=0.4, width=0.1, height=0.3), mass=1.0, position=(x, 6, 0))
        for x in (0, 1, 2)
    )
    scene.revolute(lid.origin, axis=(0, 0, 1))
    scene.universal(leaf.at((-1, 0, 0)), lid.origin, axis_a=(1, 0, 0), axis_b=(0, 1, 0))
    scene.prismatic(slide.origin, leaf.origin, axis=(1, 0, 0))
    bolt = scene.add_body(ancf.Cylinder(0.1, 0.5), mass=1.0, position=(2, 6, 1))
    pivot = scene.cylindrical(bolt.origin, slide.origin, axis=(0, 0, 1))
    scene.weld(scene.add_body(ancf.Sphere(0.1), mass=0.2, position=(2, 6, 1)).origin, bolt.origin)
    bead = scene.add_body(ancf.Sphere(0.1), mass=0.1, position=(0.5, 0, 0))
    scene.slide(bead.origin, rod, lateral=(0, 1, 0))
    hinge = scene.revolute(leaf.at((0, 0.1, 0)), slide.at((-1, 0.1, 0)), axis=(0, 0, 1))
    scene.gear(hinge, pivot, -0.5, of_other="angle")
    scene.winch([lid.at((0.1, 0, 0)), (0.5, 8.0, 0.0), slide.origin], drum=hinge, radius=0.05)
    scene.rope(
        [lid.at((0.1, 0, 0)), slide.origin], stiffness=10.0, length=ancf.Ramp(9.0, 1.0) + 1.0
    )
    scene.rope([bolt.origin, (9.0, 9.0, 9.0)], stiffness=10.0, damping=0.1, slack=1e-3)
    scene.joint_spring(hinge, stiffness=1.0, damping=0.1)
    scene.joint_stop(pivot, -0.5, 0.5, stiffness=100.0, of="angle")
    scene.joint_friction(pivot, 0.2, slip=1e-3, of="displacement")
    scene.joint_friction(hinge, coefficient=0.1, radius=0.02, slip=1e-3)
    scene.drive_joint(pivot, ancf.Ramp(0.1, 0.5, smooth=True), of="angle")
    scene.distance(bolt.at((0, 0, 0.25)), link.end)
    scene.pin(link.end)
    scene.spring(box.at((0.1, 0.05, 0.0)), rope.node(2 * fine), stiffness=10.0)
    scene.clamp(rod.start, stretch="fixed")
    scene.connect(rod.end, rope.start)
    scene.pin(net.node(0), as_constraint=True)
    rise = ancf.Ramp((0.1, 0.0, 0.0), 0.5, smooth=True)
    scene.drive(net.node(2), rise + np.array([7.0, 0.0, 0.0]))
    scene.rod(rope.end, (3.0, 2.0, 0.0))
    scene.rod(net.node(3), (6.0, 2.0, 0.0), length=length, rate=still, second_rate=still)
    scene.point_force(rod.at(0.3), gust)
    scene.point_force(net.at(1, 0.125), ancf.Table([0.0, 1.0], np.ones((2, 3)), outside="hold"))
    scene.point_moment(rod.node(2 * fine), (0.0, 0.0, 0.25))
    scene.distributed_force(net, ancf.Sine((0.0, 0.0, 1.0), 3.0))
    scene.changing_gravity(ancf.Sine(amplitude=(0.1,) * scene.dim, frequency=0.5))
    scene.add_mass(rod.node(3 * fine), 0.5, inertia=(1e-3, 2e-3, 2.5e-3))
    scene.add_mass(rope.at(0.1), 0.25)
    scene.rotating_frame((0.0, 0.1, 0.0), point=(1.0, 0.0, 0.0))
    scene.spring(rod.node(fine), (0.0, -1.0, 0.0), stiffness=100.0, damping=0.5)
    scene.spring(rope.node(fine), net.node(0), stiffness=law, length=0.9)
    scene.force([rope.node(2 * fine), net.node(3)], drag, coupled=True)
    scene.contact(
        net, ancf.HalfSpace((0.0, -5.0, 0.0), (0.0, 1.0, 0.1)), stiffness=1e5, push_out=True
    )
    drum = ancf.Drum((2.5, -5.0, 0.0), 2.0, axis=(0.0, 1.0, 1.0), angular_velocity=1.0)
    scene.contact(rope, drum, stiffness=1e5, friction=0.2, slip_speed=1e-3)
    scene.contact(rod, ancf.Ball((1.0, -3.0, 0.0), 1.0), stiffness=1e5, radius=0.02)
    scene.contact(rope, ancf.Capsule((1.0, -7.0, 0.0), (2.0, -8.0, 0.0), 1.0), stiffness=1e5)
    block = ancf.Block((2.5, -9.0, 0.0), (3.0, 2.0, 2.0), 0.1, (0.6, 0.8, 0.0, 0.0))
    scene.contact(rope, block, stiffness=1e5)
    scene.contact(rope, ancf.Torus((2.5, -9.0, 0.0), 2.0, 0.5, (0.0, 1.0, 0.0)), stiffness=1e5)
    add_ground(scene, rope)
    add_special_beams(scene, fine)
    return scene


def add_ground(scene, rope):
    """Let a rope touch a tetrahedron and hills."""
    corners = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
    sides = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    scene.contact(rope, ancf.TriangleMesh((2.0, -9.0, 0.0), corners, sides, 0.1), stiffness=1e5)
    hills = ancf.HeightField((0.0, -20.0, -10.0), [[0.0, 0.1, 0.2], [0.3, 0.2, 0.1]], 1.0)
    scene.contact(rope, hills, stiffness=1e5)


def add_special_beams(scene, fine):
    """Add curved, heated, eccentric and slack beams, all kinds of sections, and loads on them."""
    bar = ancf.Polygon([(0, 0), (0.1, 0), (0.1, 0.05), (0, 0.05)])
    hollow = ancf.Polygon(bar.corners, [[(0.01, 0.01), (0.09, 0.01), (0.09, 0.04), (0.01, 0.04)]])
    plain = ancf.Section(1e-4, 2e-9, 3e-9, 1e-9, inertia_yz=-1e-9)
    profile = ancf.IBeam(width=0.1, height=0.2, web=0.005, flange=0.008)
    sections = bar, hollow, plain, ancf.Tube(0.1, 0.01), profile
    for k, section in enumerate(sections):
        ends = (10, k, 0), (11, k, 0)
        scene.add_beam("thick", *ends, 2 * fine, section, MATERIAL, up=(0, 1, 1))
    strip = scene.add_beam(
        "thick", (0, 10, 0), (1, 10, 0), 2 * fine, SECTION, MATERIAL, section_strain="nodal",
        eigenstrain=ancf.Ramp(1e-4, 1.0), eigencurvature=(0.1, 0.2),
    )  # fmt: skip
    scene.point_force(strip.end, (1.0, 2.0, 3.0), follow=True)
    scene.point_moment(strip.end, (0.1, 0.2, 0.3), follow=True)
    scene.distributed_force(strip, (0.0, 1.0, 0.0), follow=True)
    scene.add_beam("string", (0, 11, 0), (1, 11, 0), 2 * fine, SECTION, MATERIAL, slack=1e-3)
    scene.add_beam(
        "thick", curve=ancf.Helix(0.5, 0.4, 2.0), n_elements=4 * fine, section=SECTION,
        material=MATERIAL, twist=0.5,
    )  # fmt: skip
    side = scene.add_beam(
        "thick", (0, 12, 0), (1, 12, 0), 2 * fine, SECTION, MATERIAL, curvature="section",
        offset=(0.1, -0.2),
    )  # fmt: skip
    scene.point_force(side.at(0.7, y=0.01, z=0.02), (0.0, -1.0, 0.0))
