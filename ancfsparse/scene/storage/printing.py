"""What was specified, in readable lines."""

from __future__ import annotations

from dataclasses import MISSING, fields, is_dataclass
from typing import Any

import numpy as np

from ancfsparse.kernels.catalog import ElementKind
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.record import BodyRef, JointRef, PointRef, Record, equal
from ancfsparse.scene.records.signal import Signal


def line(record: Record, scene: SceneBase) -> str:
    """Write one record of a scene: the call, and every argument that differs from its default."""
    words = []
    for name, each in unusual(record).items():
        unit = record.units.get(name) if isinstance(each, float | tuple | np.ndarray) else None
        words.append(" ".join([name, value(each, scene), *([unit] if unit else [])]))
    return f"{record.method.removeprefix('add_').replace('_', ' ')}: {', '.join(words)}"


def value(given: Any, scene: SceneBase) -> str:
    """Write one argument."""
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
        return "(" + ", ".join(value(each, scene) for each in given) + ")"
    if isinstance(given, ElementKind):
        return repr(given)
    if isinstance(given, Signal):
        return repr(given)
    if is_dataclass(given):
        words = (f"{name}={value(each, scene)}" for name, each in unusual(given).items())
        return f"{type(given).__name__}({', '.join(words)})"
    if callable(given):
        return f"function {getattr(given, '__qualname__', type(given).__name__)}"
    return str(given)


def unusual(record: Any) -> dict[str, Any]:
    """Return the fields of a dataclass that differ from their defaults."""
    values = {each.name: getattr(record, each.name) for each in fields(record)}
    usual = {each.name: each.default for each in fields(record) if each.default is not MISSING}
    return {k: each for k, each in values.items() if k not in usual or not equal(each, usual[k])}
