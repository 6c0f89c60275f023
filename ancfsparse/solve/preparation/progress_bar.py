"""Progress bars, which are loaded by those who look at them."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Any


class _Silent:
    """A bar that nobody sees."""

    n = 0

    def update(self, steps: int = 1) -> None:
        """Take no notice."""

    def set_postfix_str(self, text: str) -> None:
        """Take no notice."""


def progress_bar(unit: str, shown: bool, total: int | None = None) -> Any:
    """Return a context manager that gives a bar of tqdm, or one that nobody sees.

    Parameters
    ----------
    unit : str
        What is counted.
    shown : bool
        Whether the bar is drawn.
    total : int, optional
        How many there will be.
    """
    if not shown:
        return nullcontext(_Silent())
    from tqdm import tqdm

    return tqdm(total=total, unit=unit, leave=False)
