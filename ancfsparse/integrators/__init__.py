"""In comes a system at rest or in motion, out go its states, step after step.

This room knows time and no elements.
"""

from ancfsparse.integrators.conserving import EnergyMomentum
from ancfsparse.integrators.explicit import (
    CentralDifference,
    DormandPrince,
    Explicit,
    RungeKuttaNystrom,
)
from ancfsparse.integrators.implicit import HHT, GeneralizedAlpha, Implicit, Newmark

__all__ = [
    "HHT",
    "CentralDifference",
    "DormandPrince",
    "EnergyMomentum",
    "Explicit",
    "GeneralizedAlpha",
    "Implicit",
    "Newmark",
    "RungeKuttaNystrom",
]
