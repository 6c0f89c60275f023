"""Progress bars of studies."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from tqdm import tqdm


def bar(what: Iterable[Any] | int, unit: str, progress: bool) -> tqdm[Any]:
    """Draw a bar over items, or over a number of them, on a terminal if `progress` is true."""
    items, total = (None, what) if isinstance(what, int) else (what, None)
    return tqdm(items, total=total, unit=unit, disable=None if progress else True, leave=False)
