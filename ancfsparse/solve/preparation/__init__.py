"""Choice of solver, factorization, memory and threads; what few runs need loads on first use."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.solve.preparation.checkpoint_schedule import Schedule
    from ancfsparse.solve.preparation.deflation_space import DeflationModes, sliding_points
    from ancfsparse.solve.preparation.fill_in_estimate import count_factor_entries
    from ancfsparse.solve.preparation.switch_to_direct import FIRST_COMPARISON, SwitchToDirect

__all__ = [
    "FIRST_COMPARISON",
    "DeflationModes",
    "Schedule",
    "SwitchToDirect",
    "count_factor_entries",
    "sliding_points",
]

__getattr__ = on_demand(
    __name__,
    {
        "checkpoint_schedule": "Schedule",
        "deflation_space": "DeflationModes sliding_points",
        "fill_in_estimate": "count_factor_entries",
        "switch_to_direct": "FIRST_COMPARISON SwitchToDirect",
    },
)
