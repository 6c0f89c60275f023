"""Models of a scene: an element and a mesh for every beam with automatic ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import ElementChoice
from ancfsparse.plans.models.graded_mesh import (
    UNIFORM,
    MeshGrading,
    part_counts,
    round_half_up,
)
from ancfsparse.plans.models.rigid_links import references, rigid_rod
from ancfsparse.scene import Beam, ElasticBody, Point, Scene
from ancfsparse.scene.bodies.auto_element import decided
from ancfsparse.scene.bodies.mesh import MeshSpec
from ancfsparse.scene.records.record import BodyRef, PointRef, Record

# Distance over the length of a beam below which two points share a node.  With elements of 1e-6 of
# the length, rounding is as large as the loads, and equilibria of cables and beams are not found.
MIN_NODE_DISTANCE = 1e-4
MIN_LONGEST_COUNT = 4.0  # elements on the longest beam of the coarsest mesh
RIGID = ElementChoice("rigid", neglects=frozenset({"flexibility"}))
"""A rigid rod in place of a beam, with its mass and inertia; it has no mesh."""


@dataclass(frozen=True)
class Model:
    """Elements and meshes of the beams with automatic ones, by name of the beam.

    Attributes
    ----------
    elements : mapping of str to ElementChoice
        Element of every beam with an automatic element.
    counts : mapping of str to int
        Number of elements of every beam with an automatic mesh; of a mesh of cables on every edge.
    gradings : mapping of str to MeshGrading
        Distribution of the elements of beams whose elements differ in length.
    nodes : mapping of str to tuple of float
        Relative positions of nodes of every mesh, besides those that records refer to.
    """

    elements: Mapping[str, ElementChoice] = field(default_factory=dict)
    counts: Mapping[str, int] = field(default_factory=dict)
    gradings: Mapping[str, MeshGrading] = field(default_factory=dict)
    nodes: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    def with_counts(self, counts: Mapping[str, int]) -> Model:
        """Return the same elements on another mesh; rigid rods have no mesh."""
        open_ = {name: n for name, n in counts.items() if self.elements.get(name) != RIGID}
        return replace(self, counts=open_)


def requested_key(model: Model) -> tuple[object, ...]:
    """Return the key of a model before it is built."""
    gradings = sorted((name, each.element_fractions) for name, each in model.gradings.items())
    nodes = sorted(model.nodes.items())
    return (*_element_names(model), *sorted(model.counts.items()), *gradings, *nodes)


def built_key(model: Model, scene: Scene) -> tuple[object, ...]:
    """Return the key of a model after it was built: its elements and meshes.

    Nodes at given positions of a beam may turn several numbers of elements into one mesh.
    """
    bodies = {name: cast(ElasticBody, scene.body(name)) for name in sorted(model.counts)}
    counts = ((name, body.n_elements) for name, body in bodies.items())
    lengths = (body.lengths.tobytes() for body in bodies.values())
    return (*_element_names(model), *counts, *lengths)


def _element_names(model: Model) -> list[tuple[str, str]]:
    return sorted((name, str(element)) for name, element in model.elements.items())


def open_bodies(scene: Scene) -> list[ElasticBody]:
    """Return the beams and meshes with an automatic element or mesh."""
    return [body for body in scene.beams if body.automatic]


def build_model(scene: Scene, model: Model) -> Scene:
    """Return a scene with the elements and meshes of a model; itself if none is automatic.

    Joints, loads and force elements keep their positions along the beams, which become nodes.

    Raises
    ------
    InputError
        If an element does not admit a part of the scene.
    """
    beams = {beam.name: beam for beam in open_bodies(scene)}
    if not beams:
        return scene
    inner = inner_node_positions(scene, beams, model.nodes)
    return _rebuild(
        scene, {name: _record(scene, beam, model, inner[name]) for name, beam in beams.items()}
    )


def _record(scene: Scene, body: ElasticBody, model: Model, inner: list[float]) -> Record:
    """Return the record of a beam or mesh with the element and the mesh of a model."""
    record = scene.record_of(body)
    if isinstance(record, MeshSpec):
        return _of_mesh(record, model)
    assert isinstance(body, Beam)
    if model.elements.get(body.name) == RIGID:
        return rigid_rod(body)
    return replace(record, **_changes(body, model, inner))


def mesh_counts(scene: Scene, model: Model) -> dict[str, int]:
    """Return the number of elements of each beam, or on every edge, that a model meshes.

    Inner nodes change the requested numbers.
    """
    beams = {beam.name: beam for beam in open_bodies(scene) if beam.name in model.counts}
    inner = inner_node_positions(scene, beams, model.nodes)
    counts = dict(model.counts)
    for name, beam in beams.items():
        if isinstance(beam, Beam):
            counts[name] = _changes(beam, model, inner[name]).get("n_elements", counts[name])
    return counts


def element_lengths(scene: Scene, model: Model) -> Vector:
    """Return the mean lengths of the elements between inner nodes, of all parts, (n,) [m]."""
    beams = {beam.name: beam for beam in open_bodies(scene) if beam.name in model.counts}
    inner = inner_node_positions(scene, beams, model.nodes)
    out: list[float] = []
    for name, body in beams.items():
        count = model.counts[name]
        if isinstance(body, Beam):
            counts = model.gradings.get(name, UNIFORM).part_counts(count, inner[name])
            out += (body.length * np.diff([0.0, *inner[name], 1.0]) / counts).tolist()
        else:
            out.append(float(body.lengths.max()) / count)
    return np.array(out)


def _rebuild(scene: Scene, others: Mapping[str, Record]) -> Scene:
    """Return a scene with other records of some bodies; points on them keep their positions."""
    new = type(scene)(scene.gravity)

    def move(reference: BodyRef) -> BodyRef:
        if not isinstance(reference, PointRef) or reference.body not in others:
            return reference
        node = reference.of(scene)
        return new.body(reference.body).corresponding_point(node).reference

    by_record = {id(scene.record_of(scene.body(name))): other for name, other in others.items()}
    for record in scene.records:
        by_record.get(id(record), record).moved(move).build(new)
    return new


def find_counterpart(scene: Scene, node: Point) -> Point:
    """Return the same point in a scene that was built from its own."""
    body = scene.body(node.beam.name)
    if body is node.beam:
        return node
    is_finer = body.n_elements % (node.beam.n_elements or 1) == 0
    if (node.beam.automatic and not body.automatic) or not is_finer:
        return decided(body, node)
    other: Point = scene.counterpart(node)
    return other


def refine_given_meshes(scene: Scene) -> Scene | None:
    """Return the scene with every specified mesh halved; None if all meshes are automatic.

    Points at which records refer to beams become nodes.
    """
    given = [beam.name for beam in scene.beams if "n_elements" not in beam.automatic]
    for name in given:
        body = scene.body(name)
        assert isinstance(body, ElasticBody)
        scene = scene.replaced(body, **body.finer(2))
    return _insert_nodes(scene, given) if given else None


def _insert_nodes(scene: Scene, names: Sequence[str]) -> Scene:
    """Return the scene with additional nodes at the points of beams that records refer to.

    Beams with an eigenstrain of every element keep their elements.
    """
    beams = {name: cast(ElasticBody, scene.body(name)) for name in names}
    others: dict[str, Record] = {}
    for name, inner in inner_node_positions(scene, beams).items():
        beam = beams[name]
        if isinstance(beam, Beam) and beam.eigen is None:
            present = (beam.arcs / beam.length).tolist()
            nodes = sorted([*present, *_select_distant(inner, present)])
            if len(nodes) > len(present):
                changes = {"nodes": tuple(nodes), "n_elements": len(nodes) - 1}
                others[name] = replace(scene.record_of(beam), **changes)
    return _rebuild(scene, others) if others else scene


def element_counts(scene: Scene, n_longest: float) -> dict[str, int]:
    """Return numbers of elements of nearly equal length for all beams and edges to be meshed.

    The longest of these has `n_longest`; shorter ones have at least one.
    """
    lengths = _mesh_lengths(scene)
    longest = max(lengths.values(), default=1.0)
    counts = {name: round_half_up(n_longest * each / longest) for name, each in lengths.items()}
    return {name: max(1, count) for name, count in counts.items()}


def coarse_count(scene: Scene, across: float) -> float:
    """Return the number of elements on the longest beam or edge of a coarse mesh.

    With `across` elements on a beam; or, if only meshes of cables are automatic, across the largest
    of them.
    """
    lengths = _mesh_lengths(scene)
    bodies = [scene.body(name) for name in lengths]
    if not bodies or any(isinstance(body, Beam) for body in bodies):
        return across
    return max(1.0, across * max(lengths.values()) / max(body.size for body in bodies))


def _mesh_lengths(scene: Scene) -> dict[str, float]:
    """Return the lengths to be divided into elements, by name: of beams, or of longest edges."""
    return {
        body.name: body.length if isinstance(body, Beam) else float(body.lengths.max())
        for body in open_bodies(scene)
        if "n_elements" in body.automatic
    }


def inner_node_positions(
    scene: Scene,
    beams: Mapping[str, ElasticBody],
    nodes: Mapping[str, tuple[float, ...]] | None = None,
) -> dict[str, list[float]]:
    """Return the relative positions of inner points of beams that records refer to, in order.

    Forces, joints and force elements act there, so solutions have kinks, and every mesh has nodes.
    Other `nodes` are included.
    """
    referred: dict[str, set[float]] = {name: set((nodes or {}).get(name, ())) for name in beams}

    for reference in references(scene.records):
        beam = beams.get(reference.body)
        if isinstance(reference, PointRef) and isinstance(beam, Beam):
            referred[beam.name].add(beam.point(reference).s / beam.size)
    return {name: _select_distant(sorted(positions)) for name, positions in referred.items()}


def _select_distant(
    positions: Sequence[float], others: Sequence[float] = (0.0, 1.0)
) -> list[float]:
    """Return the positions, in order, that have a distance from each other and from others."""
    out: list[float] = []
    for each in positions:
        if all(abs(each - other) > MIN_NODE_DISTANCE for other in (*others, *out[-1:])):
            out.append(each)
    return out


def _of_mesh(record: MeshSpec, model: Model) -> MeshSpec:
    """Return the record of a mesh with the element and the number on every edge of a model.

    Raises
    ------
    InputError
        If the element is neither a string nor a cable.
    """
    assert record.name is not None
    element, count = model.elements.get(record.name), model.counts.get(record.name)
    if element is not None:
        if element.options or element == RIGID:
            raise InputError(
                f"{record.name} is a mesh, which takes strings or cables, not {element}"
            )
        record = replace(record, element=element.name)
    return record if count is None else replace(record, n_elements=count)


def _changes(beam: Beam, model: Model, inner: list[float]) -> dict[str, Any]:
    """Return the changes of the record of a beam."""
    changes: dict[str, Any] = {}
    if "element" in beam.automatic:
        element = model.elements[beam.name]
        changes |= {"element": element.name, **element.options}
    if "n_elements" in beam.automatic:
        count, grading = model.counts[beam.name], model.gradings.get(beam.name)
        if grading is None:
            return changes | _mesh(count, inner)
        nodes = grading.node_positions(count, inner)
        changes |= {"n_elements": len(nodes) - 1, "nodes": tuple(nodes.tolist())}
    return changes


def _mesh(count: int, inner: list[float]) -> dict[str, Any]:
    """Return a mesh of about `count` elements with nodes at inner positions.

    Each part between two positions is divided evenly, about in proportion to its length.
    """
    if not inner:
        return {"n_elements": max(1, count)}
    ends = np.array([0.0, *inner, 1.0])
    parts = part_counts(count, np.diff(ends).tolist())
    total = sum(parts)
    even = np.cumsum([0, *parts]) / total
    if np.allclose(even, ends, rtol=0.0, atol=1e-12):
        return {"n_elements": total}
    pieces = [np.linspace(a, b, n + 1)[:-1] for a, b, n in zip(ends, ends[1:], parts, strict=False)]
    return {"n_elements": total, "nodes": (*np.concatenate(pieces).tolist(), 1.0)}
