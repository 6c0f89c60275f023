"""Progress bars by tqdm, imported only if one is drawn."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Any


class _NullBar:
    """A progress bar that is not drawn."""

    n = 0

    def update(self, steps: int = 1) -> None:
        """Do nothing."""

    def set_postfix_str(self, text: str) -> None:
        """Do nothing."""


def progress_bar(unit: str, is_drawn: bool, total: int | None = None) -> Any:
    """Return a context manager that yields a bar of tqdm, or one that is not drawn.

    Parameters
    ----------
    unit : str
        Name of the counted items.
    is_drawn : bool
        Whether the bar is drawn.
    total : int, optional
        Their number.
    """
    if not is_drawn:
        return nullcontext(_NullBar())
    from tqdm import tqdm

    return tqdm(total=total, unit=unit, leave=False)
