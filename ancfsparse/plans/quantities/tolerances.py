"""Goals: quantities of interest with tolerances, absolute or relative as in ``"1 %"``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_positive
from ancfsparse.errors import InputError, format_quantity
from ancfsparse.messages import format_value
from ancfsparse.plans.quantities.quantity import Quantity
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene


@dataclass(frozen=True)
class Goal:
    """A quantity of interest and its largest error.

    Attributes
    ----------
    quantity : Quantity
        The quantity.
    error : float
        Largest error, in the unit of the quantity, or [-] if it is relative.
    relative : bool
        Whether it refers to the size of the quantity.
    """

    quantity: Quantity
    error: float
    relative: bool

    def tolerance(self, history: Vector) -> float:
        """Return the largest error, relative ones times the size of the quantity [unit]."""
        return self.error * (self.quantity.size(history) if self.relative else 1.0)

    def check_change(self, tolerance: float, run: Trajectory) -> None:
        """Refuse a relative error of a quantity that is zero or does not change in a run.

        Raises
        ------
        InputError
            If all its changes are rounding or errors of the time steps.
        """
        size, quantity = tolerance / self.error, self.quantity
        is_rounding = size <= quantity.rounding(run)
        if self.relative and (is_rounding or not quantity.varies(run)):
            amount = f" by more than rounding, {format_quantity(size, quantity.unit, 3)}"
            raise InputError(
                f"the {quantity.name} does not change{amount * (is_rounding and size > 0.0)}, so "
                "it has no relative error: give an absolute one, such as "
                f"error=1e-3 [{quantity.unit or '-'}]"
            )

    def __str__(self) -> str:
        """Write quantity and error."""
        unit = self.quantity.unit
        error = f"{100 * self.error:g} %" if self.relative else f"{self.error:g} {unit}".rstrip()
        return f"{self.quantity!r}, to {error}"


def check_quantities(quantity: Any, scene: Scene) -> tuple[Quantity, ...]:
    """Return one quantity or several as a tuple of quantities of the scene.

    Raises
    ------
    InputError
        If one is not a `Quantity`, there is none, or the scene does not have it.
    """
    given = quantity if isinstance(quantity, list | tuple) else (quantity,)
    for each in given:
        if not isinstance(each, Quantity):
            raise InputError(
                "quantity must be a Quantity, such as ancf.position(rod.end), or a list of them, "
                f"got {format_value(each)}"
            )
        each.check(scene)
    if given and len({each.is_static for each in given}) > 1:
        raise InputError(
            "quantities of a motion and of the equilibrium were given together: make a plan for "
            "each kind"
        )
    if not given:
        raise InputError("quantity is empty: give at least one, such as ancf.position(rod.end)")
    return tuple(given)


def check_goals(quantities: Sequence[Quantity], error: Any) -> tuple[Goal, ...]:
    """Return quantities with their errors.

    The error is one for all, or one for each: a number in the unit of the quantity, or a string
    such as ``"1 %"``, relative to its size.

    Raises
    ------
    InputError
        If an error is invalid, or their number differs.
    """
    errors = list(error) if isinstance(error, list | tuple) else [error] * len(quantities)
    if len(errors) != len(quantities):
        raise InputError(
            f"error has {len(errors)} entries for {len(quantities)} quantities: give one for each, "
            "or one for all"
        )
    return tuple(map(_check_goal, quantities, errors))


def _check_goal(quantity: Quantity, error: Any) -> Goal:
    if error is None:
        raise InputError(
            f"the {quantity.name} needs an error: give error=1e-3 [{quantity.unit or '-'}] or "
            "error='1 %'"
        )
    if not isinstance(error, str):
        what = f"the error of the {quantity.name}"
        return Goal(quantity, check_positive(what, error, quantity.unit), False)
    text = error.strip()
    try:
        fraction = float(text.removesuffix("%")) / 100.0 if text.endswith("%") else None
    except ValueError:
        fraction = None
    if fraction is None or not 0.0 < fraction < 1.0:
        raise InputError(
            f"a relative error must be a string such as '1 %', above 0 and below 100 %, got "
            f"{format_value(error)}"
        )
    return Goal(quantity, fraction, True)
