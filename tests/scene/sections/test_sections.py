"""Sections and materials against handbook values."""

import dataclasses
import math

import numpy as np
import pytest

from ancfsparse.errors import InputError
from ancfsparse.scene import Circle, Material, Rectangle, Section

# J = c a b^3: Timoshenko and Goodier, Theory of Elasticity, article 109, table of k1 (same
# values as Roark's table for solid rectangles), given to three digits, the square to four.
TORSION = [
    (1.0, 0.1406, 5e-5),
    (1.5, 0.196, 5e-4),
    (2.0, 0.229, 5e-4),
    (3.0, 0.263, 5e-4),
    (4.0, 0.281, 5e-4),
    (5.0, 0.291, 5e-4),
    (10.0, 0.312, 5e-4),
    (1e6, 1 / 3, 1e-6),
]


@pytest.mark.parametrize(("ratio", "coefficient", "tolerance"), TORSION)
def test_torsion_constant_of_a_rectangle(ratio, coefficient, tolerance):
    b = 0.02
    for section in (Rectangle(b, ratio * b), Rectangle(ratio * b, b)):
        assert section.torsion_constant / (ratio * b**4) == pytest.approx(
            coefficient, abs=tolerance
        )


def test_torsion_constant_equals_the_plain_series():
    # Saint-Venant's series itself, summed until the terms vanish beside 1e-12.
    a, b = 0.03, 0.02
    series = sum(math.tanh(n * math.pi * a / (2 * b)) / n**5 for n in range(1, 801, 2))
    expected = a * b**3 * (1 / 3 - 64 * b / (math.pi**5 * a) * series)
    assert Rectangle(a, b).torsion_constant == pytest.approx(expected, rel=1e-12)


def test_torsion_constant_of_a_square_against_its_second_moments():
    # 0.8436 (I_y + I_z), as Schwab and Meijaard write it, is 0.1406 b^4 to its four digits.
    square = Rectangle(0.01, 0.01)
    polar = square.inertia_y + square.inertia_z
    assert square.torsion_constant / polar == pytest.approx(0.8436, abs=2e-4)


def test_second_moments_know_which_way_the_height_points():
    # int z^2 dA = h w^3/12 with w = 0.02 along z; int y^2 dA = w h^3/12 with h = 0.06 along y.
    section = Rectangle(width=0.02, height=0.06)
    assert section.area == pytest.approx(1.2e-3)
    assert section.inertia_y == pytest.approx(4.0e-8)
    assert section.inertia_z == pytest.approx(3.6e-7)


def test_circle():
    # Handbook: A = pi d^2/4, I = pi d^4/64, J = 2 I.
    section = Circle(0.02)
    assert section.area == pytest.approx(3.1415926535e-4)
    assert section.inertia_y == pytest.approx(7.8539816e-9)
    assert section.inertia_z == section.inertia_y
    assert section.torsion_constant == pytest.approx(1.57079633e-8)


def test_shear_correction_factors():
    # Cowper, J. Appl. Mech. 33 (1966): 10 (1 + nu)/(12 + 11 nu) and 6 (1 + nu)/(7 + 6 nu),
    # by hand: 10/12 and 6/7 for nu = 0; 13/15.3 = 0.849673 and 7.8/8.8 = 0.886364 for nu = 0.3.
    for nu, rectangle, circle in [(0.0, 0.833333, 0.857143), (0.3, 0.849673, 0.886364)]:
        assert Rectangle(1.0, 2.0).shear_correction(nu) == pytest.approx(rectangle, abs=1e-6)
        assert Circle(1.0).shear_correction(nu) == pytest.approx(circle, abs=1e-6)
    assert Section(1.0, 1.0, 1.0, 1.0, shear_factor=0.5).shear_correction(0.3) == 0.5
    assert Section(1.0, 1.0, 1.0, 1.0).shear_correction(0.3) == pytest.approx(5 / 6)


def test_material_moduli():
    # nu = 0.25 makes both Lame parameters equal: lam = G = E / 2.5.
    material = Material(2.0e11, 7850.0, 0.25)
    assert material.shear_modulus == pytest.approx(8.0e10)
    assert material.lame_modulus == pytest.approx(8.0e10)
    assert Material(1e8, 4000.0).poisson_ratio == 0.3


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Rectangle(0.0, 1.0), "width of the rectangle must be positive, got 0 m"),
        (lambda: Rectangle(1.0, -0.1), "height of the rectangle must be positive, got -0.1 m"),
        (lambda: Rectangle(np.nan, 1.0), "width of the rectangle must be finite, got nan m"),
        (lambda: Circle(-2.0), "diameter of the circle must be positive, got -2 m"),
        (lambda: Circle("1"), "diameter of the circle must be a number, got '1'"),
        (lambda: Section(0, 1, 1, 1), "area of the section must be positive, got 0 m2"),
        (lambda: Section(1, -1, 1, 1), "inertia_y of the section must be positive, got -1 m4"),
        (lambda: Section(1, 1, np.nan, 1), "inertia_z of the section must be finite, got nan m4"),
        (lambda: Section(1, 1, 1, 0), "torsion_constant of the section must be positive"),
        (lambda: Section(1, 1, 1, 1, 0), "shear_factor of the section must be positive, got 0"),
        (lambda: Material(0, 1), "youngs_modulus must be positive, got 0 Pa"),
        (lambda: Material(1e8, -1), "density must be positive, got -1 kg/m3"),
        (lambda: Material(1e8, 0), "density must be positive, got 0 kg/m3"),
        (lambda: Material(1e8, np.nan), "density must be finite, got nan kg/m3"),
        (lambda: Material(1e8, 1, 0.5), "poisson_ratio must be .* less than 0.5, got 0.5.*0.49"),
        (lambda: Material(1e8, 1, -1), "poisson_ratio must be greater than -1 .* got -1: below"),
        (lambda: Material(1e8, 1, np.nan), "poisson_ratio must be finite, got nan"),
        (
            lambda: Material(1e8, 1, axial_damping=-0.1),
            "axial_damping must not be negative, got -0.1 s: it would feed energy into the motion",
        ),
        (
            lambda: Material(1e8, 1, bending_damping=-2),
            "bending_damping must not be negative, got -2 s: .*; leave it out for none",
        ),
        (lambda: Material(1e8, 1, bending_damping="x"), "bending_damping must be a number, got"),
        (
            lambda: Material(1e8, 1, rayleigh=(-3.0, 0.0)),
            "alpha of rayleigh must not be negative, got -3 1/s",
        ),
        (
            lambda: Material(1e8, 1, rayleigh=(0.0, np.inf)),
            "beta of rayleigh must be finite, got inf s",
        ),
        (lambda: Material(1e8, 1, rayleigh=0.1), "must be a pair .* got 0.1: try rayleigh="),
        (lambda: Material(1e8, 1, rayleigh=(1.0,)), r"must be a pair .* got \(1.0,\)"),
    ],
)
def test_impossible_sections_and_materials(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("side", [1e80, 1e-80])
def test_sides_whose_fourth_power_is_no_number(side):
    for make in (Circle, lambda h: Rectangle(h, 1.0), lambda h: Rectangle(1.0, h)):
        with pytest.raises(InputError, match=r"must lie between 1e-75 and 1e\+75 m"):
            make(side)


@pytest.mark.parametrize("number", [2, np.float32(2.0), np.array(2.0), np.int8(2)])
def test_numbers_are_kept_in_double_precision(number):
    for section in (
        Rectangle(number, number),
        Circle(number),
        Section(number, number, number, number, number),
        Material(number, number, 0, axial_damping=number, rayleigh=(number, number)),
    ):
        for value in dataclasses.asdict(section).values():
            assert all(type(x) is float for x in (value if isinstance(value, tuple) else [value]))
        assert hash(section) == hash(dataclasses.replace(section))
