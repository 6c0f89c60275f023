"""Time integration: methods, their coefficients, and the compiled time loops.

This package depends on time integration alone, not on elements.
"""

from ancfsparse.integrators.explicit.explicit_methods import (
    CentralDifference,
    DormandPrince,
    Explicit,
    RungeKuttaNystrom,
)
from ancfsparse.integrators.implicit.energy_momentum import EnergyMomentum
from ancfsparse.integrators.implicit.newmark_family import HHT, GeneralizedAlpha, Implicit, Newmark

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
