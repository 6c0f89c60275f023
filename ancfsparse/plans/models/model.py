"""Models of a scene: an element and a mesh for every beam whose own are open."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ancfsparse.errors import InputError
from ancfsparse.plans.models.graded_mesh import Grade
from ancfsparse.plans.models.rigid_links import rod_of
from ancfsparse.scene import Beam, ElasticBody, Point, Scene
from ancfsparse.scene.bodies.auto_element import decided
from ancfsparse.scene.bodies.beam import BeamSpec
from ancfsparse.scene.bodies.mesh import MeshSpec
from ancfsparse.scene.records.record import BodyRef, PointRef


@dataclass(frozen=True)
class Rung:
    """An element with its options.

    Attributes
    ----------
    element : str
        Its name, as `Scene.add_beam` takes it.
    options : mapping of str to str
        Options that differ from their defaults.
    order : int
        Order with which positions converge in the length of the elements.
    """

    element: str
    options: Mapping[str, str] = field(default_factory=dict)
    order: int = 4

    def __str__(self) -> str:
        """Write the element."""
        return " ".join([f'"{self.element}"', *(f"{k}={v!r}" for k, v in self.options.items())])


# Numbers of elements this near a half are rounded as a half is.
ROUNDING = 1e-9
# Elements on the longest beam of the coarsest mesh.
FEWEST_ELEMENTS = 4.0
RIGID = Rung("rigid", {}, 8)
"""A rigid rod in place of a beam, with its mass and inertia; it has no mesh."""
ORDERS = {"string": 2, "l2t2": 4, "thin": 4, "thick": 2}
"""Orders of positions in the length of the elements (docs/accuracy.md)."""
OWN_ORDER = 2  # of an element that was built outside this package, at least


def order_of(element: object) -> int:
    """Return the order with which positions converge in the length of an element."""
    return ORDERS.get(element, OWN_ORDER) if isinstance(element, str) else OWN_ORDER


@dataclass(frozen=True)
class Model:
    """What a scene is built with.

    Attributes
    ----------
    rungs : mapping of str to Rung
        Element of every beam whose element is open, by its name.
    counts : mapping of str to int
        Number of elements of every beam whose mesh is open, by its name; of a mesh of cables on
        every edge.
    grades : mapping of str to Grade
        How they are spread on beams that have no elements of one length, by its name.
    """

    rungs: Mapping[str, Rung] = field(default_factory=dict)
    counts: Mapping[str, int] = field(default_factory=dict)
    grades: Mapping[str, Grade] = field(default_factory=dict)

    def with_counts(self, counts: Mapping[str, int]) -> Model:
        """Return the same elements on another mesh; rigid rods have none."""
        open_ = {name: n for name, n in counts.items() if self.rungs.get(name) != RIGID}
        return replace(self, counts=open_)


def undecided(scene: Scene) -> list[ElasticBody]:
    """Return the beams and meshes of which something is open."""
    return [body for body in scene.beams if body.automatic]


def built(scene: Scene, model: Model) -> Scene:
    """Return a scene with the elements and meshes of a model; itself if nothing is open.

    Joints, loads and what is attached keep their places along the beams, and inner places that are
    nodes of the handle become nodes.

    Raises
    ------
    InputError
        If an element does not take what the scene has.
    """
    beams = {beam.name: beam for beam in undecided(scene)}
    if not beams:
        return scene
    inner = inner_nodes(scene, beams)
    new = type(scene)(scene.gravity)

    def move(reference: BodyRef) -> BodyRef:
        if not isinstance(reference, PointRef) or reference.body not in beams:
            return reference
        node = beams[reference.body].point(reference)
        return new.body(reference.body).corresponding_point(node).reference

    for record in scene.records:
        if isinstance(record, BeamSpec) and record.name in beams:
            beam = beams[record.name]
            assert isinstance(beam, Beam)
            if model.rungs.get(beam.name) == RIGID:
                rod_of(beam).build(new)
                continue
            record = replace(record, **_changes(beam, model, inner[beam.name]))
        elif isinstance(record, MeshSpec) and record.name in beams:
            record = _of_mesh(record, model)
        record.moved(move).build(new)
    return new


def counterpart(scene: Scene, node: Point) -> Point:
    """Return the same point of a scene that was built from the one it is of."""
    body = scene.body(node.beam.name)
    if body is node.beam:
        return node
    if node.beam.automatic and not body.automatic:
        return decided(body, node)
    found: Point = scene.counterpart(node)
    return found


def refined(scene: Scene) -> Scene | None:
    """Return the scene with every given mesh twice as fine; None if no mesh is given."""
    given = [beam.name for beam in scene.beams if "n_elements" not in beam.automatic]
    for name in given:
        body = scene.body(name)
        assert isinstance(body, ElasticBody)
        scene = scene.replaced(body, **body.finer(2))
    return scene if given else None


def spread(scene: Scene, finest: float) -> dict[str, int]:
    """Return numbers of elements of one length for all beams and edges whose mesh is open.

    Parameters
    ----------
    scene : Scene
        The scene.
    finest : float
        Number of elements on the longest of these; shorter ones have one at least.
    """
    lengths = _divided(scene)
    longest = max(lengths.values(), default=1.0)
    return {name: max(1, _whole(finest * each / longest)) for name, each in lengths.items()}


def _whole(count: float) -> int:
    """Round a number of elements, halves upwards: lengths that are equal but for rounding alike."""
    return math.floor(count + 0.5 + ROUNDING)


def coarsest(scene: Scene, across: float) -> float:
    """Return the number of elements on the longest open beam or edge of a coarse mesh.

    Parameters
    ----------
    scene : Scene
        The scene.
    across : float
        Number of elements on a beam; or, where meshes of cables alone are open, across the largest.
    """
    lengths = _divided(scene)
    bodies = [scene.body(name) for name in lengths]
    if not bodies or any(isinstance(body, Beam) for body in bodies):
        return across
    return max(1.0, across * max(lengths.values()) / max(body.size for body in bodies))


def _divided(scene: Scene) -> dict[str, float]:
    """Return the lengths of what is to be divided, by name: beams, or the longest of the edges."""
    return {
        body.name: body.length if isinstance(body, Beam) else float(body.lengths.max())
        for body in undecided(scene)
        if "n_elements" in body.automatic
    }


def inner_nodes(scene: Scene, beams: Mapping[str, ElasticBody]) -> dict[str, set[float]]:
    """Return the shares of the length at which records refer to inner nodes of the handles."""
    inner: dict[str, set[float]] = {name: set() for name in beams}

    def note(reference: BodyRef) -> BodyRef:
        if isinstance(reference, PointRef) and reference.body in beams and reference.xi == 0.0:
            beam = beams[reference.body]
            if isinstance(beam, Beam) and 0 < reference.index < beam.n_elements:
                inner[beam.name].add(reference.index / beam.n_elements)
        return reference

    for record in scene.records:
        record.moved(note)
    return inner


def _of_mesh(record: MeshSpec, model: Model) -> MeshSpec:
    """Return the record of a mesh with an element, and with a number of them on every edge.

    Raises
    ------
    InputError
        If it is neither a string nor a cable.
    """
    assert record.name is not None
    rung, count = model.rungs.get(record.name), model.counts.get(record.name)
    if rung is not None:
        if rung.options or rung == RIGID:
            raise InputError(
                f"{record.name} is a mesh, which has strings or cables, and not {rung}"
            )
        record = replace(record, element=rung.element)
    return record if count is None else replace(record, n_elements=count)


def _changes(beam: Beam, model: Model, inner: set[float]) -> dict[str, Any]:
    """Return what changes in the record of a beam."""
    changes: dict[str, Any] = {}
    if "element" in beam.automatic:
        rung = model.rungs[beam.name]
        changes |= {"element": rung.element, **rung.options}
    if "n_elements" in beam.automatic:
        count, grade = model.counts[beam.name], model.grades.get(beam.name)
        changes |= _graded(count, sorted(inner), grade) if grade else _mesh(count, sorted(inner))
    return changes


def _graded(count: int, inner: list[float], grade: Grade) -> dict[str, Any]:
    """Return a graded mesh of about so many elements with nodes at inner places."""
    nodes = grade.mesh(count, inner)
    return {"n_elements": len(nodes) - 1, "nodes": tuple(nodes.tolist())}


def _mesh(count: int, inner: list[float]) -> dict[str, Any]:
    """Return a mesh of about so many elements with nodes at inner places.

    Each part between two places is divided evenly, in proportion to its length.
    """
    if not inner:
        return {"n_elements": max(1, count)}
    ends = np.array([0.0, *inner, 1.0])
    parts = [max(1, _whole(count * each)) for each in np.diff(ends)]
    total = sum(parts)
    even = np.cumsum([0, *parts]) / total
    if np.allclose(even, ends, rtol=0.0, atol=1e-12):
        return {"n_elements": total}
    pieces = [np.linspace(a, b, n + 1)[:-1] for a, b, n in zip(ends, ends[1:], parts, strict=False)]
    return {"n_elements": total, "nodes": (*np.concatenate(pieces).tolist(), 1.0)}
