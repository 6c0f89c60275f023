"""The method of a scene that adds frames of welded beams."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_reals
from ancfsparse.errors import InputError
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.messages import format_value
from ancfsparse.scene import bodies, meshing
from ancfsparse.scene.bodies.element_choice import chosen_element, refuse_in_plane
from ancfsparse.scene.methods.add_bodies import Bodies
from ancfsparse.scene.methods.add_mechanisms import Mechanisms
from ancfsparse.scene.sections.cross_section import AnySection
from ancfsparse.scene.sections.material import Material

MIN_SINE = 1e-6  # of the angle between an edge and `up`


class Frames(Bodies, Mechanisms):
    """Frames of a scene: beams between nodes, welded where they meet."""

    def add_frame(
        self,
        nodes: ArrayLike,
        edges: ArrayLike | None,
        element: str | ElementKind,
        n_elements: int,
        section: AnySection,
        material: Material,
        *,
        up: ArrayLike | None = None,
        strain: str | None = None,
        curvature: str | None = None,
        section_strain: str | None = None,
        name: str | None = None,
    ) -> bodies.Frame:
        """Add straight, stress-free beams between nodes, welded where they meet.

        Parameters
        ----------
        nodes : array_like, shape (n, dim)
            Positions of the nodes [m], each of them at the end of some edge.
        edges : array_like of int, shape (m, 2), or None
            The two nodes of every beam, numbered from 0; None for a polyline from node to node.
        element : str or ElementKind
            ``"thick"``, or in the plane also ``"thin"`` and ``"l2t2"``.
        n_elements : int
            Number of elements of every beam.
        section : AnySection
            Cross-section of all beams.
        material : Material
            Their material.
        up : array_like, shape (3,) or (m, 3), optional
            Approximate direction of e_y of all sections in space, or one for each edge, as in
            `add_beam`.
        strain, curvature, section_strain : str, optional
            As in `add_beam`.
        name : str, optional
            Name in messages; by default ``"frame 0"`` for the first body and so on.

        Returns
        -------
        Frame
            Its `beams`, and handles by `node` and `at`.

        Raises
        ------
        InputError
            If an argument is invalid; nothing has been added then.

        Notes
        -----
        It calls `add_beam` and `weld`, whose records the scene stores.  Beams of different sections
        are welded by these methods too.
        """
        label = self._label(name, "frame")
        options = {"strain": strain, "curvature": curvature, "section_strain": section_strain}
        if edges is None:
            needed = "a table of positions"
            count = len(np.atleast_1d(check_reals(f"nodes of {label}", nodes, needed)))
            edges = np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)
        positions, pairs, _ = meshing.check_graph(label, self.dim, nodes, edges)
        element_name, _, kind = chosen_element(label, element, self.dim, options)
        if kind.is_string or (kind.is_cable and self.dim == 3):
            raise InputError(
                f"{label} cannot be made of {element_name!r}: the coordinates of "
                + ("strings do not" if kind.is_string else "cables in space do not")
                + " include the rotation that a weld constrains; take 'thick', or add_mesh, whose "
                "edges have hinges"
            )
        chords = positions[pairs[:, 1]] - positions[pairs[:, 0]]
        directions = _section_directions(label, up, chords, self.dim)
        beams = tuple(
            self.add_beam(
                element, positions[a], positions[b], n_elements, section, material,
                strain=strain, curvature=curvature, section_strain=section_strain,
                up=direction, name=f"{label}, edge {k}",
            )
            for k, ((a, b), direction) in enumerate(zip(pairs, directions, strict=True))
        )  # fmt: skip
        frame = bodies.Frame(positions, pairs, beams)
        for node in range(len(positions)):
            first, *others = frame.ends(node)
            for other in others:
                self.weld(other, first)
        return frame


def _section_directions(
    label: str, up: ArrayLike | None, chords: Vector, dim: int
) -> list[Vector | None]:
    """Return the direction of e_y of every edge, checked."""
    if up is None:
        return [None] * len(chords)
    if dim == 2:
        refuse_in_plane(label, "up")
    needed = f"one direction, or one for each of its {len(chords)} edges"
    given = check_reals(f"`up` of {label}", up, needed)
    if given.shape not in ((3,), chords.shape) or not np.isfinite(given).all():
        raise InputError(f"`up` of {label} must be {needed}, got {format_value(up)}")
    table = np.broadcast_to(given, chords.shape)
    sizes = np.linalg.norm(table, axis=1) * np.linalg.norm(chords, axis=1)
    across = np.linalg.norm(np.cross(table, chords), axis=1)
    if (across <= MIN_SINE * sizes).any():
        k = int(np.argmax(across <= MIN_SINE * sizes))
        raise InputError(
            f"`up` of {label} is parallel to edge {k} and cannot say where its section points: "
            "leave it out, or give a direction for every edge"
        )
    return list(table)
