"""Joints, and the check that together they hold no point twice.

Pins, clamps and connections hold coordinates fixed or shared and are, as a rule, made by
numbering; rods are nonlinear constraints and come with a multiplier.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, SingularSceneError
from ancfsparse.scene.beams import Node

# Share of a beam's length within which two nodes count as being at one place.
SAME_PLACE = 1e-9


@dataclass(frozen=True, eq=False)
class Pin:
    """Hold the position of a node, leave its rotation free.

    Attributes
    ----------
    node : Node
        The node held.
    as_constraint : bool
        Hold it by equations with multipliers instead of by numbering.
    """

    node: Node
    as_constraint: bool = False


@dataclass(frozen=True, eq=False)
class Clamp:
    """Hold the position and the rotation of a node.

    Attributes
    ----------
    node : Node
        The node held.
    stretch : str
        For cables: ``"free"`` holds the direction of the slope only, ``"fixed"`` its length too.
        The thick beam is always held in r, r_x, r_y and r_z.
    """

    node: Node
    stretch: str = "free"


@dataclass(frozen=True, eq=False)
class Rod:
    """Keep the distance of a node from a fixed point, as a rigid massless rod does.

    Attributes
    ----------
    node : Node
        The node held.
    anchor : ndarray, shape (dim,)
        The fixed point [m], read-only.
    length : float
        The initial distance, kept [m].
    """

    node: Node
    anchor: NDArray[np.float64]
    length: float


@dataclass(frozen=True, eq=False)
class Connect:
    """Let two nodes share one position, free to turn against each other.

    Attributes
    ----------
    a, b : Node
        The nodes.
    """

    a: Node
    b: Node


Joint = Pin | Clamp | Rod | Connect


def check_node(what: str, node: object) -> Node:
    """Return `node` if it is a node of the mesh.

    Parameters
    ----------
    what : str
        The joint or load that needs it, for the message.
    node : object
        What was given.

    Returns
    -------
    Node
        The node.
    """
    if not isinstance(node, Node):
        raise InputError(
            f"{what} needs a point on a beam such as rod.start or rod.node(3), got {node!r}"
        )
    if not node.is_node:
        spacing = node.beam.length / node.beam.n_elements
        raise InputError(
            f"{what} needs a node, but {node!r} lies inside element {node.index}: the nodes are "
            f"{spacing:.6g} m apart, take rod.node({round(node.index + node.xi)}) or choose "
            "n_elements so that a node falls there"
        )
    return node


def check_joints(joints: Sequence[Joint], new: Joint) -> None:
    """Refuse a joint that holds a point which the others hold already.

    Equations that say the same thing twice make the matrix singular and the reactions arbitrary.

    Parameters
    ----------
    joints : sequence of Joint
        The joints the scene has.
    new : Joint
        The joint about to be added.

    Raises
    ------
    SingularSceneError
        If `new` repeats what is held.
    """
    if isinstance(new, Connect):
        if new.b in _one_place(joints, new.a):
            raise SingularSceneError(
                f"{new.a!r} and {new.b!r} are one point already, by connections made before: "
                "leave this one out"
            )
        node = new.a
    else:
        node = new.node
    place = _one_place([*joints, new], node)
    here = [each for each in (*joints, new) if not isinstance(each, Connect) and each.node in place]
    fixed = [each for each in here if not isinstance(each, Rod)]
    rods = [each for each in here if isinstance(each, Rod)]
    if len(fixed) > 1:
        first, second = fixed[:2]
        raise SingularSceneError(
            f"{second.node!r} is held twice: the {type(first).__name__.lower()} at {first.node!r} "
            f"already fixes its position, leave out the {type(second).__name__.lower()} or the "
            "connection"
        )
    if fixed and rods:
        raise SingularSceneError(
            f"{rods[0].node!r} is held twice: its position is fixed by a "
            f"{type(fixed[0]).__name__.lower()}, so the rod has nothing left to hold"
        )
    if rods:
        directions = np.array([(each.node.position - each.anchor) / each.length for each in rods])
        if np.linalg.matrix_rank(directions, tol=1e-9) < len(rods):
            raise SingularSceneError(
                f"{rods[-1].node!r} is held twice: its {len(rods)} rods point in dependent "
                "directions, leave one out or move its anchor"
            )


def _one_place(joints: Sequence[Joint], node: Node) -> set[Node]:
    """Collect the nodes that share their position with `node`, itself included."""
    place = {node}
    size = 0
    while len(place) > size:
        size = len(place)
        for each in joints:
            if isinstance(each, Connect) and (each.a in place or each.b in place):
                place |= {each.a, each.b}
    return place
