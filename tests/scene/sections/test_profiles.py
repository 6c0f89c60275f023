"""Tubes, I-sections and polygons against formulas; torsion by an own solution against series."""

import math
import re
from dataclasses import fields

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError

MATERIAL = ancf.Material(2.1e11, 7850.0)
ANGLE = [(0, 0), (0.1, 0), (0.1, 0.01), (0.01, 0.01), (0.01, 0.08), (0, 0.08)]


def box(height, width, y=0.0, z=0.0):
    h, w = 0.5 * height, 0.5 * width
    return [(y - h, z - w), (y + h, z - w), (y + h, z + w), (y - h, z + w)]


def turned(corners, angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array(corners) @ [[c, s], [-s, c]]


@pytest.mark.parametrize("shape", [ancf.IBeam, ancf.Box], ids=lambda shape: shape.__name__)
def test_sizes_whose_order_differs_between_shapes_are_given_by_name(shape):
    with pytest.raises(TypeError, match="positional argument"):
        shape(*[0.3, 0.2, 0.01, 0.01][: len(fields(shape))])


def test_a_tube_is_a_circle_less_a_circle():
    tube, outer, inner = ancf.Tube(0.1, 0.02), ancf.Circle(0.1), ancf.Circle(0.06)
    for name in ("area", "inertia_y", "inertia_z", "torsion_constant"):
        difference = getattr(outer, name) - getattr(inner, name)
        assert getattr(tube, name) == pytest.approx(difference, rel=1e-14)
    full = ancf.Tube(0.1, 0.05)
    assert full.shear_correction(0.3) == pytest.approx(outer.shear_correction(0.3))
    thin = ancf.Tube(0.1, 1e-7)  # 2 (1 + nu) / (4 + 3 nu), Cowper 1966
    assert thin.shear_correction(0.3) == pytest.approx(2.6 / 4.9, rel=1e-5)


def test_an_i_section_is_a_polygon():
    h, b, w, t = 0.2, 0.1, 0.012, 0.015
    section = ancf.IBeam(width=b, height=h, web=w, flange=t)
    y, z = [h / 2 - t, h / 2], [w / 2, b / 2]
    right = [(-y[1], z[1]), (-y[0], z[1]), (-y[0], z[0]), (y[0], z[0]), (y[0], z[1]), (y[1], z[1])]
    polygon = ancf.Polygon(right + [(-y, -z) for y, z in right])
    for name in ("area", "inertia_y", "inertia_z"):
        assert getattr(section, name) == pytest.approx(getattr(polygon, name), rel=1e-13)
    # El Darwish and Johnston fitted their formula to finite differences, to about one per cent.
    assert section.torsion_constant == pytest.approx(polygon.torsion_constant, rel=1e-2)


@pytest.mark.parametrize("ratio", [1.0, 3.0, 30.0])
def test_moments_and_torsion_of_a_rectangle_wherever_it_is(ratio):
    rectangle = ancf.Rectangle(width=0.02, height=0.02 * ratio)
    for corners in (box(0.02 * ratio, 0.02, 7.0, -3.0), box(0.02 * ratio, 0.02, 7.0, -3.0)[::-1]):
        polygon = ancf.Polygon(corners)
        assert polygon.centroid == pytest.approx((7.0, -3.0))
        for name in ("area", "inertia_y", "inertia_z"):
            assert getattr(polygon, name) == pytest.approx(getattr(rectangle, name), rel=1e-10)
        assert polygon.is_principal
        assert polygon.torsion_constant == pytest.approx(rectangle.torsion_constant, rel=1e-5)


def test_torsion_of_sections_with_known_constants():
    side = 0.3
    triangle = ancf.Polygon([(0, 0), (side, 0), (side / 2, side * math.sqrt(3) / 2)])
    assert triangle.torsion_constant == pytest.approx(math.sqrt(3) / 80 * side**4, rel=1e-12)
    # Four times the integral of u, - div grad u = 1, over an L of three unit squares: 0.2140758036
    # by adaptive finite elements.
    ell = ancf.Polygon([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])
    assert ell.torsion_constant == pytest.approx(4 * 0.2140758036, rel=2e-6)


def test_torsion_of_an_ellipse_of_many_edges():
    """pi a^3 b^3 / (a^2 + b^2); a polygon in it misses its area by 1 - (n/2 pi) sin(2 pi/n)."""
    a, b, n = 0.2, 0.1, 40
    turn = 2 * math.pi * np.arange(n) / n
    polygon = ancf.Polygon(np.column_stack([a * np.cos(turn), b * np.sin(turn)]))
    share = n / (2 * math.pi) * math.sin(2 * math.pi / n)
    exact = math.pi * a**3 * b**3 / (a**2 + b**2)
    assert polygon.torsion_constant == pytest.approx(exact * share**2, rel=5e-4)


def test_torsion_of_a_thin_box_is_bredts():
    """J = 4 A^2 t / s of the middle line, and a little more for walls that are not thin."""
    for wall, share in ((0.02, 0.01), (0.005, 0.0025)):
        section = ancf.Polygon(box(1, 1), [box(1 - 2 * wall, 1 - 2 * wall)])
        bredt = (1 - wall) ** 3 * wall
        assert bredt < section.torsion_constant < (1 + share) * bredt


def test_an_angle_has_principal_axes():
    section = ancf.Polygon(ANGLE)
    assert not section.is_principal
    angle = section.principal_angle
    principal = section.principal()
    assert principal.is_principal
    assert principal.centroid == pytest.approx((0.0, 0.0), abs=1e-16)
    c, s = math.cos(angle), math.sin(angle)
    about = c * c * section.inertia_z + s * s * section.inertia_y + 2 * s * c * section.inertia_yz
    assert principal.inertia_z == pytest.approx(about, rel=1e-12)
    assert principal.inertia_y + principal.inertia_z == pytest.approx(
        section.inertia_y + section.inertia_z
    )
    assert principal.torsion_constant == pytest.approx(section.torsion_constant, rel=1e-9)
    tilted = ancf.Polygon(turned(box(0.1, 0.03), 0.3))
    assert tilted.principal_angle == pytest.approx(0.3)
    assert ancf.Polygon(turned(box(0.03, 0.1), 0.3)).principal_angle == pytest.approx(0.3)


def test_beams_have_the_bending_stiffness_of_their_sections():
    scene = ancf.Scene((0.0, 0.0, 0.0))
    hollow = ancf.Polygon(box(0.1, 0.05), [box(0.08, 0.03)])
    beam = ancf.IBeam(width=0.1, height=0.2, web=0.005, flange=0.008)
    for section in (ancf.Tube(0.1, 0.01), beam, hollow):
        rod = scene.add_beam("thick", (0, 0, 0), (1, 0, 0), 2, section, MATERIAL)
        expected = MATERIAL.youngs_modulus * section.inertia_z
        assert rod.parameters()["bending_stiffness_z"] == expected


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: ancf.Tube(0.1, 0.06), "more than half its diameter"),
        (lambda: ancf.Tube(0.1, 0.0), "thickness of the tube must be positive"),
        (
            lambda: ancf.IBeam(width=0.1, height=0.01, web=0.005, flange=0.008),
            "no room between its flanges",
        ),
        (lambda: ancf.Polygon([(0, 0), (1, 0)]), "at least three corners"),
        (lambda: ancf.Polygon([(0, 0), (1, 0), (1, 0), (0, 1)]), "corner 1 of the polygon and the"),
        (
            lambda: ancf.Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]),
            "edges 0 and 2 of the polygon meet",
        ),
        (lambda: ancf.Polygon(box(1, 1), [box(2, 0.5)]), "of the polygon meet"),
        (lambda: ancf.Polygon(box(1, 1), [box(2, 2)]), "lies outside of it"),
        (lambda: ancf.Polygon(box(1, 1), 3), "must be a list"),
        (lambda: ancf.Polygon(np.random.default_rng(1).normal(size=(101, 2))), "has 101 corners"),
    ],
)
def test_mistakes_in_sections(make, words):
    with pytest.raises(InputError, match=re.escape(words)):
        make()


UNEQUAL = ancf.Polygon(ANGLE)
NUMBERS = ancf.Section(
    UNEQUAL.area, UNEQUAL.inertia_y, UNEQUAL.inertia_z, UNEQUAL.torsion_constant,
    inertia_yz=UNEQUAL.inertia_yz,
)  # fmt: skip


@pytest.mark.parametrize("section", [UNEQUAL, NUMBERS], ids=["polygon", "numbers"])
@pytest.mark.parametrize("curve", [False, True])
def test_unsymmetrical_bending(section, curve):
    """A force F along y bends to (I_y, -I_yz) F L^3 / (3 E (I_y I_z - I_yz^2)).

    Timoshenko, Strength of Materials, part 1, article 93.
    """
    length = 60.0 * math.sqrt(section.area)
    scene = ancf.Scene((0.0, 0.0, 0.0))
    if curve:
        line = {"curve": lambda u: np.outer(u, (length, 0.0, 0.0)), "n_elements": 8}
    else:
        line = {"start": (0, 0, 0), "end": (length, 0, 0), "n_elements": 8}
    rod = scene.add_beam("thick", section=section, material=MATERIAL, **line)
    scene.clamp(rod.start)
    force = 1e-4 * MATERIAL.youngs_modulus * section.inertia_z / length**2
    scene.point_force(rod.end, (0.0, force, 0.0))
    moved = ancf.solve_static(scene).displacement(rod.end)
    determinant = section.inertia_y * section.inertia_z - section.inertia_yz**2
    share = force * length**3 / (3.0 * MATERIAL.youngs_modulus * determinant)
    expected = share * np.array([section.inertia_y, -section.inertia_yz])
    assert abs(expected[1]) > 0.2 * abs(expected[0])
    np.testing.assert_allclose(moved[1:], expected, rtol=2e-3)


def test_the_inertia_of_a_section_keeps_its_product():
    """A rod that turns about its own y, z and the line between has the tensor of its area."""
    section = UNEQUAL
    for axis in np.array([(0, 1, 0), (0, 0, 1), (0, 0.6, 0.8)], float):
        scene = ancf.Scene((0.0, 0.0, 0.0))
        scene.add_beam(
            "thick", (0, 0, 0), (0.2, 0, 0), 3, section, MATERIAL,
            velocity=lambda x, axis=axis: np.cross(axis, x),
        )  # fmt: skip
        y, z = axis[1:]
        second = y**2 * section.inertia_y + z**2 * section.inertia_z
        second -= 2.0 * y * z * section.inertia_yz
        density = MATERIAL.density * 0.2
        expected = 0.5 * density * (section.area * 0.2**2 / 3.0 + second)
        run = ancf.simulate(scene, 1e-6, 1e-6)
        assert run.energy.kinetic[0] == pytest.approx(expected, rel=1e-9)


def test_sections_whose_axes_are_not_principal_are_refused_where_they_have_no_meaning():
    plane = ancf.Scene((0.0, 0.0))
    with pytest.raises(InputError, match="bending leaves the plane: take a spatial scene"):
        plane.add_beam("thick", (0, 0), (1, 0), 2, UNEQUAL, MATERIAL)
    space = ancf.Scene((0.0, 0.0, 0.0))
    taper = ancf.Taper(NUMBERS, NUMBERS)
    with pytest.raises(InputError, match="Taper of a section with inertia_yz"):
        space.add_beam("thick", (0, 0, 0), (1, 0, 0), 2, taper, MATERIAL)
    with pytest.raises(InputError, match="inertia_yz of the section, 5e-09 m4, must be smaller"):
        ancf.Section(1e-4, 4e-9, 5e-9, 1e-9, inertia_yz=5e-9)
    with pytest.raises(InputError, match="bending stiffness is the same"):
        space.add_beam("thin", (0, 0, 0), (1, 0, 0), 2, NUMBERS, MATERIAL)


SIZES = {
    ancf.Circle: {"diameter": 1.0},
    ancf.Tube: {"diameter": 1.0, "thickness": 0.1},
    ancf.Rectangle: {"width": 1.0, "height": 0.8},
    ancf.IBeam: {"width": 1.0, "height": 0.8, "web": 0.1, "flange": 0.05},
}


@pytest.mark.parametrize("kind", SIZES, ids=lambda kind: kind.__name__)
def test_moments_are_rounded_alike_in_units_of_powers_of_two(kind):
    """The last digit of a power by `pow` of the C library depends on the unit in some sizes."""
    rng = np.random.default_rng(5)
    for _ in range(500):
        scale = 10.0 ** rng.uniform(-3, 1)
        sizes = {name: scale * rng.uniform(0.9, 1.1) * x for name, x in SIZES[kind].items()}
        here = kind(**sizes)
        there = kind(**{name: 1024.0 * size for name, size in sizes.items()})
        for name in ("area", "inertia_y", "inertia_z", "torsion_constant"):
            one, other = (math.frexp(getattr(each, name))[0] for each in (here, there))
            assert one == other
