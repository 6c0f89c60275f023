"""The errors of the package.

A message is a sentence: what is wrong, where, how much, and what to try.  It names arguments as
data (`Parameter`), so that a command line can show its options in their place.
"""

from ancfsparse.errors.equilibria import (
    ApproximateModes,
    AssemblyFailure,
    EquilibriumFailure,
    ModesFailure,
    UnstableEquilibrium,
)
from ancfsparse.errors.inputs import (
    AncfError,
    InputError,
    LoadFailure,
    RedundantConstraints,
    SingularSceneError,
)
from ancfsparse.errors.message import Parameter, Sentence, in_python, with_unit
from ancfsparse.errors.runs import (
    AccuracyFailure,
    EnergyGain,
    Instability,
    OutputFailure,
    PlanChanged,
    PlanFailure,
    StepFailure,
)

__all__ = [
    "AccuracyFailure",
    "AncfError",
    "ApproximateModes",
    "AssemblyFailure",
    "EnergyGain",
    "EquilibriumFailure",
    "InputError",
    "Instability",
    "LoadFailure",
    "ModesFailure",
    "OutputFailure",
    "Parameter",
    "PlanChanged",
    "PlanFailure",
    "RedundantConstraints",
    "Sentence",
    "SingularSceneError",
    "StepFailure",
    "UnstableEquilibrium",
    "in_python",
    "with_unit",
]
