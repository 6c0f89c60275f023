"""Charts of the studies: sizes, panels, lines by columns of a table, keys."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from typing import Any, TypeVar

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from benchmarks.common.tables import group_by

# A page shows a picture 800 pixels wide, so letters of 8 points have ten pixels there.
WIDTH = 9.0  # of all charts [in]
LETTER_SIZE = 8.0  # letters [points]
NOTE_SIZE = 7.0  # letters of notes, which no finding needs [points]

Row = TypeVar("Row")
Key = TypeVar("Key", bound=Hashable)


def new_figure(height: float, title: str) -> Figure:
    """Return an empty picture of this height [in] with its title."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    figure.suptitle(title)
    return figure


def set_legend(figure: Figure, keys: Mapping[str, Any], columns: int, title: str = "") -> None:
    """Set the key of all panels below them."""
    figure.legend(
        keys.values(), keys, loc="outside lower center", ncols=columns, fontsize=LETTER_SIZE,
        title_fontsize=LETTER_SIZE, frameon=False, title=title or None,
    )  # fmt: skip


def set_axes(ax: Axes, x: str, y: str = "", log: str = "xy", title: str = "") -> None:
    """Label the axes of a panel, where curves are drawn already, and draw its grid.

    Those of ``"x"`` and ``"y"`` that `log` names are logarithmic; x beyond a decade is labelled at
    decades.
    """
    if "x" in log:
        ax.set_xscale("log")
        low, high = ax.get_xlim()
        if high > 10.0 * low:
            ax.xaxis.set_minor_formatter(NullFormatter())
    if "y" in log:
        ax.set_yscale("log")
    ax.set_xlabel(x, fontsize=LETTER_SIZE)
    ax.set_ylabel(y, fontsize=LETTER_SIZE)
    if title:
        ax.set_title(title, fontsize=LETTER_SIZE)
    ax.grid(alpha=0.3, which="major")


def panels(figure: Figure, count: int, columns: int, **shared: Any) -> list[Axes]:
    """Return the axes of a grid, row by row, without those that are not needed."""
    columns = min(columns, count)
    grid: Any = figure.subplots(-(-count // columns), columns, squeeze=False, **shared)
    axes: list[Axes] = grid.ravel().tolist()
    for ax in axes[count:]:
        ax.remove()
    return axes[:count]


def draw_lines(
    ax: Axes,
    rows: Iterable[Row],
    line: Callable[[Row], Key],
    x: Callable[[Row], float],
    y: Callable[[Row], float],
    style_of: Callable[[Key], Mapping[str, Any]],
) -> dict[str, Any]:
    """Draw y against x, a line for each value of `line`; return them by label for the key.

    `style_of` gives the style of a line and its label, empty for a line without one.
    """
    keys = {}
    for key, members in group_by(rows, line).items():
        style = {"linestyle": "-", "marker": ".", **style_of(key)}
        (drawn,) = ax.plot([x(row) for row in members], [y(row) for row in members], **style)
        keys[str(style.get("label", ""))] = drawn
    return {label: drawn for label, drawn in keys.items() if label}


def set_empty(ax: Axes, why: str) -> None:
    """Leave a panel without data blank but for why: a logarithmic axis needs data."""
    ax.set_axis_off()
    ax.text(0.5, 0.5, why, transform=ax.transAxes, ha="center", fontsize=LETTER_SIZE)
