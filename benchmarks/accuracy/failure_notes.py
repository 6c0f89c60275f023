"""Runs without result in the charts: numbered markers, and their reasons below."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from itertools import zip_longest
from typing import cast

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.transforms import blended_transform_factory

from benchmarks.accuracy.comparison import failure, grouped_failures
from benchmarks.accuracy.models import MODELS
from benchmarks.accuracy.timed_runs import Point
from benchmarks.common.charts import LETTER_SIZE, NOTE_SIZE

NOTE_LETTERS = 71  # letters of a line in a column of notes

MODEL_COLOURS = dict(
    zip(MODELS, ("#0072b2", "#009e73", "#e69f00", "#d55e00", "#cc79a7"), strict=True)
)
"""One colour per model, also for colour-blind eyes."""


def mark_failures(
    ax: Axes, points: Sequence[Point], colour: Callable[[Point], str], notes: list[str]
) -> None:
    """Put a numbered hollow marker at the top edge for each failure, and its reason into notes.

    Curves are drawn already, and each point has the colour of its own; `notes` holds the lines of
    all panels so far, to which the new ones are appended.
    """
    groups = grouped_failures(points)
    place = blended_transform_factory(ax.transAxes, ax.transAxes)
    for column, (key, members) in enumerate(groups.items()):
        x = 0.98 - 0.045 * column
        notes.append(f"{len(notes) + 1}: {failure(*key, members)}")
        ax.plot(
            x, 0.965, "o", transform=place, markerfacecolor="none", markersize=8,
            markeredgecolor=colour(members[0]), clip_on=False,
        )  # fmt: skip
        ax.annotate(
            str(len(notes)),
            (x, 0.91),
            xycoords=place,
            ha="center",
            va="center",
            fontsize=LETTER_SIZE,
        )
    if groups:
        low, high = ax.get_ylim()
        ax.set_ylim(low, high * (high / low) ** 0.12)  # room for them above the curves


def write_notes(figure: Figure, notes: Sequence[str]) -> None:
    """Set the reasons of the hollow markers in two columns below all else.

    Parameters
    ----------
    figure : Figure
        Of constrained layout, complete otherwise with one key; it grows by the height of the notes.
    notes : sequence of str
        As `mark_failures` leaves them.
    """
    if not notes:
        return
    half = -(-len(notes) // 2)
    columns = [_wrapped(part) for part in (notes[:half], notes[half:])]
    lines = [
        f"{left:<{NOTE_LETTERS + 2}}{right}".rstrip()
        for left, right in zip_longest(*columns, fillvalue="")
    ]
    # The layout keeps one thing free below the panels: here that is the notes with the key on them.
    above = figure.get_figheight()
    below = (len(lines) + 2) * 1.3 * NOTE_SIZE / 72.0
    keys = [legend.get_window_extent().height / figure.dpi for legend in figure.legends]
    figure.set_figheight(above + below)
    fraction, floor = below / (above + below), (below + sum(keys)) / (above + below)
    cast(ConstrainedLayoutEngine, figure.get_layout_engine()).set(rect=(0, floor, 1, 1 - floor))
    for legend in figure.legends:
        legend.set_bbox_to_anchor((0, fraction, 1, floor - fraction), figure.transFigure)
    figure.text(
        0.01, fraction, "\n".join(["hollow markers, runs without result", *lines]),
        fontsize=NOTE_SIZE, va="top", family="monospace",
    )  # fmt: skip


def _wrapped(notes: Sequence[str]) -> list[str]:
    return [
        line for each in notes
        for line in textwrap.wrap(each, NOTE_LETTERS, subsequent_indent=4 * " ")
    ]  # fmt: skip
