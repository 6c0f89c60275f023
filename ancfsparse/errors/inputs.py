"""Errors about arguments."""

from __future__ import annotations

from typing import Any

from ancfsparse.errors.message import Face, Parameter, Sentence, in_python


class AncfError(Exception):
    """Base of every error that ancfsparse raises on purpose."""

    def sentence(self, face: Face = in_python) -> str:
        """Return the message as a face of the program shows it."""
        return super().__str__()

    def __str__(self) -> str:
        """Return the message as the library shows it."""
        return self.sentence()


class InputError(AncfError, ValueError):
    """An argument is invalid: its value, name or shape.

    Parameters
    ----------
    text : str
        What is wrong, where, how much, and what to try; with fields if there are values.
    values
        What stands in the fields, see `Sentence`: ``dt=Parameter("dt", "0.003 s")``.
    """

    def __init__(self, text: str = "", /, **values: Any) -> None:
        super().__init__(text)
        self.values = values

    @property
    def parameter(self) -> str | None:
        """Name of the argument that the message is about, if it names one."""
        named = (each.name for each in self.values.values() if isinstance(each, Parameter))
        return next(named, None)

    def sentence(self, face: Face = in_python) -> str:
        """Return the message as a face of the program shows it."""
        return Sentence(str(self.args[0]), **self.values).shown(face)


class SingularSceneError(InputError):
    """The scene leaves a motion undetermined, or determines one twice."""


class RedundantConstraintsWarning(UserWarning):
    """Constraints repeat others: the motion is determined, the forces of these are not."""
