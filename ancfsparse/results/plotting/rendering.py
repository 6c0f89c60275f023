"""Images with sections in true size, rendered by PyVista without a display."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_finite
from ancfsparse.errors import InputError
from ancfsparse.file_names import check_target
from ancfsparse.messages import format_value
from ancfsparse.results.fields.motion import Motion
from ancfsparse.results.fields.quantities import select_states
from ancfsparse.results.geometry.body_outlines import RigidOutline
from ancfsparse.results.geometry.deformed_shape import count_pieces, trace_elements
from ancfsparse.results.geometry.scene_outline import BodyAxis, Outline
from ancfsparse.results.geometry.wireframe import make_wireframe, trace_points
from ancfsparse.results.plotting.canvas import VIEWPOINT, axis_limits, upright_components
from ancfsparse.results.plotting.colours import COLOUR_MAP, evaluate_colours
from ancfsparse.results.plotting.plot import outline_for
from ancfsparse.results.plotting.shaded_scene import BEAM_COLOUR, BODY_COLOUR, ROPE_COLOUR
from ancfsparse.results.plotting.traced_scene import trace_scene
from ancfsparse.scene import Body

try:
    import pyvista as pv
except ImportError as missing:
    raise InputError(
        "a rendered image needs PyVista, which is not installed: "
        "pip install 'ancfsparse[view]', or take run.plot()"
    ) from missing

TUBE_SIDES = 24
VALUES = "values"  # name of the values of elements in a mesh
OBSTACLE_COLOUR = "#999999"
LINE_RADIUS = 0.01  # radius of the lines of rigid bodies, over the extent of the body
ROPE_RADIUS = 0.002  # radius of ropes and springs, over the extent of the scene
IMAGE_SIZES = range(16, 10_000)  # pixels


def render(
    run: Motion,
    row: int,
    path: str | Path,
    *,
    of: Body | None = None,
    view: tuple[float, float] | None = None,
    size: tuple[int, int] = (1000, 750),
    colour: str | None = None,
) -> Path:
    """Render one saved state; see `Trajectory.render`."""
    outline = outline_for(run.system, of)
    target = check_target("an image", path, (".png", ".jpg"))
    view = VIEWPOINT if view is None else view
    if not (isinstance(view, tuple) and len(view) == 2):
        raise InputError(f"view must be elevation and azimuth in degrees, got {format_value(view)}")
    tilt, turn = (np.radians(check_finite("view", each, "degrees")) for each in view)
    if not (
        isinstance(size, tuple) and len(size) == 2 and all(each in IMAGE_SIZES for each in size)
    ):
        raise InputError(
            f"size must be two numbers of pixels such as (1000, 750), got {format_value(size)}"
        )
    states = select_states(run, np.array([row]))
    q, colours = states.q[0], None
    if colour is not None:
        colours = evaluate_colours(run.system, states, colour, outline)
    axes = upright_components(outline.gravity) if outline.dim == 3 else [0, 1, 2]
    if outline.dim == 2:  # seen from the front
        tilt, turn, axes = 0.0, 0.5 * np.pi, [0, 2, 1]
    eye, up = np.zeros(3), np.zeros(3)
    eye[axes] = np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)
    up[axes[2]] = 1.0
    plotter: Any = pv.Plotter(off_screen=True, window_size=list(size))
    try:
        pieces = count_pieces(outline.parts)
        for k, part in enumerate(outline.parts):
            look: dict[str, Any] = {"color": BEAM_COLOUR}
            values = np.zeros(len(part.lengths))
            if colours is not None:
                values = colours.values[k][0]
                bar = {"title": f"{colours.label}\n", "color": "black", "fmt": "%.3g"}
                look = {"scalars": VALUES, "scalar_bar_args": bar}
                look |= {"cmap": COLOUR_MAP, "clim": colours.limits}
            tube = _tube(q[None, :], part, pieces, values)
            plotter.add_mesh(tube, smooth_shading=True, specular=0.3, **look)
        for solid in outline.solids:
            for mesh in _meshes(q[None, :], solid):
                plotter.add_mesh(mesh, color=BODY_COLOUR, specular=0.3)
        for rope in _ropes(outline, q, np.ptp(np.reshape(plotter.bounds, (3, 2)), axis=1).max()):
            plotter.add_mesh(rope, color=ROPE_COLOUR)
        for lines in _obstacles(outline, q, float(states.t[0])):
            plotter.add_mesh(lines, color=OBSTACLE_COLOUR, lighting=False)
        plotter.set_background("white")
        centre = np.array(plotter.center)
        plotter.camera_position = [tuple(centre + eye), tuple(centre), tuple(up)]
        plotter.reset_camera()
        plotter.screenshot(str(target))
    finally:
        plotter.close()
    return target


def _tube(q: Vector, part: BodyAxis, pieces: int, values: Vector) -> Any:
    """Return a tube with the area of the section of a body, and values of its elements."""
    lines = trace_elements(q, part, pieces)[0]
    n_elements, n_points, dim = lines.shape
    points = np.zeros((n_elements * n_points, 3))
    points[:, :dim] = lines.reshape(-1, dim)
    links = np.arange(n_elements * n_points).reshape(n_elements, n_points)
    cells = np.column_stack([np.full(n_elements, n_points), links])
    mesh = pv.PolyData(points, lines=cells.ravel())
    mesh[VALUES] = np.repeat(values, n_points)
    return mesh.tube(radius=part.radius, n_sides=TUBE_SIDES, capping=True)


def _meshes(q: Vector, solid: RigidOutline) -> list[Any]:
    """Return the surface of a rigid body, or thin tubes if it has none."""
    drawn = make_wireframe(solid)
    there = trace_points(q, solid, drawn)[0]
    points = np.zeros((len(there), 3))
    points[:, : there.shape[1]] = there
    if len(drawn.facets):
        cells = np.column_stack([np.full(len(drawn.facets), 3), drawn.facets])
        return [pv.PolyData(points, faces=cells.ravel())]
    radius = LINE_RADIUS * float(np.ptp(points, axis=0).max())
    ends = points[drawn.edges]
    pairs = ends[np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) > radius]
    return [pv.Line(*pair).tube(radius=radius, n_sides=TUBE_SIDES) for pair in pairs]


def _ropes(outline: Outline, q: Vector, extent: float) -> list[Any]:
    """Return ropes, springs and distance joints as thin tubes."""
    ends = np.zeros((len(outline.links), 2, 3))
    ends[..., : outline.dim] = outline.links.ends(q[None])[0]
    pairs = ends[np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) > ROPE_RADIUS * extent]
    return [pv.Line(*pair).tube(radius=ROPE_RADIUS * extent, n_sides=TUBE_SIDES) for pair in pairs]


def _obstacles(outline: Outline, q: Vector, time: float) -> list[Any]:
    """Return the lines of obstacles as thin tubes in one mesh."""
    scene = trace_scene(outline, q[None], np.array([time]))
    limits = axis_limits(scene.frame)
    lines = scene.trace_obstacles(0, limits)
    if not len(lines):
        return []
    points = np.zeros((2 * len(lines), 3))
    points[:, : outline.dim] = lines.reshape(-1, outline.dim)
    ends = np.arange(len(points)).reshape(-1, 2)
    mesh = pv.PolyData(points, lines=np.column_stack([np.full(len(ends), 2), ends]).ravel())
    return [mesh.tube(radius=ROPE_RADIUS * float(np.ptp(limits, axis=0).max()), n_sides=8)]
