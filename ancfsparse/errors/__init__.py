"""The errors of the package.

A message is a sentence: what is wrong, where, how much, and what to try.  It names arguments as
data (`Parameter`), so that a command line can show its options in their place.
"""

from ancfsparse.errors.equilibria import (
    ApproximateModesWarning,
    AssemblyError,
    EquilibriumError,
    ModesError,
    UnstableEquilibriumWarning,
)
from ancfsparse.errors.inputs import (
    AncfError,
    InputError,
    RedundantConstraintsWarning,
    SingularSceneError,
)
from ancfsparse.errors.message import Parameter, Sentence, in_python, with_unit
from ancfsparse.errors.runs import (
    AccuracyError,
    ConvergenceError,
    EnergyIncreaseError,
    InstabilityError,
    LoadError,
    OutputError,
    PlanChangedWarning,
    PlanError,
    StepError,
    trial_call,
)

__all__ = [
    "AccuracyError",
    "AncfError",
    "ApproximateModesWarning",
    "AssemblyError",
    "ConvergenceError",
    "EnergyIncreaseError",
    "EquilibriumError",
    "InputError",
    "InstabilityError",
    "LoadError",
    "ModesError",
    "OutputError",
    "Parameter",
    "PlanChangedWarning",
    "PlanError",
    "RedundantConstraintsWarning",
    "Sentence",
    "SingularSceneError",
    "StepError",
    "UnstableEquilibriumWarning",
    "in_python",
    "trial_call",
    "with_unit",
]
