"""Records as readable text."""

from __future__ import annotations

from dataclasses import MISSING, fields, is_dataclass
from typing import Any

import numpy as np

from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.record import BodyRef, JointRef, PointRef, Record, equal
from ancfsparse.scene.records.signal import Signal


def format_record(record: Record, scene: SceneBase) -> str:
    """Return a record of a scene as text: the method, and the arguments that are not defaults."""
    words = []
    for name, argument in changed_fields(record).items():
        unit = record.units.get(name) if isinstance(argument, float | tuple | np.ndarray) else None
        words.append(" ".join([name, format_argument(argument, scene), *([unit] if unit else [])]))
    return f"{record.method.removeprefix('add_').replace('_', ' ')}: {', '.join(words)}"


def format_argument(given: Any, scene: SceneBase) -> str:
    """Return an argument as text."""
    if isinstance(given, PointRef):
        return repr(given.of(scene))
    if isinstance(given, JointRef):
        return str(given.of(scene).label)
    if isinstance(given, BodyRef):
        return given.body
    if isinstance(given, np.ndarray):
        return "array of shape " + " x ".join(map(str, given.shape))
    if isinstance(given, float):
        return f"{given:.6g}"
    if isinstance(given, tuple):
        return "(" + ", ".join(format_argument(item, scene) for item in given) + ")"
    if isinstance(given, ElementKind | Signal):
        return repr(given)
    if is_dataclass(given):
        words = (
            f"{name}={format_argument(field, scene)}"
            for name, field in changed_fields(given).items()
        )
        return f"{type(given).__name__}({', '.join(words)})"
    if callable(given):
        return f"function {getattr(given, '__qualname__', type(given).__name__)}"
    return str(given)


def changed_fields(record: Any) -> dict[str, Any]:
    """Return the fields of a dataclass that differ from their defaults."""
    values = {field.name: getattr(record, field.name) for field in fields(record)}
    defaults = {field.name: field.default for field in fields(record)}
    return {
        name: value
        for name, value in values.items()
        if defaults[name] is MISSING or not equal(value, defaults[name])
    }
