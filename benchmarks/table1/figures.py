"""Figures 1 and 2 of the paper, from the runs of table 1."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator
from scipy.ndimage import maximum_filter1d

from ancfsparse.array_types import Vector
from ancfsparse.results.geometry.deformed_shape import trace_elements
from ancfsparse.results.geometry.scene_outline import make_part
from benchmarks.common import paper
from benchmarks.table1.table import Results

SNAPSHOTS = 11  # shapes in figure 1
PIECES = 12  # straight pieces of an element
WINDOW = 11  # output times whose largest difference is drawn

COLOURS = {
    "Broyden": "#e69f00", "Davidon": "#0072b2", "DFP": "#009e73", "BFGS": "#cc79a7",
    "RK23": "#56b4e9", "LSODA": "#d55e00", "Radau": "#333333",
}  # fmt: skip
"""One colour per method, distinguished by colour-blind eyes too."""


def figure1(table: Results) -> Figure:
    """Draw snapshots of the motion."""
    run, rod = table.motion, table.problem.rod
    figure = Figure(figsize=(7.2, 3.9), layout="constrained")
    ax = figure.add_subplot()
    rows = np.linspace(0, len(run.t) - 1, SNAPSHOTS).round().astype(int)
    elements = trace_elements(run.q[rows], make_part(run.system, rod), PIECES)
    lines = elements.reshape(SNAPSHOTS, -1, elements.shape[-1])[..., :2]  # x and y, also in space
    nodes = [*range(0, lines.shape[1], PIECES + 1), lines.shape[1] - 1]
    colours = mpl.colormaps["viridis_r"](np.linspace(0.2, 0.95, SNAPSHOTS))
    for row, line, colour in zip(rows, lines, colours, strict=True):
        ax.plot(
            *line.T, "-o", color=colour, markevery=nodes, markersize=3, linewidth=1.6,
            label=f"{run.t[row]:.3g} s",
        )  # fmt: skip
    ax.plot(0.0, 0.0, "k^", markersize=9)
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    ax.grid(alpha=0.3)
    ax.set_aspect("equal", adjustable="box")
    ax.yaxis.set_major_locator(MultipleLocator(0.5))
    ax.legend(title="time", fontsize="small", loc="center left", bbox_to_anchor=(1.01, 0.5))
    ax.set_title(
        f"A rod of {rod.length:g} m pinned at one end falls from rest and bends as it swings",
        fontsize="medium",
    )
    return figure


def figure2(table: Results) -> Figure:
    """Draw differences in vertical tip position between methods, and from the exact motion."""
    row = "Thin" if "Thin" in table.rows else table.rows[0]
    height = {
        column: cell.tip[:, 1]
        for (name, column), cell in table.cells.items()
        if name == row and cell.tip is not None
    }
    exact = table.references[row][:, 1]
    figure = Figure(figsize=(7.2, 8.4), layout="constrained")
    among, against, off = figure.subplots(3, 1, sharex=True)
    figure.suptitle(f"Differences in the vertical position of the tip, {row} element")

    pairs = [("Davidon", each) for each in paper.QUASI_NEWTON if each != "Davidon"]
    _draw(among, "Quasi-Newton methods", table.t, _between(pairs, height))
    pairs = [("Davidon", "Radau"), ("RK23", "Radau")]
    _draw(against, "From the stand-in for ode23t", table.t, _between(pairs, height))
    shown = [each for each in ("Davidon", *paper.ODE_FUNCTIONS) if each in height]
    errors = {each: (each, height[each] - exact) for each in shown}
    _draw(off, "From the motion converged in time", table.t, errors)
    off.set_xlabel("time [s]")
    return figure


def _between(
    pairs: Sequence[tuple[str, str]], height: Mapping[str, Vector]
) -> dict[str, tuple[str, Vector]]:
    """Return the finished differences, with the method that gives each its colour."""
    return {
        f"{a} – {b}": (a if b == "Radau" else b, height[a] - height[b])
        for a, b in pairs
        if a in height and b in height
    }


def _draw(ax: Axes, title: str, t: Vector, curves: Mapping[str, tuple[str, Vector]]) -> None:
    """Draw the sizes of differences over time, and state the largest of each in the key.

    A difference that oscillates crosses zero all the time; drawn is the largest nearby.
    """
    largest = [float(np.abs(each).max()) for _, each in curves.values()]
    for (name, (colour, difference)), most in zip(curves.items(), largest, strict=True):
        nearby = maximum_filter1d(np.abs(difference), WINDOW)
        label = f"{name}: {most:.1e} m"
        ax.plot(t[1:], nearby[1:], color=COLOURS[colour], linewidth=1.4, label=label)
    if largest:
        ax.set_yscale("log")
        top = max(largest)
        ax.set_ylim(1e-5 * top, 3.0 * top)
        ax.legend(fontsize="small", loc="lower right", ncols=len(largest))
    ax.set_ylabel(f"largest within ± {t[WINDOW // 2] - t[0]:.2g} s [m]")
    ax.set_title(title, fontsize=10)
    ax.grid(alpha=0.3)
