"""Load amplitudes and generalized forces."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.system.loads.time_dependent_eigenstrain import TimeDependentEigenstrain

__all__ = ["TimeDependentEigenstrain"]

__getattr__ = on_demand(__name__, {"time_dependent_eigenstrain": "TimeDependentEigenstrain"})
