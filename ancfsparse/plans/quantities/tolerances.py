"""Errors that are asked for: absolute numbers, or shares as in ``"1 %"``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_positive
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.plans.quantities.quantity import Quantity

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Wanted:
    """A quantity and its largest error.

    Attributes
    ----------
    quantity : Quantity
        What is asked for.
    error : float
        Largest error, in the unit of the quantity, or [-] if it is relative.
    relative : bool
        Whether it refers to the size of the quantity.
    """

    quantity: Quantity
    error: float
    relative: bool

    def tolerance(self, history: Array) -> float:
        """Return the largest error for a quantity of this size [unit]."""
        return self.error * (self.quantity.size(history) if self.relative else 1.0)

    def __str__(self) -> str:
        """Write the request."""
        unit = self.quantity.unit
        amount = f"{100 * self.error:g} %" if self.relative else f"{self.error:g} {unit}".rstrip()
        return f"{self.quantity!r}, to {amount}"


def wanted(quantities: Sequence[Quantity], error: Any) -> tuple[Wanted, ...]:
    """Return quantities with their errors.

    Parameters
    ----------
    quantities : sequence of Quantity
        What is asked for.
    error : float, str or sequence of them
        One for all, or one for each: a number in the unit of the quantity, or a string such as
        ``"1 %"``, a share of its size.

    Raises
    ------
    InputError
        If an error is invalid, or their number differs.
    """
    given = list(error) if isinstance(error, list | tuple) else [error] * len(quantities)
    if len(given) != len(quantities):
        raise InputError(
            f"error has {len(given)} entries for {len(quantities)} quantities: give one for each, "
            "or one for all"
        )
    return tuple(map(_wanted, quantities, given))


def _wanted(quantity: Quantity, error: Any) -> Wanted:
    if error is None:
        raise InputError(
            f"the {quantity.name} needs an error: give error=1e-3 [{quantity.unit or '-'}] or "
            "error='1 %'"
        )
    if not isinstance(error, str):
        what = f"the error of the {quantity.name}"
        return Wanted(quantity, check_positive(what, error, quantity.unit), False)
    text = error.strip()
    try:
        share = float(text.removesuffix("%")) / 100.0 if text.endswith("%") else None
    except ValueError:
        share = None
    if share is None or not 0.0 < share < 1.0:
        raise InputError(
            f"a relative error must be a string such as '1 %', above 0 and below 100 %, got "
            f"{format_value(error)}"
        )
    return Wanted(quantity, share, True)
