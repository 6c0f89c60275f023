"""Errors about arguments."""

from __future__ import annotations

from typing import Any

from ancfsparse.errors.message import MessageStyle, MessageTemplate, Parameter, python_style


class AncfError(Exception):
    """Base class of the errors of ancfsparse.

    Errors with several arguments are dataclasses.
    """

    def __post_init__(self) -> None:
        """Keep all arguments in `args`, so that a dataclass survives pickling between processes."""
        self.args = tuple(vars(self).values())

    def message(self, style: MessageStyle = python_style) -> str:
        """Return the message in a style."""
        return super().__str__()

    def __str__(self) -> str:
        """Return the message in Python style."""
        return self.message()


class InputError(AncfError, ValueError):
    """An argument is invalid: its value, name or shape.

    Parameters
    ----------
    text : str
        Description of the fault with place, amount and advice; a template if there are values.
    values
        Values of the fields, see `MessageTemplate`: ``dt=Parameter("dt", "0.003 s")``.
    """

    def __init__(self, text: str = "", /, **values: Any) -> None:
        super().__init__(text)
        self.values = values

    @property
    def parameter(self) -> str | None:
        """Name of the invalid argument, None if the message does not name it."""
        named = (each.name for each in self.values.values() if isinstance(each, Parameter))
        return next(named, None)

    def message(self, style: MessageStyle = python_style) -> str:
        """Return the message in a style."""
        return MessageTemplate(str(self.args[0]), **self.values).format(style)


class SingularSceneError(InputError):
    """The scene leaves a motion or a force undetermined."""


class RedundantConstraintsWarning(UserWarning):
    """Redundant constraints: the motion is determined, but not their constraint forces."""
