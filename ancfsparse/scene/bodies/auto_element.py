"""Beams whose element or mesh is chosen by a plan.

Until then the handle is a beam of many elements, at whose nodes joints and loads may act.  Points
are given by arc length, so they are the same points on every mesh.
"""

from __future__ import annotations

from typing import overload

from ancfsparse.errors import InputError
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.scene.bodies.body import Body, Point

AUTO = "auto"
# Elements of the handle, with nodes at halves to sixths, eighths, tenths and half percents.
AUTO_ELEMENTS = 600


def stand_ins(
    element: str | ElementKind, n_elements: int | str | None, richest: str, count: int
) -> tuple[str | ElementKind, int | str | None, tuple[str, ...]]:
    """Return element and number of elements of the handle, and the arguments that are ``"auto"``.

    The handle has the richest element, so that it takes all joints and loads of the others, and
    `count` elements.
    """
    choices: list[str] = []
    if isinstance(element, str) and element == AUTO:
        choices.append("element")
        element = richest
    if isinstance(n_elements, str) and n_elements == AUTO:
        choices.append("n_elements")
        n_elements = count
    return element, n_elements, tuple(choices)


def check_decided(bodies: list[Body]) -> None:
    """Refuse a scene with arguments that a plan must choose."""
    for body in bodies:
        if body.automatic:
            raise InputError(
                f"{body.name} has {' and '.join(f'{name}={AUTO!r}' for name in body.automatic)}, "
                "which a plan chooses: give simulate a quantity and its error, call "
                "ancf.plan(scene, t_end, quantity=..., error=...), or give a value"
            )


@overload
def decided(body: Body, handle: Point) -> Point: ...
@overload
def decided(body: Body, handle: Body) -> Body: ...
def decided(body: Body, handle: Body | Point) -> Body | Point:
    """Return the handle on a body that replaces an ``"auto"`` body of the same name."""
    return body.corresponding_point(handle) if isinstance(handle, Point) else body
