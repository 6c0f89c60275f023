"""Points of thick beams beside the centroid: joints, loads and results, beside calculations."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize

import ancfsparse as ancf
from tests.beams import build_beam
from tests.solve.refusals import assert_refused

LENGTH, SIDE, OFF = 2.0, 0.05, 0.08
SECTION, STEEL = ancf.Rectangle(SIDE, SIDE), ancf.Material(2e11, 7800.0)
EA, EI = 2e11 * SIDE**2, 2e11 * SIDE**4 / 12.0
GJ = STEEL.shear_modulus * SECTION.torsion_constant
# With a tension F at the height e the deflection is e (1 / cosh(k L) - 1), k^2 = F / EI, for small
# forces -F e L^2 / 2 EI; the loaded point moves by F L (1 / EA + e^2 / EI) to first order.
TENSION = 10.0
DOWN = OFF * (1.0 / np.cosh(LENGTH * np.sqrt(TENSION / EI)) - 1.0)
ALONG = TENSION * LENGTH * (1.0 / EA + OFF**2 / EI)


def cantilever(n, dim, section=SECTION, **options):
    """A clamped beam along x, without gravity."""
    z = (0.0,) * (dim - 2)
    scene = ancf.Scene((0.0, 0.0, *z))
    options = {"curvature": "section"} | options
    rod = scene.add_beam("thick", (0, 0, *z), (LENGTH, 0, *z), n, section, STEEL, **options)
    scene.clamp(rod.start)
    return scene, rod


@pytest.mark.parametrize("section_strain", ["consistent", "nodal"])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_tension_beside_the_centroid_bends_as_calculated(dim, section_strain):
    errors = []
    for n in (2, 8):
        scene, rod = cantilever(n, dim, section_strain=section_strain)
        top = rod.at(LENGTH, y=OFF)
        scene.point_force(top, (TENSION, 0.0, 0.0)[:dim])
        rest = ancf.solve_static(scene)
        errors.append(abs(rest.position(rod.end)[1] / DOWN - 1.0))
        assert rest.position(top)[0] - LENGTH == pytest.approx(ALONG, rel=2e-3)
    assert errors[0] < 1e-5
    assert errors[1] < 6e-7
    np.testing.assert_allclose(rest.section_force(rod, 0.5).N, TENSION, rtol=1e-3)


def offset_cantilever(n, element, dim):
    """A cantilever whose load acts on an axis that lies OFF above its centroid."""
    z = (0.0,) * (dim - 2)
    ends = (0, 0, *z), (LENGTH, 0, *z)
    scene, rod = build_beam(element, *ends, n, SECTION, STEEL, "clamp", gravity=(0.0, 0.0, *z))
    inertia = 1e-3 if dim == 2 else (1e-3, 1e-3, 1e-3)
    arm = scene.add_body(mass=1.0, inertia=inertia, position=(LENGTH, 0, *z))
    scene.weld(rod.end, arm.origin)
    scene.point_force(arm.at((0.0, OFF, *z)), (TENSION, 0.0, *z))
    return ancf.solve_static(scene), rod, arm


@pytest.mark.parametrize(("element", "dim"), [("thin", 2), ("thick", 2), ("thick", 3)])
def test_an_axial_load_on_an_eccentric_axis_bends_and_stretches(element, dim):
    errors = []
    for n in (4, 8):
        rest, rod, arm = offset_cantilever(n, element, dim)
        top = arm.at((0.0, OFF, *(0.0,) * (dim - 2)))
        errors.append(abs(rest.position(rod.end)[1] / DOWN - 1.0))
        # Clamps of thick beams hold the height of the section, which is felt over an element.
        near = 3e-4 if element == "thin" else 2e-2 / n
        assert rest.position(top)[0] - LENGTH == pytest.approx(ALONG, rel=near)
    assert errors[1] < 2e-7
    assert element == "thin" or errors[0] / errors[1] > 12.0  # order 4
    np.testing.assert_allclose(rest.section_force(rod, 0.5).N, TENSION, rtol=1e-3)


def test_points_are_those_of_rigid_bodies_welded_there():
    scene, rod = cantilever(8, 3)
    scene.point_force(rod.at(LENGTH, y=0.03, z=-0.06), (300.0, -50.0, 80.0))
    own = ancf.solve_static(scene)
    scene, other = cantilever(8, 3)
    arm = scene.add_body(mass=1.0, inertia=(1e-3,) * 3, position=(LENGTH, 0, 0))
    scene.weld(other.end, arm.origin)
    scene.point_force(arm.at((0.0, 0.03, -0.06)), (300.0, -50.0, 80.0))
    its = ancf.solve_static(scene)
    # The weld also keeps the section of the last element from contracting, so only across.
    moved = own.position(rod.end)[1:]
    np.testing.assert_allclose(its.position(other.end)[1:], moved, rtol=1e-5)


def test_a_force_across_twists_by_its_arm():
    scene, rod = cantilever(4, 3)
    side = rod.at(LENGTH, y=OFF)
    scene.point_force(side, (0.0, 0.0, 10.0))
    rest = ancf.solve_static(scene)
    twist = (rest.position(side) - rest.position(rod.end))[2] / OFF
    assert twist == pytest.approx(10.0 * OFF * LENGTH / GJ, rel=1e-3)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("s", [1.0, 1.75])  # a node, and inside an element
def test_forces_that_follow_or_not_act_beside_the_axis_inside_too(dim, s):
    # A moment F e at s: the end deflects by -F e s (L - s / 2) / EI, if the force is small.
    small = 0.01
    expected = -small * OFF * s * (LENGTH - 0.5 * s) / EI
    for follow in (False, True):
        scene, rod = cantilever(8, dim)
        scene.point_force(rod.at(s, y=OFF), (small, 0.0, 0.0)[:dim], follow=follow)
        rest = ancf.solve_static(scene)
        assert rest.position(rod.end)[1] == pytest.approx(expected, rel=2e-3 if s > 1.5 else 2e-6)


def test_a_force_follows_planar_thick_beams():
    scene, rod = cantilever(8, 2)
    scene.point_force(rod.end, (0.0, 10.0), follow=True)
    rest = ancf.solve_static(scene)
    kga = SECTION.shear_correction(0.3) * STEEL.shear_modulus * SECTION.area
    expected = 10.0 * LENGTH**3 / (3.0 * EI) + 10.0 * LENGTH / kga
    assert rest.position(rod.end)[1] == pytest.approx(expected, rel=4e-3)


def test_a_column_compressed_beside_its_centroid_follows_the_secant_formula():
    # Timoshenko and Gere, Theory of Elastic Stability, 1.12: e (sec(L / 2 sqrt(P / EI)) - 1).
    e, load = 1e-4, 0.5 * np.pi**2 * EI / LENGTH**2
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam(
        "thick", (0, 0), (LENGTH, 0), 16, SECTION, STEEL, curvature="section", offset=e
    )
    ground = scene.add_body(mass=1.0, inertia=1.0, position=(LENGTH, 0))
    scene.pin(rod.start)
    scene.prismatic(ground.origin, axis=(1, 0))
    scene.connect(rod.end, ground.origin)
    scene.point_force(rod.end, (-load, 0.0))
    rest = ancf.solve_static(scene)
    middle = rod.at(0.5 * LENGTH, y=0.0)
    bowed = rest.position(middle)[1] - middle.position[1]
    expected = e / np.cos(0.5 * LENGTH * np.sqrt(load / EI)) - e
    # Shear lowers the load at which it buckles by P / kGA, and so on: 1e-3 of it.
    assert bowed == pytest.approx(expected, rel=6e-3)


def test_supports_below_the_centroid_stiffen_a_beam_as_calculated():
    # Symmetric vibrations of a beam whose ends are pinned e below the centroid, with its axial
    # inertia: w'' + e^2 EA/EI k cot(k l) w' = 0 at l = L / 2, k = omega sqrt(rho / E).
    height, e = 0.01, 0.02
    section = ancf.Rectangle(0.02, height)
    ea, ei = 2e11 * section.area, 2e11 * section.inertia_z
    half = 0.5 * LENGTH

    def moment(omega):
        beta = (omega**2 * 7800.0 * section.area / ei) ** 0.25
        k = omega * np.sqrt(7800.0 / 2e11)
        a, b = np.cosh(beta * half), -np.cos(beta * half)  # w = a cos(beta x) + b cosh(beta x)
        slope = beta * (-a * np.sin(beta * half) + b * np.sinh(beta * half))
        bend = beta**2 * (-a * np.cos(beta * half) + b * np.cosh(beta * half))
        return ei * bend + e**2 * ea * k / np.tan(k * half) * slope

    simple = np.pi**2 / LENGTH**2 * np.sqrt(ei / (7800.0 * section.area))
    omega = scipy.optimize.brentq(moment, 1.2 * simple, 2.4 * simple)
    assert omega > 2.1 * simple
    errors = []
    for n in (16, 32):
        scene = ancf.Scene((0.0, 0.0))
        rod = scene.add_beam(
            "thick", (0, 0), (LENGTH, 0), n, section, STEEL, curvature="section", offset=e
        )
        scene.pin(rod.start)
        scene.pin(rod.end)
        errors.append(ancf.modes(scene, 1).frequencies[0] * 2.0 * np.pi / omega - 1.0)
    assert 3.5 < errors[0] / errors[1] < 5.0  # order 2
    assert abs(errors[1] + (errors[1] - errors[0]) / 3.0) < 2e-4  # of it 1e-4 is shear


@pytest.mark.parametrize("dim", [2, 3])
def test_two_flanges_joined_along_their_faces_are_one_beam(dim):
    # By the parallel axis theorem, with the shear of a Timoshenko beam; nu = 0, because each
    # flange of other materials is held by the other in its lateral contraction at the wall.
    material, force, z = ancf.Material(2e11, 7800.0, 0.0), 100.0, (0.0,) * (dim - 2)
    inertia = SIDE * (2.0 * SIDE) ** 3 / 12.0
    kga = 2.0 * SECTION.shear_correction(0.0) * material.shear_modulus * SECTION.area
    deflection = force * LENGTH**3 / (3.0 * 2e11 * inertia) + force * LENGTH / kga
    errors = []
    for n in (8, 16):
        scene = ancf.Scene((0.0, 0.0, *z))
        flanges = [
            scene.add_beam(
                "thick", (0, 0, *z), (LENGTH, 0, *z), n, SECTION, material,
                curvature="section", offset=(side * 0.5 * SIDE, *z),
            )
            for side in (1.0, -1.0)
        ]  # fmt: skip
        for flange in flanges:
            scene.clamp(flange.start)
        for i in range(1, n + 1):
            scene.connect(flanges[0].node(i), flanges[1].node(i))
        scene.point_force(flanges[0].end, (0.0, -force, *z))
        rest = ancf.solve_static(scene)
        errors.append(abs(rest.position(flanges[1].end)[1] / -deflection - 1.0))
    assert errors[1] < 2e-3
    assert errors[0] / errors[1] > 3.5  # order 2: they are joined at nodes


@pytest.mark.parametrize("dim", [2, 3])
def test_a_swinging_eccentric_beam_keeps_its_energy(dim):
    z = (0.0,) * (dim - 2)
    scene = ancf.Scene((0.0, -9.81, *z))
    rod = scene.add_beam(
        "thick", (0, 0, *z), (1, 0, *z), 4, ancf.Rectangle(0.02, 0.02), ancf.Material(1e8, 1000.0),
        curvature="section", offset=(0.05, *z),
    )  # fmt: skip
    scene.pin(rod.start)
    scene.add_mass(rod.end, 0.3)
    scene.spring(rod.at(0.5, y=-0.1), (0.5, -1.0, *z), stiffness=50.0)
    run = ancf.simulate(scene, 0.2, 1e-3, integrator=ancf.EnergyMomentum())
    total = run.energy.total
    assert np.abs(total - total[0]).max() < 1e-9 * np.ptp(run.energy.kinetic)
    np.testing.assert_allclose(run.position(rod.start), 0.0, atol=1e-12)


def test_scenes_with_such_points_are_copied_refined_and_stored(tmp_path):
    scene, rod = cantilever(4, 3, section=ancf.Polygon([(0, 0), (0.06, 0), (0, 0.03)]))
    point = rod.at(1.3, y=0.01, z=0.02)
    scene.point_force(point, (0.0, -1.0, 0.0))
    other = scene.add_beam(
        "thick", (0, 1, 0), (2, 1, 0), 4, SECTION, STEEL, curvature="section", offset=(0.1, -0.2)
    )
    scene.clamp(other.start)
    scene.add_mass(other.end, 1.0)
    scene.save(tmp_path / "scene.json")
    again = ancf.Scene.load(tmp_path / "scene.json")
    assert again == scene
    assert again.digest() == scene.digest()
    finer = scene.refined(2)
    np.testing.assert_allclose(finer.counterpart(point).position, point.position)
    np.testing.assert_allclose(point.position, (1.3, 0.01, 0.02), atol=1e-15)
    np.testing.assert_allclose(other.end.position, (2, 1, 0))
    np.testing.assert_allclose(other.positions[-1], (2, 1.1, -0.2))
    np.testing.assert_allclose(finer.counterpart(other).end.position, (2, 1, 0))
    np.testing.assert_allclose(other.at(2.0, y=0.0).position, (2, 1.1, -0.2))
    assert repr(other.end) == "beam 1 at s = 2 m, y = -0.1 m, z = 0.2 m"


def test_sections_that_do_not_turn_by_themselves_have_no_such_points():
    scene = ancf.Scene((0.0, 0.0))
    for element, options in (("thin", {}), ("thick", {}), ("string", {})):
        rod = scene.add_beam(element, (0, 0), (1, 0), 2, SECTION, STEEL, **options)
        assert_refused("curvature='section', or weld a rigid body", rod.at, 1.0, y=0.1)
    with pytest.raises(ancf.InputError, match="no points off its axis before a plan"):
        scene.add_beam("auto", (0, 0), (1, 0), 2, SECTION, STEEL).at(1.0, y=0.1)
    with pytest.raises(ancf.InputError, match="no points off its axis"):
        scene.add_beam("thin", (0, 0), (1, 0), 2, SECTION, STEEL, offset=0.1)


def test_invalid_places_in_a_section_are_refused():
    scene, rod = cantilever(2, 2)
    assert_refused(r"z of a point .* has no meaning in a planar", rod.at, 1.0, z=0.1)
    assert_refused("y of a point of beam 0 must be finite", rod.at, 1.0, y=np.nan)
    assert_refused("lies inside element", scene.clamp, rod.at(0.3, y=0.1))
    with pytest.raises(ancf.InputError, match="offset of beam 1 needs a straight beam"):
        scene.add_beam(
            "thick", n_elements=4, section=SECTION, material=STEEL, curvature="section",
            curve=ancf.Arc((0, 0), (1, 0), np.pi / 2), offset=0.1,
        )  # fmt: skip
    with pytest.raises(ancf.InputError, match="offset of beam 1 must be a number of metres"):
        scene.add_beam(
            "thick", (0, 0), (1, 0), 2, SECTION, STEEL, curvature="section", offset=(0.1, 0.2)
        )
