"""Depth of the axes of a contact in its obstacle between the points with a contact force."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ancfsparse.array_types import Indices, Vector
from ancfsparse.errors import PenetrationWarning
from ancfsparse.kernels.hermite import position_weights
from ancfsparse.scene import Point
from ancfsparse.scene.force_elements.contacts import Contact
from ancfsparse.system.contributions.force_elements.penetrations import MAX_SOFT_RATIO, Penetration
from ancfsparse.system.contributions.point_weights import PointSums
from ancfsparse.system.coordinates.discretization import Discretization

# Points of an element, from end to end.  Its contact points are .39 of it apart; with five points
# the edge of a block can be between two of these too.
POINTS_PER_ELEMENT = 9
# On a flat obstacle with a given stiffness points have no limit: there the axis between two points
# may be this many times as deep as they are.  A cable of three elements at rest had 1.12 (1.55
# radii between points of 1.39 radii).
MAX_DEPTH_RATIO = 2.0
# States of a run that are always checked; as many take 2 ms for 100 elements.
CHECKED_STATES = 100
MAX_POINTS = 2**16  # of several states together, in 5 MB


class AxisDepths:
    """Depths of points of the axes, also between contact points.

    Parameters
    ----------
    system : Discretization
        The system.
    contact : Contact
        The contact.
    is_left_out : (n,) bool
        Whether a point of the contact has no force, since a joint fixes the axis there.
    is_limited : bool
        Whether penetrations of the points have a limit.
    """

    def __init__(
        self, system: Discretization, contact: Contact, is_left_out: Indices, is_limited: bool
    ) -> None:
        self._contact, self._is_limited = contact, is_limited
        self._positions = np.linspace(0.0, 1.0, POINTS_PER_ELEMENT)
        self._axes = [self._axis_of(system, body) for body in contact.bodies]
        sizes = [body.n_elements for body in contact.bodies]
        self._radii = np.repeat(np.repeat(contact.radii, sizes), POINTS_PER_ELEMENT)
        self._is_left_out = np.zeros(sum(sizes), dtype=bool)
        self._is_left_out[contact.elements[is_left_out]] = True
        self._body: PointSums | None = None
        if contact.on is not None:
            at = [contact.on.origin, *(contact.on.at(unit) for unit in np.eye(system.dim))]
            self._body = PointSums.of(
                system, [[(1.0, point)] for point in (contact.base_point, *at)]
            )

    def _axis_of(self, system: Discretization, body: Any) -> tuple[Indices, Vector]:
        """Return coordinates (n, 2 or 4, dim) and weights (n, k, 2 or 4) of the points."""
        body = system.resolve(body)
        kind, is_string = system.kind_of(body), system.kind_of(body).is_string
        columns = [kind.columns("r")] if is_string else [kind.columns("r"), kind.columns("r_x")]
        ends = system.elements(body).reshape(body.n_elements, 2, -1)
        indices = np.stack([ends[:, :, each] for each in columns], axis=2)
        indices = indices.reshape(body.n_elements, -1, system.dim)
        return indices, position_weights(self._positions, body.lengths[:, None], is_string)

    def deepest(self, q: Vector) -> tuple[Vector, Indices]:
        """Return the largest depth over the radius in states (k, n_all), and its point, (k,)."""
        contact, dim = self._contact, self._contact.obstacle.dim
        positions = np.concatenate(
            [(weights @ q[:, indices]).reshape(len(q), -1, dim) for indices, weights in self._axes],
            axis=1,
        )
        if self._body is not None and contact.on is not None:
            terms = self._body.weight * q[:, self._body.place]
            sums = np.add.reduceat(terms, self._body.start[:-1], axis=2).swapaxes(1, 2)
            axes = sums[:, 2:] - sums[:, 1:2]
            turned = (positions - sums[:, :1]) @ axes.swapaxes(1, 2) @ contact.on.vectors[0]
            positions = np.array(contact.obstacle.base) + turned
        distances = contact.obstacle.distances(positions.reshape(-1, dim))
        ratios = 1.0 - distances.reshape(len(q), -1) / self._radii
        ratios[:, np.repeat(self._is_left_out, POINTS_PER_ELEMENT)] = 0.0
        points = ratios.argmax(axis=1)
        return ratios[np.arange(len(q)), points], points

    def warnings(self, q: Any, of_points: Penetration, when: Callable[[int], str]) -> list[Warning]:
        """Return a warning if in one of the states an axis is inside between points with forces.

        Parameters
        ----------
        q : (n, n_all) array_like
            States one after the other.
        of_points : Penetration
            Largest penetration of points with a force.
        when : function
            Returns the time or load of a state in words.
        """
        of_points_ratio = max(of_points.depth, 0.0) / of_points.radius
        allowed = MAX_SOFT_RATIO
        if not self._is_limited:
            allowed = max(allowed, MAX_DEPTH_RATIO * of_points_ratio)
        ratio, row, k = self._deepest_state(q, allowed)
        if ratio <= allowed:
            return []
        element, which = divmod(k, POINTS_PER_ELEMENT)
        point, times = self._point(element, which), int(np.ceil(ratio))
        return [
            PenetrationWarning(
                f"{self._contact.what} has no force on a part of the axis that is "
                f"{(ratio - 1.0) * self._radii[k]:.3g} m inside, {when(row)} at {point!r}, between "
                f"two points with forces, which have penetrations of {of_points_ratio:.2g} radii: "
                f"take at least {times} times as many elements, {times * point.beam.n_elements}, "
                "or a larger stiffness"
            )
        ]

    def _deepest_state(self, q: Any, allowed: float) -> tuple[float, int, int]:
        """Return the largest depth over the radius, and the numbers of its state and its point.

        States are searched between two of `CHECKED_STATES` if the depth in these, and its largest
        change between two of them there or next to it, add up to more than the allowed depth.
        """
        rows = np.unique(np.linspace(0, len(q) - 1, CHECKED_STATES).astype(int)).tolist()
        depths, points = self.deepest(np.stack([q[row] for row in rows]))
        k = int(depths.argmax())
        deepest = float(depths[k]), rows[k], int(points[k])
        change = np.pad(np.abs(np.diff(depths)), 1)
        change = np.maximum(np.maximum(change[:-2], change[2:]), change[1:-1])
        reach = np.maximum(depths[1:], depths[:-1]) + change
        size = max(1, MAX_POINTS // len(self._radii))
        for interval in np.flatnonzero(reach > allowed).tolist():
            end = rows[interval + 1]
            for first in range(rows[interval] + 1, end, size):
                depths, points = self.deepest(np.asarray(q[first : min(first + size, end)]))
                k = int(depths.argmax())
                deepest = max(deepest, (float(depths[k]), first + k, int(points[k])))
        return deepest

    def _point(self, element: int, which: int) -> Point:
        """Return a point of an element, numbered among those of all bodies."""
        contact = self._contact
        number = int(np.searchsorted(contact.starts, element, side="right")) - 1
        body, element = contact.bodies[number], element - int(contact.starts[number])
        if 0 < which < POINTS_PER_ELEMENT - 1:
            return Point(body, element, float(self._positions[which]))
        return Point(body, int(body.row_nodes[body.ends[element, int(which > 0)]]))
