"""Consistent initial conditions; prescribed and redundant constraints are loaded on first use."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.solve.initial_conditions.prescribed_smoothness import check_smooth
    from ancfsparse.solve.initial_conditions.prescribed_start import drive_march, start_drives
    from ancfsparse.solve.initial_conditions.redundant_constraints import (
        contradiction,
        repeats,
        warn_of_repeats,
    )

__all__ = [
    "check_smooth",
    "contradiction",
    "drive_march",
    "repeats",
    "start_drives",
    "warn_of_repeats",
]

__getattr__ = on_demand(
    __name__,
    {
        "check_smooth": "prescribed_smoothness",
        "contradiction": "redundant_constraints",
        "drive_march": "prescribed_start",
        "repeats": "redundant_constraints",
        "start_drives": "prescribed_start",
        "warn_of_repeats": "redundant_constraints",
    },
)
