"""Choice of solver, factorization, memory and threads; what few runs need loads on first use."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.solve.preparation.deflation_space import DeflationModes, sliding_points
    from ancfsparse.solve.preparation.switch_to_direct import FIRST_COMPARISON, SwitchToDirect

__all__ = ["FIRST_COMPARISON", "DeflationModes", "SwitchToDirect", "sliding_points"]

__getattr__ = on_demand(
    __name__,
    {
        "deflation_space": "DeflationModes sliding_points",
        "switch_to_direct": "FIRST_COMPARISON SwitchToDirect",
    },
)
