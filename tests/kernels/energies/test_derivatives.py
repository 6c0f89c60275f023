"""Energy, force and tangent against energies written independently; rigid motions; symmetry."""

import numpy as np
import pytest

from tests.kernels.bench import VALUES
from tests.kernels.reference_energies import ENERGIES, gradient, hessian_times
from tests.kernels.states import STATES, rotate, rotation, straight

TOLERANCE = 1e-10


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("name", ENERGIES)
def test_kernels_are_the_energy_and_its_derivatives(name, state, bench, rng):
    element = bench(name)
    q = STATES[state](element.labels, VALUES["length"], rng)
    energy = ENERGIES[name]

    def close(found, wanted, scale=1.0):
        assert np.abs(found - wanted).max() <= TOLERANCE * max(np.abs(wanted).max(), scale)

    stiffness = VALUES["axial_stiffness"] * VALUES["length"]
    expected = energy(q.astype(np.longdouble), VALUES)
    close(element.run("energy", q)[0], expected, scale=1e-6 * stiffness)
    close(element.run("force", q)[0], gradient(energy, q, VALUES), scale=1e-6 * stiffness)
    if "tangent" in element.kind.kernels:
        tangent = element.matrix("tangent", q)[0]
        for v in rng.normal(size=(2, element.n)):
            close(tangent @ v, hessian_times(energy, q, VALUES, v))


@pytest.mark.parametrize("name", [n for n in ENERGIES if not n.endswith("slack")])
def test_rigid_motion_stores_no_energy(name, bench, rng):
    element = bench(name)
    labels = element.labels
    q = rotate(straight(labels, VALUES["length"]), labels, rotation(labels, rng))
    for i, label in enumerate(labels * 2):
        if label in ("r_1", "r_2"):
            q[i] += 0.7
    scale = VALUES["axial_stiffness"] * VALUES["length"]
    assert abs(element.run("energy", q)[0, 0]) <= 1e-28 * scale
    assert np.abs(element.run("force", q)).max() <= 1e-14 * scale


@pytest.mark.parametrize("kernel", ["tangent", "material"])
@pytest.mark.parametrize("name", [n for n in ENERGIES if not n.endswith("gauss")])
def test_matrices_turn_with_the_element(name, kernel, bench, rng):
    element = bench(name)
    labels = element.labels
    turn = rotation(labels, rng)
    q = STATES["random"](labels, VALUES["length"], rng)
    big = np.column_stack([rotate(e, labels, turn) for e in np.eye(element.n)])
    # Without this a seed that turns with the body would be of no use.
    matrix = element.matrix(kernel, q)[0]
    turned = element.matrix(kernel, big @ q)[0]
    assert np.abs(turned - big @ matrix @ big.T).max() <= 1e-12 * np.abs(matrix).max()
    force = element.run("force", q)[0]
    turned = element.run("force", big @ q)[0]
    assert np.abs(turned - big @ force).max() <= 1e-12 * np.abs(matrix).max()


@pytest.mark.parametrize("name", [n for n in ENERGIES if not n.endswith("gauss")])
def test_residual_is_force_plus_mass_times_acceleration(name, bench, rng):
    element = bench(name)
    q, a = rng.normal(size=(2, 5, element.n))
    mass = element.matrix("mass", q)
    inertia = np.einsum("eij,ej->ei", mass, a)
    found = element.run("inertia", q, a)
    assert np.abs(found - inertia).max() <= 1e-14 * np.abs(inertia).max()
    expected = element.run("force", q) + inertia
    found = element.run("residual", q, a)
    assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max()
