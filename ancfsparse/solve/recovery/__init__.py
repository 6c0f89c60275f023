"""Recovery of failed steps, and steps across singular configurations; loaded on first use."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.solve.recovery.checkpoints import RepeatedSteps as RepeatedSteps
    from ancfsparse.solve.recovery.complete_seed import CompleteSeed as CompleteSeed
    from ancfsparse.solve.recovery.compliant_constraints import (
        CompliantConstraints as CompliantConstraints,
    )
    from ancfsparse.solve.recovery.singular_crossing import prepare_crossings as prepare_crossings
    from ancfsparse.solve.recovery.step_halving import StepHalving as StepHalving

__getattr__ = on_demand(
    __name__,
    {
        "checkpoints": "RepeatedSteps",
        "complete_seed": "CompleteSeed",
        "compliant_constraints": "CompliantConstraints",
        "singular_crossing": "prepare_crossings",
        "step_halving": "StepHalving",
    },
)
