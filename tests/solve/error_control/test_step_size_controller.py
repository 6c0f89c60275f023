"""Steps that follow a motion, and states between them."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.solve.error_control.step_size_controller import STEP_RATIO, StepSizeController
from ancfsparse.solve.stepping.sampled_states import SampledStates
from ancfsparse.system import System
from tests.solve.error_control.accuracy_problems import spin_up, swinging_pendulum


def test_steps_follow_the_motion_and_are_powers_of_a_root():
    # The moment sets in smoothly and turns off: short steps while it acts, longer ones before.
    system = System(spin_up())
    t = np.linspace(0.0, 2.0, 11)
    stepper = StepSizeController(system, ancf.GeneralizedAlpha(0.8), "auto", 1e-8, 1e-5, t, 0.01)
    lengths = [stepper.dt]
    change = stepper._change

    def watch(dt, now):
        lengths.append(dt)
        change(dt, now)

    stepper._change = watch
    stepper.run()
    # All but the last, with which steps come to the end.
    levels = np.log(np.array(lengths[:-1]) / 1e-5) / math.log(STEP_RATIO)
    np.testing.assert_allclose(levels, np.round(levels), atol=1e-9)
    assert max(lengths) > 8.0 * min(lengths)
    assert stepper.stats.rejected_steps > 0
    # Few changes for many steps: the factor of one serves the next.
    assert len(lengths) < 0.1 * stepper.stats.steps
    assert sum(n * dt for dt, n in stepper.pattern[0]) == pytest.approx(2.0, abs=1e-12)


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


def test_an_error_below_rounding_ends_with_a_sentence():
    system, t = System(swinging_pendulum()), np.array([0.0, 0.1])
    stepper = StepSizeController(system, ancf.Newmark(), ancf.Newton(), 1e-40, 1e-4, t, 0.01)
    with pytest.raises(ancf.StepError, match="however short it is"):
        stepper.run()
