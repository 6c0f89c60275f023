"""Functions of a scene in a form that can be copied and sent to other processes."""

from __future__ import annotations

import pickle
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ancfsparse.errors import InputError

# Functions that are being pickled by value: one may refer to the scene it belongs to.
_in_progress = threading.local()


@dataclass(frozen=True)
class MissingFunction:
    """Placeholder for a function that could not be pickled; calling it raises an error.

    Parameters
    ----------
    name : str
        Name of the function.
    """

    name: str

    def __call__(self, *_: object) -> Any:
        """Raise an error.

        Raises
        ------
        InputError
            Always.
        """
        raise InputError(self.reason)

    @property
    def reason(self) -> str:
        """Cause and remedy, for messages."""
        return (
            f"the function {self.name} of this scene was not sent along from the process in "
            "which it was made: define it by def at the top of a module, where other processes "
            "find it, or import cloudpickle there"
        )


@dataclass(frozen=True, eq=False)
class PicklableFunction:
    """A function in a form that is copied and pickled; the result is the function itself.

    Parameters
    ----------
    function : callable
        The function.  One that cannot be pickled, such as a lambda, is pickled by value if the
        program has loaded cloudpickle, as clusters do; otherwise the result is a `MissingFunction`.
    """

    function: Callable[..., Any]

    def __call__(self, *arguments: object) -> Any:
        """Call the function."""
        return self.function(*arguments)

    def __deepcopy__(self, memo: dict[int, Any]) -> Callable[..., Any]:
        """Return the function: functions are not copied."""
        return self.function

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any]]:
        """Pickle the function by reference, by value, or by name only."""
        if _pickle(pickle, self.function) is not None:
            return _identity, (self.function,)
        code = _pickle_by_value(self.function)
        if code is not None:
            return pickle.loads, (code,)
        return MissingFunction, (getattr(self.function, "__qualname__", repr(self.function)),)


def picklable(value: Any) -> Any:
    """Return a value in a form that is copied and pickled, whether it is a function or not."""
    return PicklableFunction(value) if callable(value) else value


def _pickle_by_value(function: Callable[..., Any]) -> bytes | None:
    """Return a function pickled by value; None without cloudpickle, and inside itself."""
    modules = (
        module for name, module in [*sys.modules.items()] if name.split(".")[-1] == "cloudpickle"
    )
    pickler = next((module for module in modules if hasattr(module, "dumps")), None)
    functions = _in_progress.__dict__.setdefault("functions", set())
    if pickler is None or id(function) in functions:
        return None
    functions.add(id(function))
    try:
        return _pickle(pickler, function)
    finally:
        functions.remove(id(function))


def _pickle(pickler: Any, function: Callable[..., Any]) -> bytes | None:
    try:
        return bytes(pickler.dumps(function))
    except (pickle.PicklingError, AttributeError, TypeError):
        return None


def _identity(function: Callable[..., Any]) -> Callable[..., Any]:
    return function
