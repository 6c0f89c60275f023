"""Frames: beams between nodes, welded where they meet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.checks import check_count, check_reals
from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import ElementKind
from ancfsparse.messages import format_value
from ancfsparse.scene.bodies.beam import Beam
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.bodies.element_choice import DEFAULTS, chosen_element
from ancfsparse.scene.meshing.node_edge_checks import checked_graph
from ancfsparse.scene.sections.material import Material
from ancfsparse.scene.sections.sections import AnySection

if TYPE_CHECKING:
    from ancfsparse.scene.scene import Scene

Vector = NDArray[np.float64]

# Sine of the angle between an edge and `up` below which it gives the section no direction.
ALONG = 1e-6


@dataclass(frozen=True, eq=False, repr=False)
class Frame:
    """Beams that are welded at their ends, as `Scene.add_frame` returns them.

    Attributes
    ----------
    positions : ndarray, shape (n, dim)
        The nodes [m].
    edges : ndarray of int, shape (m, 2)
        Nodes at the start and the end of every beam.
    beams : tuple of Beam
        One for each edge.
    """

    positions: Vector
    edges: NDArray[np.int32]
    beams: tuple[Beam, ...]

    def __repr__(self) -> str:
        """Count nodes and beams."""
        length = sum(beam.length for beam in self.beams)
        return f"frame: {len(self.positions)} nodes, {len(self.beams)} beams, {length:.6g} m"

    def ends(self, node: int) -> list[Point]:
        """Return the ends of all beams that meet at a node.

        Parameters
        ----------
        node : int
            Number of the node, in the order given.
        """
        number = check_count("the number of a node", node, 0)
        if number >= len(self.positions):
            raise InputError(
                f"the frame has nodes 0 to {len(self.positions) - 1}, there is no node {number}"
            )
        pairs = zip(self.beams, self.edges, strict=True)
        found = [(beam, end) for beam, edge in pairs for end in (0, 1) if edge[end] == number]
        return [beam.end if end else beam.start for beam, end in found]

    def node(self, node: int) -> Point:
        """Return the handle of a node, for joints, loads and results.

        Parameters
        ----------
        node : int
            Number of the node, in the order given.
        """
        return self.ends(node)[0]

    def at(self, edge: int, s: float) -> Point:
        """Return the point of a beam at an arc coordinate.

        Parameters
        ----------
        edge : int
            Number of the beam.
        s : float
            Distance from its start [m].
        """
        number = check_count("the number of an edge", edge, 0)
        if number >= len(self.beams):
            raise InputError(
                f"the frame has edges 0 to {len(self.beams) - 1}, there is no edge {number}"
            )
        return self.beams[number].at(s)


def frame_of(
    scene: Scene,
    label: str,
    nodes: ArrayLike,
    edges: ArrayLike | None,
    element: str | ElementKind,
    n_elements: int,
    section: AnySection,
    material: Material,
    up: ArrayLike | None,
    options: dict[str, str],
) -> Frame:
    """Add the beams of a frame to a scene, and weld them; nothing is added if they do not fit.

    Parameters
    ----------
    scene : Scene
        To which they are added.
    label : str
        Its name; beams are called by it and the number of their edge.
    nodes, edges, element, n_elements, section, material, up
        As in `Scene.add_frame`.
    options : dict
        Those of `Scene.add_beam` that the element has.
    """
    if edges is None:
        count = len(np.atleast_1d(check_reals(f"nodes of {label}", nodes, "a table of positions")))
        edges = np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)
    positions, pairs, _ = checked_graph(label, scene.dim, nodes, edges)
    name, _, kind = chosen_element(label, element, scene.dim, DEFAULTS | options)
    if kind.is_string or (kind.is_cable and scene.dim == 3):
        raise InputError(
            f"{label} cannot be made of {name!r}: the coordinates of "
            + ("strings do not" if kind.is_string else "cables in space do not")
            + " include the rotation that a weld holds; take 'thick', or add_mesh, whose edges "
            "have hinges"
        )
    ways = positions[pairs[:, 1]] - positions[pairs[:, 0]]
    directions = _directions(label, up, ways, scene.dim)
    beams = tuple(
        scene.add_beam(
            element, positions[a], positions[b], n_elements, section, material,
            strain=options["strain"], curvature=options["curvature"],
            section_strain=options["section_strain"], up=direction, name=f"{label}, edge {k}",
        )
        for k, ((a, b), direction) in enumerate(zip(pairs, directions, strict=True))
    )  # fmt: skip
    frame = Frame(positions, pairs, beams)
    for k in range(len(positions)):
        first, *others = frame.ends(k)
        for other in others:
            scene.weld(other, first)
    return frame


def _directions(label: str, up: ArrayLike | None, ways: Vector, dim: int) -> list[Vector | None]:
    """Return the direction of e_y of every edge, checked."""
    if up is None:
        return [None] * len(ways)
    if dim == 2:
        raise InputError(
            f"`up` of {label} has no meaning in a planar scene, where the height of the section "
            "lies in the plane: leave it out"
        )
    needed = f"one direction, or one for each of its {len(ways)} edges"
    given = check_reals(f"`up` of {label}", up, needed)
    if given.shape not in ((3,), ways.shape) or not np.isfinite(given).all():
        raise InputError(f"`up` of {label} must be {needed}, got {format_value(up)}")
    table = np.broadcast_to(given, ways.shape)
    sizes = np.linalg.norm(table, axis=1) * np.linalg.norm(ways, axis=1)
    across = np.linalg.norm(np.cross(table, ways), axis=1)
    if (across <= ALONG * sizes).any():
        k = int(np.argmax(across <= ALONG * sizes))
        raise InputError(
            f"`up` of {label} is parallel to edge {k} and cannot say where its section points: "
            "leave it out, or give a direction for every edge"
        )
    return list(table)
