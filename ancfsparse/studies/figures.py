"""Figures 1 and 2 of the paper, from the runs of table 1."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ancfsparse.results.plots import snapshots
from ancfsparse.studies import paper
from ancfsparse.studies.table1 import Table

Vector = NDArray[np.float64]

SNAPSHOTS = 11
COLOURS = {
    "Broyden": "#e69f00", "Davidon": "#0072b2", "DFP": "#009e73", "BFGS": "#cc79a7",
    "RK23": "#56b4e9", "LSODA": "#d55e00", "Radau": "#333333",
}  # fmt: skip
"""One colour per method, told apart by colour-blind eyes too."""


def write(table: Table, folder: Path) -> list[Path]:
    """Write figure1.png and figure2.png.

    Parameters
    ----------
    table : Table
        A finished table.
    folder : Path
        Where to; made if missing.

    Returns
    -------
    list of Path
        The files.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / "figure1.png", folder / "figure2.png"]
    figure1(table).savefig(paths[0], dpi=120)
    figure2(table).savefig(paths[1], dpi=120)
    return paths


def figure1(table: Table) -> Figure:
    """Draw snapshots of the motion."""
    run, rod = table.motion, table.problem.rod
    figure = Figure(figsize=(6.4, 4.4), layout="constrained")
    ax = figure.add_subplot()
    times = run.t[-1] * np.linspace(0.0, 1.0, SNAPSHOTS)
    snapshots(run, rod, times.tolist(), ax)
    ax.plot(0.0, 0.0, "k^", markersize=8)
    ax.set_title(
        f"A rod of {rod.length:g} m pinned at one end falls from rest and bends as it swings",
        fontsize="medium",
    )
    return figure


def figure2(table: Table) -> Figure:
    """Draw differences in vertical tip position between methods, and from the exact motion."""
    row = "Thin" if "Thin" in table.rows else table.rows[0]
    height = {
        column: cell.tip[:, 1]
        for (name, column), cell in table.cells.items()
        if name == row and cell.tip is not None
    }
    exact = table.references[row][:, 1]
    figure = Figure(figsize=(6.4, 8.6), layout="constrained")
    among, against, off = figure.subplots(3, 1, sharex=True)
    figure.suptitle(f"Vertical position of the tip, {row} element", fontsize="medium")

    others = [c for c in paper.QUASI_NEWTON if c != "Davidon" and c in height]
    pairs = {f"Davidon – {c}": (c, height["Davidon"] - height[c]) for c in others}
    largest = _draw(among, table.t, pairs)
    among.set_title(f"Quasi-Newton methods differ by at most {largest:.0e} m", fontsize="medium")

    pairs = {
        f"{a} – {b}": (c, height[a] - height[b])
        for a, b, c in (("Davidon", "Radau", "Davidon"), ("Radau", "RK23", "RK23"))
        if a in height and b in height
    }
    largest = _draw(against, table.t, pairs)
    against.set_title(
        f"Newmark and SciPy at the paper's tolerances differ by at most {largest:.0e} m",
        fontsize="medium",
    )

    shown = ("Davidon", *paper.ODE_FUNCTIONS)
    pairs = {c: (c, height[c] - exact) for c in shown if c in height}
    _draw(off, table.t, pairs)
    closest = min(pairs, key=lambda c: float(np.abs(pairs[c][1]).max()))
    error = float(np.abs(pairs[closest][1]).max())
    off.set_title(
        f"Closest to the motion converged in time: {closest}, within {error:.0e} m",
        fontsize="medium",
    )
    off.set_xlabel("time [s]")
    return figure


def _draw(ax: Axes, t: Vector, curves: Mapping[str, tuple[str, Vector]]) -> float:
    """Draw sizes of differences on a logarithmic scale and return the largest."""
    for label, (colour, difference) in curves.items():
        size = np.abs(difference)
        ax.plot(
            t, np.where(size > 0.0, size, np.nan), color=COLOURS[colour], linewidth=1.1, label=label
        )
    ax.set_yscale("log")
    ax.set_ylabel("difference [m]")
    ax.grid(alpha=0.3)
    ax.legend(fontsize="small", loc="lower right")
    return max((float(np.abs(d).max()) for _, d in curves.values()), default=0.0)
