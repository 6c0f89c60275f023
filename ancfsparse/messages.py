"""Formatting of values in messages, and suggestions for misspelt names."""

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

MAX_INTEGER = int(sys.float_info.max)  # largest integer with a floating-point approximation


def format_value(value: object) -> str:
    """Return the ``repr`` of any object in one short line; its type if the ``repr`` fails."""
    if isinstance(value, int) and abs(value) > MAX_INTEGER:
        return "an integer beyond 1.8e308"
    try:
        return " ".join(_SHORT_REPR.repr(value).split())
    except Exception:  # a repr of the caller's may raise anything
        return f"an object of type {type(value).__name__}"


def checksum(data: bytes) -> str:
    """Return 16 digits that identify data too long to print."""
    digest: str = _sha256()(data).hexdigest()
    return digest[:16]


@cache
def _sha256() -> Any:
    """Return SHA-256 of the extension module, as `random` of the standard library does.

    `hashlib` loads OpenSSL, which takes longer than the set-up of a small scene.
    """
    for name in ("_sha2", "_sha256"):  # since Python 3.12, and before
        with suppress(ImportError):
            return import_module(name).sha256
    return import_module("hashlib").sha256


class _Short(reprlib.Repr):
    """Shorten long tables, but not texts, numbers and handles."""

    def __init__(self) -> None:
        super().__init__()
        self.maxstring = self.maxlong = self.maxother = 80

    def repr_int(self, x: int, level: int) -> str:
        """Return an integer, also with more digits than Python prints."""
        return format_value(x) if abs(x) > MAX_INTEGER else super().repr_int(x, level)


_SHORT_REPR = _Short()


def suggest_names(name: object, valid: Iterable[str]) -> str:
    """List the valid names, and the one most similar to an invalid name, if that is a string.

    For example ``did you mean 'thin'? Valid are 'l2t2', 'thin', 'thick'``.
    """
    names = list(valid)
    listing = "valid are " + ", ".join(repr(each) for each in names)
    import difflib  # for this message alone

    near = difflib.get_close_matches(name.lower(), names, 1, 0.5) if isinstance(name, str) else []
    return f"did you mean {near[0]!r}? V{listing[1:]}" if near else listing


def format_numbers(values: ArrayLike) -> str:
    """Return numbers with nine digits each, fewer than rounding errors change."""
    if not (isinstance(values, tuple) and values and isinstance(values[0], float)):
        values = np.ravel(values).astype(float).tolist()  # fractions have no digits
    return "(" + ", ".join([f"{each:.9g}" for each in values]) + ")"
