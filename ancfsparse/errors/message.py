"""Messages whose arguments are data, written in Python or in command-line style."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple


class Parameter(NamedTuple):
    """An argument in a message: ``dt = 0.001 s`` in Python, ``--step 0.001 s`` on a command line.

    Attributes
    ----------
    name : str
        Name of the argument in Python.
    value : str
        Value with its unit; empty if the message names the argument alone.
    separator : str
        Text between name and value in Python: ``"="`` for a quoted call; empty to write the value
        alone.
    is_optional : bool
        Whether the argument is a remark in parentheses, omitted in styles that do not know it.
    """

    name: str
    value: str = ""
    separator: str = " = "
    is_optional: bool = False


MessageStyle = Callable[[Parameter], str]
"""Function that writes an argument in a style."""


def python_style(parameter: Parameter) -> str:
    """Write an argument by its name in Python."""
    if parameter.is_optional:
        return f" ({parameter.name})"
    if not parameter.value:
        return parameter.name
    name = parameter.name if parameter.separator else ""
    return f"{name}{parameter.separator}{parameter.value}"


class MessageTemplate:
    """A text with fields, as `str.format` takes them, and their values.

    Parameters
    ----------
    text : str
        The message; without values it is written unchanged, with its braces.
    values
        Values by field name: arguments as `Parameter`, parts of the message as `MessageTemplate`,
        anything else unchanged.
    """

    def __init__(self, text: str, /, **values: Any) -> None:
        self.text = text
        self.values = values

    def format(self, style: MessageStyle = python_style) -> str:
        """Return the message in a style."""
        if not self.values:
            return self.text
        return self.text.format(
            **{name: _format(each, style) for name, each in self.values.items()}
        )

    def __str__(self) -> str:
        """Return the message in Python style."""
        return self.format()


def _format(value: Any, style: MessageStyle) -> Any:
    if isinstance(value, Parameter):
        return style(value)
    return value.format(style) if isinstance(value, MessageTemplate) else value


def format_quantity(number: float, unit: str, digits: int = 6) -> str:
    """Return a number with its unit."""
    return f"{number:.{digits}g} {unit}".rstrip()
