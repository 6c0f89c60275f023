"""Pictures of results, drawn into axes the caller may pass and saves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from ancfsparse.checks import check_finite
from ancfsparse.errors import InputError
from ancfsparse.kernels.hermite import position_weights
from ancfsparse.results.source import Array
from ancfsparse.results.trajectory import Trajectory
from ancfsparse.scene import Beam


def centre_line(
    trajectory: Trajectory, beam: Beam, states: ArrayLike, per_element: int = 12
) -> Array:
    """Trace the deformed centre line of a beam.

    Parameters
    ----------
    trajectory : Trajectory
        The motion.
    beam : Beam
        One of its beams.
    states : array_like of int, shape (j,)
        Which saved states.
    per_element : int, optional
        Pieces per element.

    Returns
    -------
    ndarray, shape (j, n_elements * per_element + 1, dim)
        Points on the line [m]: the cubic through the positions and slopes of the nodes.
    """
    rows = np.asarray(states, dtype=np.intp)
    nodes = [beam.node(i) for i in range(beam.n_nodes)]
    position = np.stack([trajectory.position(each)[rows] for each in nodes], axis=1)
    slope = np.stack([trajectory.slope(each)[rows] for each in nodes], axis=1)
    length = beam.length / beam.n_elements
    xi = np.linspace(0.0, 1.0, per_element, endpoint=False)
    shape = position_weights(xi, length)
    ends = np.stack([position[:, :-1], slope[:, :-1], position[:, 1:], slope[:, 1:]], axis=2)
    inner = np.einsum("pc,jecd->jepd", shape, ends).reshape(len(rows), -1, beam.dim)
    return np.concatenate([inner, position[:, -1:]], axis=1)


def snapshots(
    trajectory: Trajectory,
    beam: Beam,
    times: Sequence[float],
    ax: Axes | None = None,
    plane: tuple[int, int] = (0, 1),
) -> Axes:
    """Draw a beam at chosen times, early ones light and late ones dark.

    Parameters
    ----------
    trajectory : Trajectory
        The motion.
    beam : Beam
        The beam to draw.
    times : sequence of float
        Times [s]; the nearest saved state is drawn and its time is written in the legend.
    ax : Axes, optional
        Where to draw; a new figure if not given.
    plane : tuple of int, optional
        The two components that are drawn, x and y by default.

    Returns
    -------
    Axes
        The axes drawn into.
    """
    rows = [_nearest(trajectory.t, time) for time in times]
    if ax is None:
        _, ax = plt.subplots(figsize=(6.4, 4.8), layout="constrained")
    lines = centre_line(trajectory, beam, rows)
    colours = plt.get_cmap("viridis_r")(np.linspace(0.2, 0.95, len(rows)))
    ends = np.arange(0, lines.shape[1], (lines.shape[1] - 1) // beam.n_elements)
    for row, line, colour in zip(rows, lines, colours, strict=True):
        across, up = line[:, plane[0]], line[:, plane[1]]
        ax.plot(
            across, up, "-o", color=colour, markevery=list(ends), markersize=3, linewidth=1.6,
            label=f"{trajectory.t[row]:.3g} s",
        )  # fmt: skip
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel(f"{'xyz'[plane[0]]} [m]")
    ax.set_ylabel(f"{'xyz'[plane[1]]} [m]")
    ax.grid(alpha=0.3)
    ax.legend(title="time", fontsize="small")
    return ax


def differences(
    t: Array,
    curves: Mapping[str, Array],
    reference: Array,
    ax: Axes | None = None,
    against: str = "the reference",
) -> Axes:
    """Draw how far points are from a reference over time, on a logarithmic scale.

    Parameters
    ----------
    t : ndarray, shape (k,)
        Times [s].
    curves : mapping of str to ndarray, each of shape (k, dim)
        Positions [m] of the same point by different methods, by the name for the legend.
    reference : ndarray, shape (k, dim)
        Positions [m] they are compared with.
    ax : Axes, optional
        Where to draw; a new figure if not given.
    against : str, optional
        What the reference is, for the axis label.

    Returns
    -------
    Axes
        The axes drawn into.  States with no difference at all leave a gap.
    """
    if ax is None:
        _, ax = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
    for name, positions in curves.items():
        if positions.shape != reference.shape or len(positions) != len(t):
            raise InputError(
                f"curve {name!r} has shape {positions.shape}, but the reference has "
                f"{reference.shape} and there are {len(t)} times: save the same times in all runs"
            )
        distance = np.linalg.norm(positions - reference, axis=1)
        ax.plot(t, np.where(distance > 0.0, distance, np.nan), linewidth=1.2, label=name)
    ax.set_yscale("log")
    ax.set_xlabel("time [s]")
    ax.set_ylabel(f"distance from {against} [m]")
    ax.grid(alpha=0.3)
    ax.legend(fontsize="small")
    return ax


def _nearest(t: Array, time: float) -> int:
    wanted = check_finite("time of a snapshot", time, "s")
    slack = 1e-9 * max(abs(float(t[0])), abs(float(t[-1])))
    if not t[0] - slack <= wanted <= t[-1] + slack:
        raise InputError(
            f"no state was saved at t = {wanted:.6g} s: the run goes from {t[0]:.6g} s "
            f"to {t[-1]:.6g} s"
        )
    return int(np.argmin(np.abs(t - wanted)))
