"""Beams whose element or mesh a plan chooses: the handle until then, and the beam that it becomes.

Such a handle is a beam of many elements, at whose ends joints and loads may be, as at nodes.  It
refers to points by arc length, so they mean the same point on every mesh.
"""

from __future__ import annotations

from typing import overload

from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import ElementKind
from ancfsparse.scene.bodies.body import Body, Point

AUTO = "auto"
# Places of nodes on an undecided mesh: halves to sixths, eighths, tenths and half percent.
AUTO_ELEMENTS = 600


def stand_ins(
    element: str | ElementKind, n_elements: int | str | None, dim: int
) -> tuple[str | ElementKind, int | str | None, tuple[str, ...]]:
    """Return element and number of elements of the handle, and which of both are open.

    The handle has the richest element, so that everything a chosen one takes can be attached.
    """
    choices: list[str] = []
    if isinstance(element, str) and element == AUTO:
        choices.append("element")
        element = "thin" if dim == 2 else "thick"
    if isinstance(n_elements, str) and n_elements == AUTO:
        choices.append("n_elements")
        n_elements = AUTO_ELEMENTS
    return element, n_elements, tuple(choices)


def check_decided(bodies: list[Body]) -> None:
    """Refuse a scene that only a plan can build."""
    for body in bodies:
        if body.automatic:
            raise InputError(
                f"{body.name} has {' and '.join(f'{each}={AUTO!r}' for each in body.automatic)}, "
                "which a plan decides: give simulate a quantity and its error, ask for "
                "ancf.plan(scene, t_end, quantity=..., error=...), or give a value"
            )


@overload
def decided(body: Body, handle: Point) -> Point: ...
@overload
def decided(body: Body, handle: Body) -> Body: ...
def decided(body: Body, handle: Body | Point) -> Body | Point:
    """Return the handle on a body that was chosen for an undecided one of its name."""
    return body.corresponding_point(handle) if isinstance(handle, Point) else body
