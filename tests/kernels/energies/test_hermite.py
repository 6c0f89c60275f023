"""Hermite's cubic beside SciPy's spline and quadrature."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from ancfsparse.kernels.hermite import integral_weights, position_weights, slope_weights

LENGTH = 0.7
XI = np.linspace(0.0, 1.0, 11)
ENDS = np.array([0.3, -1.2, 2.0, 0.4])  # position, slope, position, slope


@pytest.fixture
def spline():
    return CubicHermiteSpline([0.0, LENGTH], ENDS[[0, 2]], ENDS[[1, 3]])


def test_position_is_that_of_a_spline(spline):
    np.testing.assert_allclose(position_weights(XI, LENGTH) @ ENDS, spline(XI * LENGTH), atol=1e-14)


def test_slope_is_that_of_a_spline(spline):
    wanted = spline(XI * LENGTH, 1)
    np.testing.assert_allclose(slope_weights(XI, LENGTH) @ ENDS, wanted, atol=1e-13)


def test_integral_is_that_of_a_spline(spline):
    assert integral_weights(LENGTH) @ ENDS == pytest.approx(float(spline.integrate(0.0, LENGTH)))


def test_many_elements_at_once():
    lengths = np.array([0.5, 2.0])
    assert position_weights(XI[:, None], lengths).shape == (11, 2, 4)
    for k, length in enumerate(lengths):
        np.testing.assert_array_equal(integral_weights(lengths)[k], integral_weights(length))
        np.testing.assert_array_equal(
            slope_weights(XI[:, None], lengths)[:, k], slope_weights(XI, length)
        )
