"""Lowering of joints to fixed, prescribed and shared coordinates, and to equations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Integers
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.kernels.hermite import position_weights
from ancfsparse.scene import Body, Point, Scene
from ancfsparse.scene.kinematics.linear_forms import LINEAR, RheonomicTerm
from ancfsparse.system.coordinates.constraint_terms import Constraints
from ancfsparse.system.coordinates.nodal_vectors import weigh_ends, weigh_offsets

if TYPE_CHECKING:
    from ancfsparse.scene.kinematics.joint_coordinates import JointCoordinate
    from ancfsparse.scene.kinematics.sliding_curve import CurveOffset
    from ancfsparse.scene.records.prescribed_motion import PrescribedMotion


ROUNDING = 1e-9  # gradient of an equation by free coordinates, over its entire gradient


class Lowering:
    """The `Builder` to which joints are lowered; it counts all coordinates separately.

    Parameters
    ----------
    scene : Scene
        The bodies and joints.
    kinds : sequence of ElementKind
        Element type of each body.
    turns, lines : bool, optional
        Allow prescribed angles and sliding joints by numbering.

    Attributes
    ----------
    turned : bool
        True if angles are prescribed by numbering.
    raw : list of (n_rows, n_c) int32 arrays
        Raw index of each coordinate of each row, per body.
    n_raw : int
        Number of raw coordinates.
    on_lines : list of (k,) int32 arrays
        Coordinates fixed in place of equations.
    courses : list of Course
        Motions of prescribed coordinates.
    """

    def __init__(
        self,
        scene: Scene,
        kinds: Sequence[ElementKind],
        turns: bool = True,
        lines: bool = True,
    ) -> None:
        self.turns, self.lines = turns, lines
        self.turned = turns and any(joint.turns_body for joint in scene.joints)
        self.raw: list[Integers] = []
        self.n_raw = 0
        self._kinds = {id(body): kind for body, kind in zip(scene.bodies, kinds, strict=True)}
        self._index: dict[int, int] = {}
        for body, kind in zip(scene.bodies, kinds, strict=True):
            self._index[id(body)] = len(self.raw)
            self.raw.append(_count_coordinates(body, len(kind.node_coordinates), self.n_raw))
            self.n_raw = int(self.raw[-1][-1, -1]) + 1
        self._fixed: list[Integers] = []
        self.on_lines: list[Integers] = []
        self._driven: list[Integers] = []
        self.courses: list[PrescribedMotion] = []
        self._rheonomic: list[RheonomicTerm | None] = []
        self._one: list[Integers] = []
        self._other: list[Integers] = []
        self._equations = Constraints()
        for body in scene.bodies:
            self._source = id(body), 0
            body.constrain(self)
        for joint in scene.joints:
            self._source = id(joint), 0
            joint.lower(self)

    def kind(self, node: Point) -> ElementKind:
        """Return the element type at a node."""
        return self._kinds[id(node.beam)]

    def rows(self, node: Point) -> Integers:
        """Return the coordinates of all rows of a node, (k, n_c)."""
        return self.raw[self._index[id(node.beam)]][node.beam.rows_of(node.index)]

    def position(self, node: Point) -> Integers:
        """Return the coordinates of the position of a node, (dim,)."""
        return self.rows(node)[0, self.kind(node).columns("r")]

    def ends(self, node: Point) -> Integers:
        """Return the coordinates of all rows that a point depends on, (k, n_c)."""
        if not node.xi:
            return self.rows(node)
        return np.asarray(self.raw[self._index[id(node.beam)]][node.beam.ends[node.index]])

    def point(self, node: Point) -> tuple[Integers, NDArray[np.float64]]:
        """Return coordinates (dim, p) and weights (p,) of a point."""
        kind = self.kind(node)
        if not node.xi:
            return weigh_offsets(kind, self.rows(node)[0], node.offsets)
        length = node.beam.lengths[node.index]
        return weigh_ends(
            kind, self.ends(node), node, position_weights(node.xi, length, kind.is_string)
        )

    def fix(self, coordinates: Integers) -> None:
        """Fix coordinates at their reference values."""
        self._fixed.append(coordinates)

    def hold(self, coordinates: Integers) -> None:
        """Fix coordinates in place of equations."""
        self.on_lines.append(coordinates)

    def drive(self, coordinates: Integers, course: PrescribedMotion) -> None:
        """Prescribe the motion of coordinates, one component each."""
        self._driven.append(coordinates)
        self.courses.append(course)

    def share(self, one: Integers, other: Integers) -> None:
        """Identify coordinates pair by pair."""
        self._one.append(one)
        self._other.append(other)

    def equation(
        self,
        label: str,
        offset: float,
        *terms: tuple[float, int, int],
        about: Sequence[float] = (),
        size: float = 0.0,
        rheonomic: RheonomicTerm | None = None,
        mass: float = 0.0,
        measures: Sequence[tuple[float, JointCoordinate | CurveOffset]] = (),
    ) -> None:
        """Add an equation with a multiplier."""
        self._rheonomic.append(rheonomic)
        self._equations.add(
            label,
            offset,
            *terms,
            about=about,
            size=size,
            mass=mass,
            measures=measures,
            source=self._source,
        )
        self._source = self._source[0], self._source[1] + 1

    def final_indices(self, tables: Sequence[Integers]) -> Integers:
        """Return the index in q of each coordinate (n_raw,), from the indices of each body."""
        final = np.empty(self.n_raw, dtype=np.int32)
        for raw, each in zip(self.raw, tables, strict=True):
            final[raw] = each
        return final

    def owner(self) -> Integers | None:
        """Return the lowest coordinate identified with each one; None if none are shared."""
        if not self._one:
            return None
        import scipy.sparse as sp
        from scipy.sparse.csgraph import connected_components

        one, other = np.concatenate(self._one), np.concatenate(self._other)
        pairs = (np.ones(len(one), dtype=bool), (one, other))
        graph = sp.coo_array(pairs, shape=(self.n_raw, self.n_raw))
        _, group = connected_components(graph, directed=False)
        _, lowest = np.unique(group, return_index=True)
        owner: Integers = lowest.astype(np.int32)[group]
        return owner

    def held(self, owner: Integers | None) -> NDArray[np.bool_]:
        """Return a mask of fixed coordinates, (n_raw,); of shared ones the owner."""
        out = np.zeros(self.n_raw, dtype=bool)
        if self._fixed or self.on_lines:
            fixed = np.concatenate([each.ravel() for each in self._fixed + self.on_lines])
            out[fixed if owner is None else owner[fixed]] = True
        return out

    def repeats(self, owner: Integers | None, q: NDArray[np.float64]) -> bool:
        """Return True if coordinates fixed in place of equations are constrained again.

        Then equations are needed, because only they report redundant constraints by name.  The
        coordinates ``q`` (n_raw,) are those of the reference shape.
        """
        others = [each.ravel() for each in self._fixed + self._driven]
        every = np.concatenate(self.on_lines + others)
        owners = every if owner is None else owner[every]
        mine, rest = np.split(owners, [len(self.on_lines)])
        if len(np.unique(mine)) < len(mine) or np.isin(mine, rest).any():
            return True
        held = np.zeros(self.n_raw, dtype=bool)
        held[owners] = True
        free = ~(held if owner is None else held[owner])
        gradients = np.abs(self._equations.jacobian(q))
        idle = gradients[:, free].sum(axis=1) <= ROUNDING * gradients.sum(axis=1)
        return bool(idle[np.array(self._equations.mass) == 0.0].any())

    def driven(self, owner: Integers | None) -> Integers:
        """Return the prescribed coordinates in the order of `courses`; of shared ones the owner."""
        if not self._driven:
            return np.empty(0, dtype=np.int32)
        driven = np.concatenate(self._driven)
        return driven if owner is None else owner[driven]

    @property
    def rheonomic(self) -> list[RheonomicTerm]:
        """Prescribed right-hand sides of the last equations."""
        return [rheonomic for rheonomic in self._rheonomic if rheonomic is not None]

    def constraints(self, final: Integers, still: range) -> Constraints:
        """Return the equations in the final indices, prescribed ones last.

        Equations of bodies are omitted if all their coordinates are fixed, in the range `still`, or
        if they repeat those of a body with the same coordinates.
        """
        is_rheonomic = np.array(
            [rheonomic is not None for rheonomic in self._rheonomic], dtype=bool
        )
        out = self._equations.ordered(np.argsort(is_rheonomic, kind="stable"))
        out.i = [int(final[i]) for i in out.i]
        out.j = [LINEAR if j == LINEAR else int(final[j]) for j in out.j]
        out.measures = [(row, c, each.placed(final)) for row, c, each in out.measures]
        return _without_redundant(out, still)


def _count_coordinates(body: Body, n_c: int, start: int) -> Integers:
    """Return raw indices of the coordinates of a body from `start` on, (n_rows, n_c), by nodes."""
    node, dim = body.row_nodes, body.dim
    rows = np.arange(len(node), dtype=np.int32)
    begins = rows.copy()  # the first row of the node that the row belongs to
    begins[1:][node[1:] == node[:-1]] = 0
    begins = np.maximum.accumulate(begins)
    numbers = np.empty((len(node), n_c), dtype=np.int32)
    numbers[:, 0] = start + dim * node + (n_c - dim) * begins
    for k in range(1, dim):
        numbers[:, k] = numbers[:, 0] + np.int32(k)
    for k in range(n_c - dim):
        numbers[:, dim + k] = start + dim * (node + 1) + (n_c - dim) * rows + np.int32(k)
    return numbers


def _without_redundant(equations: Constraints, still: range) -> Constraints:
    """Omit equations with a mass that have only fixed coordinates, or repeat others."""
    if not any(equations.mass):
        return equations
    pairs: dict[int, list[tuple[int, int]]] = {}
    for row, i, j in zip(equations.row, equations.i, equations.j, strict=True):
        pairs.setdefault(row, []).append((min(i, j), max(i, j)))
    kept, seen = [], set()
    for row, mass in enumerate(equations.mass):
        key = tuple(sorted(pairs.get(row, ())))
        if mass and (key in seen or all(place in still for pair in key for place in pair)):
            continue
        if mass:
            seen.add(key)
        kept.append(row)
    return equations.only(kept)
