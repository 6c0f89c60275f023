"""Names of handles in files of scenes: "rope", "rope.end", "rope.at(0.3)", "hinge".

A name identifies a part, and a point of it is an attribute or a method of the body that returns a
`Point`; no other is called.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Mapping
from contextlib import suppress
from functools import cache
from inspect import signature
from typing import Any

from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value, suggest_names
from ancfsparse.scene.bodies.body import Body
from ancfsparse.scene.records.record import BodyRef, JointRef, PointRef
from ancfsparse.scene.storage.quantities import parse_quantity

TYPES = frozenset({"Point", "Joint", "Body", "ElasticBody", "Beam", "Mesh", "RigidBody"})
"""Types of handles in annotations of the methods of a scene."""
POINT = re.compile(r"(\w+)\s*(?:\((.*)\))?")
ARGUMENT = re.compile(r"\s*(?:(\w+)\s*=\s*)?(.*?)\s*")


def find_handle(name: str, handles: Mapping[str, Any]) -> Any:
    """Return the part, or the point of a part, with a name such as "rope.at(0.3)".

    Parameters
    ----------
    name : str
        The name.
    handles : mapping of str to object
        The preceding parts by name.

    Raises
    ------
    InputError
        If it names neither a part nor a point.
    """
    part = part_in(name, handles)
    if part == name:
        return handles[name]
    if part is None:
        word = name.split(".", 1)[0]
        if not handles:
            raise InputError(f"no part before this one is named {format_value(word)}")
        raise InputError(
            f"no part before this one is named {format_value(word)}: "
            + suggest_names(word, handles)
        )
    body, match = handles[part], POINT.fullmatch(name[len(part) + 1 :])
    if not isinstance(body, Body):
        raise InputError(f"{part} is not a body and has no points, got {format_value(name)}")
    points = points_of(body)
    if match is None:
        raise InputError(
            f"a point of {part} is written like {part}.{next(iter(points))}, got "
            f"{format_value(name)}"
        )
    check_choice(f"point of {part}", match[1], points)
    takes_arguments = points[match[1]]
    if takes_arguments != (match[2] is not None):
        example = f"{match[1]}(...)" if takes_arguments else match[1]
        raise InputError(f"this point is written {part}.{example}, got {format_value(name)}")
    return _call(body, match[1], match[2]) if takes_arguments else getattr(body, match[1])


def part_in(name: str, parts: Container[str]) -> str | None:
    """Return the longest name of a part that a name is, or begins with before a dot."""
    ends = [len(name), *(k for k, letter in enumerate(name) if letter == ".")]
    return next((name[:k] for k in sorted(ends, reverse=True) if name[:k] in parts), None)


def name_of_reference(
    reference: BodyRef, scene: Any, joints: Mapping[int, str], parts: Container[str]
) -> str | dict[str, Any]:
    """Return the name of a handle from its reference.

    Parameters
    ----------
    reference : BodyRef
        The reference.
    scene : Scene
        Its scene.
    joints : mapping of int to str
        Names of the joints, by their numbers.
    parts : container of str
        Names of all parts.

    Returns
    -------
    str or dict
        The name; for a point that no name gives to the last bit, its fields.
    """
    if isinstance(reference, JointRef):
        return joints[reference.number]
    if not isinstance(reference, PointRef):
        return reference.body
    body = scene.body(reference.body)
    points = {}
    for name, takes_arguments in points_of(body).items():
        with suppress(InputError):  # a ball has no end
            if not takes_arguments:
                points[name] = getattr(body, name)
    if not reference.xi:
        points[f"node({reference.index})"] = body.node(reference.index)
    for name, point in points.items():
        if point.reference == reference and f"{body.name}.{name}" not in parts:
            return f"{body.name}.{name}"
    return {"kind": reference.kind()} | reference.__dict__


def points_of(body: Body) -> dict[str, bool]:
    """Return the attributes of a body that are points, and whether they are methods."""
    kind: Any = type(body)
    return _points_of(kind)


@cache
def _points_of(kind: Any) -> dict[str, bool]:
    """Return the points of a class; in descending order, so that the origin precedes the centre."""
    values = {n: getattr(kind, n) for n in reversed(dir(kind)) if not n.startswith("_")}
    functions = {k: v.fget if isinstance(v, property) else v for k, v in values.items()}
    return {
        name: not isinstance(values[name], property)
        for name, function in functions.items()
        if callable(function) and _returns_point(function)
    }


def _returns_point(function: Callable[..., Any]) -> bool:
    """Return True for a function of numbers whose return type is `Point`."""
    try:
        described = signature(function)
    except (TypeError, ValueError):
        return False
    taken = " ".join(str(each.annotation) for each in described.parameters.values())
    return described.return_annotation == "Point" and "Point" not in taken


def _call(body: Body, method: str, text: str) -> Any:
    """Call a method with numbers in parentheses, such as "0.3, y=0.01"."""
    numbers: list[float] = []
    named: dict[str, float] = {}
    parameters = signature(getattr(body, method)).parameters
    for part in text.split(",") if text.strip() else ():
        match = ARGUMENT.fullmatch(part)
        assert match is not None  # every text matches
        number = _number(match[2])
        if match[1] is None:
            numbers.append(number)
        else:
            named[check_choice(f"argument of {method}", match[1], parameters)] = number
    if numbers and [each.annotation for each in parameters.values()] == ["ArrayLike"]:
        return getattr(body, method)(numbers if len(numbers) > 1 else numbers[0])
    try:
        signature(getattr(body, method)).bind(*numbers, **named)
    except TypeError as error:
        raise InputError(f"{body.name}.{method}({text}): {error}") from None
    return getattr(body, method)(*numbers, **named)


def _number(text: str) -> float | int:
    """Return an integer, a number, or a length with a unit [m]."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return parse_quantity(text, ("m",))
