"""JSON files of scenes: the gravity, and one line for each record, a method and its arguments."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ancfsparse.checks import check_choice
from ancfsparse.errors import AncfError, InputError
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.messages import format_value
from ancfsparse.scene.bodies.rigid_shapes import SHAPE_TYPES
from ancfsparse.scene.force_elements.obstacles import OBSTACLE_TYPES
from ancfsparse.scene.geometry.curves import Arc, Helix
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.compiled_callbacks import is_compiled
from ancfsparse.scene.records.inputs import Input
from ancfsparse.scene.records.picklable_functions import MissingFunction
from ancfsparse.scene.records.record import RECORD_TYPES, REFERENCE_TYPES, BodyRef, Record
from ancfsparse.scene.records.signal import Sum
from ancfsparse.scene.records.signals import Pulse, Ramp, Sine, Table
from ancfsparse.scene.records.spin_up import SpinUp
from ancfsparse.scene.sections.cross_section import SECTION_TYPES
from ancfsparse.scene.sections.material import Material

FORMAT = "ancfsparse scene"
VERSION = 1
UNITS = "SI: m, kg, s, N, Pa, Hz, rad; smooth in degrees"
MAX_INLINE_NUMBERS = 1000  # of an array; larger ones are written in base64
# Classes of data in arguments, by name.
SIGNALS = (Table, Ramp, Sine, Pulse, SpinUp, Input, Sum)
CURVES = (Arc, Helix)
DATA: dict[str, type[Any]] = (
    SECTION_TYPES
    | SHAPE_TYPES
    | OBSTACLE_TYPES
    | {kind.__name__: kind for kind in (Material, *SIGNALS, *CURVES)}
)

AnyScene = TypeVar("AnyScene", bound=SceneBase)


def written(scene: SceneBase) -> str:
    """Return a scene as the text of its file.

    Raises
    ------
    InputError
        If a file cannot hold it.
    """
    names: dict[str, object] = {}
    lines = []
    for number, record in enumerate(scene.records):
        where = f"record {number + 1} of the scene, {record.method}"
        values = {name: encoded(each, where, names) for name, each in record.given.items()}
        lines.append(json.dumps({"method": record.method, **values}))
    head = {"format": FORMAT, "version": VERSION, "units": UNITS, "gravity": scene.gravity.tolist()}
    first = ",\n".join(f"{json.dumps(name)}: {json.dumps(each)}" for name, each in head.items())
    return f'{{{first},\n"records": [\n' + ",\n".join(lines) + "\n]}\n"


def built(
    kind: Callable[[Any], AnyScene], text: str | bytes, file: Path, own: Mapping[str, Any]
) -> AnyScene:
    """Build a scene of a class from the text of its file; `own` are those of `Scene.load`."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:  # not text or not JSON
        raise InputError(f"{file} is not a file of a scene: {error}") from error
    return built_from_records(kind, data, file, own)


def built_from_records(
    kind: Callable[[Any], AnyScene], data: Any, file: Path, own: Mapping[str, Any]
) -> AnyScene:
    """Build a scene of a class from the data of its file, a list of records."""
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise InputError(f"{file} is not a file of a scene: its format is not {FORMAT!r}")
    if data.get("version") != VERSION:
        raise InputError(
            f"{file} has version {format_value(data.get('version'))} of the format of scenes, and "
            f"this program reads version {VERSION}: update ancfsparse"
        )
    records = data.get("records")
    if not isinstance(records, list):
        raise InputError(f"{file} is damaged: it has no list of records")
    try:
        scene = kind(data.get("gravity"))
    except InputError as error:
        raise InputError(f"{file}: {error}") from error
    for number, entry in enumerate(records):
        try:
            _build(scene, entry, own)
        except AncfError as error:
            raise InputError(f"{file}, record {number + 1}: {error}") from error
    return scene


def encoded(value: Any, where: str, names: dict[str, object]) -> Any:
    """Return an argument as JSON data, and enter functions in the table of names so far."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, tuple):
        return [encoded(each, where, names) for each in value]
    if isinstance(value, np.ndarray):
        return _array(value)
    kind = value.kind() if isinstance(value, BodyRef) else type(value).__name__
    if (DATA | REFERENCE_TYPES).get(kind) is type(value):
        given = {each.name: getattr(value, each.name) for each in fields(value) if each.init}
        return {"kind": kind} | {k: encoded(v, where, names) for k, v in given.items()}
    if isinstance(value, ElementKind):
        name = value.package or value.name
        return {"own": name, "definition": value.definition, "values": dict(value.values)}
    if isinstance(value, MissingFunction):
        raise InputError(f"{where}: {value.reason}")
    if callable(value) and not is_compiled(value):
        name = name_of(value)
        if names.setdefault(name, value) is not value:
            raise InputError(
                f"{where}: two functions are named {name}, so a file cannot distinguish them: "
                "define them under names of their own"
            )
        return {"own": name}
    raise InputError(
        f"{where}: {format_value(value)} cannot be written to a file; give a Python function, or a "
        "signal such as Ramp, Sine, Pulse or Table"
    )


def name_of(value: Any) -> str:
    """Return the name under which a file stores a user function or element."""
    kind = value if hasattr(value, "__qualname__") else type(value)
    return f"{kind.__module__}.{kind.__qualname__}"


def _array(values: np.ndarray[Any, Any]) -> Any:
    if values.size <= MAX_INLINE_NUMBERS:
        return values.tolist()
    plain = np.ascontiguousarray(values, values.dtype.newbyteorder("<"))
    text = base64.b64encode(plain.tobytes()).decode()
    return {"array": plain.dtype.str, "shape": list(values.shape), "base64": text}


def _build(scene: SceneBase, entry: Any, own: Mapping[str, Any]) -> None:
    if not isinstance(entry, dict):
        raise InputError(f"it must be a method and its arguments, got {format_value(entry)}")
    method = check_choice("method", entry.get("method"), RECORD_TYPES)
    given = {name: decoded(each, own) for name, each in entry.items() if name != "method"}
    record: Record = _made(RECORD_TYPES[method], given, method)
    record.build(scene)


def decoded(value: Any, own: Mapping[str, Any]) -> Any:
    """Return an argument from JSON data."""
    if isinstance(value, list):
        return tuple(decoded(each, own) for each in value)
    if not isinstance(value, dict):
        return value
    if "own" in value:
        if not isinstance(value["own"], str) or value["own"] not in own:
            raise InputError(
                f"it needs {format_value(value['own'])}, which a file cannot hold: give it to "
                f"load, as in own={{{value['own']!r}: ...}}"
            )
        return _element(own[value["own"]], value) if "definition" in value else own[value["own"]]
    if "base64" in value:
        return _array_of(value)
    known = DATA | REFERENCE_TYPES
    kind = check_choice("kind", value.get("kind"), known)
    given = {name: decoded(each, own) for name, each in value.items() if name != "kind"}
    return _made(known[kind], given, kind)


def _element(kind: Any, saved: Mapping[str, Any]) -> ElementKind:
    """Return a user element, if it has the definition that was saved."""
    if not isinstance(kind, ElementKind) or kind.definition != saved["definition"]:
        raise InputError(
            f"it was made with another element than the {format_value(kind)} that was given as "
            f"{saved['own']!r}: its energy or coordinates have changed since"
        )
    values = saved.get("values")
    if not isinstance(values, dict):
        raise InputError(f"the values of element {kind.name} are damaged: {format_value(values)}")
    return kind.with_values(**values) if values else kind


def _made(kind: type[Any], given: Mapping[str, Any], what: str) -> Any:
    """Build an object from its fields, after a check of their names."""
    known = {each.name: each for each in fields(kind) if each.init}
    for name in given:
        check_choice(f"argument of {what}", name, known)
    for name, each in known.items():
        if name not in given and each.default is MISSING:
            raise InputError(f"{what} lacks {name}")
    return kind(**given)


def _array_of(value: Mapping[str, Any]) -> Any:
    try:
        numbers = np.frombuffer(base64.b64decode(value["base64"]), np.dtype(value["array"]))
        return numbers.reshape(value["shape"])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"its array is damaged: {error}") from error
