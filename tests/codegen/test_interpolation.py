"""Shape functions and Legendre modes are what they say."""

from fractions import Fraction

import pytest
import sympy as sp

from codegen.declarations import interpolate, length, x
from codegen.elements import ELEMENTS
from codegen.modes import ModeVectors, gauss_rule, legendre_value, product_modes
from codegen.tape import Tape

xi = sp.Symbol("xi")


def test_cubic_shape_functions_are_the_published_ones():
    s = x / length
    published = (
        1 - 3 * s**2 + 2 * s**3,
        length * (s - 2 * s**2 + s**3),
        3 * s**2 - 2 * s**3,
        length * (s**3 - s**2),
    )
    for found, expected in zip(interpolate("r", (0,), "r", "r_x").shape, published, strict=True):
        assert sp.expand(found - expected) == 0


@pytest.mark.parametrize("nodal", [("r", "r_x"), ("r_y",)])
def test_shape_functions_are_nodal(nodal):
    field = interpolate(nodal[0], (0,), *nodal)
    rows = [
        [sp.diff(s, x, order).subs(x, end) for s in field.shape]
        for end in (0, length)
        for order in range(len(nodal))
    ]
    assert sp.simplify(sp.Matrix(rows)) == sp.eye(len(field.shape))


@pytest.mark.parametrize("name", ["l2t2", "thin_spatial_green", "thick_axis_consistent"])
def test_modes_add_up_to_the_field(name):
    element = ELEMENTS[name][1]()
    tape = Tape()
    modes = ModeVectors(tape, element, [tape.coordinate(i) for i in range(element.n_coordinates)])
    for field in element.fields:
        total = [sp.Integer(0)] * len(field.shape)
        for m, (factor, vector) in enumerate(modes.of(field)):
            row = modes.rows[vector][1]
            polynomial = sp.legendre(m, 2 * x / length - 1)
            total = [t + factor * polynomial * c for t, c in zip(total, row, strict=True)]
        for found, shape in zip(total, field.shape, strict=True):
            assert sp.expand(found - shape) == 0


def test_thick_beam_has_seven_mode_vectors():
    element = ELEMENTS["thick_axis_consistent"][1]()
    tape = Tape()
    modes = ModeVectors(tape, element, [tape.coordinate(i) for i in range(24)])
    for field in element.fields:
        modes.of(field)
    assert len(modes.rows) == 7


def test_products_of_legendre_polynomials():
    for m in range(3):
        for n in range(3):
            total = sum(product_modes(m, n, k) * sp.legendre(k, xi) for k in range(m + n + 1))
            assert sp.expand(total - sp.legendre(m, xi) * sp.legendre(n, xi)) == 0


@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_gauss_rules_are_exact_to_their_degree(n):
    rule = gauss_rule(n)
    for power in range(2 * n):
        expected = Fraction(1, power + 1) if power % 2 == 0 else 0
        assert abs(sum(share * point**power for point, share in rule) - expected) < 1e-38
    assert [p for p, _ in rule] == [-p for p, _ in reversed(rule)]


def test_legendre_values():
    assert legendre_value(2, Fraction(1, 2)) == Fraction(-1, 8)


def test_section_energy_around_the_stress_free_section():
    """lam (ex+ey+ez)^2 + 2G (ex^2+ey^2+ez^2) = E ex^2 + lam (a+b)^2 + 2G (a^2+b^2)."""
    ex, ey, ez, shear, nu = sp.symbols("ex ey ez G nu")
    lam, youngs = 2 * shear * nu / (1 - 2 * nu), 2 * shear * (1 + nu)
    a, b = ey + nu * ex, ez + nu * ex
    published = lam * (ex + ey + ez) ** 2 + 2 * shear * (ex**2 + ey**2 + ez**2)
    rearranged = youngs * ex**2 + lam * (a + b) ** 2 + 2 * shear * (a**2 + b**2)
    assert sp.simplify(published - rearranged) == 0


def test_reissner_shear_is_the_square_of_the_first_two_modes():
    """1/(2L) W^T [[4,-2],[-2,4]] W, W_i = int N_i gamma dx, equals 1/2 int (P1 gamma)^2 dx."""
    coefficients = sp.symbols("c:4")
    gamma = sum(c * x**k for k, c in enumerate(coefficients))
    s = x / length
    w = sp.Matrix([sp.integrate(sp.expand(n * gamma), (x, 0, length)) for n in (1 - s, s)])
    reissner = (w.T * sp.Matrix([[4, -2], [-2, 4]]) * w)[0] / (2 * length)
    modes = [
        (2 * k + 1) / length
        * sp.integrate(sp.expand(gamma * sp.legendre(k, 2 * s - 1)), (x, 0, length))
        for k in (0, 1)
    ]  # fmt: skip
    projected = sum(length / (2 * k + 1) * mode**2 for k, mode in enumerate(modes)) / 2
    assert sp.expand(reissner - projected) == 0
