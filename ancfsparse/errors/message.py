"""Sentences about arguments, which each face of the program shows under its own names."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple


class Parameter(NamedTuple):
    """An argument in a sentence: ``dt = 0.001 s`` in Python, ``--step 0.001 s`` on a command line.

    Attributes
    ----------
    name : str
        As the library calls it.
    value : str
        With its unit; empty where the sentence names the argument alone.
    joint : str
        What Python shows between the two: ``"="`` where the sentence quotes a call; nothing shows
        the value alone.
    aside : bool
        Whether it only gives, in parentheses, the origin of a number; left out by a face that has
        no such argument.
    """

    name: str
    value: str = ""
    joint: str = " = "
    aside: bool = False


Face = Callable[[Parameter], str]
"""How a face of the program shows an argument."""


def in_python(parameter: Parameter) -> str:
    """Show an argument by its name in the library."""
    if parameter.aside:
        return f" ({parameter.name})"
    if not parameter.value:
        return parameter.name
    name = parameter.name if parameter.joint else ""
    return f"{name}{parameter.joint}{parameter.value}"


class Sentence:
    """A text with fields, as `str.format` takes them, and what stands in them.

    Parameters
    ----------
    text : str
        The sentence; without values it is taken as it is.
    values
        By the names of the fields: arguments as `Parameter`, parts of the sentence as `Sentence`,
        anything else as it is.
    """

    def __init__(self, text: str, /, **values: Any) -> None:
        self.text = text
        self.values = values

    def shown(self, face: Face = in_python) -> str:
        """Return the sentence as a face shows it."""
        if not self.values:
            return self.text
        return self.text.format(**{name: _shown(each, face) for name, each in self.values.items()})

    def __str__(self) -> str:
        """Return the sentence as the library shows it."""
        return self.shown()


def _shown(value: Any, face: Face) -> Any:
    if isinstance(value, Parameter):
        return face(value)
    return value.shown(face) if isinstance(value, Sentence) else value


def with_unit(number: float, unit: str, digits: int = 6) -> str:
    """Write a number [unit] with some digits."""
    return f"{number:.{digits}g} {unit}".rstrip()
