"""Strings that go slack: derivatives by complex steps, and the limits of their law."""

import numpy as np
import pytest

from tests.kernels.bench import VALUES

STIFFNESS, LENGTH = VALUES["axial_stiffness"], VALUES["length"]
STEP = 1e-30


def law(strain, w):
    """Force over E A: the derivative of s^2 / 2 with s = (eps + sqrt(eps^2 + w^2)) / 2."""
    root = np.sqrt(strain**2 + w**2)
    return (strain + root) ** 2 / (4.0 * root)


def nodal_force(q, w):
    """Force of one element on its nodes, for complex coordinates too."""
    first, last = q.reshape(2, -1)
    slope = (last - first) / LENGTH
    stretch = np.sqrt(slope @ slope + w**2)
    pull = STIFFNESS * law(stretch - 1.0, w) * slope / stretch
    return np.concatenate([-pull, pull])


def base_of(element, w):
    return np.array([[(VALUES | {"transition": w})[p] for p in element.kind.parameters]])


def stretched(dim, strain, rng):
    """Ends of an element in a random direction."""
    direction = rng.normal(size=dim)
    direction /= np.linalg.norm(direction)
    first = rng.normal(size=dim)
    return np.concatenate([first, first + (1.0 + strain) * LENGTH * direction])


@pytest.mark.parametrize("w", [1e-3, 1e-6])
@pytest.mark.parametrize("strain", [0.1, 3e-3, 1e-6, 0.0, -1e-6, -3e-3, -0.1, -0.9])
@pytest.mark.parametrize(("dim", "where"), [(2, "planar"), (3, "spatial")])
def test_force_and_tangent_are_those_of_the_law(dim, where, strain, w, bench, rng):
    element = bench(f"string_{where}_slack")
    q, base = stretched(dim, strain, rng), base_of(element, w)
    # Strains have rounding errors of 1e-16, and the stiffness changes over a strain of w.
    rounding = 2e-15 * STIFFNESS / LENGTH
    found = element.run("force", q, base=base)[0]
    np.testing.assert_allclose(found, nodal_force(q, w), rtol=1e-12, atol=rounding)
    columns = []
    for k in range(2 * dim):
        moved = q.astype(complex)
        moved[k] += 1j * STEP
        columns.append(nodal_force(moved, w).imag / STEP)
    wanted = np.stack(columns, axis=1)
    tangent = element.matrix("tangent", q, base=base)[0]
    np.testing.assert_allclose(tangent, wanted, rtol=1e-12, atol=rounding / w)


@pytest.mark.parametrize("strain", [0.1, 3e-3, 0.0, -3e-3, -0.9])
@pytest.mark.parametrize(("dim", "where"), [(2, "planar"), (3, "spatial")])
def test_energy_is_that_of_the_law(dim, where, strain, bench, rng):
    element, w = bench(f"string_{where}_slack"), 1e-3
    q = stretched(dim, strain, rng)
    slope = (q[dim:] - q[:dim]) / LENGTH
    elongation = np.sqrt(slope @ slope + w**2) - 1.0
    s = (elongation + np.hypot(elongation, w)) / 2.0
    energy = element.run("energy", q, base=base_of(element, w))[0, 0]
    # s rounds by 1e-16 where both terms cancel.
    rounding = STIFFNESS * LENGTH * 1e-15 * s
    assert energy == pytest.approx(0.5 * STIFFNESS * LENGTH * s**2, rel=1e-12, abs=rounding)


@pytest.mark.parametrize("w", [1e-2, 1e-5])
def test_it_pulls_as_hooke_has_it_and_never_pushes(w, bench):
    element = bench("string_planar_slack")
    strains = np.array([-0.99, -50 * w, -10 * w, 0.0, 10 * w, 50 * w])
    q = np.zeros((len(strains), 4))
    q[:, 2] = (1.0 + strains) * LENGTH
    base = np.repeat(base_of(element, w), len(q), axis=0)
    pull = element.run("force", q, base=base)[:, 2] / STIFFNESS
    assert (pull >= 0.0).all()
    assert (np.diff(pull) > 0.0).all()
    # |r'| is sqrt(r'.r' + w^2), which adds w^2 / 2 to strains.
    assert pull[3] == pytest.approx(w / 4.0, rel=1.5 * w)
    np.testing.assert_allclose(pull[4:], strains[4:], rtol=1e-5 + w)
    np.testing.assert_allclose(pull[1:3], w**4 / 16.0 / -(strains[1:3] ** 3), rtol=0.02 + 10 * w)


def test_an_element_that_has_shrunk_to_a_point_has_no_force(bench):
    element = bench("string_spatial_slack")
    q, base = np.ones(6), base_of(element, 1e-6)
    np.testing.assert_array_equal(element.run("force", q, base=base), 0.0)
    tangent = element.matrix("tangent", q, base=base)[0]
    assert np.abs(tangent).max() <= 1e-9 * STIFFNESS / LENGTH
