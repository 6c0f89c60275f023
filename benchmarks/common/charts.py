"""What the charts of the studies have in common: sizes, findings, keys, failures in the margin."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

# A page shows a picture 800 pixels wide: what is drawn at this width [in] has letters of ten pixels
# and more if they are of 8 points; notes, which no finding needs, of 8.6 pixels.
WIDTH = 9.0
SMALL = 8.0
NOTE_SIZE = 7.0


def new_figure(height: float, title: str) -> Figure:
    """Return an empty picture of this height [in], with what it shows above it."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    figure.suptitle(title)
    return figure


def set_legend(figure: Figure, shown: Mapping[str, Any], columns: int, title: str = "") -> None:
    """Set the key of all panels below them."""
    figure.legend(
        shown.values(), shown, loc="outside lower center", ncols=columns, fontsize=SMALL,
        title_fontsize=SMALL, frameon=False, title=title or None,
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
    ax.set_xlabel(x, fontsize=SMALL)
    ax.set_ylabel(y, fontsize=SMALL)
    if title:
        ax.set_title(title, fontsize=SMALL)
    ax.grid(alpha=0.3, which="major")


def set_empty(ax: Axes, why: str) -> None:
    """Leave a panel without data blank but for why: a logarithmic axis needs data."""
    ax.set_axis_off()
    ax.text(0.5, 0.5, why, transform=ax.transAxes, ha="center", fontsize=SMALL)
