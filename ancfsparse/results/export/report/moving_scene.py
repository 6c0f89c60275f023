"""The moving scene of a page: tubes, rigid bodies, lines and points in some states."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.results.data.interpolation import interpolate
from ancfsparse.results.fields.quantities import evaluate_quantity, label_of
from ancfsparse.results.geometry.body_outlines import RigidOutline
from ancfsparse.results.geometry.obstacle_outlines import trace_obstacle
from ancfsparse.results.geometry.scene_outline import Outline
from ancfsparse.results.geometry.tubes import (
    ROPE,
    SOLID,
    count_pieces,
    join_tubes,
    make_lines,
    make_tubes,
    pad_points,
)
from ancfsparse.results.geometry.wireframe import make_wireframe, trace_edges
from ancfsparse.results.plotting.canvas import axis_limits, upright_components
from ancfsparse.results.plotting.colours import COLOUR_MAP
from ancfsparse.results.plotting.traced_scene import clip_lines, trace_scene
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.system import System

QUANTITIES = "N", "strain", "curvature"
N_COLOURS = 32
LINE_RADIUS = 0.01  # radius of the lines of rigid bodies, over the extent of the body


@dataclass
class MovingScene:
    """Contents and tables of a page, for `packing.pack`.

    Attributes
    ----------
    contents : dict
        Descriptions of all that is drawn.
    moving : dict of str to ndarray, shape (k, n)
        Numbers that change: ``"x"``, ``"y"``, ``"z"`` of the points of tubes [m], and others.
    fixed : dict of str to ndarray
        Numbers that do not.
    """

    contents: dict[str, Any] = field(default_factory=dict)
    moving: dict[str, Vector] = field(default_factory=dict)
    fixed: dict[str, Vector] = field(default_factory=dict)


def make_moving_scene(
    system: System, outline: Outline, states: StateHistory, *, coloured: bool = True
) -> MovingScene:
    """Return the scene of an outline in some states."""
    q, dim = states.q, outline.dim
    traced = trace_scene(outline, q, states.t)
    limits = axis_limits(traced.frame)
    if dim == 2:  # shown in the plane z = 0
        limits = np.column_stack([limits, np.zeros(2)])
    up = upright_components(outline.gravity)[2] if dim == 3 else 1
    page = trace_motion(system, outline, states, coloured=coloured)
    page.contents |= {"box": limits.tolist(), "up": up}
    first, middle = (
        _trace_obstacles(outline, traced.box, limits[:, :dim], float(t))
        for t in (states.t[0], states.t[len(states.t) // 2])
    )
    page.fixed["obstacles"] = pad_points(first[(first == middle).all(axis=(1, 2))])
    if page.contents["quantities"]:
        page.contents["colours"] = [
            [round(255.0 * x) for x in COLOUR_MAP(level)[:3]]
            for level in np.linspace(0.0, 1.0, N_COLOURS)
        ]
    return page


def trace_motion(
    system: System, outline: Outline, states: StateHistory, *, coloured: bool = True
) -> MovingScene:
    """Return the parts of the scene that move, without box, obstacles and colours."""
    q, dim = states.q, outline.dim
    page = MovingScene({"t": states.t.tolist(), "dim": dim, "quantities": [], "arrows": []})
    _add_tubes(page, outline, q)
    page.contents["solids"] = [
        _add_solid(page, k, solid, q, dim) for k, solid in enumerate(outline.solids)
    ]
    if outline.supports:
        points = [interpolate((each.places, each.weights), q) for each in outline.supports]
        page.moving["supports"] = np.concatenate(points, axis=1)
    page.contents["supports"] = [each.kind for each in outline.supports]
    for what in QUANTITIES if coloured and outline.parts else ():
        _add_quantity(page, system, outline, states, what)
    return page


def _add_tubes(page: MovingScene, outline: Outline, q: Vector) -> None:
    """Add the tubes of beams and meshes, and of lines: ropes, springs, bodies without surface."""
    pieces, every, bodies, n = count_pieces(outline.parts), [], [], 0
    for part in outline.parts:
        every.append(make_tubes(q, part, pieces))
        bodies.append({"name": part.name, "first": n, "end": n + every[-1].points.shape[1]})
        n = bodies[-1]["end"]
    every.append(make_lines(outline.links.ends(q), ROPE))
    for solid in outline.solids:
        if not len(make_wireframe(solid).facets):  # a body without surface, such as a thin rod
            ends = trace_edges(q, solid)
            radius = LINE_RADIUS * float(np.ptp(ends[0].reshape(-1, outline.dim), axis=0).max())
            every.append(make_lines(ends, SOLID, radius))
    tubes = join_tubes(every)
    page.contents["bodies"] = bodies
    page.contents["elements"] = sum(len(part.lengths) for part in outline.parts)
    for axis in range(outline.dim):
        page.moving["xyz"[axis]] = tubes.points[..., axis]
    page.fixed["rings"], page.fixed["strips"] = tubes.rings, tubes.strips


def _add_solid(
    page: MovingScene, k: int, solid: RigidOutline, q: Vector, dim: int
) -> dict[str, Any]:
    """Add a rigid body, and return its description."""
    drawn = make_wireframe(solid)
    vectors = np.asarray(q[:, solid.places])
    page.moving[f"origin {k}"] = vectors[:, 0]
    page.moving[f"axes {k}"] = vectors[:, 1:].reshape(len(q), -1)
    page.fixed[f"points {k}"] = pad_points(drawn.weights[:, 1:])
    page.fixed[f"edges {k}"] = drawn.edges.astype(float)
    page.fixed[f"facets {k}"] = drawn.facets.astype(float)
    return {"name": solid.name, "axes": len(solid.places) - 1}


def _add_quantity(
    page: MovingScene, system: System, outline: Outline, states: StateHistory, what: str
) -> None:
    """Add a quantity of all elements, a magnitude where it has components."""
    bodies: list[Any] = [system.scene.body(part.name) for part in outline.parts]
    if what == "curvature" and any(len(body.kind.axis) == 1 for body in bodies):
        return
    each = [evaluate_quantity(system, states, what, body) for body in bodies]
    sizes = [np.linalg.norm(x, axis=2) if x.ndim > 2 else x for x in each]
    page.moving[what] = np.concatenate(sizes, axis=1)
    page.contents["quantities"].append({"name": what, "label": label_of(what)})


def _trace_obstacles(outline: Outline, box: Vector, limits: Vector, t: float) -> Vector:
    """Return the ends of the lines of obstacles at a time [s], (n, 2, dim) [m]."""
    lines = [trace_obstacle(each, box, limits, t) for each in outline.obstacles]
    every = np.concatenate([np.zeros((0, 2, outline.dim)), *lines])
    return np.nan_to_num(clip_lines(every, *limits))
