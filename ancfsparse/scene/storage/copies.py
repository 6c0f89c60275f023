"""Copies of a scene: refined, or with other arguments in one call."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

from numpy.typing import ArrayLike

from ancfsparse.checks import check_choice, check_count
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.bodies.auto_element import AUTO_ELEMENTS
from ancfsparse.scene.bodies.body import Body, Point
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.record import BodyRef, PointRef, Record

AnyScene = TypeVar("AnyScene", bound=SceneBase)


def build(like: AnyScene, records: Iterable[Record], gravity: ArrayLike | None = None) -> AnyScene:
    """Build a scene from records, by default with the gravity of another scene [m/s2]."""
    scene = type(like)(like.gravity if gravity is None else gravity)
    for record in records:
        record.build(scene)
    return scene


def refined(scene: AnyScene, factor: int) -> AnyScene:
    """Return a copy with every element divided; see `Scene.refined`."""
    times = check_count("the factor of refined", factor)
    finer: dict[int, Record] = {}
    for body in scene.beams:
        record = scene.record_of(body)
        finer[id(record)] = replace(record, **body.finer(times))
    return build(scene, _with(scene, finer))


def replaced(
    scene: AnyScene, handle: object, gravity: ArrayLike | None, changes: Mapping[str, Any]
) -> AnyScene:
    """Return a copy with other arguments in one call; see `Scene.replaced`."""
    if handle is None:
        if changes:
            raise InputError(
                f"replaced was given {next(iter(changes))!r} but no handle: give the beam, joint "
                "or load to change first"
            )
        return build(scene, scene.records, gravity)
    record = scene.record_of(handle)
    for name in changes:
        check_choice(f"argument of {record.method}", name, record.given)
    other = replace(record, **{name: _as_data(scene, value) for name, value in changes.items()})
    return build(scene, _with(scene, {id(record): other}), gravity)


def counterpart(scene: SceneBase, handle: Body | Point) -> Any:
    """Return the handle of the same body or point in a scene; see `Scene.counterpart`."""
    if isinstance(handle, Point):
        here = scene.body(handle.beam.name)
        if type(here) is not type(handle.beam):
            raise InputError(f"{here.name} of this scene is not a {type(handle.beam).__name__}")
        return here.point(handle.beam.among(here.n_each, handle))
    if isinstance(handle, Body):
        return scene.body(handle.name)
    raise InputError(
        f"counterpart needs a beam, a mesh or a point on one, got {format_value(handle)}"
    )


def _with(scene: SceneBase, others: Mapping[int, Record]) -> list[Record]:
    """Return the records of a scene with some replaced, and with adapted references to points."""
    bodies = {body.name: others.get(id(scene.record_of(body))) for body in scene.bodies}

    def move(reference: BodyRef) -> BodyRef:
        new = bodies.get(reference.body)
        if new is None:
            return reference
        if isinstance(reference, PointRef):
            node, count = reference.of(scene), 0
            if node.beam.n_elements:
                count = _count(new)
            reference = node.beam.among(count, node)
        return replace(reference, body=new.given["name"])

    return [others.get(id(record)) or record.moved(move) for record in scene.records]


def _count(record: Record) -> int:
    """Return the number of elements of a beam, or of every edge of a mesh, from its record."""
    n_elements = record.given["n_elements"]
    if isinstance(n_elements, str) and n_elements == "auto":
        return 1 if record.method == "add_mesh" else AUTO_ELEMENTS
    return check_count(f"n_elements of {record.given['name']}", n_elements)


def _as_data(scene: SceneBase, value: Any) -> Any:
    """Return an argument as data, with handles replaced by references."""
    if isinstance(value, Joint):
        return scene._joint("replaced", value)
    if isinstance(value, Body | Point):
        body = value if isinstance(value, Body) else value.beam
        if scene.body(body.name) is not body:
            raise InputError(f"replaced was given {value!r} of another scene")
        return value.reference
    if isinstance(value, list | tuple) and any(isinstance(item, Body | Point) for item in value):
        return tuple(_as_data(scene, item) for item in value)
    return value
