"""Columns with a rigid body on top buckle at the loads of beam theory."""

import numpy as np
import pytest
from scipy.optimize import brentq

import ancfsparse as ancf
from tests.beams import build_beam

G, LENGTH, ABOVE, SIDE, MODULUS = 9.81, 1.0, 0.2, 0.01, 2e9
EI = MODULUS * SIDE**4 / 12.0


def exact(k):
    """Return load k of a clamped column under a dead weight `ABOVE` its top, on a rigid arm.

    cos(x L) = a x sin(x L) with x^2 = P / EI, from y'' = (P / EI) (y_weight - y).
    """
    low, high = k * np.pi / LENGTH, (k + 0.5) * np.pi / LENGTH
    x = brentq(lambda x: np.cos(x * LENGTH) - ABOVE * x * np.sin(x * LENGTH), low, high)
    return EI * x**2


def column(n, mass, element="thin", dim=2, density=1e-3):
    up = np.eye(dim)[-1]
    options = {"curvature": "section"} if element == "thick" else {}
    scene, rod = build_beam(
        element, 0.0 * up, LENGTH * up, n, ancf.Rectangle(SIDE, SIDE),
        ancf.Material(MODULUS, density, 0.0), "clamp", gravity=-G * up, **options,
    )  # fmt: skip
    box = scene.add_body(
        ancf.Box(length=0.1, width=0.1, height=0.1), mass=mass, position=(LENGTH + ABOVE) * up
    )
    scene.weld(rod.end, box.at(-ABOVE * up))
    return scene, box


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("element", "order"), [("thin", 4.0), ("thick", 2.0)])
def test_a_column_with_a_body_on_top_to_the_order_of_the_mesh(element, order):
    off = []
    for n in (4, 8):
        found = ancf.buckling(column(n, 0.2, element)[0], 2).factors * 0.2 * G
        off.append(found / [exact(0), exact(1)] - 1.0)
    assert np.all(np.abs(off[1]) < (2e-4 if element == "thin" else 0.02))
    np.testing.assert_allclose(np.log2(np.divide(*off)), order, atol=0.3)


@pytest.mark.parametrize(("n", "density"), [(8, 1e-3), (8, 1500.0), (40, 1e-3), (40, 1500.0)])
def test_about_an_equilibrium_the_load_is_that_of_the_stress_free_shape(n, density):
    """Which the column leaves by its shortening, P / EA = 1e-5."""
    scene, _ = column(n, 0.2, density=density)
    rest = ancf.solve_static(scene)
    assert rest.stable
    np.testing.assert_allclose(
        ancf.buckling(rest, 2).factors, ancf.buckling(scene, 2).factors, rtol=1e-4
    )


def test_a_column_in_space_buckles_alike_in_both_directions():
    scene, _ = column(16, 0.2, "thick", 3)
    found = ancf.buckling(scene, 2).factors * 0.2 * G
    np.testing.assert_allclose(found, exact(0), rtol=5e-4)


@pytest.mark.filterwarnings("error")
def test_a_body_that_is_too_heavy_has_a_load_below_its_weight():
    scene, box = column(16, 2.0)
    found = ancf.buckling(scene)
    assert found.factors[0] == pytest.approx(exact(0) / (2.0 * G), rel=1e-6)
    # The shape is that of the theory: the body leaves sideways, and turns along.
    aside = found.displacement(box.origin)[0]
    assert abs(aside[0]) > 1e3 * abs(aside[1])


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_loads_do_not_depend_on_units(size):
    """All lengths times a factor, forces as they are: one multiple of the weight."""
    scene, rod = build_beam(
        "thin", (0, 0), (0, LENGTH * size), 8, ancf.Rectangle(SIDE * size, SIDE * size),
        ancf.Material(MODULUS / size**2, 1e-3 / size**3, 0.0), "clamp", gravity=(0.0, -G),
    )  # fmt: skip
    box = scene.add_body(
        ancf.Box(length=0.1 * size, width=0.1 * size, height=0.1 * size), mass=0.2,
        position=(0, (LENGTH + ABOVE) * size),
    )  # fmt: skip
    scene.weld(rod.end, box.at((0, -ABOVE * size)))
    alike = ancf.buckling(column(8, 0.2)[0], 2).factors
    np.testing.assert_allclose(ancf.buckling(scene, 2).factors, alike, rtol=1e-6)
