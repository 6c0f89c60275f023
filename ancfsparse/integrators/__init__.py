"""Time integration: methods, their coefficients, and the compiled time loops.

This package depends on time integration alone, not on elements.
"""

from typing import TYPE_CHECKING

from ancfsparse.integrators.implicit.energy_momentum import EnergyMomentum
from ancfsparse.integrators.implicit.newmark_family import HHT, GeneralizedAlpha, Implicit, Newmark
from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.integrators.explicit.explicit_methods import (
        CentralDifference,
        DormandPrince,
        Explicit,
        RungeKuttaNystrom,
    )
    from ancfsparse.integrators.names import EXAMPLES

__all__ = [
    "EXAMPLES",
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

__getattr__ = on_demand(
    __name__,
    {
        "explicit.explicit_methods": "CentralDifference DormandPrince Explicit RungeKuttaNystrom",
        "names": "EXAMPLES",
    },
)
