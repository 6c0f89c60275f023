"""States of a run to an accuracy between its steps."""

import numpy as np
import pytest

from ancfsparse.solve.stepping.sampled_states import SampledStates


def between(power, resolved, t):
    """States at tenths of a second, from steps between them, of a motion t^power - t."""
    times = np.linspace(0.0, 1.0, 11)
    states = SampledStates.empty(times, 1, 1)
    rates = [lambda t, k=k: polynomial(power, k, t) for k in range(3)]
    states.begin(*(rate(0.0) for rate in rates), 0.0)
    states.fill(t, *(rate(t)[:, None] for rate in rates), t[:, None], resolved=resolved)
    assert states.rows == 11
    return states, rates


def polynomial(power, derivatives, t):
    p = np.polynomial.Polynomial([0.0, -1.0] + [0.0] * (power - 2) + [1.0])
    return (p.deriv(derivatives) if derivatives else p)(t)


def test_states_between_steps_are_those_of_a_cubic():
    states, rates = between(3, False, np.array([0.0, 0.33, 0.61, 1.02]))
    for table, rate in zip((states.q, states.v, states.a), rates, strict=True):
        np.testing.assert_allclose(table[:, 0], rate(states.t), atol=1e-13)
    np.testing.assert_allclose(states.lam[:, 0], states.t, atol=1e-14)


@pytest.mark.parametrize(("steps", "power"), [(1, 5), (2, 8), (3, 11), (7, 11)])
def test_where_all_is_resolved_states_between_steps_are_of_high_degree(steps, power):
    states, rates = between(power, True, np.linspace(0.0, 1.02, steps + 1))
    for table, rate in zip((states.q, states.v), rates, strict=False):
        np.testing.assert_allclose(table[:, 0], rate(states.t), atol=1e-11)


@pytest.mark.parametrize("at_once", [3, 64])
def test_accelerations_between_means_over_steps_are_of_second_order(at_once):
    """`EnergyMomentum` has the means; the first state is that at the start itself."""
    saved, errors = np.linspace(0.0, 1.0, 38), []
    for n in (64, 128):
        t = np.linspace(0.0, 1.0, n + 1)
        means = np.concatenate([[1.0], np.diff(np.sin(3.0 * t)) / (3.0 * np.diff(t))])[:, None]
        q, v, none = (
            -np.cos(3.0 * t)[:, None] / 9.0,
            np.sin(3.0 * t)[:, None] / 3.0,
            0.0 * t[:, None],
        )
        states = SampledStates.empty(saved, 1, 1)
        states.begin(q[0], v[0], means[0], means[0])
        for k in range(0, n, at_once):
            part = slice(k, min(k + at_once, n) + 1)
            rows = (table[part] for table in (q, v, means, means))
            states.fill(t[part], *rows, none[part, :0], has_means=True)
        expected = np.cos(3.0 * saved)
        errors.append([np.abs(each[:, 0] - expected).max() for each in (states.a, states.lam)])
    np.testing.assert_allclose(errors[0], 4.0 * np.array(errors[1]), rtol=0.3)
    assert errors[0][0] < 2e-3
