"""Plots of motions and equilibria: shapes, and quantities over time or along a beam."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice, check_finite, check_reals
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.results.data.index_checks import check_index
from ancfsparse.results.fields.energy_balance import ENERGIES, Energy
from ancfsparse.results.fields.motion import UNITS, Motion
from ancfsparse.results.fields.quantities import (
    QUANTITIES,
    components_of,
    evaluate_along,
    evaluate_history,
    label_of,
    select_states,
)
from ancfsparse.results.geometry.deformed_shape import read_rows
from ancfsparse.results.geometry.scene_outline import Outline, make_outline
from ancfsparse.results.plotting.canvas import Canvas
from ancfsparse.results.plotting.colours import Colours, draw_coloured, evaluate_colours
from ancfsparse.results.plotting.traced_scene import trace_scene
from ancfsparse.scene import Body, Point
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.system import System

N_TIMES = 6  # shapes by default
RANGE = "minimum", "mean", "maximum"  # curves of a range graph
MODE_AMPLITUDE = 0.1  # of a mode, over the extent of the scene


def plot_motion(
    run: Motion,
    what: str = "shape",
    of: Body | Point | None = None,
    *,
    times: ArrayLike | None = None,
    ax: Axes | None = None,
    view: str | tuple[float, float] | None = None,
    colour: str | None = None,
) -> Axes:
    """Plot shapes at some times, or a quantity; see `Trajectory.plot`."""
    check_choice("what to plot", what, ("shape", "energy", *UNITS, *QUANTITIES))
    if what == "shape" and colour is None:
        return draw_shapes(outline_for(run.system, of), run.t, run.q, times, ax, view)
    if what == "shape":
        rows = nearest_rows(run.t, run.t[-1] if times is None else times)
        states, outline = select_states(run, rows), outline_for(run.system, of)
        return _draw_coloured(run.system, outline, states, colour, ax, view)
    _refuse_options_of_shapes(what, view=view, colour=colour)
    if what == "energy":
        return _plot_energies(run, of, times, ax)
    if isinstance(of, Point):
        if times is not None:
            raise InputError(f"{what} of {of!r} is plotted over all times: leave times out")
        return _plot_over_time(run, what, of, ax)
    if what in UNITS:
        raise InputError(
            f"{what} is a quantity of a point, such as rod.end, got {format_value(of)}"
        )
    if isinstance(times, str) and times == "range":
        return _plot_along(run.system, select_states(run), what, of, ax, RANGE)
    rows = nearest_rows(run.t, times)
    labels = [f"{run.t[row]:.3g} s" for row in rows]
    ax = _plot_along(run.system, select_states(run, rows), what, of, ax, labels)
    ax.legend(title="time", fontsize="small")
    return ax


def colours_of(
    run: Motion, colour: str | None, outline: Outline
) -> Callable[[NDArray[np.intp]], Colours] | None:
    """Return a function that evaluates a quantity in some saved states, None without a quantity."""
    if colour is None:
        return None
    return lambda rows: evaluate_colours(run.system, select_states(run, rows), colour, outline)


def draw_shapes(
    outline: Outline,
    t: Vector,
    q: Vector,
    times: ArrayLike | None = None,
    ax: Axes | None = None,
    view: str | tuple[float, float] | None = None,
) -> Axes:
    """Plot shapes at some of the times t; parameters as in `Trajectory.plot`, q of shape (k, n)."""
    rows = nearest_rows(t, times)
    canvas = Canvas(trace_scene(outline, read_rows(q, rows), t[rows]), ax, view)
    for k, (row, colour) in enumerate(zip(rows, _time_colours(len(rows)), strict=True)):
        canvas.draw(k, colour, label=f"{t[row]:.3g} s")
    canvas.draw_supports(len(rows) - 1)
    canvas.add_legend("time")
    return canvas.ax


def _draw_coloured(
    system: System,
    outline: Outline,
    states: StateHistory,
    colour: object,
    ax: Axes | None,
    view: str | tuple[float, float] | None,
) -> Axes:
    """Plot shapes with colours for a quantity of the elements."""
    colours = evaluate_colours(system, states, colour, outline)
    canvas = Canvas(trace_scene(outline, states.q, states.t), ax, view)
    draw_coloured(canvas, colours)
    canvas.draw_supports(len(states.t) - 1)
    return canvas.ax


def plot_equilibrium(
    system: System,
    states: StateHistory,
    what: str = "shape",
    of: Body | None = None,
    *,
    ax: Axes | None = None,
    view: str | tuple[float, float] | None = None,
    colour: str | None = None,
) -> Axes:
    """Plot an equilibrium and its reference shape, or a quantity; see `Equilibrium.plot`."""
    check_choice("what to plot", what, ("shape", *QUANTITIES))
    if what != "shape":
        _refuse_options_of_shapes(what, view=view, colour=colour)
        return _plot_along(system, states, what, of, ax, [""])
    outline = outline_for(system, of)
    if colour is not None:
        return _draw_coloured(system, outline, states, colour, ax, view)
    canvas = Canvas(trace_scene(outline, np.stack([system.q_ref, states.q[0]])), ax, view)
    canvas.draw(0, "0.7", label="reference")
    canvas.draw(1, "C0", label="equilibrium")
    canvas.draw_supports(1)
    canvas.add_legend()
    return canvas.ax


def plot_mode(
    system: System,
    q: Vector,
    unit: Vector,
    amplitude: float | None,
    name: str,
    *,
    ax: Axes | None = None,
    view: str | tuple[float, float] | None = None,
) -> Axes:
    """Plot both extreme shapes of a mode about q, `unit` times an amplitude; see `Modes.plot`."""
    outline = outline_for(system, None)
    if amplitude is None:
        amplitude = MODE_AMPLITUDE * float(
            np.max(np.ptp(trace_scene(outline, q[None]).box, axis=0))
        )
    change = amplitude * unit
    canvas = Canvas(trace_scene(outline, np.stack([q, q + change, q - change])), ax, view)
    canvas.draw(0, "0.7", label="at rest")
    canvas.draw(1, "C0", label=name)
    canvas.draw(2, "C0", alpha=0.35)
    canvas.draw_supports(0)
    canvas.add_legend()
    return canvas.ax


def plot_load_path(
    displacements: Vector,
    factors: Vector,
    stable: NDArray[np.bool_],
    turns: NDArray[np.intp],
    axis: int,
    ax: Axes | None,
) -> Axes:
    """Plot load factors (k,) over the displacements (k, dim) of a point; see `LoadPath.plot`."""
    ax = _prepare_axes(ax)
    axis = check_index("axis", axis, displacements.shape[1])
    x = displacements[:, axis]
    ax.plot(x, factors, "C0--", linewidth=1.0)
    ax.plot(x, np.where(stable, factors, np.nan), "C0-", linewidth=1.8)
    ax.plot(x[turns], factors[turns], "ko", markersize=4)
    ax.set_xlabel(f"displacement along {'xyz'[axis]} [m]")
    ax.set_ylabel("load factor [-]")
    return ax


def _plot_energies(run: Motion, of: object, times: ArrayLike | None, ax: Axes | None) -> Axes:
    if of is not None or times is not None:
        raise InputError("energies are of the entire scene over all times: leave of and times out")
    return draw_energies(run.t, run.energy, ax)


def draw_energies(t: Vector, energy: Energy, ax: Axes | None = None) -> Axes:
    """Plot all energies that are not zero over times t (k,) [s]."""
    ax = _prepare_axes(ax)
    for name in ENERGIES:
        values = getattr(energy, name)
        if values.any():
            style = "k--" if name == "total" else "-"
            ax.plot(t, values, style, label=name.replace("_", " "), linewidth=1.4)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("energy [J]")
    ax.legend(fontsize="small")
    return ax


def _plot_over_time(run: Motion, what: str, point: Point, ax: Axes | None) -> Axes:
    values = evaluate_history(run, point, what)
    label = f"{what} [{UNITS[what]}]" if what in UNITS else label_of(what)
    ax = _prepare_axes(ax)
    for values_of, name in components_of(values, what, point.beam):
        ax.plot(run.t, values_of, linewidth=1.4, label=name or None)
    ax.set_title(repr(point), fontsize="medium")
    ax.set_xlabel("time [s]")
    ax.set_ylabel(label)
    if values.ndim > 1:
        ax.legend(fontsize="small")
    return ax


def _plot_along(
    system: System,
    states: StateHistory,
    what: str,
    of: object,
    ax: Axes | None,
    labels: Sequence[str],
) -> Axes:
    """Plot a quantity along a beam, one curve for every state, or the curves of `RANGE`."""
    line, arcs, values = evaluate_along(system, states, what, of)
    ax = _prepare_axes(ax)
    if labels is RANGE:
        values = np.stack([values.min(axis=0), values.mean(axis=0), values.max(axis=0)])
        for low, high in zip(*(np.atleast_2d(each.T) for each in values[::2]), strict=True):
            ax.fill_between(arcs, low, high, color="C0", alpha=0.1, linewidth=0.0)
    styles, colours = ("-", "--", ":"), ["C0"] if len(labels) == 1 else _time_colours(len(labels))
    for state, colour, label in zip(values, colours, labels, strict=True):
        for (component, name), style in zip(components_of(state, what, line), styles, strict=False):
            text = ", ".join(part for part in (label, name) if part)
            ax.plot(arcs, component, style, marker=".", color=colour, linewidth=1.4, label=text)
    ax.set_title(line.name, fontsize="medium")
    ax.set_xlabel("arc coordinate s [m]")
    ax.set_ylabel(label_of(what))
    if values.ndim > 2 or labels is RANGE:
        ax.legend(fontsize="small")
    return ax


def _refuse_options_of_shapes(what: str, **options: object) -> None:
    """Refuse options of shapes for a quantity."""
    for name, value in options.items():
        if value is not None:
            raise InputError(f"{name} is for shapes and does not apply to {what!r}: leave it out")


def nearest_rows(t: Vector, times: ArrayLike | None) -> NDArray[np.intp]:
    """Return the indices of the saved states nearest to some times, without repetition."""
    if times is None:
        selected = np.linspace(t[0], t[-1], N_TIMES)
    else:
        selected = np.atleast_1d(check_reals("times", times, "a list of times in s"))
        if selected.ndim != 1 or not selected.size:
            raise InputError(f"times must be a list such as [0.0, 0.5], got {format_value(times)}")
    return np.unique([nearest_row(t, float(time)) for time in selected])


def nearest_row(t: Vector, time: float) -> int:
    """Return the index of the saved state nearest to a time [s]."""
    time = check_finite("time", time, "s")
    tolerance = 1e-9 * max(abs(float(t[0])), abs(float(t[-1])))
    if not t[0] - tolerance <= time <= t[-1] + tolerance:
        raise InputError(
            f"no state was saved at t = {time:.6g} s: the run goes from {t[0]:.6g} s "
            f"to {t[-1]:.6g} s"
        )
    return int(np.argmin(np.abs(t - time)))


def outline_for(system: System, of: object) -> Outline:
    """Return the outline of a body of a system, or of all bodies."""
    if isinstance(of, Point):
        raise InputError(
            f"a point has no shape: give {of.beam.name}, or leave it out for all bodies"
        )
    if of is not None and not isinstance(of, Body):
        raise InputError(
            f"a beam, a mesh or a rigid body of the run is needed, got {format_value(of)}"
        )
    return make_outline(system, of)


def _time_colours(n: int) -> list[object]:
    """Return colours for times, light at the beginning and dark at the end."""
    return list(plt.get_cmap("viridis_r")(np.linspace(0.2, 0.95, n) if n > 1 else [0.7]))


def _prepare_axes(ax: object) -> Axes:
    if ax is None:
        ax = plt.subplots(figsize=(6.4, 4.0), layout="constrained")[1]
    if not isinstance(ax, Axes):
        raise InputError(f"ax must be axes of matplotlib, got {format_value(ax)}")
    ax.grid(alpha=0.3)
    return ax
