"""What a scene consists of, in words that two scenes can be compared by."""

from __future__ import annotations

import re
from collections.abc import Mapping
from hashlib import sha256

import numpy as np

from ancfsparse.scene.bodies import Body, Node
from ancfsparse.scene.contents import Contents
from ancfsparse.scene.joints import Joint
from ancfsparse.scene.loads import DistributedForce, Load, Value
from ancfsparse.scene.signal import Signal
from ancfsparse.words import numbers

# Longer descriptions are cut here and end in a checksum.
LONGEST = 200

# Numbers, and what version 0.1.0 wrote around those that were not Python's.
WRAPPED = re.compile(r"(?:np\.float\d+|array)\(([^(),]*)(?:, dtype=\w+)?\)")
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d*)?(?:e[-+]?\d+)?(?![\w.])")


def digest(scene: Contents, joints: list[Joint], loads: list[Load]) -> dict[str, str]:
    """Describe what decides how a scene moves, but for its shape and initial velocities.

    These are numbers, and compared as such.  Of a load that is a function of time only its place
    counts, unless the function is a `Signal`.

    Parameters
    ----------
    scene : Contents
        Its beams and meshes, and gravity.
    joints, loads : list
        What holds them and acts on them.

    Returns
    -------
    dict of str to str
        A description of every part, by the name of the part.
    """
    number = {id(body): f"body {k}" for k, body in enumerate(scene.beams)}

    def at(node: Node) -> str:
        inside = f" + {node.xi:.9g}" if node.xi else ""
        return f"{number[id(node.beam)]}, {node.index}{inside}"

    def load(each: Load) -> str:
        where = number[id(each.beam)] if isinstance(each, DistributedForce) else at(each.node)
        return f"{type(each).__name__} ({where}): {_course(each.value)}"

    parts = {"gravity": numbers(scene.gravity)}
    for body in scene.beams:
        for name, value in _of(body).items():
            parts[f"{name} of {number[id(body)]}"] = value
    parts["joints"] = "; ".join(joint.describe(at) for joint in joints)
    parts["loads"] = "; ".join(map(load, loads))
    parts["attached"] = "; ".join(each.describe(at) for each in scene.attached)
    return {name: _short(value) for name, value in parts.items()}


def difference(there: Mapping[str, str], here: Mapping[str, str]) -> str | None:
    """Say what is the first part that two descriptions differ in; None if they do not.

    Numbers are compared by value: 100000000 is 1e8.
    """
    for name in [*there, *here]:
        then, now = there.get(name) or "none", here.get(name) or "none"
        if then != now and _by_value(then) != _by_value(now):
            return f"{name} there: {then}; here: {now}"
    return None


def _of(body: Body) -> dict[str, str]:
    links = np.concatenate([body.row_nodes, body.ends.ravel()]).astype("<i4")
    return {
        "element": " ".join([body.element, *body.options.values()]),
        "section": repr(body.section),
        "material": repr(body.material),
        "mesh": f"{body.n_elements} elements, {sha256(links.tobytes()).hexdigest()[:16]}",
    }


def _course(value: Value) -> str:
    if isinstance(value, Signal):
        return value.describe()
    return "a function of time" if callable(value) else numbers(value)


def _by_value(text: str) -> str:
    return NUMBER.sub(lambda found: repr(float(found[0])), WRAPPED.sub(r"\1", text))


def _short(text: str) -> str:
    if len(text) <= LONGEST:
        return text
    return f"{text[:LONGEST]}... {sha256(text.encode()).hexdigest()[:16]}"
