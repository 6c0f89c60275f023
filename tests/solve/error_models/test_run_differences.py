"""What the differences of two runs show."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.solve.error_models.run_differences import difference_growth
from ancfsparse.solve.stepping.sampled_states import SampledStates
from ancfsparse.system import System


@pytest.fixture
def system():
    scene = ancf.Scene((0.0, 0.0, 0.0))
    section, material = ancf.Rectangle(1e-3, 1e-3), ancf.Material(1e6, 1000.0, 0.3)
    scene.add_beam("thin", (0, 0, 0), (1, 0, 0), 2, section, material)
    return System(scene)


def runs(system, t, differences):
    """Two runs whose positions are apart by differences at times."""
    one = SampledStates.empty(t, system.n_all, 0)
    one.q[:] = system.q0
    other = SampledStates.empty(t, system.n_all, 0)
    other.q[:] = system.q0
    other.q[:, system.positions[1]] += differences
    return one, other


@pytest.mark.parametrize("power", [1, 2, 4])
def test_growth_of_a_power_of_time(system, power):
    t = np.linspace(3.0, 5.0, 9)
    growth = difference_growth(system, *runs(system, t, 1e-3 * (t - 3.0) ** power), 0.0)
    assert growth == pytest.approx(2.0**power)


def test_small_differences_of_the_first_half_do_not_count(system):
    t = np.linspace(0.0, 1.0, 5)
    growth = difference_growth(system, *runs(system, t, 1e-3 * (t > 0.5)), 1e-5)
    assert growth == pytest.approx(100.0)


def test_without_a_state_in_the_first_half_there_is_no_growth(system):
    t = np.array([0.0, 0.6, 1.0])
    assert difference_growth(system, *runs(system, t, 1e-3 * t), 0.0) == 1.0


def test_slopes_grow_apart_from_positions():
    section, material = ancf.Rectangle(1e-3, 1e-3), ancf.Material(1e6, 1000.0, 0.3)
    scene = ancf.Scene((0.0, 0.0, 0.0))
    scene.add_beam("thick", (0, 0, 0), (1, 0, 0), 2, section, material)
    system, t = System(scene), np.linspace(0.0, 1.0, 5)
    one, other = runs(system, t, 1e-3 * t)
    other.q[:, system.places[0][1, -1]] += 1e-2 * t**6
    assert difference_growth(system, one, other, 0.0) == pytest.approx(64.0)
    # Masses of a slope, interpolated linearly, and of a cubic position at the middle node.
    radius = 1e-3 / math.sqrt(12.0) * math.sqrt((2 / 3) / (26 / 35))
    assert difference_growth(system, one, other, 1e-6) == pytest.approx(1e-2 * radius / 1e-7)
