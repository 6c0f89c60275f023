"""What the error of a run is made of, and what it would be with other steps or another method.

Smooth motions and unresolved waves differ in what shorter steps do to their error: of the first it
falls with a power of the step, of the second only once the step resolves them.  Where two runs part
by more in velocity than in place, it is waves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ancfsparse.integrators.explicit.nystrom_tableaus import Tableau
from ancfsparse.solve.stepping.sampled_states import SampledStates, nodal_differences
from ancfsparse.system import System

SMALLEST_POWER = 0.1  # of the step with which an error is thought to fall


@dataclass(frozen=True)
class DominantFrequency:
    """A vibration that stands for the error: how large it is, how fast, and how long it lasts.

    Attributes
    ----------
    amplitude : float
        Of the vibration [m].
    omega : float
        Its angular frequency [rad/s].
    time : float
        In which its phase is lost, step by step [s].
    lost : float
        What the finer run loses of the phase [rad]; beyond 1 the runs cannot be compared.
    """

    amplitude: float
    omega: float
    time: float
    lost: float

    @classmethod
    def of(
        cls, apart: float, omega: float, time: float, coarse: float, fine: float
    ) -> DominantFrequency:
        """Find the vibration that parts two runs by a distance [m].

        They lose these shares of its phase (`phase_lost`).
        """
        most, least = (min(1.0, each * omega * time) for each in (coarse, fine))
        share = max(most - least, 0.5 * most)
        return cls(apart / share if share > 0.0 else math.inf, omega, time, fine * omega * time)

    def error(self, lost: float) -> float:
        """Return the error of a run that loses a share of the phase [m]."""
        return self.amplitude * min(1.0, lost * self.omega * self.time)


def frequency(
    system: System, one: SampledStates, other: SampledStates, resolved: bool = False
) -> float:
    """Return the angular frequency of the difference of two runs [rad/s].

    It is speed over place; or, where the steps of both resolve all vibrations, the root of
    acceleration over place, which has more of the fast ones.
    """
    names = ("q", "a") if resolved else ("q", "v")
    tables = [(getattr(one, name), getattr(other, name)) for name in names]
    below, above = (
        max(float(np.max(np.abs(apart))) for apart in nodal_differences(system, *pair))
        for pair in tables
    )
    ratio = above / below if below > 0.0 else 0.0
    return math.sqrt(ratio) if resolved else ratio


def phase_lost(tableau: Tableau, z: float) -> float:
    """Return the share of its phase, or of its size, that a vibration of `z` radian a step loses.

    Beyond the interval of stability nothing is left.
    """
    return _lost(tableau, z) if 0.0 < z < tableau.interval else float(z > 0.0)


@lru_cache(maxsize=256)
def _lost(tableau: Tableau, z: float) -> float:
    values = np.linalg.eigvals(tableau.transfer(z))
    return float(np.max(np.abs(values[np.argmax(values.imag)] - np.exp(1j * z)))) / z


def phase_lost_implicitly(z: float) -> float:
    """Return that of the trapezoidal rule, which takes 2 atan(z / 2) for `z`."""
    return 1.0 - 2.0 * math.atan(0.5 * z) / z if z > 0.0 else 0.0


def power_of_fall(first: float, apart: float, second: float, third: float, nearer: float) -> float:
    """Return with which power of the step an error falls, by the distances of three runs.

    Parameters
    ----------
    first, second, third : float
        How fine the runs were, ascending.
    apart, nearer : float
        Distance of the first two, and of the last two.
    """

    def ratio(power: float) -> float:
        return 1.0 / fall(first, second, third, power)

    low, high = 0.0, 16.0
    if apart <= nearer * ratio(SMALLEST_POWER):
        return SMALLEST_POWER
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if ratio(max(middle, 1e-6)) * nearer < apart else (low, middle)
    return low


def fall(first: float, second: float, third: float, power: float) -> float:
    """Return the distance of the last two of three runs, over that of the first two.

    Parameters
    ----------
    first, second, third : float
        How fine the runs are, ascending.
    power : float
        Of the step, with which their errors decrease.
    """
    a, b, c = (each**-power for each in (first, second, third))
    return float((b - c) / (a - b))
