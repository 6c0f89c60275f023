"""Shapes of bodies, supports and connection lines in the states that a picture shows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.results.data.interpolation import interpolate
from ancfsparse.results.geometry.deformed_shape import count_pieces, trace_elements
from ancfsparse.results.geometry.obstacle_outlines import enlarge_box, trace_obstacle
from ancfsparse.results.geometry.scene_outline import Outline
from ancfsparse.results.geometry.wireframe import trace_edges

MAX_THICK_LINES = 200  # elements and rigid bodies, above which lines become thinner
# Bodies are drawn at least half an inch large; lines to anchors that are farther away are cut.
MAX_ANCHOR_RATIO = 10.0  # distance of an anchor from the bodies, over their extent


@dataclass(frozen=True)
class TracedScene:
    """Shapes of bodies and positions of supports in j states.

    Attributes
    ----------
    outline : Outline
        The outline of the scene.
    lines : list of ndarray, each of shape (j, n, pieces + 1, dim)
        Points on the elements of every beam and mesh, then the ends of the edges of every rigid
        body [m].
    supported : list of ndarray, each of shape (j, dim)
        The point of every support [m].
    links : ndarray, shape (j, n, 2, dim)
        The ends of ropes, springs and distances [m].
    times : ndarray, shape (j,)
        Times of the states [s].
    """

    outline: Outline
    lines: list[Vector]
    supported: list[Vector]
    links: Vector
    times: Vector

    @property
    def supports(self) -> list[tuple[str, Vector, Vector]]:
        """Kind, point and other vector of every support."""
        pairs = zip(self.outline.supports, self.supported, strict=True)
        return [(support.kind, positions, support.other) for support, positions in pairs]

    @cached_property
    def reach(self) -> Vector:
        """Smallest and largest coordinates to which lines are drawn, shape (2, dim) [m]."""
        points = [each.reshape(-1, self.outline.dim) for each in self.lines]
        points += [positions for _, positions, _ in self.supports]
        every = np.concatenate(points)
        low, high = every.min(axis=0), every.max(axis=0)
        distance = MAX_ANCHOR_RATIO * float(np.max(high - low)) or np.inf
        return np.stack([low - distance, high + distance])

    @cached_property
    def box(self) -> Vector:
        """Smallest and largest coordinates of all lines, shape (2, dim) [m]."""
        points = [*self.lines, self.links]
        points += [
            clip_lines(
                np.stack([positions, np.broadcast_to(other, positions.shape)], axis=1), *self.reach
            )
            for kind, positions, other in self.supports
            if kind == "rod"
        ]
        every = np.concatenate([each.reshape(-1, self.outline.dim) for each in points])
        return np.stack([np.nanmin(every, axis=0), np.nanmax(every, axis=0)])

    @cached_property
    def frame(self) -> Vector:
        """Smallest and largest coordinates of the picture without margins, (2, dim) [m]."""
        return enlarge_box(self.box, self.outline.obstacles)

    def trace_obstacles(self, state: int, limits: Vector) -> Vector:
        """Return the ends of the lines of obstacles in a box (2, dim) [m], (n, 2, dim) [m]."""
        time = float(self.times[state])
        lines = [trace_obstacle(o, self.box, limits, time) for o in self.outline.obstacles]
        clipped = clip_lines(np.concatenate([np.zeros((0, 2, self.outline.dim)), *lines]), *limits)
        return clipped[~np.isnan(clipped).any(axis=(1, 2))]

    @property
    def width(self) -> float:
        """Width of lines [pt]."""
        n = sum(len(part.lengths) for part in self.outline.parts) + len(self.outline.solids)
        return float(np.clip(1.8 * np.sqrt(MAX_THICK_LINES / max(n, MAX_THICK_LINES)), 0.5, 1.8))


def trace_scene(outline: Outline, q: Vector, t: Vector | None = None) -> TracedScene:
    """Return the shapes of bodies for coordinates q (j, n) at times t (j,) [s], or t = 0."""
    pieces = count_pieces(outline.parts)
    lines = [trace_elements(q, part, pieces) for part in outline.parts]
    lines += [trace_edges(q, solid) for solid in outline.solids]
    supported = [interpolate((each.places, each.weights), q) for each in outline.supports]
    times = np.zeros(len(q)) if t is None else t
    traced = TracedScene(outline, lines, supported, outline.links.ends(q), times)
    return replace(traced, links=clip_lines(traced.links, *traced.reach))


def clip_lines(ends: Vector, low: Vector, high: Vector) -> Vector:
    """Return the parts of lines inside a box, NaN of lines outside.

    The ends are of shape (..., 2, dim), the corners of the box of shape (dim,) [m].
    """
    start, along = ends[..., 0, :], ends[..., 1, :] - ends[..., 0, :]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings = np.stack([(low - start) / along, (high - start) / along])
    # Lines along a face of the box are in it or not at all.
    is_still, is_inside = along == 0.0, (low <= start) & (start <= high)
    first = np.where(is_still, np.where(is_inside, -np.inf, np.inf), crossings.min(axis=0))
    last = np.where(is_still, np.inf, crossings.max(axis=0))
    begin = np.maximum(first.max(axis=-1), 0.0)[..., None]
    end = np.minimum(last.min(axis=-1), 1.0)[..., None]
    one = np.where(begin > 0.0, start + np.minimum(begin, 1.0) * along, start)
    other = np.where(end < 1.0, start + np.maximum(end, 0.0) * along, ends[..., 1, :])
    return np.where((begin <= end)[..., None], np.stack([one, other], axis=-2), np.nan)
