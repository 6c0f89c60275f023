"""Load amplitudes and generalized forces."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.system.loads.time_dependent_eigenstrain import ChangingStrain

__all__ = ["ChangingStrain"]

__getattr__ = on_demand(__name__, {"ChangingStrain": "time_dependent_eigenstrain"})
