"""Shaded tubes and surfaces of a scene: polygons of matplotlib, drawn from back to front."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize, to_rgb
from matplotlib.ticker import MaxNLocator

from ancfsparse.array_types import Vector
from ancfsparse.results.geometry.obstacle_surfaces import make_obstacle_surface
from ancfsparse.results.geometry.wireframe import make_wireframe, trace_points
from ancfsparse.results.plotting.canvas import (
    OBSTACLE_COLOUR,
    SUPPORT_COLOUR,
    VIEWPOINT,
    axis_limits,
    select_components,
    upright_components,
)
from ancfsparse.results.plotting.colours import COLOUR_MAP, Colours
from ancfsparse.results.plotting.traced_scene import TracedScene

BEAM_COLOUR = "#1f77b4"
BODY_COLOUR = "#ff9d3c"
ROPE_COLOUR = "#404040"
SURFACE_COLOUR = "#d9dde3"  # of balls and drums
WIDTH = 6.4  # inch
MAX_HEIGHT = 5.6  # inch
TITLE_HEIGHT = 0.6  # inch
STRIP_EDGES = np.array([-1.0, -1.0 / 3.0, 1.0 / 3.0, 1.0])
"""Edges of the strips across a tube, over its radius."""
MIN_RADIUS_RATIO = 0.003  # of a tube, over the extent of the picture, below which it is thicker
ROPE_RATIO = 0.0015  # radius of ropes, springs and edges, over the extent of the picture
LIGHT = np.array([-0.35, 0.5, 0.79])  # direction to the light: right, up, towards the viewer
AMBIENT = 0.45  # brightness of surfaces turned away from the light, over the brightness towards it
DOT_RATIOS = {"pin": 0.007, "clamp": 0.008, "joint": 0.005, "mass": 0.01}
"""Radii of supports, joints and masses, over the extent of the picture."""
DOT_ANGLES = np.linspace(0.0, 2.0 * np.pi, 13)  # of the corners of a dot
BAR = 0.6, 0.25, 0.34, 0.1
"""Left edge [-], distance from the top [inch], width [-] and height [inch] of the colour bar."""


class ShadedScene:
    """Axes that contain a scene in all its states, as tubes and surfaces.

    Parameters
    ----------
    of : TracedScene
        The shapes to draw.
    q : ndarray, shape (j, n)
        Their coordinates.
    view : str or (float, float), optional
        As of `Canvas`.
    colours : Colours, optional
        Values of the elements in the same states.
    """

    def __init__(
        self, of: TracedScene, q: Vector, view: object = None, colours: Colours | None = None
    ) -> None:
        self.scene, self.q, self.colours = of, q, colours
        self._norm = None if colours is None else Normalize(*colours.limits)
        self._basis = _make_basis(of, view)
        box = of.box
        surfaces = [make_obstacle_surface(each, box) for each in of.outline.obstacles]
        self._surfaces = [points[facets] for points, facets in filter(None, surfaces)]
        points = [box] + [each.reshape(-1, of.outline.dim) for each in of.lines]
        frame = of.frame  # without obstacles that would make bodies too small
        points += [
            each
            for each in (part.reshape(-1, 3)[:, : of.outline.dim] for part in self._surfaces)
            if (each >= frame[0] - 1e-9).all() and (each <= frame[1] + 1e-9).all()
        ]
        flat = self._project(np.concatenate(points[1:] or points))[:, :2]
        limits = axis_limits(np.stack([flat.min(axis=0), flat.max(axis=0)]))
        self._world_limits = axis_limits(frame)
        self._size = float(np.ptp(limits, axis=0).max())
        across, up = np.ptp(limits, axis=0)
        height = min(WIDTH * up / across, MAX_HEIGHT)
        self.figure: Any = plt.figure(figsize=(WIDTH, height + TITLE_HEIGHT))
        self.ax = self.figure.add_axes((0.0, 0.0, 1.0, height / (height + TITLE_HEIGHT)))
        self.ax.set(xlim=limits[:, 0], ylim=limits[:, 1], aspect="equal")
        self.ax.set_axis_off()
        total = height + TITLE_HEIGHT
        self._title = self.figure.text(
            0.03, 1.0 - 0.5 * TITLE_HEIGHT / total, "", va="center", fontsize=14
        )
        if colours is not None:
            left, top, width, bar = BAR
            cax = self.figure.add_axes((left, 1.0 - top / total, width, bar / total))
            mapping = ScalarMappable(self._norm, COLOUR_MAP)
            self.figure.colorbar(mapping, cax=cax, orientation="horizontal")
            cax.xaxis.set_major_locator(MaxNLocator(3))
            cax.tick_params(labelsize=10, length=2.0, pad=1.5)
            cax.set_ylabel(f"{colours.label}  ", rotation=0, ha="right", va="center", size=12)

    def draw_state(self, state: int) -> list[Any]:
        """Draw one state."""
        of, shapes = self.scene, _Shapes()
        for k, part in enumerate(of.outline.parts):
            colour = np.array(to_rgb(BEAM_COLOUR))
            if self.colours is not None and self._norm is not None:
                colour = COLOUR_MAP(self._norm(self.colours.values[k][state]))[:, None, :3]
            radius = max(part.radius, MIN_RADIUS_RATIO * self._size)
            shapes.add_tubes(self._project(of.lines[k][state]), radius, colour)
        for solid in of.outline.solids:
            drawn = make_wireframe(solid)
            points = self._project(trace_points(self.q[state : state + 1], solid, drawn)[0])
            if len(drawn.facets):
                shapes.add_triangles(points[drawn.facets], to_rgb(BODY_COLOUR))
            if not len(drawn.facets) or of.outline.dim == 2:  # edges show the rotation of a disc
                shapes.add_tubes(points[drawn.edges], ROPE_RATIO * self._size, to_rgb(ROPE_COLOUR))
        for triangles in self._surfaces:
            shapes.add_triangles(self._project(triangles), to_rgb(SURFACE_COLOUR))
        links = of.links[state][~np.isnan(of.links[state]).any(axis=(1, 2))]
        shapes.add_tubes(self._project(links), ROPE_RATIO * self._size, to_rgb(ROPE_COLOUR))
        for kind, positions, _ in of.supports:
            if kind in DOT_RATIOS:
                radius = DOT_RATIOS[kind] * self._size
                shapes.add_dot(self._project(positions[state]), radius, to_rgb(SUPPORT_COLOUR))
        lines: Any = self._project(of.trace_obstacles(state, self._world_limits))[..., :2]
        back = LineCollection(lines, colors=OBSTACLE_COLOUR, linewidths=0.6, alpha=0.5, zorder=0)
        artists: list[Any] = [back, shapes.collect()]
        for artist in artists:
            self.ax.add_collection(artist, autolim=False)
        return artists

    def set_title(self, text: str) -> None:
        """Write a title above the picture."""
        self._title.set_text(text)

    def draw_path(self, points: Vector) -> list[Any]:
        """Draw the path of a point, (j, dim) [m]."""
        x, y, _ = self._project(points).T
        return list(self.ax.plot(x, y, "-", color="C1", linewidth=1.0, zorder=1))

    def _project(self, points: Vector) -> Vector:
        """Return the components of points to the right, upwards and towards the viewer [m]."""
        return np.asarray(points @ self._basis[:, : points.shape[-1]].T)


class _Shapes:
    """Quadrangles with their colours and their order from back to front."""

    def __init__(self) -> None:
        self._corners, self._colours, self._depths = [], [], []  # type: ignore[var-annotated]

    def add_tubes(self, lines: Vector, radius: float, colour: Any) -> None:
        """Add tubes around lines (n, p, 3), in a colour of all or of each (n, 1, 3)."""
        steps = np.diff(lines, axis=1)
        widths = np.linalg.norm(steps[..., :2], axis=-1, keepdims=True)
        across = np.stack([-steps[..., 1], steps[..., 0]], axis=-1) / np.maximum(widths, 1e-300)
        side = np.concatenate([across, 0.0 * widths], axis=-1)
        along = steps / np.maximum(np.linalg.norm(steps, axis=-1, keepdims=True), 1e-300)
        front = np.cross(along, side)
        front *= np.where(front[..., 2:] < 0.0, -1.0, 1.0)
        depth = np.maximum(lines[:, 1:, 2], lines[:, :-1, 2]) + radius
        ends = (lines[:, :-1, :2], lines[:, 1:, :2])
        for low, high in pairwise(STRIP_EDGES):
            middle = 0.5 * (low + high)
            normal = middle * side + np.sqrt(1.0 - middle**2) * front
            offsets = radius * low * across, radius * high * across
            corners = [ends[0] + offsets[0], ends[1] + offsets[0]]
            corners += [ends[1] + offsets[1], ends[0] + offsets[1]]
            self._add(np.stack(corners, axis=-2), normal, colour, depth)

    def add_triangles(self, triangles: Vector, colour: Any) -> None:
        """Add triangles (n, 3, 3) of a surface, those that face the viewer.

        They are ordered by their farthest corners, so that tubes on them are visible.
        """
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-300)
        if not triangles[..., 2].any():  # in the plane
            normal = np.broadcast_to((0.0, 0.0, 1.0), normal.shape)
        faces_viewer = normal[:, 2] > 0.0
        corners = triangles[faces_viewer][:, [0, 1, 2, 2]]
        self._add(corners[..., :2], normal[faces_viewer], colour, corners[..., 2].min(axis=-1))

    def add_dot(self, centre: Vector, radius: float, colour: Any) -> None:
        """Add a disc that faces the viewer."""
        rim = centre[:2] + radius * np.stack([np.cos(DOT_ANGLES), np.sin(DOT_ANGLES)], axis=-1)
        middle = np.broadcast_to(centre[:2], rim[1:].shape)
        corners = np.stack([middle, rim[:-1], rim[1:], rim[1:]], axis=1)
        depth = np.full(len(corners), centre[2] + 2.0 * radius)
        self._add(corners, np.broadcast_to((0.0, 0.0, 1.0), (len(corners), 3)), colour, depth)

    def _add(self, corners: Vector, normal: Vector, colour: Any, depth: Vector) -> None:
        light = AMBIENT + (1.0 - AMBIENT) * np.maximum(normal @ LIGHT, 0.0)
        self._corners.append(corners.reshape(-1, 4, 2))
        self._colours.append((light[..., None] * colour).reshape(-1, 3))
        self._depths.append(depth.ravel())

    def collect(self) -> PolyCollection:
        """Return one artist of all shapes."""
        order = np.argsort(np.concatenate(self._depths), kind="stable")
        colours = np.concatenate(self._colours)[order]
        corners: Any = np.concatenate(self._corners)[order]
        return PolyCollection(
            corners, facecolors=colours, edgecolors=colours,
            linewidths=0.3, zorder=2,
        )  # fmt: skip


def _make_basis(of: TracedScene, view: object) -> Vector:
    """Return the unit vectors to the right, upwards and towards the viewer, in rows."""
    axes = select_components(of, view, of.box)
    basis = np.zeros((3, 3))
    if len(axes) == 2:
        basis[0, axes[0]] = basis[1, axes[1]] = 1.0
        basis[2] = np.cross(basis[0], basis[1])
        return basis
    first, second, up = upright_components(of.outline.gravity)
    tilt, turn = np.radians(view if isinstance(view, tuple) else VIEWPOINT)
    basis[0, [first, second]] = -np.sin(turn), np.cos(turn)
    basis[2, [first, second, up]] = (
        np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt),
    )  # fmt: skip
    basis[1] = np.cross(basis[2], basis[0])
    return basis
