"""Phase errors of integrators, and the dominant frequency of an error.

Shorter steps reduce the error of smooth motions with a power of the step, and that of unresolved
waves only once they resolve them.  Two runs differ by waves if they differ by more in velocity than
in position.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ancfsparse.integrators.explicit.nystrom_tableaus import Tableau
from ancfsparse.solve.stepping.sampled_states import SampledStates, nodal_differences
from ancfsparse.system import System

MIN_ORDER = 0.1  # of the step in an error


@dataclass(frozen=True)
class DominantFrequency:
    """A vibration that represents the error of a run.

    Attributes
    ----------
    amplitude : float
        Amplitude [m].
    omega : float
        Angular frequency [rad/s].
    time : float
        Duration of the integration [s].
    phase_error : float
        Phase error of the finer run [rad]; beyond 1 the runs cannot be compared.
    """

    amplitude: float
    omega: float
    time: float
    phase_error: float

    @classmethod
    def of(
        cls, difference: float, omega: float, time: float, coarse: float, fine: float
    ) -> DominantFrequency:
        """Find the vibration that causes a difference of two runs [m].

        Their relative phase errors are `coarse` and `fine` (`phase_error`).
        """
        larger, smaller = (min(1.0, rate * omega * time) for rate in (coarse, fine))
        ratio = max(larger - smaller, 0.5 * larger)
        amplitude = difference / ratio if ratio > 0.0 else math.inf
        return cls(amplitude, omega, time, fine * omega * time)

    def error(self, phase: float) -> float:
        """Return the error of a run with a relative phase error [m]."""
        return self.amplitude * min(1.0, phase * self.omega * self.time)


def difference_frequency(
    system: System, one: SampledStates, other: SampledStates, resolved: bool = False
) -> float:
    """Return the angular frequency of the difference of two runs [rad/s].

    The ratio of velocity to position; if both runs resolve all vibrations, the root of the ratio of
    acceleration to position, which has more of the high ones.  At least a radian during the motion:
    runs begin equal, and where only loads cause accelerations these do not differ at all.
    """
    names = ("q", "a") if resolved else ("q", "v")
    tables = [(getattr(one, name), getattr(other, name)) for name in names]
    position, rate = (
        max(float(np.max(np.abs(x))) for x in nodal_differences(system, *pair)) for pair in tables
    )
    ratio = rate / position if position > 0.0 else 0.0
    return max(math.sqrt(ratio) if resolved else ratio, 1.0 / float(one.t[-1] - one.t[0]))


def phase_error(tableau: Tableau, z: float) -> float:
    """Return the relative error of phase or amplitude of a vibration of `z` radians per step.

    It is 1 beyond the interval of stability.
    """
    return _tableau_phase_error(tableau, z) if 0.0 < z < tableau.interval else float(z > 0.0)


@lru_cache(maxsize=256)
def _tableau_phase_error(tableau: Tableau, z: float) -> float:
    values = np.linalg.eigvals(tableau.transfer(z))
    return float(np.max(np.abs(values[np.argmax(values.imag)] - np.exp(1j * z)))) / z


def trapezoidal_phase_error(z: float) -> float:
    """Return the phase error of the trapezoidal rule, which advances 2 atan(z / 2) for `z`."""
    return 1.0 - 2.0 * math.atan(0.5 * z) / z if z > 0.0 else 0.0


def observed_order(
    first: float, coarse_difference: float, second: float, third: float, fine_difference: float
) -> float:
    """Return the observed order of convergence, by the differences of three runs.

    Parameters
    ----------
    first, second, third : float
        Resolutions of the runs, ascending.
    coarse_difference, fine_difference : float
        Difference of the first two, and of the last two.
    """

    def ratio(order: float) -> float:
        return 1.0 / difference_ratio(first, second, third, order)

    low, high = 0.0, 16.0
    if coarse_difference <= fine_difference * ratio(MIN_ORDER):
        return MIN_ORDER
    for _ in range(50):
        middle = 0.5 * (low + high)
        is_low = ratio(max(middle, 1e-6)) * fine_difference < coarse_difference
        low, high = (middle, high) if is_low else (low, middle)
    return low


def difference_ratio(first: float, second: float, third: float, order: float) -> float:
    """Return the difference of the last two of three runs over that of the first two.

    Parameters
    ----------
    first, second, third : float
        Resolutions of the runs, ascending.
    order : float
        Order of their errors.
    """
    a, b, c = (n**-order for n in (first, second, third))
    return float((b - c) / (a - b))
