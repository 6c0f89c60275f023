"""The check that the joints of a scene hold no point twice."""

from __future__ import annotations

import numpy as np

from ancfsparse.errors import SingularSceneError
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.joints.joint import Joint


class ConstrainedPoints:
    """What the joints of a scene hold where, so that no point is held twice.

    Redundant equations make the matrix singular and the reactions arbitrary.
    Nodes that connections put at one place are a tree whose root keeps the list of what holds
    them, so that the cost of a joint does not grow with their number.
    """

    def __init__(self) -> None:
        self._above: dict[Point, Point] = {}
        self._held: dict[Point, list[tuple[int, Joint]]] = {}
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
        root = leaf = self._root(new.nodes[0])
        if new.joins:
            leaf = self._root(new.nodes[1])
            if root == leaf:
                first, second = new.nodes
                raise SingularSceneError(
                    f"{first!r} and {second!r} are one point already, by connections made before: "
                    "leave this one out"
                )
            here = self._held.get(root, []) + self._held.get(leaf, [])
            here.sort(key=lambda each: each[0])
        else:
            here = [*self._held.get(root, []), (self._count, new)]
        _check_place([joint for _, joint in here])
        self._count += 1
        if leaf != root:
            self._above[leaf] = root
            self._held.pop(leaf, None)
        if here:
            self._held[root] = here

    def _root(self, node: Point) -> Point:
        while node in self._above:
            above = self._above[node]
            if above in self._above:
                self._above[node] = self._above[above]
            node = above
        return node


def _check_place(here: list[Joint]) -> None:
    """Refuse joints, in the order they were added, that hold one place twice."""
    found = [(each, each.direction) for each in here]
    fixed = [each for each, direction in found if direction is None]
    partly = [each for each, direction in found if direction is not None]
    if len(fixed) > 1:
        first, second = fixed[:2]
        (node,), (other,) = second.nodes, first.nodes
        raise SingularSceneError(
            f"{node!r} is held twice: the {first.name} at {other!r} already fixes its position, "
            f"leave out the {second.name}" + ("" if node == other else " or the connection")
        )
    if fixed and partly:
        raise SingularSceneError(
            f"{partly[0].nodes[0]!r} is held twice: its position is fixed by a {fixed[0].name}, so "
            f"the {partly[0].name} has nothing left to hold"
        )
    if len(partly) > 1:
        directions = np.array([direction for _, direction in found])
        if np.linalg.matrix_rank(directions, tol=1e-9) < len(partly):
            last = partly[-1]
            raise SingularSceneError(
                f"{last.nodes[0]!r} is held twice: its {len(partly)} {last.name}s point in "
                "dependent directions, leave one out or move its anchor"
            )
