"""Values that are constant or functions of time: loads and prescribed motions."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_finite, check_reals, check_vector, set_fields
from ancfsparse.errors import InputError, LoadError, trial_call
from ancfsparse.messages import format_value
from ancfsparse.scene.records.picklable_functions import picklable

Value = ArrayLike | Callable[[float], ArrayLike]


class TimeDependentValue(ABC):
    """A load or a prescribed value: constant, or a function of time.

    It can be pickled, if necessary without its function of time.

    Attributes
    ----------
    value : number, ndarray or callable
        A value [`unit`], or a function of t [s] that returns it.
    """

    value: Value
    unit: str
    number: ClassVar[str] = "one number about +z because the scene is planar"

    def __post_init__(self) -> None:
        """Evaluate the value at t = 0, and store a constant as a checked number or vector."""
        with trial_call():
            now = self.at(0.0)
        if not callable(self.value):
            set_fields(self, value=now if self.shape else float(now[0]))

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling."""
        return self.__dict__ | {"value": picklable(self.__dict__["value"])}

    @property
    @abstractmethod
    def what(self) -> str:
        """Name in messages."""

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Shape of a value: ``(dim,)``, or ``()`` for a number."""

    def at(self, t: float) -> Vector:
        """Return the value at time `t` [s], shape (dim,) or (1,) [`unit`].

        Raises
        ------
        InputError
            If a constant value is invalid; a `LoadError` for a function.
        """
        if not callable(self.value):
            return self._checked(self.what, self.value)
        try:
            now = self.value(t)
        except Exception as error:  # a user function may raise anything
            raise self.failure(t, error) from error
        return self.checked(t, now)

    def checked(self, t: float, now: ArrayLike) -> Vector:
        """Check a value that a function of time has returned; return it, (dim,) or (1,).

        Raises
        ------
        LoadError
            If the value is invalid.
        """
        try:
            return self._checked(f"{self.what}, a function of time, at t = {t:.6g} s,", now)
        except InputError as wrong:
            raise LoadError(str(wrong), t) from None

    def failure(self, t: float, error: Exception) -> LoadError:
        """Return the error for a function that raised an exception."""
        kind = "" if isinstance(error, InputError) else f"{type(error).__name__}: "
        reason = f"{kind}{error}".rstrip(": ")
        return LoadError(f"{self.what}, a function of time, failed at t = {t:.6g} s: {reason}", t)

    def _checked(self, name: str, value: ArrayLike) -> Vector:
        if self.shape:
            return check_vector(name, value, self.shape[0], self.unit)
        if check_reals(name, value, self.number).ndim:
            raise InputError(f"{name} must be {self.number}, got {format_value(value)}")
        return np.array([check_finite(name, value, self.unit)])
