"""The states of a motion at several times."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


class StateHistory(NamedTuple):
    """States of a system at k times.

    Attributes
    ----------
    q, v, a : (k, n_all) float
        Coordinates [m, 1], velocities [m/s, 1/s] and accelerations [m/s2, 1/s2].
    lam : (k, m) float
        Multipliers [N].
    t : (k,) float
        Times [s].
    """

    q: Vector
    v: Vector
    a: Vector
    lam: Vector
    t: Vector
