"""Derivatives by complex steps (Squire and Trapp, SIAM Rev. 40 (1998) 110), without differences."""

import numpy as np

IMAGINARY_STEP = 1e-30  # its square is far below rounding errors of all real parts


def derivative(function, x, n):
    """The derivative (m, n) of a function of rows of coordinates by the first n of them."""
    moves = 1j * IMAGINARY_STEP * np.eye(len(x))[:n]
    return function(x + moves).imag.T / IMAGINARY_STEP


def assert_same(found, expected, bound):
    """Compare with a bound relative to the largest number, which is not zero."""
    size = np.abs(expected).max()
    assert size > 0.0
    assert np.abs(found - expected).max() < bound * size
