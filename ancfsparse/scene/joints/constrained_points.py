"""The check that joints do not constrain a point twice."""

from __future__ import annotations

import numpy as np

from ancfsparse.errors import SingularSceneError
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.joints.joint import Joint


class ConstrainedPoints:
    """Constraints of the points of a scene, none of which may be redundant.

    Redundant equations make the matrix singular and the reactions arbitrary.  Connected nodes form
    a tree (union-find) whose root stores their joints, so the cost of a joint does not grow with
    the number of nodes.
    """

    def __init__(self) -> None:
        self._parent: dict[Point, Point] = {}
        self._joints: dict[Point, list[tuple[int, Joint]]] = {}
        self._count = 0

    def add(self, new: Joint) -> None:
        """Add a joint, or raise a `SingularSceneError` if it is redundant."""
        root = leaf = self._root(new.nodes[0])
        if new.joins:
            leaf = self._root(new.nodes[1])
            if root == leaf:
                first, second = new.nodes
                raise SingularSceneError(
                    f"{first!r} and {second!r} already coincide by other connections: "
                    "leave this one out"
                )
            here = self._joints.get(root, []) + self._joints.get(leaf, [])
            here.sort(key=lambda entry: entry[0])
        else:
            here = [*self._joints.get(root, []), (self._count, new)]
        _check_point([joint for _, joint in here])
        self._count += 1
        if leaf != root:
            self._parent[leaf] = root
            self._joints.pop(leaf, None)
        if here:
            self._joints[root] = here

    def _root(self, node: Point) -> Point:
        while node in self._parent:
            parent = self._parent[node]
            if parent in self._parent:
                self._parent[node] = self._parent[parent]
            node = parent
        return node


def _check_point(here: list[Joint]) -> None:
    """Refuse joints, in the order of their addition, that constrain one point twice."""
    fixed = [joint for joint in here if joint.direction is None]
    partial = [joint for joint in here if joint.direction is not None]
    if len(fixed) > 1:
        first, second = fixed[:2]
        (node,), (other,) = second.nodes, first.nodes
        raise SingularSceneError(
            f"{node!r} is constrained twice: the {first.name} at {other!r} already fixes its "
            f"position, leave out the {second.name}"
            + ("" if node == other else " or the connection")
        )
    if fixed and partial:
        raise SingularSceneError(
            f"{partial[0].nodes[0]!r} is constrained twice: its position is fixed by a "
            f"{fixed[0].name}, so the {partial[0].name} is redundant"
        )
    if len(partial) > 1:
        directions = np.array([joint.direction for joint in partial])
        if np.linalg.matrix_rank(directions, tol=1e-9) < len(partial):
            last = partial[-1]
            raise SingularSceneError(
                f"{last.nodes[0]!r} is constrained twice: its {len(partial)} {last.name}s point in "
                "dependent directions, leave one out or move its anchor"
            )
