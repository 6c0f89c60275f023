"""A rubber cord and its elastic catenary; shared by tests of strings."""

import numpy as np
from scipy.optimize import brentq

import ancfsparse as ancf

# E A = 785 N, weight 0.77 N over 1 m, strained by 1e-3 under 1 m of it.
CORD = ancf.Circle(0.01)
RUBBER = ancf.Material(youngs_modulus=1e7, density=1000.0)
STIFFNESS = 1e7 * CORD.area
PER_LENGTH = 1000.0 * CORD.area * 9.81  # [N/m]


def elastic_catenary(length, span):
    """Sag in the middle and horizontal force of a cord between supports of one height.

    Irvine, Cable Structures (1981), section 1.3: x(s) = H s / E A + H / w asinh(w s / H) from the
    lowest point on, z(s) = w s^2 / 2 E A + H / w (sqrt(1 + (w s / H)^2) - 1).
    """
    half = length / 2

    def ends(h):
        return h * half / STIFFNESS + h / PER_LENGTH * np.arcsinh(PER_LENGTH * half / h) - span / 2

    h = brentq(ends, 1e-3, 1e3, xtol=1e-14)
    up = np.hypot(1.0, PER_LENGTH * half / h) - 1.0
    return PER_LENGTH * half**2 / (2.0 * STIFFNESS) + h / PER_LENGTH * up, h
