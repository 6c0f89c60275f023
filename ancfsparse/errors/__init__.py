"""The errors and warnings of the package.

A message states the fault, the place, the amount, and a remedy.  Its arguments are data
(`Parameter`), so that a command line can write its options in their place.
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
from ancfsparse.errors.message import MessageTemplate, Parameter, format_quantity, python_style
from ancfsparse.errors.run_warnings import (
    ErrorNotMetWarning,
    PenetrationWarning,
    PlanChangedWarning,
    UnresolvedSignalWarning,
)
from ancfsparse.errors.runs import (
    AccuracyError,
    ConvergenceError,
    EnergyIncreaseError,
    InstabilityError,
    LoadError,
    OutputError,
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
    "ErrorNotMetWarning",
    "InputError",
    "InstabilityError",
    "LoadError",
    "MessageTemplate",
    "ModesError",
    "OutputError",
    "Parameter",
    "PenetrationWarning",
    "PlanChangedWarning",
    "PlanError",
    "RedundantConstraintsWarning",
    "SingularSceneError",
    "StepError",
    "UnresolvedSignalWarning",
    "UnstableEquilibriumWarning",
    "format_quantity",
    "python_style",
    "trial_call",
]
