"""Time integration: methods, their coefficients, and the compiled time loops.

This package depends on time integration alone, not on elements.
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
