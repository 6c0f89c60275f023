"""The mass matrix against elements' published entries."""

import numpy as np
import pytest

from tests.kernels.bench import VALUES
from tests.kernels.reference_energies import ENERGIES, cubic, gauss

WITH_MASS = [name for name in ENERGIES if not name.endswith("gauss")]


def test_chrono_unit_test(bench):
    """Chrono's numbers for rho 7850, 0.1 x 0.1, L = 1."""
    element = bench("thick_axis_consistent")
    given = {"length": 1.0, "mass_per_length": 78.5, "inertia_y": 7850 * 0.1**4 / 12}
    base = np.array([[given.get(p, 0.0) for p in element.kind.parameters]])
    mass = element.matrix("mass", np.zeros(24), base=base)[0]
    at = {"r": 0, "r_x": 3, "r_y": 6}
    expected = {
        ("r", "r"): 29.1571428571,
        ("r", "r_x"): 4.1119047619,
        ("r", "r 1"): 10.0928571429,
        ("r", "r_x 1"): -2.4297619048,
        ("r_x", "r_x"): 0.7476190476,
        ("r_x", "r_x 1"): -0.5607142857,
        ("r_y", "r_y"): 0.0218055556,
        ("r_y", "r_y 1"): 0.0109027778,
    }
    for (row, column), value in expected.items():
        name, _, end = column.partition(" ")
        for axis in range(3):
            found = mass[at[row] + axis, at[name] + axis + (12 if end else 0)]
            assert found == pytest.approx(value, abs=1e-10)


@pytest.mark.parametrize("name", WITH_MASS)
def test_mass_is_the_integral_of_the_shape_functions(name, bench):
    element = bench(name)
    length = VALUES["length"]
    xi, w = gauss(8)
    line, _, _ = cubic(xi, length)
    shapes = {"r_": (0, line[0], line[2]), "r_x": (0, line[1], line[3])}
    if name.startswith("string"):
        shapes["r_"] = (0, 1 - xi, xi)
    shapes |= {v: (v, 1 - xi, xi) for v in ("r_y", "r_z")}
    weights = {0: "mass_per_length", "r_y": "inertia_y", "r_z": "inertia_z"}
    rows = [
        (shapes[label[:-1]][0], label[-1], shapes[label[:-1]][1 + end])
        for end in (0, 1)
        for label in element.labels
    ]
    expected = np.zeros((element.n, element.n))
    for i, (kind, axis, s) in enumerate(rows):
        for j, (other, direction, t) in enumerate(rows):
            if (kind, axis) == (other, direction):
                expected[i, j] = VALUES[weights[kind]] * length * (w @ (s * t))
    found = element.matrix("mass", np.zeros(element.n))[0]
    np.testing.assert_allclose(found, expected, rtol=1e-14, atol=1e-16)


def test_published_cable_mass(bench):
    length = VALUES["length"]
    block = np.array([
        [13 / 35, 11 * length / 210, 9 / 70, -13 * length / 420],
        [11 * length / 210, length**2 / 105, 13 * length / 420, -(length**2) / 140],
        [9 / 70, 13 * length / 420, 13 / 35, -11 * length / 210],
        [-13 * length / 420, -(length**2) / 140, -11 * length / 210, length**2 / 105],
    ])  # fmt: skip
    for name, dim in (("l2t2", 2), ("thin_spatial_green", 3)):
        element = bench(name)
        found = element.matrix("mass", np.zeros(element.n))[0]
        expected = VALUES["mass_per_length"] * length * np.kron(block, np.eye(dim))
        np.testing.assert_allclose(found, expected, rtol=1e-14, atol=1e-16)
