"""Orders of elimination and groups of unknowns; CHOLMOD is loaded on first use."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.seeds.ordering.cholmod import Supernodal, order

__all__ = ["Supernodal", "order"]

__getattr__ = on_demand(__name__, {"cholmod": "Supernodal order"})
