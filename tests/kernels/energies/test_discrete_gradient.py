"""The force between two states: exact differences of energy, no resultant, no moment."""

import numpy as np
import pytest

from tests.kernels.bench import VALUES
from tests.kernels.reference_energies import ENERGIES
from tests.kernels.states import STATES, rotate, rotation

NAMES = [name for name in ENERGIES if not name.endswith("gauss")]
STIFFNESS = VALUES["axial_stiffness"] * VALUES["length"]


def two_states(element, state, reach, rng):
    q0 = STATES[state](element.labels, VALUES["length"], rng)
    other = STATES["random"](element.labels, VALUES["length"], rng)
    return q0, q0 + reach * (other - q0)


@pytest.mark.parametrize("reach", [1.0, 1e-2, 1e-6])
@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("name", NAMES)
def test_it_times_the_way_is_the_difference_of_the_energies(name, state, reach, bench, rng):
    element = bench(name)
    q0, q1 = two_states(element, state, reach, rng)
    energies = [ENERGIES[name](q.astype(np.longdouble), VALUES) for q in (q0, q1)]
    found = element.run("discrete_gradient", q0, q1)[0] @ (q1 - q0)
    noise = 1e-13 * max(float(max(energies)), 1e-6 * STIFFNESS)
    assert abs(found - float(energies[1] - energies[0])) <= noise


@pytest.mark.parametrize("name", NAMES)
def test_of_one_state_it_is_the_force(name, bench, rng):
    element = bench(name)
    q = STATES["uneven stretch"](element.labels, VALUES["length"], rng)
    force = element.run("force", q)
    assert np.abs(element.run("discrete_gradient", q, q) - force).max() <= (
        1e-13 * np.abs(force).max()
    )


@pytest.mark.parametrize("name", NAMES)
def test_between_close_states_it_is_the_force_in_the_middle_to_second_order(name, bench, rng):
    element = bench(name)
    q = STATES["uneven stretch"](element.labels, VALUES["length"], rng)
    way = 0.1 * rng.normal(size=element.n)
    force = element.run("force", q)
    off = []
    for reach in (1e-1, 1e-2, 1e-3):
        found = element.run("discrete_gradient", q - 0.5 * reach * way, q + 0.5 * reach * way)
        off.append(np.abs(found - force).max())
    assert np.abs(np.log10(np.array(off[:-1]) / off[1:]) - 2.0).max() < 0.1


@pytest.mark.parametrize("name", NAMES)
def test_there_and_back_it_is_the_same(name, bench, rng):
    element = bench(name)
    q0, q1 = two_states(element, "uneven stretch", 1.0, rng)
    there = element.run("discrete_gradient", q0, q1)
    assert np.abs(element.run("discrete_gradient", q1, q0) - there).max() <= (
        1e-13 * np.abs(there).max()
    )


@pytest.mark.parametrize("name", NAMES)
def test_it_pushes_and_turns_nothing_as_a_whole(name, bench, rng):
    """No resultant, and no moment about the origin with the arms in the middle."""
    element = bench(name)
    labels = element.labels
    q0, q1 = two_states(element, "uneven stretch", 1.0, rng)
    f = element.run("discrete_gradient", q0, q1)[0]
    middle, size = 0.5 * (q0 + q1), np.abs(f).max()
    for i, label in enumerate(labels):
        if label.startswith("r_") and label[2:].isdigit():
            assert abs(f[i] + f[i + len(labels)]) <= 1e-13 * size
    turns = [(0, 1)] if "r_3" not in labels else [(0, 1), (1, 2), (2, 0)]
    for a, b in turns:
        spin = np.zeros((3, 3))
        spin[a, b], spin[b, a] = -1.0, 1.0
        assert abs(f @ rotate(middle, labels, spin)) <= 1e-13 * size * np.abs(middle).max()


@pytest.mark.parametrize("name", NAMES)
def test_it_turns_with_the_element(name, bench, rng):
    element = bench(name)
    labels = element.labels
    turn = rotation(labels, rng)
    q0, q1 = two_states(element, "uneven stretch", 1.0, rng)
    expected = rotate(element.run("discrete_gradient", q0, q1)[0], labels, turn)
    found = element.run("discrete_gradient", rotate(q0, labels, turn), rotate(q1, labels, turn))[0]
    assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()
