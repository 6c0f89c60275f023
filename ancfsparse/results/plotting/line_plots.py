"""Pictures of results, drawn into axes the caller may pass and saves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from ancfsparse.checks import check_count, check_finite, check_reals
from ancfsparse.errors import InputError
from ancfsparse.messages import shown
from ancfsparse.results.data.solved_system import Array
from ancfsparse.results.geometry.deformed_shape import rows_of, shapes
from ancfsparse.results.geometry.scene_outline import part_of
from ancfsparse.results.solutions.trajectory import Trajectory
from ancfsparse.scene import Beam, ElasticBody, Mesh

Rows = NDArray[np.intp]


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

    Raises
    ------
    InputError
        If an argument is invalid, or the beam is a mesh, which has no single line.
    """
    if isinstance(beam, Mesh):
        raise InputError(
            f"{beam.name} is a mesh, which has no single centre line: use edge_lines, which traces "
            "every edge"
        )
    return _joined(edge_lines(trajectory, beam, states, per_element), gaps=False)[0]


def edge_lines(
    trajectory: Trajectory, body: ElasticBody, states: ArrayLike, per_element: int = 12
) -> Array:
    """Trace the deformed shape of every edge of a mesh, or of every element of a beam.

    Parameters
    ----------
    trajectory : Trajectory
        The motion.
    body : Beam or Mesh
        One of its bodies.
    states : array_like of int, shape (j,)
        Which saved states.
    per_element : int, optional
        Pieces per element.

    Returns
    -------
    ndarray, shape (j, n_elements, per_element + 1, dim)
        Points on each edge [m], from its first node, as given, to its second: the cubic through
        positions and slopes at both ends.

    Raises
    ------
    InputError
        If an argument is invalid.
    """
    _check_run(trajectory)
    if not isinstance(body, ElasticBody):
        raise InputError(f"a beam or a mesh of the run is needed, got {shown(body)}")
    rows = _check_states(states, len(trajectory.t))
    pieces = check_count("per_element", per_element)
    lines = shapes(rows_of(trajectory.q, rows), part_of(trajectory.system, body), pieces)
    if isinstance(body, Mesh):
        lines[:, body.flipped] = lines[:, body.flipped, ::-1]
    return lines


def snapshots(
    trajectory: Trajectory,
    body: ElasticBody,
    times: Sequence[float],
    ax: Axes | None = None,
    plane: tuple[int, int] = (0, 1),
) -> Axes:
    """Draw a beam or a mesh at chosen times, early ones light and late ones dark.

    Parameters
    ----------
    trajectory : Trajectory
        The motion.
    body : Beam or Mesh
        What to draw: of a mesh, every edge.
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

    Raises
    ------
    InputError
        If an argument is invalid, or a time lies outside the run.
    """
    _check_run(trajectory)
    instants = check_reals("times of snapshots", times, "a list of times in s")
    if instants.ndim != 1 or not instants.size:
        raise InputError(
            f"times of snapshots must be a list such as [0.0, 0.5], got {shown(times)}"
        )
    rows = [nearest(trajectory.t, time) for time in instants]
    lines = edge_lines(trajectory, body, rows)
    across, up = _check_plane(plane, body.dim)
    ax = _axes(ax, (6.4, 4.8))
    path, nodes = _joined(lines, isinstance(body, Mesh))
    colours = plt.get_cmap("viridis_r")(np.linspace(0.2, 0.95, len(rows)))
    for row, line, colour in zip(rows, path, colours, strict=True):
        ax.plot(
            line[:, across], line[:, up], "-o", color=colour, markevery=nodes, markersize=3,
            linewidth=1.6, label=f"{trajectory.t[row]:.3g} s",
        )  # fmt: skip
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel(f"{'xyz'[across]} [m]")
    ax.set_ylabel(f"{'xyz'[up]} [m]")
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

    Raises
    ------
    InputError
        If an argument is invalid, or the curves do not have the times of the reference.
    """
    instants = check_reals("times of curves", t, "a list of times in s")
    base = check_reals("reference of curves", reference, "a table of positions, one row per time")
    if not isinstance(curves, Mapping) or not curves:
        raise InputError(
            "curves must be given by name, such as {'davidon': run.position(rod.end)}, got "
            f"{shown(curves)}"
        )
    if not isinstance(against, str):
        raise InputError(f"against must be a string, the label of the axis, got {shown(against)}")
    if instants.ndim != 1 or base.ndim != 2 or len(base) != len(instants):
        raise InputError(
            "times must have shape (k,) and the reference (k, dim), got shapes "
            f"{instants.shape} and {base.shape}"
        )
    distances = {}
    for name, given in curves.items():
        positions = check_reals(f"curve {name!r}", given, "a table of positions, one row per time")
        if positions.shape != base.shape:
            raise InputError(
                f"curve {name!r} has shape {positions.shape}, but the reference has "
                f"{base.shape} and there are {len(instants)} times: save the same times in all runs"
            )
        distances[name] = np.linalg.norm(positions - base, axis=1)
    ax = _axes(ax, (6.4, 4.0))
    for name, distance in distances.items():
        ax.plot(instants, np.where(distance > 0.0, distance, np.nan), linewidth=1.2, label=name)
    ax.set_yscale("log")
    ax.set_xlabel("time [s]")
    ax.set_ylabel(f"distance from {against} [m]")
    ax.grid(alpha=0.3)
    ax.legend(fontsize="small")
    return ax


def _check_run(trajectory: object) -> None:
    if not isinstance(trajectory, Trajectory):
        raise InputError(f"a Trajectory of simulate is needed, got {shown(trajectory)}")


def _check_states(states: ArrayLike, n: int) -> Rows:
    """Return the numbers of saved states as an array of integers."""
    rows = check_reals("states", states, "a list of numbers of saved states")
    if rows.ndim != 1 or not rows.size or np.any(rows != np.round(rows)):
        raise InputError(f"states must be a list of integers such as [0, 10], got {shown(states)}")
    outside = (rows < -n) | (rows >= n)
    if outside.any():
        raise InputError(
            f"the run has saved states 0 to {n - 1}, there is no state {rows[outside][0]:g}"
        )
    return rows.astype(np.intp)


def _check_plane(plane: object, dim: int) -> tuple[int, int]:
    """Return the two components that are drawn."""
    valid = range(dim)
    if not (
        isinstance(plane, Sequence)
        and len(plane) == 2
        and all(isinstance(each, (int, np.integer)) and each in valid for each in plane)
        and plane[0] != plane[1]
    ):
        choices = "(0, 1)" if dim == 2 else "(0, 1), (0, 2) or (1, 2)"
        raise InputError(
            f"plane must be two different components of {'xyz'[:dim]}, {choices}, in either order, "
            f"got {shown(plane)}"
        )
    return int(plane[0]), int(plane[1])


def _axes(ax: object, size: tuple[float, float]) -> Axes:
    """Return the axes given, or those of a new figure of a size [inch]."""
    if ax is None:
        return plt.subplots(figsize=size, layout="constrained")[1]
    if not isinstance(ax, Axes):
        raise InputError(f"ax must be axes of matplotlib, got {shown(ax)}")
    return ax


def _joined(lines: Array, gaps: bool) -> tuple[Array, list[int]]:
    """Join the edges (j, e, p, dim) of each state to one path, and locate the nodes in it.

    With gaps, edges are apart; without, each begins where the last ends.
    """
    j, e, p, dim = lines.shape
    if gaps:
        apart = np.full((j, e, 1, dim), np.nan)
        path = np.concatenate([lines, apart], axis=2).reshape(j, -1, dim)
        return path, [k * (p + 1) + end for k in range(e) for end in (0, p - 1)]
    path = np.concatenate([lines[:, :, :-1].reshape(j, -1, dim), lines[:, -1, -1:]], axis=1)
    return path, [k * (p - 1) for k in range(e + 1)]


def nearest(t: Array, time: float) -> int:
    """Return the number of the saved state that is nearest to a time [s]."""
    wanted = check_finite("time of a snapshot", time, "s")
    slack = 1e-9 * max(abs(float(t[0])), abs(float(t[-1])))
    if not t[0] - slack <= wanted <= t[-1] + slack:
        raise InputError(
            f"no state was saved at t = {wanted:.6g} s: the run goes from {t[0]:.6g} s "
            f"to {t[-1]:.6g} s"
        )
    return int(np.argmin(np.abs(t - wanted)))
