"""Orders of elimination and groups of unknowns; orderings and CHOLMOD are loaded on first use."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.seeds.ordering.cholmod import supernodal
    from ancfsparse.seeds.ordering.fill_reducing import METHODS, order

__all__ = ["METHODS", "order", "supernodal"]

__getattr__ = on_demand(__name__, {"cholmod": "supernodal", "fill_reducing": "METHODS order"})
