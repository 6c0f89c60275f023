"""Scenes in axes of matplotlib with equal scales, planar or in perspective."""

from __future__ import annotations

from itertools import product
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.markers import MarkerStyle
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Affine2D
from mpl_toolkits.mplot3d import Axes3D, proj3d
from mpl_toolkits.mplot3d.art3d import Line3DCollection

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_finite
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.results.plotting.traced_scene import TracedScene, clip_lines

FLATNESS = 1e-6  # extent of a planar motion across its plane, over the largest extent
MARGIN = 0.06  # margin around the scene, over its largest extent
MIN_EXTENT = 0.2  # extent of an axis, over the largest extent
MAX_WIDTH = 5.2  # inch, planar axes
MAX_HEIGHT = 5.2  # inch
LEFT = 0.8  # inch, margin of planar axes
BOTTOM = 0.55  # inch
TOP = 0.35  # inch
RIGHT = 0.2  # inch
LEGEND_WIDTH = 1.15  # inch
VIEWPOINT = 22.0, -60.0  # degrees, elevation and azimuth
LABEL_MARGINS = {"left": 0.65, "bottom": 1.1, "right": 0.85, "top": 0.4}
"""Margins for ticks and labels of a figure in perspective [inch]."""
LABEL_PAD = 10.0  # pt, between ticks and label of the vertical axis in perspective
LABEL_OFFSET = 21.0  # pt, that matplotlib adds to the pad of a label
TICK_OFFSET = 8.0  # pt, the same of a tick
DEFAULT_TICK_PAD = 3.5  # pt
TICK_PAD = 2.5  # pt for each letter of the widest tick, of the others, above half of that
MAX_TICK_LETTERS = 5  # letters of ticks in perspective; five wider ones overlap
MAX_WIDE_TICKS = 3  # intervals between ticks that are wider
ZOOM_ITERATIONS = 3  # the size of a box in perspective is not exactly linear in its zoom
SUPPORT_COLOUR = "0.25"
OBSTACLE_COLOUR = "0.6"
OBSTACLE_WIDTH = 0.8  # pt
ARROW_LENGTH = 0.35  # inch, of forces in the plane
ARROW_WIDTH = 0.02  # inch
ARROW_RATIO = 0.15  # length of the arrows of forces in perspective, over the largest extent
MIN_SINE = 0.05  # of the angle of a force to the line of sight, below which it is a cross
MOMENT_SYMBOLS = {
    1.0: r"$\circlearrowleft$",
    -1.0: r"$\circlearrowright$",
    0.0: r"$\circlearrowleft$",
}
"""Symbols of moments counterclockwise, clockwise and of another axis."""
CONNECTION_WIDTH = 0.5  # line width of ropes and springs, over that of beams

_TRIANGLE = Path(
    [(0, 0), (-0.7, -1.1), (0.7, -1.1), (0, 0), (-1.0, -1.1), (1.0, -1.1)],
    [Path.MOVETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY, Path.MOVETO, Path.LINETO],
)
_WALL = Path(
    [(0, -1.2), (0, 1.2), *(p for y in (-1.2, -0.4, 0.4, 1.2) for p in ((0, y), (-0.6, y - 0.5)))],
    [Path.MOVETO, Path.LINETO] * 5,
)


class Canvas:
    """Axes with equal scales that contain a scene in all its states.

    Parameters
    ----------
    of : Film
        The shapes to draw.
    ax : Axes, optional
        Axes to draw into; by default those of a new figure.
    view : str or (float, float), optional
        Two of ``"xyz"`` for a planar view, or elevation and azimuth of the viewpoint [degrees].  By
        default the plane of a planar motion, else perspective.
    legend : bool, optional
        Reserve space for a legend in a new figure.

    Raises
    ------
    InputError
        If an argument is invalid.
    """

    def __init__(
        self, of: TracedScene, ax: object = None, view: object = None, *, legend: bool = True
    ) -> None:
        self.film = of
        self.axes = select_components(of, view, of.box)
        limits = axis_limits(of.frame[:, self.axes])
        self.is_new = ax is None
        if ax is None:
            self.ax = _make_axes(limits, LEGEND_WIDTH if legend else RIGHT)
        elif isinstance(ax, Axes):
            self.ax = ax
        else:
            raise InputError(f"ax must be axes of matplotlib, got {format_value(ax)}")
        if (len(self.axes) == 3) != isinstance(self.ax, Axes3D):
            needed = "projection='3d'" if len(self.axes) == 3 else "two dimensions"
            raise InputError(f"ax must have {needed} for this view: leave it out, or give view")
        self.figure: Any = self.ax.get_figure(root=True)
        self._set_limits(limits)
        if isinstance(self.ax, Axes3D):
            elevation, azimuth = view if isinstance(view, tuple) else VIEWPOINT
            self.ax.view_init(elev=elevation, azim=azimuth)
            _set_label_pads(self.ax, np.ptp(limits, axis=0))
            if self.is_new:
                left = LEGEND_WIDTH if legend else 0.0
                _fill_figure(self.ax, self.figure, limits, LABEL_MARGINS["left"] + left)

    def draw(self, state: int, colour: Any, *, alpha: float = 1.0, label: str = "") -> list[Any]:
        """Draw all bodies in one state, each as one artist, and ropes and springs as others."""
        artists = []
        collection = Line3DCollection if len(self.axes) == 3 else LineCollection
        for lines in self.film.lines:
            artist = collection(
                lines[state][..., self.axes], colors=[colour], alpha=alpha, capstyle="round",
                linewidths=self.film.width, label=label or None,
            )  # fmt: skip
            self.ax.add_collection(artist, autolim=False)
            artists.append(artist)
            label = ""
        links, springs = self.film.links[state][..., self.axes], self.film.outline.links.springs
        for some, style in ((links[~springs], "solid"), (links[springs], "dashed")):
            if len(some):
                artist = collection(
                    some, colors=[colour], alpha=alpha, linestyles=style,
                    linewidths=CONNECTION_WIDTH * self.film.width,
                )  # fmt: skip
                self.ax.add_collection(artist, autolim=False)
                artists.append(artist)
        return artists

    def draw_state(self, state: int) -> list[Any]:
        """Draw all bodies, obstacles and supports in one state."""
        return [*self.draw(state, "C0"), *self.draw_supports(state)]

    def set_title(self, text: str) -> None:
        """Write a title above the axes."""
        self.ax.set_title(text, fontsize="medium")

    def add_legend(self, title: str | None = None) -> None:
        """Add a legend, next to the axes of a new figure."""
        if self.is_new and len(self.axes) == 2:
            self.ax.legend(
                title=title, fontsize="small", frameon=False, loc="upper left",
                bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0,
            )  # fmt: skip
        elif self.is_new:
            self.ax.legend(
                title=title, fontsize="small", frameon=False, loc="upper left",
                bbox_to_anchor=(0.0, 1.0), bbox_transform=self.figure.transFigure,
            )  # fmt: skip
        elif len(self.axes) == 3:  # the vertical axis is on the right
            self.ax.legend(title=title, fontsize="small", loc="upper left")
        else:
            self.ax.legend(title=title, fontsize="small")

    def draw_supports(self, state: int) -> list[Any]:
        """Draw obstacles, and symbols of supports, joints, masses and loads, in one state."""
        artists = self._draw_obstacles(state)
        style: dict[str, Any] = {
            "color": SUPPORT_COLOUR,
            "mfc": "w",
            "zorder": 3,
            "linestyle": "none",
        }

        def mark(places: Vector, marker: Any, size: float, **more: Any) -> None:
            columns = np.atleast_2d(places)[:, self.axes].T
            artists.extend(self.ax.plot(*columns, marker=marker, markersize=size, **style | more))

        supports = self.film.supports
        joints = [places[state] for kind, places, _ in supports if kind == "joint"]
        pins = [places[state] for kind, places, _ in supports if kind == "pin"]
        inside = self.film.reach
        pins += [
            anchor
            for kind, _, anchor in supports
            if kind == "rod" and ((inside[0] <= anchor) & (anchor <= inside[1])).all()
        ]
        for kind, places, other in supports:
            if kind == "rod":
                ends = clip_lines(np.stack([places[state], other]), *inside)[:, self.axes].T
                artists += self.ax.plot(*ends, "-", color=SUPPORT_COLOUR, linewidth=1.0, zorder=3)
                mark(places[state], "o", 3.5)
            elif kind == "clamp" and len(self.axes) == 2:
                across, up = other[self.axes]
                turn = Affine2D().rotate(float(np.arctan2(up, across)))
                mark(places[state], MarkerStyle(_WALL, transform=turn), 22.0)
            elif kind == "clamp":
                mark(places[state], "s", 7.0)
        masses = [places[state] for kind, places, _ in supports if kind == "mass"]
        if masses:
            mark(np.array(masses), "o", 8.0, mfc=SUPPORT_COLOUR)
        for sign, symbol in MOMENT_SYMBOLS.items():
            moments = [
                places[state]
                for kind, places, other in supports
                if kind == "moment" and other[0] == sign
            ]
            if moments:
                mark(np.array(moments), symbol, 16.0, mfc=SUPPORT_COLOUR)
        artists += self._draw_forces(state)
        if joints:
            mark(np.array(joints), "o", 2.0 * self.film.width)
        if pins:
            flat = len(self.axes) == 2
            mark(np.array(pins), MarkerStyle(_TRIANGLE) if flat else "^", 14.0 if flat else 8.0)
        return artists

    def _draw_obstacles(self, state: int) -> list[Any]:
        """Draw half-spaces, drums and balls, behind the bodies, as one artist."""
        lines = self.film.trace_obstacles(state, axis_limits(self.film.frame))[..., self.axes]
        if not len(lines):
            return []
        collection = Line3DCollection if len(self.axes) == 3 else LineCollection
        artist = collection(
            list(lines),
            colors=[OBSTACLE_COLOUR],
            linewidths=OBSTACLE_WIDTH,
            capstyle="round",
            zorder=0.9,
        )
        self.ax.add_collection(artist, autolim=False)
        return [artist]

    def _draw_forces(self, state: int) -> list[Any]:
        """Draw forces as arrows that end at their points, those without a direction as crosses."""
        forces = [
            (each[state], other) for kind, each, other in self.film.supports if kind == "force"
        ]
        if not forces:
            return []
        points, directions = (np.array(each)[:, self.axes] for each in zip(*forces, strict=True))
        is_across = np.linalg.norm(directions, axis=1) > MIN_SINE
        columns = [*points[is_across].T, *directions[is_across].T]
        artists: list[Any] = []
        style: dict[str, Any] = {"color": SUPPORT_COLOUR, "pivot": "tip", "zorder": 3}
        if isinstance(self.ax, Axes3D):
            limits = np.array([self.ax.get_xlim(), self.ax.get_ylim(), self.ax.get_zlim()])
            style |= {"length": ARROW_RATIO * float(np.ptp(limits, axis=1).max()), "linewidth": 1.2}
        else:
            style |= {"angles": "xy", "units": "inches", "scale_units": "inches"}
            style |= {"scale": 1.0 / ARROW_LENGTH, "width": ARROW_WIDTH}
        if is_across.any():
            artists.append(self.ax.quiver(*columns, **style))
        if not is_across.all():
            artists += self.ax.plot(
                *points[~is_across].T, "x", color=SUPPORT_COLOUR, markersize=6.0, zorder=3
            )
        return artists

    def draw_path(self, points: Vector) -> list[Any]:
        """Draw the path of a point, (j, dim) [m]."""
        return list(self.ax.plot(*points[:, self.axes].T, "-", color="C1", linewidth=1.0, zorder=1))

    def _set_limits(self, limits: Vector) -> None:
        ax, size = self.ax, limits[1] - limits[0]
        for name, axis, (low, high) in zip("xyz", self.axes, limits.T, strict=False):
            ax.set(**{f"{name}lim": (low, high), f"{name}label": f"{'xyz'[axis]} [m]"})
        if isinstance(ax, Axes3D):
            ax.set_box_aspect(size, zoom=0.95)
            for axis, share in zip((ax.xaxis, ax.yaxis, ax.zaxis), size / size.max(), strict=True):
                axis.set_major_locator(MaxNLocator(int(np.clip(1 + 4 * share, 2, 5))))
        else:
            ax.set_aspect("equal")
            ax.grid(alpha=0.3)


def select_components(of: TracedScene, view: object, box: Vector) -> list[int]:
    """Return the components of the axes: two, or three in perspective."""
    if isinstance(view, str):
        axes = ["xyz".find(letter) for letter in view]
        if (
            len(axes) != 2
            or axes[0] == axes[1]
            or not all(0 <= each < of.outline.dim for each in axes)
        ):
            raise InputError(
                f"view must name two of {'xyz'[: of.outline.dim]!r}, got {format_value(view)}"
            )
        return axes
    if view is not None:
        numbers = isinstance(view, tuple) and len(view) == 2
        if not numbers or not all(isinstance(each, (int, float)) for each in view):  # type: ignore[attr-defined]
            raise InputError(
                "view must be a plane such as 'xz', or elevation and azimuth in degrees such as "
                f"(20, -60), got {format_value(view)}"
            )
        if of.outline.dim == 2:
            raise InputError("the scene is planar and has no viewpoint: leave view out")
        for angle in view:  # type: ignore[attr-defined]
            check_finite("view", angle, "degrees")
        return upright_components(of.outline.gravity)
    extent = box[1] - box[0]
    wide = [k for k in range(of.outline.dim) if extent[k] > FLATNESS * extent.max()]
    if of.outline.dim == 2:
        return [0, 1]
    first, second, up = upright_components(of.outline.gravity)
    if len(wide) == 3:
        return [first, second, up]
    if up not in wide and len(wide) == 2:
        return sorted(wide)
    return [first if second not in wide else second, up]


def upright_components(gravity: Vector) -> list[int]:
    """Return the three components in cyclic order, ending with that of gravity, or else z."""
    up = int(np.argmax(np.abs(gravity))) if gravity.any() else 2
    return [(up + 1) % 3, (up + 2) % 3, up]


def axis_limits(box: Vector) -> Vector:
    """Return the limits of all axes with margins and minimum extents, shape (2, c) [m]."""
    extent = box[1] - box[0]
    size = float(extent.max()) or 1.0
    half = 0.5 * np.maximum(extent, MIN_EXTENT * size) + MARGIN * size
    middle = box.mean(axis=0)
    return np.stack([middle - half, middle + half])


def _make_axes(limits: Vector, right: float) -> Axes:
    """Return axes that fill a new figure, with a right margin [inch]."""
    size = limits[1] - limits[0]
    if len(size) == 3:
        across = 6.4 - RIGHT + right
        figure = plt.figure(figsize=(across, 3.4 + 2.2 * float(size[2] / size.max())))
        axes: Axes = figure.add_axes((0.02, 0.01, 0.92, 0.92), projection="3d")
        return axes
    width, height = size * min(MAX_WIDTH / size[0], MAX_HEIGHT / size[1])
    across, up = LEFT + width + right, BOTTOM + height + TOP
    figure = plt.figure(figsize=(across, up))
    return figure.add_axes((LEFT / across, BOTTOM / up, width / across, height / up))


def _set_label_pads(ax: Any, size: Vector) -> None:
    """Move ticks and labels of axes in perspective apart, by the width of the ticks.

    Matplotlib takes distances from an axis in proportion to the extent of the box across it.
    """
    for k, axis in enumerate((ax.xaxis, ax.yaxis, ax.zaxis)):
        ticks = axis.get_major_formatter().format_ticks(axis.get_major_locator()())
        widest = max(map(len, ticks), default=0)
        if axis is not ax.zaxis and len(ticks) > MAX_WIDE_TICKS + 2 and widest > MAX_TICK_LETTERS:
            axis.set_major_locator(MaxNLocator(MAX_WIDE_TICKS))
        pad = LABEL_PAD if axis is ax.zaxis else 0.5 * LABEL_PAD + TICK_PAD * widest
        stretch = size.max() / np.delete(size, k).max()
        axis.labelpad = stretch * (pad + LABEL_OFFSET) - LABEL_OFFSET
        axis.set_tick_params(pad=stretch * (DEFAULT_TICK_PAD + TICK_OFFSET) - TICK_OFFSET)


def _fill_figure(ax: Any, figure: Any, limits: Vector, left: float) -> None:
    """Scale a box in perspective such that it fills the figure with its labels and a title.

    The margin at the left [inch] has room for a legend, if there is one.
    """
    size = limits[1] - limits[0]
    figure_size = figure.get_size_inches()
    low = np.array([left, LABEL_MARGINS["bottom"]])
    room = figure_size - (LABEL_MARGINS["right"], LABEL_MARGINS["top"]) - low
    ax.set_position((*(low / figure_size), *(room / figure_size)))
    zoom, corners = 1.0, np.array(list(product(*limits.T)))
    for _ in range(ZOOM_ITERATIONS):
        ax.set_box_aspect(size, zoom=zoom)
        x, y, _ = proj3d.proj_transform(*corners.T, ax.get_proj())
        there = ax.transData.transform(np.column_stack([x, y])) / figure.dpi
        extent = np.ptp(there, axis=0)
        zoom *= float(np.min(room / extent))
    shift = low + 0.5 * room - 0.5 * (there.min(axis=0) + there.max(axis=0))
    ax.set_position(ax.get_position().translated(*(shift / figure_size)))
