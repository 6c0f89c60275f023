"""Warnings of runs, equilibria and plans."""

from __future__ import annotations

from ancfsparse.errors.message import format_quantity


class PlanChangedWarning(UserWarning):
    """A run has left the validity range of its plan, and was planned again."""


class UnresolvedSignalWarning(UserWarning):
    """Fixed steps miss, shift or alias a signal."""


class PenetrationWarning(UserWarning):
    """A body sank deep into an obstacle or another body.

    With the default stiffness the limit is 30 % of its radius in a run, and 3 % in an equilibrium;
    with a given one it is the radius, between bodies the smaller one, except on flat obstacles,
    where a soft contact is allowed.  Motions with a given stiffness and without a `start` are also
    warned of if they begin in an obstacle by more than 5 % of the radius, and deeper than known
    loads, tensions and speeds press them.
    """


class ErrorNotMetWarning(UserWarning):
    """The error of a quantity exceeds the requested one, by prediction or by measurement.

    Parameters
    ----------
    quantity : str
        Description of the quantity.
    tolerance, error : float
        The requested error, and the predicted or measured one.
    unit : str
        Unit of both.
    source : str
        Largest source of the error, with its amount.
    advice : str
        What to try, a clause.
    is_measured : bool, optional
        Whether the error is the difference from a finer run.
    """

    def __init__(
        self,
        quantity: str,
        tolerance: float,
        error: float,
        unit: str,
        source: str,
        advice: str,
        is_measured: bool = False,
    ) -> None:
        super().__init__(quantity, tolerance, error, unit, source, advice, is_measured)
        self.quantity, self.tolerance, self.error = quantity, tolerance, error
        self.unit, self.source, self.advice = unit, source, advice
        self.is_measured = is_measured

    def __str__(self) -> str:
        """Return the message."""
        error = format_quantity(self.error, self.unit, 2)
        clause = f"differs by {error} from a finer run" if self.is_measured else (
            f"has a predicted error of {error}")  # fmt: skip
        return (
            f"the {self.quantity} {clause}, and "
            f"{format_quantity(self.tolerance, self.unit, 2)} was requested; the largest source is "
            f"{self.source}: {self.advice}"
        )
