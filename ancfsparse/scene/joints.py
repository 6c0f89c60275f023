"""Joints, and the check that together they hold no point twice.

Pins, clamps and connections hold coordinates fixed or shared and are, as a rule, made by
numbering; rods are nonlinear constraints and come with a multiplier.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, SingularSceneError
from ancfsparse.scene.bodies import Node
from ancfsparse.words import shown

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
        ``"free"`` leaves the slope of the axis its length, and with ``curvature="section"`` all
        of it; ``"fixed"`` holds it too.  With ``curvature="axis"`` it is always held.
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


def check_point(what: str, node: object) -> Node:
    """Return `node` if it is a point, at a node of the mesh or not.

    Parameters
    ----------
    what : str
        The load or result that needs it, for the message.
    node : object
        What was given.
    """
    if not isinstance(node, Node):
        raise InputError(
            f"{what} needs a point on a beam such as rod.start or rod.node(3), got {shown(node)}"
        )
    return node


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
    point = check_point(what, node)
    if not point.is_node:
        raise InputError(
            f"{what} needs a node, but {point!r} lies inside element {point.index}: "
            f"{point.beam.hint(point)}"
        )
    return point


class Holds:
    """What the joints of a scene hold where, so that no point is held twice.

    Equations that say the same thing twice make the matrix singular and the reactions arbitrary.
    Nodes that connections put at one place are a tree whose root keeps the list of what holds
    them, so that the cost of a joint does not grow with their number.
    """

    def __init__(self) -> None:
        self._above: dict[Node, Node] = {}
        self._held: dict[Node, list[tuple[int, Pin | Clamp | Rod]]] = {}
        self._count = 0

    def add(self, new: Joint) -> None:
        """Take a joint in.

        Parameters
        ----------
        new : Joint
            The joint about to be added to the scene.

        Raises
        ------
        SingularSceneError
            If `new` repeats what is held; then nothing is taken in.
        """
        if isinstance(new, Connect):
            root, leaf = self._root(new.a), self._root(new.b)
            if root == leaf:
                raise SingularSceneError(
                    f"{new.a!r} and {new.b!r} are one point already, by connections made before: "
                    "leave this one out"
                )
            here = self._held.get(root, []) + self._held.get(leaf, [])
            here.sort(key=lambda each: each[0])
        else:
            root = leaf = self._root(new.node)
            here = [*self._held.get(root, []), (self._count, new)]
        _check_place([joint for _, joint in here])
        self._count += 1
        if leaf != root:
            self._above[leaf] = root
            self._held.pop(leaf, None)
        if here:
            self._held[root] = here

    def _root(self, node: Node) -> Node:
        while node in self._above:
            above = self._above[node]
            if above in self._above:
                self._above[node] = self._above[above]
            node = above
        return node


def _check_place(here: list[Pin | Clamp | Rod]) -> None:
    """Refuse joints, in the order they were added, that hold one place twice."""
    fixed = [each for each in here if not isinstance(each, Rod)]
    rods = [each for each in here if isinstance(each, Rod)]
    if len(fixed) > 1:
        first, second = fixed[:2]
        raise SingularSceneError(
            f"{second.node!r} is held twice: the {type(first).__name__.lower()} at {first.node!r} "
            f"already fixes its position, leave out the {type(second).__name__.lower()}"
            + ("" if first.node == second.node else " or the connection")
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
