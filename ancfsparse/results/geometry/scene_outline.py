"""Outline of a scene for plots, also stored in the file of a run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.results.data.hdf5_format import DAMAGE_ERRORS, describe_damage
from ancfsparse.results.geometry.body_outlines import (
    PACKED,
    RigidOutline,
    make_solid,
    read_solids,
    write_solids,
)
from ancfsparse.results.geometry.connection_lines import (
    ConnectionLines,
    make_connections,
    no_connections,
    read_connections,
)
from ancfsparse.results.geometry.obstacle_outlines import (
    collect_obstacles,
    make_moving_obstacles,
    read_obstacles,
    write_obstacles,
)
from ancfsparse.scene import Body, ElasticBody, Point
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.force_elements.obstacles import Obstacle
from ancfsparse.scene.joints.joint import Mark
from ancfsparse.system.system import System

if TYPE_CHECKING:
    import h5py

SUPPORT_KINDS = ("pin", "clamp", "rod", "joint", "mass", "force", "moment")
"""Kinds of supports, and of masses and loads; files contain their indices."""


@dataclass(frozen=True, eq=False)
class BodyAxis:
    """Axis of a beam or a mesh.

    Attributes
    ----------
    name : str
        Name of the body.
    lengths : ndarray, shape (n_elements,)
        Lengths of its elements [m].
    places : ndarray of int, shape (n_elements, 4, dim), of strings (n_elements, 2, dim)
        Coordinates of position and slope of both ends of every element; strings have no slopes.
    radius : float
        Radius of the circle with the area of its section [m].
    """

    name: str
    lengths: Vector
    places: NDArray[np.int32]
    radius: float


@dataclass(frozen=True, eq=False)
class Support:
    """A joint to the ground, the common point of a rigid and another body, a mass or a load.

    Attributes
    ----------
    kind : str
        One of `SUPPORT_KINDS`.
    places : ndarray of int, shape (dim, p)
        Coordinates that the position of the supported point depends on.
    weights : ndarray, shape (p,)
        Their weights.
    other : ndarray, shape (dim,)
        Direction out of the wall for a clamp [-], anchor for a rod [m], direction of a load [-].
    """

    kind: str
    places: NDArray[np.int32]
    weights: Vector
    other: Vector


@dataclass(frozen=True, eq=False)
class Outline:
    """Axes of beams and meshes, outlines of rigid bodies, supports, lines and obstacles.

    Attributes
    ----------
    gravity : ndarray, shape (dim,)
        Acceleration of gravity [m/s2].
    parts : list of Part
        The beams and meshes, in the order of the scene.
    solids : list of Solid
        The rigid bodies, in the order of the scene.
    supports : list of Support
        Pins, clamps, rods and joints, masses and loads.
    links : Links
        Ropes, springs and distances.
    obstacles : list of Obstacle
        The fixed bodies that beams and meshes touch.
    """

    gravity: Vector
    parts: list[BodyAxis]
    solids: list[RigidOutline]
    supports: list[Support]
    links: ConnectionLines
    obstacles: list[Obstacle]

    @property
    def dim(self) -> int:
        """Components of a position, 2 or 3."""
        return len(self.gravity)

    @property
    def nbytes(self) -> int:
        """Bytes of all tables."""
        beams = sum(each.places.nbytes + each.lengths.nbytes for each in self.parts)
        links = self.links.places.nbytes + self.links.weights.nbytes + self.links.fixed.nbytes
        return beams + links + sum(each.places.nbytes + each.points.nbytes for each in self.solids)

    def write(self, file: h5py.File) -> None:
        """Write the outline to the file of a run, as the group ``outline``."""
        group = file.create_group("outline")
        group.attrs["gravity"], group.attrs["bodies"] = self.gravity, len(self.parts)
        for k, part in enumerate(self.parts):
            body = group.create_group(f"body {k}")
            body.attrs["name"], body.attrs["radius"] = np.bytes_(part.name.encode()), part.radius
            body.create_dataset("lengths", data=part.lengths, **PACKED)
            body.create_dataset("places", data=part.places, **PACKED)
        write_solids(group, self.solids)
        self.links.write(group)
        write_obstacles(group, self.obstacles)
        if self.supports:
            kinds = [SUPPORT_KINDS.index(each.kind) for each in self.supports]
            group.create_dataset("support kinds", data=np.array(kinds, np.int8), **PACKED)
            width = max(len(each.weights) for each in self.supports)
            places = np.zeros((len(kinds), self.dim, width), np.int32)
            weights = np.zeros((len(kinds), width))
            for k, each in enumerate(self.supports):
                places[k, :, : len(each.weights)] = each.places
                weights[k, : len(each.weights)] = each.weights
            group.create_dataset("support places", data=places, **PACKED)
            group.create_dataset("support weights", data=weights, **PACKED)
            others = np.stack([each.other for each in self.supports])
            group.create_dataset("support others", data=others, **PACKED)

    @staticmethod
    def read(path: Path, file: h5py.File) -> Outline | None:
        """Read the outline; None from a file of an early version, or without all coordinates.

        Raises
        ------
        InputError
            If the file is damaged.
        """
        if "outline" not in file:
            return None
        group, n = file["outline"], int(file.attrs["coordinates"])
        try:
            parts = []
            for k in range(sum(name.startswith("body ") for name in group)):
                body = group[f"body {k}"]
                name = bytes(body.attrs["name"]).decode()
                lengths, places = np.asarray(body["lengths"]), np.asarray(body["places"])
                parts.append(BodyAxis(name, lengths, places, float(body.attrs["radius"])))
            solids = read_solids(group)
            supports = _read_supports(group) if "support kinds" in group else []
            gravity = np.asarray(group.attrs["gravity"])
            links = read_connections(group, len(gravity))
            obstacles = read_obstacles(group)
            # Files of earlier versions have no such number, and at least one body.
            lost = len(parts) != group.attrs.get("bodies", max(len(parts), 1))
        except DAMAGE_ERRORS as error:
            raise InputError(describe_damage(path, ": its outline is lost")) from error
        if not (lost or parts or solids):
            return None
        every = [each.places for some in (parts, solids, supports, [links]) for each in some]
        if lost or any(((each < 0) | (each >= n)).any() for each in every):
            raise InputError(describe_damage(path, ": its outline is lost"))
        return Outline(gravity, parts, solids, supports, links, obstacles)


def _read_supports(group: h5py.Group) -> list[Support]:
    """Read the supports; in files of early versions they are at nodes and have no weights."""
    kinds, places, others = (
        np.asarray(group[f"support {each}"]) for each in ("kinds", "places", "others")
    )
    if "support weights" in group:
        weights = np.asarray(group["support weights"])
    else:
        places, weights = places[..., None], np.ones((len(kinds), 1))
    rows = zip(kinds, places, weights, others, strict=True)
    return [Support(SUPPORT_KINDS[kind], *rest) for kind, *rest in rows]


def make_part(system: System, body: ElasticBody) -> BodyAxis:
    """Return the axis of one body of a system."""
    ends, kind = system.elements(body).reshape(body.n_elements, 2, -1), body.kind
    each = [ends[:, end, kind.columns(name)] for end in (0, 1) for name in kind.axis]
    places = np.stack(each, axis=1)
    return BodyAxis(body.name, body.lengths, places, float(np.sqrt(body.section.area / np.pi)))


def make_outline(system: System, of: Body | None = None) -> Outline:
    """Return the outline of a system, or of one of its bodies."""
    bodies = system.bodies if of is None else (of,)
    supports = []
    used: dict[str, list[Point]] = {}
    for joint in system.joints:
        for node in joint.nodes:
            used.setdefault(node.beam.name, []).append(node)
        node, mark = joint.nodes[0], joint.mark
        if joint.joins and any(isinstance(each.beam, RigidBody) for each in joint.nodes):
            mark = Mark("joint")
        if mark is None or of not in (None, node.beam):
            continue
        other = np.zeros(system.scene.dim) if mark.other is None else mark.other
        supports.append(_support(system, mark.kind, node, other))
    supports += [
        _support(system, kind, node, np.zeros(system.scene.dim) if direction is None else direction)
        for element in (*system.attachments, *system.external_loads)
        for kind, node, direction in element.marks
        if of in (None, node.beam)
    ]
    ends = [end for element in system.attachments for pair in element.links for end in pair]
    for end in ends:
        if isinstance(end, Point):
            used.setdefault(end.beam.name, []).append(end)
    parts = [make_part(system, body) for body in bodies if isinstance(body, ElasticBody)]
    solids = [
        make_solid(system, body, used.get(body.name, []))
        for body in bodies
        if isinstance(body, RigidBody)
    ]
    solids += make_moving_obstacles(system, of)
    links = make_connections(system) if of is None else no_connections(system.scene.dim)
    obstacles = collect_obstacles(system, of)
    return Outline(system.scene.gravity, parts, solids, supports, links, obstacles)


def _support(system: System, kind: str, point: Point, other: Vector) -> Support:
    """Return the support at a point."""
    places, weights = system.point(point)
    return Support(kind, places.astype(np.int32), weights, other)
