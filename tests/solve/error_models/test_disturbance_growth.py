"""Growth of small disturbances, against that of an inverted pendulum."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.solve.error_models.disturbance_growth import growth_exponent
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.stepping.sampled_states import SampledStates
from ancfsparse.system import System

GRAVITY, LENGTH, T_END = 9.81, 0.8, 2.0
MODULUS, DENSITY = 1e9, 1000.0
SECTION, MATERIAL = ancf.Rectangle(0.02, 0.02), ancf.Material(MODULUS, DENSITY)


def at_rest(direction, as_constraint=False, n=2):
    """Return a stiff rod that stands on a joint, or hangs from it, with loads and states."""
    scene = ancf.Scene((0.0, -GRAVITY))
    beam = scene.add_beam("thin", (0, 0), (0, direction * LENGTH), n, SECTION, MATERIAL)
    scene.pin(beam.start, as_constraint=as_constraint)
    system = System(scene)
    t = np.linspace(0.0, T_END, 5)
    states = SampledStates.empty(t, system.n_all, system.n_multipliers)
    for table in states.tables:
        table[:] = 0.0
    states.q[:] = system.q0
    # Strain by the weight beyond a point, and its integral.
    along = np.linspace(0.0, LENGTH, n + 1)
    strain = -direction * DENSITY * GRAVITY / MODULUS * (LENGTH - along)
    stretch = -direction * DENSITY * GRAVITY / MODULUS * (LENGTH - 0.5 * along) * along
    places = system.places[0]
    states.q[:, places[:, 1]] = direction * (along + stretch)
    states.q[:, places[:, 3]] = direction * (1.0 + strain)
    return system, LoadDiscontinuities(system, 0.0, T_END), states


@pytest.mark.parametrize("as_constraint", [False, True])
def test_a_standing_rod_falls_as_an_inverted_pendulum(as_constraint):
    # Its equation is m L^2 / 3 phi'' = m g L / 2 phi.
    expected = math.sqrt(1.5 * GRAVITY / LENGTH) * T_END
    assert growth_exponent(*at_rest(1.0, as_constraint)) == pytest.approx(expected, rel=1e-3)


def test_disturbances_of_a_hanging_rod_do_not_grow():
    # Rounding of the stiffness can change a frequency of zero.
    assert growth_exponent(*at_rest(-1.0)) < 0.1


def test_growth_is_the_integral_of_the_rate_over_time():
    system, loads, states = at_rest(1.0)
    standing = growth_exponent(system, loads, states)
    states.q[2:] = at_rest(-1.0)[2].q[2:]
    assert growth_exponent(system, loads, states) == pytest.approx(
        0.4 * standing, rel=1e-3, abs=0.1
    )


def test_the_growth_of_scenes_with_many_coordinates_is_not_determined():
    assert growth_exponent(*at_rest(1.0, n=100)) == 0.0
