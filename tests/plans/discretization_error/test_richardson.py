"""Estimates against errors that are known."""

import math
from itertools import pairwise

import numpy as np
import pytest

from ancfsparse.plans.discretization_error.richardson import estimate, observed_order


def series(order, resolutions, factor=3.0):
    errors = [factor * x**-order for x in resolutions]
    return errors, [a - b for a, b in pairwise(errors)]


@pytest.mark.parametrize("order", [1, 2, 4])
@pytest.mark.parametrize("resolutions", [(8, 16), (8, 16, 32), (8, 12, 18), (8, 11, 21)])
def test_a_power_is_continued_exactly(order, resolutions):
    errors, apart = series(order, resolutions)
    error_model = estimate(resolutions, apart, order)
    assert error_model.error == pytest.approx(errors[-1], rel=1e-9)
    assert error_model.at(100) == pytest.approx(3.0 * 100.0**-order, rel=1e-9)
    assert error_model.resolution_for(1e-6) == pytest.approx((3.0 / 1e-6) ** (1 / order), rel=1e-9)
    assert error_model.is_asymptotic == (len(resolutions) == 3)


def test_the_observed_order_is_that_of_a_power():
    for order in (0.7, 2.0, 3.5):
        _, apart = series(order, (5, 9, 30))
        assert observed_order((5, 9, 30), *apart) == pytest.approx(order, rel=1e-9)


def test_a_lower_observed_order_is_believed_and_a_higher_one_is_not():
    _, slow = series(1, (8, 16, 32))
    pessimistic = estimate((8, 16, 32), slow, 2)
    assert pessimistic.order == pytest.approx(1.0)
    assert pessimistic.error == pytest.approx(3.0 / 32, rel=1e-9)
    assert not pessimistic.is_asymptotic
    errors, fast = series(5, (8, 16, 32))
    cautious = estimate((8, 16, 32), fast, 2)
    assert cautious.order == 2
    assert cautious.error > errors[-1]
    assert not cautious.is_asymptotic


@pytest.mark.parametrize("order", [1, 3.5, 5])
def test_errors_at_lower_resolutions_are_not_below_those_that_were_seen(order):
    """An order above that of the method, once assumed where it was not seen, hid 2.4 times."""
    errors, apart = series(order, (8, 16, 32))
    error_model = estimate((8, 16, 32), apart, 2)
    assert error_model.at(8) >= 0.99 * errors[0]
    assert error_model.resolution_for(errors[0]) >= 7.99


def test_errors_of_solutions_that_were_seen_are_their_differences_from_the_last():
    """A strain was planned with 100 steps, by an order of .5 from 1600 steps on: 16 times off."""
    error_model = estimate((100, 200, 400, 800, 1600), (31.0, 5.0, 0.2, 0.19), 2)
    assert error_model.at(100) >= 36.0
    assert error_model.at(200) == pytest.approx(5.39 + error_model.error)
    assert error_model.at(50) >= error_model.at(100)
    assert 5.0 < error_model.at(150) < 36.0
    assert error_model.resolution_for(6.0) == pytest.approx(200, rel=0.1)
    assert error_model.resolution_for(error_model.error) == pytest.approx(1600)


@pytest.mark.parametrize("resolutions", [(8, 12, 18), (8, 16, 32), (12, 18, 27)])
@pytest.mark.parametrize(("order", "other"), [(1, 2), (2, 3), (2, 4), (3, 4), (4, 6)])
def test_an_extremum_of_the_error_does_not_hide_it(resolutions, order, other):
    """Two terms of opposite signs agree at two resolutions; errors were hidden up to 1900 times."""
    for extremum in np.geomspace(2.0, 60.0, 200):
        factor = order / other * extremum ** (other - order)
        errors = [x**-order - factor * x**-other for x in map(float, resolutions)]
        error_model = estimate(resolutions, [abs(a - b) for a, b in pairwise(errors)], order)
        assert abs(errors[-1]) <= 4.2 * error_model.error + 1e-15


def test_solutions_that_agree_by_chance_are_estimated_by_the_previous_difference():
    """A strain between unequal elements showed order 4.6, and had 1.64 times its error."""
    error_model = estimate((8, 16, 32), (1.0, 0.041), 2)
    assert observed_order((8, 16, 32), 1.0, 0.041) == pytest.approx(4.6, abs=0.05)
    assert error_model.error == pytest.approx(1.0 / 4.0 / 3.0)
    assert error_model.order == 2


def test_what_diverges_is_not_settled_and_its_error_is_not_small():
    error_model = estimate((8, 16, 32), (1.0, 2.0), 2)
    assert not error_model.is_asymptotic
    assert error_model.error > 2.0
    assert observed_order((8, 16, 32), 1.0, 2.0) == -math.inf


def test_equal_solutions_have_no_error():
    error_model = estimate((8, 16, 32), (2e-16, 0.0), 2)
    assert error_model.is_asymptotic
    assert error_model.error == 0.0
    assert estimate((8, 16), (0.0,), 2).resolution_for(1e-3) == 0.0
