"""Consistent initial conditions; prescribed and redundant constraints are loaded on first use."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.solve.initial_conditions.prescribed_motion_checks import (
        check_prescribed_motions as check_prescribed_motions,
    )
    from ancfsparse.solve.initial_conditions.prescribed_start import (
        prescribe_motions_of_loop as prescribe_motions_of_loop,
        start_prescribed_motions as start_prescribed_motions,
    )
    from ancfsparse.solve.initial_conditions.redundant_constraints import (
        describe_contradiction as describe_contradiction,
        find_redundant_constraints as find_redundant_constraints,
        warn_of_redundant_constraints as warn_of_redundant_constraints,
    )

__getattr__ = on_demand(
    __name__,
    {
        "prescribed_motion_checks": "check_prescribed_motions",
        "prescribed_start": "prescribe_motions_of_loop start_prescribed_motions",
        "redundant_constraints": "describe_contradiction find_redundant_constraints "
        "warn_of_redundant_constraints",
    },
)
