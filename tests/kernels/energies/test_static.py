"""Small structures solved with the kernels alone, against numbers computed by other programs.

The numbers of the thick beam are those of an independent implementation of the same element; the
large-deflection cantilever has been computed with Exudyn (biot strain) and independently (others).
"""

import numpy as np
import pytest

from tests.kernels.reference_energies import ENERGIES
from tests.kernels.states import straight


def square_section(length, width, youngs=2.1e11, nu=0.3):
    """Parameters of a square section, elements.md section 4."""
    shear, area, inertia = youngs / (2 * (1 + nu)), width**2, width**4 / 12
    shear_factor = 10 * (1 + nu) / (12 + 11 * nu)
    bending = youngs * inertia
    return {
        "length": length,
        "axial_stiffness": youngs * area,
        "bending_stiffness": bending,
        "lame_area": 2 * shear * nu / (1 - 2 * nu) * area,
        "shear_modulus_area": shear * area,
        "youngs_modulus_area": youngs * area,
        "poisson_ratio": nu,
        "shear_stiffness_y": shear_factor * shear * area,
        "shear_stiffness_z": shear_factor * shear * area,
        "torsion_stiffness": 0.8436 * shear * 2 * inertia,
        "bending_stiffness_y": bending,
        "bending_stiffness_z": bending,
        "mass_per_length": 0.0,
        "inertia_y": 0.0,
        "inertia_z": 0.0,
    }


class Cantilever:
    """A straight chain of equal elements held at its first node."""

    def __init__(self, element, n, values, held):
        self.element, self.n = element, n
        self.base = np.tile([values[p] for p in element.kind.parameters], (n, 1))
        h = len(element.labels)
        self.places = np.arange(n)[:, None] * h + np.arange(2 * h)
        nodes = [
            straight(element.labels, 1.0, i * values["length"])[:h].copy() for i in range(n + 1)
        ]
        self.q = np.concatenate(nodes)
        self.free = np.setdiff1d(np.arange(len(self.q)), held)
        self.tip = len(self.q) - h

    def force(self):
        out = np.zeros_like(self.q)
        np.add.at(out, self.places, self.element.run("force", self.q[self.places], base=self.base))
        return out[self.free]

    def tangent(self):
        out = np.zeros((len(self.q), len(self.q)))
        matrices = self.element.matrix("tangent", self.q[self.places], base=self.base)
        np.add.at(out, (self.places[:, :, None], self.places[:, None, :]), matrices)
        return out[np.ix_(self.free, self.free)]

    def load(self, direction, size):
        out = np.zeros_like(self.q)
        out[self.tip + direction] = size
        return out[self.free]


@pytest.mark.parametrize("plane", ["", "planar_"])
@pytest.mark.parametrize(
    ("curvature", "slenderness", "expected"),
    [
        ("axis", 10, {1: 0.77726301, 2: 0.97592754, 4: 0.99867957, 8: 0.99994144}),
        ("section", 2, {4: 1.17562, 16: 1.19027, 64: 1.19119}),
    ],
)
def test_small_deflection_of_the_thick_beam(plane, curvature, slenderness, expected, bench):
    element = bench(f"thick_{plane}{curvature}_consistent")
    for n, ratio in expected.items():
        values = square_section(slenderness * 0.1 / n, 0.1)
        section = ("r_", *element.kind.section)  # with curvature "section" r_x is free to shear
        held = [k for k, label in enumerate(element.labels) if label[:-1] in section]
        beam = Cantilever(element, n, values, held)
        load = beam.load(1, 1.0)
        deflection = load @ np.linalg.solve(beam.tangent(), load)
        euler = (slenderness * 0.1) ** 3 / (3 * values["bending_stiffness_z"])
        digits = len(str(ratio)) - 2
        assert deflection / euler == pytest.approx(ratio, abs=0.6 * 10.0**-digits)


@pytest.mark.parametrize(
    ("name", "tip"),
    [
        ("thin_planar_biot", {1: (0.3622447299, 0.9941447587), 4: (0.5074287151, 1.2055337022)}),
        ("thin_planar_green", {1: (0.3622203273, 0.9946509508), 4: (0.5078240958, 1.2066939246)}),
        ("l2t2", {1: (0.3626937620, 0.9936062716), 4: (0.5079243761, 1.2052200783)}),
    ],
)
def test_large_deflection_of_a_cantilever(name, tip, bench):
    """L = 2, E = 2.07e11, b = h = 0.1, tip force 3 EI / L^2; r and r'_y held (elements.md 7.1)."""
    element = bench(name)
    for n, expected in tip.items():
        values = square_section(2.0 / n, 0.1, youngs=2.07e11)
        beam = Cantilever(element, n, values, [0, 1, 3])
        full = 3 * values["bending_stiffness"] / 4
        for share in np.linspace(0.1, 1.0, 10):
            load = beam.load(1, -share * full)
            for _ in range(12):
                beam.q[beam.free] += np.linalg.solve(beam.tangent(), load - beam.force())
        x, y = beam.q[beam.tip : beam.tip + 2]
        assert (2.0 - x, -y) == pytest.approx(expected, abs=2e-10)


@pytest.mark.parametrize("n", [1, 2, 8])
@pytest.mark.parametrize(
    "name", [each for each in ENERGIES if not each.endswith(("gauss", "slack"))]
)
def test_only_rigid_motions_of_a_straight_beam_cost_nothing(name, n, bench):
    """3 in the plane, 6 in space; a cable that turns about itself does not move.

    Of a string every node moves freely across, beside one translation along it.
    """
    element = bench(name)
    beam = Cantilever(element, n, square_section(2.0 / n, 0.1), [])
    matrix = beam.tangent()
    # In units in which slopes and positions weigh alike.
    unit = np.array([2.0 / n if label[:-1] == "r_" else 1.0 for label in element.labels] * (n + 1))
    sizes = np.linalg.eigvalsh(unit[:, None] * matrix * unit)
    rigid = {2: 3, 3: 6 if "thick" in name else 5}[element.kind.dim]
    if element.kind.is_string:
        rigid = (n + 1) * (element.kind.dim - 1) + 1
    assert np.abs(sizes[:rigid]).max() <= 1e-13 * sizes[-1]
    assert sizes[rigid] > 1e-9 * sizes[-1]
