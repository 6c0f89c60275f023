"""Motions: arguments of `simulate`, and the three kinds of runs, each loaded on first use.

Checkpoints in files and `resume` are loaded on first use as well.
"""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.solve.motion.checkpoint_files import (
        describe_request as describe_request,
        pack as pack,
    )
    from ancfsparse.solve.motion.error_controlled_run import (
        ErrorControlledRun as ErrorControlledRun,
    )
    from ancfsparse.solve.motion.explicit_run import ExplicitRun as ExplicitRun
    from ancfsparse.solve.motion.implicit_run import ImplicitRun as ImplicitRun

__getattr__ = on_demand(
    __name__,
    {
        "checkpoint_files": "describe_request pack",
        "error_controlled_run": "ErrorControlledRun",
        "explicit_run": "ExplicitRun",
        "implicit_run": "ImplicitRun",
    },
)
