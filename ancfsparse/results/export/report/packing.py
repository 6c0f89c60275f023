"""Tables of numbers for a page: 16 bits each, second differences in time, compressed as text."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector

LEVELS = 65535  # steps of a quantized number
COMPRESSION = 9  # of gzip; level 6 makes files 2 % larger


def pack(
    contents: Mapping[str, Any], moving: Mapping[str, Vector], fixed: Mapping[str, Vector]
) -> str:
    """Return contents and tables as one text of base64.

    Parameters
    ----------
    contents : mapping
        Anything that JSON can represent.
    moving : mapping of str to ndarray, shape (k, n)
        Numbers that change in time, in k states.  They are rounded to 1 / 65535 of the range of
        their table.
    fixed : mapping of str to ndarray
        Other numbers, in single precision.

    Returns
    -------
    str
        Compressed: the length of a JSON object in four bytes, the object, and the tables.  It has
        the contents, and for every table its shape, the place of its first byte, and of those
        that move the least value and the step.
    """
    parts: list[bytes] = []
    index: dict[str, dict[str, Any]] = {}
    start = 0
    for name, table in moving.items():
        low, step, data = _quantize(table)
        index[name] = {"shape": table.shape, "start": start, "low": low, "step": step}
        parts.append(data)
        start += len(data)
    for name, table in fixed.items():
        parts.append(b"\0" * (-start % 4))  # views of a buffer begin at multiples of their size
        start += len(parts[-1])
        data = np.ascontiguousarray(table, "<f4").tobytes()
        index[name] = {"shape": table.shape, "start": start}
        parts.append(data)
        start += len(data)
    text = json.dumps({**contents, "tables": index}, allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    return compress(len(text).to_bytes(4, "little") + text + b"".join(parts))


def compress(data: bytes) -> str:
    """Return data as text of base64, compressed; equal data give equal texts."""
    return base64.b64encode(gzip.compress(data, COMPRESSION, mtime=0)).decode("ascii")


def _quantize(table: Vector) -> tuple[float, float, bytes]:
    """Return least value, step, and bytes of a table: all low ones, then all high ones."""
    low = float(table.min()) if table.size else 0.0
    step = (float(table.max()) - low) / LEVELS if table.size else 0.0
    levels = np.rint((table - low) / step) if step else np.zeros(table.shape)
    numbers = levels.astype(np.int64).T  # each column over all times
    # Smooth motions have small second differences; the numbers before the first are zero.
    data = np.diff(np.diff(numbers, axis=1, prepend=0), axis=1, prepend=0) & LEVELS
    halves = (data & 255).astype(np.uint8), (data >> 8).astype(np.uint8)
    return low, step, b"".join(half.tobytes() for half in halves)
