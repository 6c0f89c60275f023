"""Loads that begin smoothly: what they make of each mode, against exact solutions, and of runs."""

import numpy as np
from scipy.integrate import solve_ivp

import ancfsparse as ancf
from ancfsparse.solve.followed_loads import parts
from tests.solve.accuracy_scenes import SAVED, make


def test_modes_follow_loads_that_begin_smoothly():
    t = np.linspace(0.0, 2.0, 1025)
    omega = np.array([0.0, 1.5, 12.0])
    load = np.outer([1.0, 2.0, 30.0], np.sin(3.0 * t) ** 2)

    def rate(now, y):
        push = np.array([1.0, 2.0, 30.0]) * np.sin(3.0 * now) ** 2
        return np.concatenate([y[3:], push - omega**2 * y[:3]])

    exact = solve_ivp(rate, (0.0, 2.0), np.zeros(6), "DOP853", t, rtol=1e-11, atol=1e-12).y[:3]
    led, led_omega, free, _ = parts(t, load, omega)
    np.testing.assert_allclose(led, np.abs(exact).max(axis=1), rtol=2e-4)
    # Their frequencies as a whole are those of the loads or of the vibrations, by their sizes.
    most = np.abs(load - omega[:, None] ** 2 * exact).max(axis=1)
    np.testing.assert_allclose(led_omega, np.sqrt(most / led), rtol=1e-3)
    assert (free[:2] == 0.0).all()


def test_a_load_that_has_come_leaves_the_vibration_of_its_rise():
    # A half cosine of duration T: of a mode w it leaves (pi / T)^2 / |w^2 - (pi / T)^2| times
    # |1 + e^(i w T)| / 2 of what it bends the mode by in the end.
    rise, t = 0.4, np.linspace(0.0, 2.0, 4097)
    omega = np.array([6.0, 20.0, 43.0])
    load = np.outer(omega**2, 0.5 - 0.5 * np.cos(np.pi * np.minimum(t / rise, 1.0)))
    turn = (np.pi / rise) ** 2
    left = turn / np.abs(omega**2 - turn) * np.abs(1.0 + np.exp(1j * omega * rise)) / 2.0
    np.testing.assert_allclose(parts(t, load, omega)[2], left, rtol=1e-2)


def test_runs_under_loads_that_begin_smoothly_are_planned():
    # Without a prediction four runs were made here, and six times the forces of the cheapest one.
    case = make(41)
    run = ancf.simulate(case.scene, case.t_end, case.t_end / SAVED, accuracy=1e-4)
    assert run.stats.runs == 2
