"""The pendulum as first-order equations."""

import numpy as np
import pytest

from ancfsparse.errors import InputError
from ancfsparse.problems import pendulum
from ancfsparse.system import System
from benchmarks.common.first_order import FirstOrder, OutOfTimeError, integrate


def test_right_hand_side_balances_the_equations_of_motion():
    system = System(pendulum("thin", 4).scene)
    equations, n = FirstOrder(system), system.n_free
    y = equations.y0 + 1e-3 * np.sin(np.arange(2 * n))
    rate = equations(0.0, y)
    q, a = system.q0.copy(), np.zeros(system.n_all)
    q[:n], a[:n] = y[:n], rate[n:]
    balance = system.assembly.inertia(a) + system.assembly.force(q) - system.dead_load
    np.testing.assert_array_equal(rate[:n], y[n:])
    np.testing.assert_allclose(balance[:n], 0.0, rtol=0, atol=1e-9)


def test_coordinates_keep_the_pin():
    system = System(pendulum("thin", 4).scene)
    run = integrate(FirstOrder(system), "RK23", np.linspace(0.0, 0.01, 3), 1e-3, 1e-6)
    assert run.q.shape == (3, system.n_all)
    np.testing.assert_array_equal(
        run.q[:, system.n_free :], system.q0[system.n_free :] * np.ones((3, 1))
    )


@pytest.mark.parametrize("method", ["RK23", "LSODA", "Radau"])
def test_cap_stops_every_integrator(method):
    equations = FirstOrder(System(pendulum("thin", 10).scene))
    with pytest.raises(OutOfTimeError, match=r"longer than 0\.01 s"):
        integrate(equations, method, np.linspace(0.0, 2.0, 3), 1e-3, 1e-6, cap=0.01)


def test_progress_is_reported():
    seen = []
    equations = FirstOrder(System(pendulum("thin", 10).scene))
    integrate(equations, "RK23", np.linspace(0.0, 0.05, 3), 1e-3, 1e-6, on_time=seen.append)
    assert seen
    assert seen == sorted(seen)


def test_multipliers_are_refused():
    with pytest.raises(InputError, match="without multipliers"):
        FirstOrder(System(pendulum("thin", 4, as_constraint=True).scene))


def test_jacobian_is_the_derivative_of_the_right_hand_side():
    equations = FirstOrder(System(pendulum("thin", 3).scene))
    y = equations.y0 + 1e-2 * np.sin(np.arange(len(equations.y0)))
    reach = 1e-6
    differences = np.stack(
        [
            (equations(0.0, y + reach * e) - equations(0.0, y - reach * e)) / (2.0 * reach)
            for e in np.eye(len(y))
        ],
        axis=1,
    )
    size = np.abs(differences).max()
    np.testing.assert_allclose(equations.jacobian(0.0, y), differences, rtol=0, atol=1e-7 * size)


def test_radau_with_the_jacobian_finds_the_same_motion_with_fewer_evaluations():
    t = np.linspace(0.0, 0.05, 3)
    without, given = (
        integrate(FirstOrder(System(pendulum("thin", 4).scene)), "Radau", t, 1e-5, 1e-7,
                  with_jacobian=each)
        for each in (False, True)
    )  # fmt: skip
    np.testing.assert_allclose(given.q, without.q, rtol=0, atol=1e-5)
    assert given.evaluations < without.evaluations
    assert given.counts["jacobians"] > 0
