"""Digests: descriptions of the parts of a scene, by which scenes are compared."""

from __future__ import annotations

import re
from collections.abc import Mapping

from ancfsparse.messages import checksum, format_numbers
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.record import BodyRef, JointRef, PointRef

MAX_CHARACTERS = 200  # of a description; longer ones are cut and end in a checksum

# Numbers, and the wrappers that version 0.1.0 wrote around NumPy numbers.
WRAPPED_NUMBER = re.compile(r"(?:np\.float\d+|array)\(([^(),]*)(?:, dtype=\w+)?\)")
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d*)?(?:e[-+]?\d+)?(?![\w.])")


def digest(scene: SceneBase) -> dict[str, str]:
    """Describe the parts of a scene except its shape and initial velocities.

    Shape and velocities are numbers, and compared as such.  A load that is a function of time is
    described by its position only, unless the function is a `Signal`.
    """
    number = {body.name: f"body {k}" for k, body in enumerate(scene.bodies)}

    def at(reference: BodyRef) -> str:
        here = number[reference.body]
        if isinstance(reference, JointRef):
            return f"joint {reference.number}"
        if not isinstance(reference, PointRef):
            return here
        inside = ""
        if reference.xi:
            inside = f" + {reference.of(scene).xi:.9g}"
        if reference.offsets:
            inside += f" + {format_numbers(reference.offsets)}"
        return f"{here}, {reference.index}{inside}"

    parts = {"gravity": format_numbers(scene.gravity)}
    for body in scene.bodies:
        for name, value in body.describe().items():
            parts[f"{name} of {number[body.name]}"] = value
    for part, handles in (
        ("joints", scene.joints),
        ("loads", scene.loads),
        ("attached", scene.attachments),
    ):
        parts[part] = "; ".join(scene.record_of(handle).describe(at, handle) for handle in handles)
    return {name: _short(value) for name, value in parts.items()}


def difference(there: Mapping[str, str], here: Mapping[str, str]) -> str | None:
    """Return the first part in which two descriptions differ; None if they do not.

    Numbers are compared by value: 100000000 is 1e8.
    """
    for name in [*there, *here]:
        then, now = there.get(name) or "none", here.get(name) or "none"
        if then != now and _by_value(then) != _by_value(now):
            return f"{name} there: {then}; here: {now}"
    return None


def _by_value(text: str) -> str:
    return NUMBER.sub(lambda found: repr(float(found[0])), WRAPPED_NUMBER.sub(r"\1", text))


def _short(text: str) -> str:
    if len(text) <= MAX_CHARACTERS:
        return text
    return f"{text[:MAX_CHARACTERS]}... {checksum(text.encode())}"
