"""Errors of a planned run that exceed the requested ones, and the warnings about them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

from ancfsparse.errors import ErrorNotMetWarning
from ancfsparse.plans.execution.plan_data import PlanData, Prediction
from ancfsparse.plans.model_error.effects import METHOD_EFFECTS, SOURCE_NAMES

LARGER_ERROR = "or request a larger error"
ADVICE = {
    "mesh": "leave n_elements out where it is given, smooth loads that jump, " + LARGER_ERROR,
    "time": (
        "leave dt out where it is given, smooth loads that jump, damp vibrations (axial_damping, "
        f"bending_damping), {LARGER_ERROR}"
    ),
    "mesh and steps": "smooth loads that jump, damp vibrations, " + LARGER_ERROR,
}
"""Advice by source."""
ADVICE_FOR_METHODS = "plan with integrator=GeneralizedAlpha(0.9), " + LARGER_ERROR
ADVICE_FOR_ELEMENTS = "give element='thick', " + LARGER_ERROR
ADVICE_IF_MEASURED = "request a smaller error, which takes a finer mesh and shorter steps"


@dataclass(frozen=True)
class UnmetError:
    """Error of a quantity that exceeds the requested one.

    Attributes
    ----------
    prediction : Prediction
        The quantity, the requested error and the predicted one.
    error : float
        The predicted error, or the measured one if that is larger [unit of the quantity].
    is_measured : bool
        Whether it is the measured one.
    """

    prediction: Prediction
    error: float
    is_measured: bool

    def __str__(self) -> str:
        """Write the error in a clause."""
        quantity, verb = (
            self.prediction.goal.quantity,
            "measured" if self.is_measured else "predicted",
        )
        error, tolerance = (
            f"{each:.2g} {quantity.unit}".rstrip()
            for each in (self.error, self.prediction.tolerance)
        )
        name = quantity.name
        return f"the error of the {name} is {verb} to be {error}, and {tolerance} was requested"

    def warning(self) -> ErrorNotMetWarning:
        """Return the warning."""
        goal, sources = self.prediction.goal, self.prediction.sources
        largest = max(sources, key=lambda name: sources[name])
        advice = ADVICE.get(largest, ADVICE_FOR_ELEMENTS)
        source, amount = f"the {SOURCE_NAMES[largest]}", sources[largest]
        if largest in METHOD_EFFECTS:
            advice = ADVICE_FOR_METHODS
        if self.prediction.floor > self.prediction.error:
            source, amount = "the difference between converged elements", self.prediction.floor
            advice = "no element gives less: request a larger error"
        if self.is_measured:
            advice = ADVICE_IF_MEASURED
        source = f"{source}, {amount:.2g} {goal.quantity.unit}".rstrip()
        return ErrorNotMetWarning(
            goal.quantity.name,
            self.prediction.tolerance,
            self.error,
            goal.quantity.unit,
            source,
            advice,
            self.is_measured,
        )


def unmet_errors(plan: PlanData, measured: Sequence[float] = ()) -> list[UnmetError]:
    """Return the errors that exceed the requested ones, by prediction or by measurement."""
    out = []
    differences = measured or (0.0,) * len(plan.predictions)
    for each, difference in zip(plan.predictions, differences, strict=True):
        predicted = each.bound
        if max(predicted, difference) > each.tolerance:
            out.append(UnmetError(each, max(predicted, difference), difference > predicted))
    return out


def warn_of_unmet_errors(plan: PlanData, measured: Sequence[float], stacklevel: int) -> None:
    """Warn of every error that exceeds the requested one.

    Warns
    -----
    ErrorNotMetWarning
        For each of them.
    """
    for each in unmet_errors(plan, measured):
        warnings.warn(each.warning(), stacklevel=stacklevel + 1)
