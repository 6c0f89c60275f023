"""Elements that are free of strain in a curved shape, against strains written a second time."""

import numpy as np
import pytest

from ancfsparse.kernels.catalog import module_names
from tests.kernels.bench import VALUES
from tests.kernels.reference_energies import LONG
from tests.kernels.reference_strains import STRAINS, jacobian
from tests.kernels.states import STATES, rotate, rotation, straight

NAMES = [name for name in module_names() if name.endswith("_curved")]
STIFFNESS = VALUES["axial_stiffness"] * VALUES["length"]


def prepared(name, bench, rng):
    """Return the element, its strains, a shape without strain, and its base parameters."""
    element = bench(name)
    rest = STATES["uneven stretch"](element.labels, VALUES["length"], rng)
    values = VALUES | {f"reference_{k}": x for k, x in enumerate(rest)}
    base = np.array([[values[each] for each in element.kind.parameters]])
    strains = STRAINS[name.removesuffix("_curved")]

    def relative(q):
        weights, here = strains(np.asarray(q, dtype=LONG), VALUES, q)
        return weights, here - strains(rest.astype(LONG), VALUES, rest)[1]

    return element, relative, strains, rest, base


def test_there_is_one_for_planar_cables_and_for_thick_beams():
    assert len(NAMES) == 2 + 8


@pytest.mark.parametrize("name", NAMES)
def test_kernels_are_of_strains_less_those_of_the_reference(name, bench, rng):
    element, relative, strains, _, base = prepared(name, bench, rng)
    q = STATES["random"](element.labels, VALUES["length"], rng)
    weights, values = relative(q)
    assert element.run("energy", q, base=base)[0, 0] == pytest.approx(
        float(weights @ values**2 / 2), rel=1e-13
    )
    slopes = jacobian(strains, q, VALUES)
    force = (weights * values) @ slopes
    found = element.run("force", q, base=base)[0]
    assert np.abs(found - force).max() <= 1e-12 * np.abs(force).max()
    material = slopes.T @ (weights[:, None] * slopes)
    found = element.matrix("material", q, base=base)[0]
    assert np.abs(found - material).max() <= 1e-12 * np.abs(material).max()
    tangent = element.matrix("tangent", q, base=base)[0]
    for v in rng.normal(size=(2, element.n)):
        damping = element.run("damping", q, v, base=base)[0]
        assert np.abs(damping - material @ v).max() <= 1e-12 * np.abs(material @ v).max()
        expected = np.zeros(element.n, dtype=LONG)
        for k, share in ((1, LONG(3) / 4), (2, -LONG(3) / 20), (3, LONG(1) / 60)):
            for sign in (1, -1):
                moved = q + sign * k * LONG(1e-3) * v
                w, s = relative(moved)
                expected += sign * share * (w * s) @ jacobian(strains, moved, VALUES, base=q)
        expected /= LONG(1e-3)
        assert np.abs(tangent @ v - expected).max() <= 1e-10 * np.abs(expected).max()


@pytest.mark.parametrize("name", NAMES)
def test_the_difference_of_two_energies_is_the_discrete_gradient_times_the_way(name, bench, rng):
    element, relative, _, rest, base = prepared(name, bench, rng)
    q = STATES["random"](element.labels, VALUES["length"], rng)
    for q0, q1 in ((rest, q), (q, rest), (q, q + 1e-6 * (rest - q))):
        energies = [float(w @ s**2 / 2) for w, s in map(relative, (q0, q1))]
        found = element.run("discrete_gradient", q0, q1, base=base)[0] @ (q1 - q0)
        assert abs(found - (energies[1] - energies[0])) <= 1e-13 * max(energies)


@pytest.mark.parametrize("name", NAMES)
def test_the_reference_stores_nothing_however_it_is_turned(name, bench, rng):
    element, _, _, rest, base = prepared(name, bench, rng)
    turned = rotate(rest, element.labels, rotation(element.labels, rng))
    for q in (rest, turned):
        assert abs(element.run("energy", q, base=base)[0, 0]) <= 1e-28 * STIFFNESS
        assert np.abs(element.run("force", q, base=base)).max() <= 1e-13 * STIFFNESS
    tangent, material = (
        element.matrix(each, rest, base=base)[0] for each in ("tangent", "material")
    )
    assert np.abs(tangent - material).max() <= 1e-13 * np.abs(tangent).max()


@pytest.mark.parametrize("name", NAMES)
def test_straight_in_the_reference_it_is_the_straight_element(name, bench, rng):
    element, other = bench(name), bench(name.removesuffix("_curved"))
    rest = straight(element.labels, VALUES["length"])
    values = VALUES | {f"reference_{k}": x for k, x in enumerate(rest)}
    base = np.array([[values[each] for each in element.kind.parameters]])
    q = STATES["random"](element.labels, VALUES["length"], rng)
    for kernel in ("force", "tangent", "discrete_gradient"):
        a = q if kernel != "discrete_gradient" else rest
        found, expected = element.run(kernel, q, a, base=base), other.run(kernel, q, a)
        assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max()
