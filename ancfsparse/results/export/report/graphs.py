"""Graphs of a report, drawn by matplotlib as SVG inside the page."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

SIZE = 5.2, 2.9  # inch
POINTS = 72.0  # units of SVG per inch
STYLE: Any = {
    "svg.fonttype": "none",  # letters as text
    "svg.hashsalt": "ancfsparse",  # equal pages from equal runs
    "font.size": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
}


def make_graph(draw: Callable[..., object], times: tuple[float, float] | None = None) -> str:
    """Return a graph as HTML.

    Parameters
    ----------
    draw : callable
        Draws into axes, its argument ``ax``.
    times : (float, float), optional
        First and last time of a graph over time [s]; the page shows the present time in it.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=SIZE, layout="constrained")
        axes = figure.subplots()
        draw(ax=axes)
        if times is not None:
            margin = 0.02 * (times[1] - times[0])
            axes.set_xlim(times[0] - margin, times[1] + margin)
        file = io.StringIO()
        figure.savefig(file, format="svg", transparent=True, metadata={"Date": None})
    text = file.getvalue()
    svg = text[text.index("<svg") :]
    if times is None:
        return f"<figure>{svg}</figure>"
    ends = axes.transData.transform([(time, 0.0) for time in times])[:, 0] * POINTS / figure.dpi
    box, height = axes.get_position(), SIZE[1] * POINTS
    numbers = np.array([*ends, height * (1.0 - box.y1), height * (1.0 - box.y0), *times])
    return f'<figure data-axis="{" ".join(f"{x:.9g}" for x in numbers)}">{svg}</figure>'
