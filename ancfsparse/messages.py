"""How messages show a value, and which names they suggest."""

from __future__ import annotations

import reprlib
import sys
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

# Integers beyond have no floating-point number, and cannot even be printed from 4300 digits on.
MAX_INTEGER = int(sys.float_info.max)


def format_value(value: object) -> str:
    """Write what was given in one short line, whatever it is.

    Parameters
    ----------
    value : object
        Anything, an array or an integer of a million digits too.

    Returns
    -------
    str
        Its ``repr``, shortened; its type where that fails.
    """
    if isinstance(value, int) and abs(value) > MAX_INTEGER:
        return "an integer beyond 1.8e308"
    try:
        return " ".join(_SHORT.repr(value).split())
    except Exception:  # a repr of the caller's may raise anything
        return f"an object of type {type(value).__name__}"


def checksum(data: bytes) -> str:
    """Return 16 digits that stand for data too long to show."""
    digest: str = _sha256()(data).hexdigest()
    return digest[:16]


@cache
def _sha256() -> Any:
    """Return the function of the lean module, as `random` of the standard library does.

    `hashlib` loads OpenSSL, which takes longer than to set up a small scene.
    """
    for name in ("_sha2", "_sha256"):  # since Python 3.12, and before
        with suppress(ImportError):
            return import_module(name).sha256
    return import_module("hashlib").sha256


class _Short(reprlib.Repr):
    """Keep texts, numbers and handles whole; shorten long tables."""

    def __init__(self) -> None:
        super().__init__()
        self.maxstring = self.maxlong = self.maxother = 80

    def repr_int(self, x: int, level: int) -> str:
        """Write an integer that may have more digits than Python prints."""
        return format_value(x) if abs(x) > MAX_INTEGER else super().repr_int(x, level)


_SHORT = _Short()


def suggest_names(name: object, valid: Iterable[str]) -> str:
    """List the names that are valid, the nearest one first.

    Parameters
    ----------
    name : object
        What was given; anything but a string has no nearest name.
    valid : iterable of str
        The names that would have been understood.

    Returns
    -------
    str
        For example ``did you mean 'thin'? Valid are 'l2t2', 'thin', 'thick'``.
    """
    names = list(valid)
    listing = "valid are " + ", ".join(repr(each) for each in names)
    import difflib  # for this message alone

    near = difflib.get_close_matches(name.lower(), names, 1, 0.5) if isinstance(name, str) else []
    return f"did you mean {near[0]!r}? V{listing[1:]}" if near else listing


def format_numbers(values: ArrayLike) -> str:
    """Write numbers with nine digits each, which distinguish what rounding does not make."""
    if not (isinstance(values, tuple) and values and isinstance(values[0], float)):
        values = np.ravel(values).astype(float).tolist()  # fractions have no digits
    return "(" + ", ".join([f"{each:.9g}" for each in values]) + ")"
