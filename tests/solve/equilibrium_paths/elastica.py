"""Euler's elastica, beside which columns are put that have buckled."""

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk


def elastica(multiple):
    """Where the tip of a cantilever of length 1 is under a multiple of Euler's load (x, y).

    With k = sin(a / 2) of the angle a at the tip: P / P_Euler = (2 K / pi)^2 (Timoshenko and Gere,
    Theory of Elastic Stability, article 2.7).
    """
    m = brentq(lambda m: (2.0 * ellipk(m) / np.pi) ** 2 - multiple, 1e-12, 0.99, xtol=1e-15)
    return 2.0 * ellipe(m) / ellipk(m) - 1.0, 2.0 * np.sqrt(m) / ellipk(m)
