"""Euler's column, of every element and option."""

import numpy as np
import pytest
from scipy.sparse.linalg import eigsh

import ancfsparse as ancf
from tests.matrices import stiffness

YOUNGS, NU, WIDTH, LENGTH = 2.07e11, 0.3, 0.1, 2.0
CURVATURES = {
    f"{curvature}, {strain}": ("thick", {"curvature": curvature, "section_strain": strain})
    for curvature in ("axis", "section")
    for strain in ("consistent", "nodal")
}
ELEMENTS = {"l2t2": ("l2t2", {}), "green": ("thin", {}), "biot": ("thin", {"strain": "biot"})}
ELEMENTS |= CURVATURES


def expected(name, p):
    """Critical load over Euler's, with the shortening lambda before it buckles.

    A slope w' off the line of the force P saves P w'^2 / (2 lambda), and bending costs
    E I w''^2 / 2 times lambda^-4 (green), lambda^-2 (biot), 1 (l2t2) and lambda^(-2 nu) (thick,
    whose sections widen), so that P is Euler's load times lambda for each; with shear the two act
    in series.
    """
    euler = np.pi**2 * p["bending_stiffness"] / (4 * LENGTH**2)
    power = {"l2t2": 0.0, "green": -4.0, "biot": -2.0}.get(name, -2 * NU)
    soft = 1 / (1 + euler / p["shear_stiffness_y"]) if name.startswith("section") else 1.0
    ratio = 1.0
    for _ in range(20):
        strain = -ratio * euler / p["axial_stiffness"]
        stretch = 1 + strain if name == "biot" else 1 + strain - 1.5 * strain**2
        ratio = soft * stretch ** (1 + power)
    return ratio


def lowest(name, dim, share):
    """Eigenvalue of the tangent of the straight column next to zero, and the parameters."""
    element, options = ELEMENTS[name]
    z = (0.0,) * (dim - 1)
    scene = ancf.Scene((0.0, *z))
    section, material = ancf.Rectangle(WIDTH, WIDTH), ancf.Material(YOUNGS, 7850.0, NU)
    rod = scene.add_beam(element, (0.0, *z), (LENGTH, *z), 128, section, material, **options)
    scene.clamp(rod.start)
    p = rod.parameters()
    euler = np.pi**2 * p["bending_stiffness"] / (4 * LENGTH**2)
    scene.point_force(rod.end, (-share * euler, *z))
    equilibrium = ancf.solve_static(scene)
    matrix = stiffness(equilibrium.system, equilibrium.q, amplitudes=np.zeros(0))
    return eigsh(matrix, 1, sigma=0.0, return_eigenvectors=False)[0], p


@pytest.mark.parametrize(
    ("dim", "name"), [(d, name) for name in ELEMENTS for d in ((2,) if name == "l2t2" else (2, 3))]
)
def test_a_column_buckles_at_eulers_load(name, dim):
    """Fixed and free, 20 times as long as wide; with shear at 0.998 of the load of Euler."""
    (one, p), (two, _) = lowest(name, dim, 0.96), lowest(name, dim, 0.98)
    found = 0.96 + 0.02 * one / (one - two)
    assert found == pytest.approx(expected(name, p), abs=3e-5)
    assert found == pytest.approx(0.998 if name.startswith("section") else 1.0, abs=2e-3)
