"""Hermite's cubic beside SciPy's spline and quadrature."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from ancfsparse.kernels.hermite import integral_weights, position_weights, slope_weights

LENGTH = 0.7
XI = np.linspace(0.0, 1.0, 11)
ENDS = np.array([0.3, -1.2, 2.0, 0.4])  # position, slope, position, slope


def test_positions_slopes_and_integrals_are_those_of_a_spline():
    spline = CubicHermiteSpline([0.0, LENGTH], ENDS[[0, 2]], ENDS[[1, 3]])
    np.testing.assert_allclose(position_weights(XI, LENGTH) @ ENDS, spline(XI * LENGTH), atol=1e-14)
    slopes = spline(XI * LENGTH, 1)
    np.testing.assert_allclose(slope_weights(XI, LENGTH) @ ENDS, slopes, atol=1e-13)
    assert integral_weights(LENGTH) @ ENDS == pytest.approx(float(spline.integrate(0.0, LENGTH)))


def test_many_elements_at_once():
    lengths = np.array([0.5, 2.0])
    assert position_weights(XI[:, None], lengths).shape == (11, 2, 4)
    for k, length in enumerate(lengths):
        np.testing.assert_array_equal(integral_weights(lengths)[k], integral_weights(length))
        np.testing.assert_array_equal(
            slope_weights(XI[:, None], lengths)[:, k], slope_weights(XI, length)
        )
