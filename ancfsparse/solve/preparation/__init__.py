"""Choice of solver, factorization, memory and threads; what few runs need loads on first use."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.solve.preparation.checkpoint_schedule import Schedule as Schedule
    from ancfsparse.solve.preparation.deflation_space import (
        DeflationModes as DeflationModes,
        sliding_points as sliding_points,
    )
    from ancfsparse.solve.preparation.fill_in_estimate import (
        count_factor_entries as count_factor_entries,
    )
    from ancfsparse.solve.preparation.switch_to_direct import (
        FIRST_COMPARISON as FIRST_COMPARISON,
        SwitchToDirect as SwitchToDirect,
    )

__getattr__ = on_demand(
    __name__,
    {
        "checkpoint_schedule": "Schedule",
        "deflation_space": "DeflationModes sliding_points",
        "fill_in_estimate": "count_factor_entries",
        "switch_to_direct": "FIRST_COMPARISON SwitchToDirect",
    },
)
