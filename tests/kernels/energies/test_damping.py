"""Material part of the tangent and force of viscous damping, against strains written twice."""

import numpy as np
import pytest

from tests.kernels.bench import VALUES
from tests.kernels.reference_energies import ENERGIES, LONG, centre_line, dot, gauss, square
from tests.kernels.reference_strains import STRAINS, jacobian
from tests.kernels.states import STATES, rotate, rotation, split

PLANAR = [name for name in STRAINS if name == "l2t2" or "planar" in name]
THICK = [name for name in STRAINS if name.startswith("thick")]


def spun(q, labels, spin):
    """Velocities of a rigid rotation about the origin, with an angular velocity (3,)."""
    x, y, z = spin
    return rotate(q, labels, np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]))


def test_every_element_that_moves_has_strains():
    assert set(STRAINS) == {name for name in ENERGIES if not name.endswith("gauss")}


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("name", STRAINS)
def test_material_is_the_weighted_square_of_the_strain_gradients(name, state, bench, rng):
    element, strains = bench(name), STRAINS[name]
    q = STATES[state](element.labels, VALUES["length"], rng)
    weights, values = strains(q.astype(LONG), VALUES, q)
    energy = ENERGIES[name](q.astype(LONG), VALUES)
    assert abs(weights @ values**2 / 2 - energy) <= 1e-14 * energy
    slopes = jacobian(strains, q, VALUES)
    expected = slopes.T @ (weights[:, None] * slopes)
    found = element.matrix("material", q)[0]
    assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()
    assert np.linalg.eigvalsh(found).min() >= -1e-13 * np.abs(found).max()


@pytest.mark.parametrize("name", [n for n in STRAINS if not n.startswith("thin_spatial")])
def test_tangent_is_material_and_geometric_part(name, bench, rng):
    """K v = M v + derivative along v of J^T w s with w s held."""
    element, strains = bench(name), STRAINS[name]
    q = STATES["random"](element.labels, VALUES["length"], rng)
    weights, values = strains(q.astype(LONG), VALUES, q)
    v, step = rng.normal(size=element.n), LONG(1e-3)
    geometric = np.zeros(element.n, dtype=LONG)
    for k, share in ((1, LONG(3) / 4), (2, -LONG(3) / 20), (3, LONG(1) / 60)):
        for sign in (1, -1):
            moved = q + sign * k * step * v
            slopes = jacobian(strains, moved, VALUES, base=q)
            geometric += sign * share * (weights * values) @ slopes / step
    expected = element.matrix("tangent", q)[0] @ v
    found = element.matrix("material", q)[0] @ v + geometric
    assert np.abs(geometric).max() > 1e-3 * np.abs(expected).max()
    assert np.abs(found - expected).max() <= 1e-10 * np.abs(expected).max()


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("name", STRAINS)
def test_damping_is_material_times_velocity(name, state, bench, rng):
    element = bench(name)
    q = np.array([STATES[state](element.labels, VALUES["length"], rng) for _ in range(9)])
    v = rng.normal(size=q.shape)
    expected = np.einsum("eij,ej->ei", element.matrix("material", q), v)
    found = element.run("damping", q, v)
    assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("name", [*PLANAR, *(n for n in THICK if n not in PLANAR)])
def test_rigid_motion_is_not_damped(name, state, bench, rng):
    """However strained the element is."""
    element = bench(name)
    q = STATES[state](element.labels, VALUES["length"], rng)
    spin = np.array([0, 0, 1.7]) if name in PLANAR else rng.normal(size=3)
    v = spun(q, element.labels, spin)
    for i, label in enumerate(element.labels * 2):
        v[i] += split(label)[0] == "r_"
    speed = np.abs(v).max()
    assert speed > 0.5
    stiff = np.abs(element.matrix("material", q)[0]).max()
    assert np.abs(element.run("damping", q, v)).max() <= 1e-13 * stiff * speed


@pytest.mark.parametrize("strain", ["green", "biot"])
def test_spatial_cable_feels_only_the_spin_about_its_own_tangent(strain, bench, rng):
    """A cable knows no spin of its sections: v.Q_d = int EI |kappa|^2 (spin.t)^2 dx."""
    element = bench(f"thin_spatial_{strain}")
    length = VALUES["length"]
    q = STATES["random"](element.labels, length, rng)
    spin = rng.normal(size=3)
    v = spun(q, element.labels, spin)
    xi, w = gauss(3)
    r_x, r_xx = centre_line(q.reshape(4, 3).astype(LONG), xi, LONG(length))
    kappa = square(np.cross(r_x, r_xx)) / square(r_x) ** (3 if strain == "green" else 2)
    about = dot(r_x, spin) ** 2 / square(r_x)
    expected = length * VALUES["bending_stiffness"] * (w @ (kappa * about))
    assert v @ element.run("damping", q, v)[0] == pytest.approx(float(expected), rel=1e-11)

    # Bent in a plane and turned in it, nothing is felt: the form is objective there.
    flat = q.reshape(4, 3).copy()
    flat[:, 2] = 0.0
    turn = rotation(element.labels, rng)
    q = rotate(flat.ravel(), element.labels, turn)
    v = spun(q, element.labels, 1.7 * turn[:, 2])
    stiff = np.abs(element.matrix("material", q)[0]).max()
    assert np.abs(element.run("damping", q, v)).max() <= 1e-13 * stiff * np.abs(v).max()
