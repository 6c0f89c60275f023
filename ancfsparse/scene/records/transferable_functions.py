"""Functions of a scene, and their transfer to other processes."""

from __future__ import annotations

import pickle
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError

Vector = NDArray[np.float64]

# Functions that are being pickled by value: one may refer to the scene it belongs to.
_under_way = threading.local()


@dataclass(frozen=True)
class Unsent:
    """Stands for a function that could not be sent to another process; a call raises an error.

    Parameters
    ----------
    name : str
        The function.
    """

    name: str

    def __call__(self, *_: object) -> Any:
        """Refuse.

        Raises
        ------
        InputError
            Always.
        """
        raise InputError(self.reason)

    @property
    def reason(self) -> str:
        """Why there is no function, and what to do."""
        return (
            f"the function {self.name} of this scene was not sent along from the process in "
            "which it was made: define it by def at the top of a module, where other processes "
            "find it, or import cloudpickle there"
        )


@dataclass(frozen=True, eq=False)
class Sent:
    """A function in the form that is copied and pickled; the result is the function itself.

    Parameters
    ----------
    function : callable
        The function.  One that cannot be pickled, such as a lambda, is pickled by value where the
        program has loaded cloudpickle, as clusters do; elsewhere the result is `Unsent`.
    """

    function: Callable[..., Any]

    def __call__(self, *arguments: object) -> Any:
        """Call it."""
        return self.function(*arguments)

    def __deepcopy__(self, memo: dict[int, Any]) -> Callable[..., Any]:
        """Return it: functions are not copied."""
        return self.function

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any]]:
        """Pickle it by reference, by value, or by name only."""
        if _pickled(pickle, self.function) is not None:
            return _itself, (self.function,)
        code = _code(self.function)
        if code is not None:
            return pickle.loads, (code,)
        return Unsent, (getattr(self.function, "__qualname__", repr(self.function)),)


def sendable(value: Any) -> Any:
    """Return a value, function or not, in the form that is copied and pickled."""
    return Sent(value) if callable(value) else value


def _code(function: Callable[..., Any]) -> bytes | None:
    """Pickle a function by value; None without cloudpickle, and inside itself."""
    picklers = (
        module for name, module in [*sys.modules.items()] if name.split(".")[-1] == "cloudpickle"
    )
    pickler = next((each for each in picklers if hasattr(each, "dumps")), None)
    under_way = _under_way.__dict__.setdefault("functions", set())
    if pickler is None or id(function) in under_way:
        return None
    under_way.add(id(function))
    try:
        return _pickled(pickler, function)
    finally:
        under_way.remove(id(function))


def _pickled(pickler: Any, function: Callable[..., Any]) -> bytes | None:
    try:
        return bytes(pickler.dumps(function))
    except (pickle.PicklingError, AttributeError, TypeError):
        return None


def _itself(function: Callable[..., Any]) -> Callable[..., Any]:
    return function
