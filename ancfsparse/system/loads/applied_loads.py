"""Applied forces: one vector of constant forces, and amplitudes of time-dependent ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Integers, Vector
from ancfsparse.errors import LoadError
from ancfsparse.kernels.hermite import integral_weights, position_weights
from ancfsparse.scene import (
    Body,
    ChangingGravity,
    DistributedForce,
    ElasticBody,
    Point,
    PointForce,
    PointMoment,
    Scene,
)
from ancfsparse.scene.records.time_dependent import TimeDependentValue
from ancfsparse.system import loads
from ancfsparse.system.loads.amplitudes import Amplitudes, FunctionAmplitude, TimeAmplitude

# Exact for the product of the cubic with a load of degree six.
GAUSS_POINTS = 5  # of an element, for follower loads and loads that vary along it


class Places(Protocol):
    """Indices of the coordinates of a scene."""

    n_all: int
    dim: int

    def place(self, node: Point) -> NDArray[np.int32]:
        """Return the indices of a node, (n_c,)."""

    def point(self, node: Point) -> tuple[NDArray[np.int32], Vector]:
        """Return indices (dim, p) and weights (p,) of the position of a point."""

    def frame(self, node: Point) -> NDArray[np.int32]:
        """Return the indices (3, dim) of the vectors r_x, r_y, r_z under a moment, or -1."""

    def elements(self, beam: Body) -> NDArray[np.int32]:
        """Return the indices of the elements of a beam, (n_e, 2 n_c)."""


@dataclass
class AppliedLoads:
    """Generalized loads of a scene.

    Attributes
    ----------
    constant : (n_all,) float
        Constant forces without gravity [N, N m].
    place, weight, column : lists
        Time-dependent forces: ``force[place] += weight * amplitude[column]``.
    moment_place : list of (3, dim) int
        Indices of the vectors r_x, r_y, r_z under a moment; -1 for the others.
    moment_column : list of (1,) or (3,) int
        Amplitudes of the moments [N m].
    moment_axes : list of (3, 3) int, or None
        Indices of r_x, r_y and r_z for a follower moment.
    followers : list of Follower
        Follower forces.
    gravity_column : list of (dim,) int
        Amplitudes of time-dependent gravity [m/s2].
    sources : list of Amplitudes
        The functions of the amplitudes, in order.
    """

    constant: Vector
    place: list[int] = field(default_factory=list)
    weight: list[float] = field(default_factory=list)
    column: list[int] = field(default_factory=list)
    moment_place: list[NDArray[np.int32]] = field(default_factory=list)
    moment_column: list[list[int]] = field(default_factory=list)
    moment_axes: list[NDArray[np.int32] | None] = field(default_factory=list)
    followers: list[loads.Follower] = field(default_factory=list)
    gravity_column: list[list[int]] = field(default_factory=list)
    sources: list[Amplitudes] = field(default_factory=list)

    @property
    def n_amplitudes(self) -> int:
        """Number of amplitudes."""
        return sum(source.width for source in self.sources)

    @property
    def growing(self) -> NDArray[np.bool_]:
        """Mask of the amplitudes that scale with the load factor, unlike the time."""
        flags = [np.full(each.width, not isinstance(each, TimeAmplitude)) for each in self.sources]
        return np.concatenate([np.zeros(0, dtype=bool), *flags])

    def add_amplitudes(self, load: TimeDependentValue, width: int) -> list[int]:
        """Add the amplitudes of a load; return their indices."""
        first = self.n_amplitudes
        self.sources.append(FunctionAmplitude(load))
        return list(range(first, first + width))

    def tabulate(self, times: Vector) -> tuple[Vector, LoadError | None]:
        """Return the amplitudes up to the first time at which a load fails.

        Parameters
        ----------
        times : (k,) float
            Times [s].

        Returns
        -------
        table : (j, n_amplitudes) float
            j is k if nothing fails [N or N m].
        failure : LoadError or None
            Failure at time j.
        """
        table, failure, start = np.empty((len(times), self.n_amplitudes)), None, 0
        for source in self.sources:
            rows, failed = source.tabulate(times[: len(table)])
            table, failure = table[: len(rows)], failed or failure
            table[:, start : start + source.width] = rows
            start += source.width
        return table, failure

    def amplitudes(self, times: Vector) -> Vector:
        """Return the amplitudes at times [s], shape (k, n_amplitudes) [N or N m].

        Raises
        ------
        LoadError
            If a load fails at one of them.
        """
        table, failure = self.tabulate(times)
        if failure is not None:
            raise failure
        return table


def collect_loads(scene: Scene, system: Places) -> AppliedLoads:
    """Return the generalized loads of a scene.

    Parameters
    ----------
    scene : Scene
        The scene.
    system : Places
        Indices of the coordinates of its nodes and elements.
    """
    out = AppliedLoads(np.zeros(system.n_all))
    for load in scene.loads:
        ADDITIONS[type(load)](out, system, load)
    return out


def _add_moment(out: AppliedLoads, system: Places, load: PointMoment) -> None:
    """Add a moment at a node."""
    out.moment_place.append(system.frame(load.node))
    out.moment_column.append(out.add_amplitudes(load, 1 if system.dim == 2 else 3))
    out.moment_axes.append(_frame_indices(load, system) if load.follow else None)


def _add_gravity(out: AppliedLoads, system: Places, load: ChangingGravity) -> None:
    """Add an acceleration of all masses."""
    out.gravity_column.append(out.add_amplitudes(load, system.dim))


def _add_point_force(out: AppliedLoads, system: Places, load: PointForce) -> None:
    """Add a force at a point."""
    if not load.follow:
        _add_fixed_force(out, load, *system.point(load.node))
        return
    node, kind = load.node, load.node.beam.kind
    if not node.xi:
        points = loads.follower_at_node(kind, system.place(node), node.offsets)
    else:
        ends = system.elements(node.beam)[node.index].reshape(1, 2, -1)
        length = node.beam.lengths[[node.index]]
        points = loads.follower_inside(kind, ends, np.array([node.xi]), length, node.offsets)
    _add_follower(out, load, points, np.ones(1))


def _add_distributed_force(out: AppliedLoads, system: Places, load: DistributedForce) -> None:
    """Add a force along a body, a follower force at Gauss points of its elements."""
    beam, elements = load.beam, system.elements(load.beam)
    if not load.follow:
        _add_fixed_force(out, load, *_integrate_load(load, elements))
        return
    xi, shares = _gauss_rule()
    n, lengths = beam.n_elements, beam.lengths.repeat(len(xi))
    ends = elements.reshape(n, 2, -1).repeat(len(xi), axis=0)
    points = loads.follower_inside(beam.kind, ends, np.tile(xi, n), lengths)
    factor = beam.lengths[:, None] * shares * load.factors(_arc_coordinates(beam, xi))
    _add_follower(out, load, points, factor.ravel())


def _add_fixed_force(
    out: AppliedLoads, load: TimeDependentValue, places: NDArray[np.int32], weights: Vector
) -> None:
    """Add a force along the axes of space at indices (dim, p) with weights (p,)."""
    if not callable(load.value):
        np.add.at(out.constant, places, load.at(0.0)[:, None] * weights)
        return
    for column, row in zip(out.add_amplitudes(load, len(places)), places, strict=True):
        out.place += [int(p) for p in row]
        out.weight += [float(w) for w in weights]
        out.column += [column] * len(weights)


def _add_follower(
    out: AppliedLoads, load: TimeDependentValue, points: tuple[Integers, Vector], factor: Vector
) -> None:
    """Add a force along the axes of sections at points, as `Follower` describes them."""
    place, weight = points
    column = np.full(place.shape[2], -1)
    width = load.shape[0] if load.shape else 1
    column[:width] = out.add_amplitudes(load, width)
    out.followers.append(loads.Follower(place, weight, np.tile(column, (len(place), 1)), factor))


ADDITIONS: dict[type, Callable[[AppliedLoads, Places, Any], None]] = {
    PointMoment: _add_moment,
    ChangingGravity: _add_gravity,
    PointForce: _add_point_force,
    DistributedForce: _add_distributed_force,
}
"""The function that adds each kind of load to those of a system."""


def _frame_indices(load: PointMoment, system: Places) -> NDArray[np.int32] | None:
    """Return the indices (3, 3) of r_x, r_y and r_z of a follower moment in space."""
    kind, row = load.node.beam.kind, system.place(load.node)
    if kind.dim == 2:
        return None
    return np.stack([row[kind.columns(name)] for name in ("r_x", "r_y", "r_z")])


def _gauss_rule() -> tuple[Vector, Vector]:
    """Return Gauss points and weights on [0, 1]."""
    points, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    return 0.5 * (1.0 + points), 0.5 * weights


def _arc_coordinates(beam: ElasticBody, xi: Vector) -> Vector:
    """Return the arc coordinates of points of every element, (n_e, k) [m]."""
    starts = np.concatenate([[0.0], np.cumsum(beam.lengths)[:-1]])
    return np.asarray(starts[:, None] + beam.lengths[:, None] * xi)


def _integrate_load(
    load: DistributedForce, places: NDArray[np.int32]
) -> tuple[NDArray[np.int32], Vector]:
    """Return indices (dim, p) and weights (p,) of a distributed force by integration."""
    ends, kind = places.reshape(len(places), 2, -1), load.beam.kind
    each = [ends[:, end, kind.columns(name)] for end in (0, 1) for name in kind.axis]
    lengths = load.beam.lengths
    if load.along is None:
        weights = integral_weights(lengths, kind.is_string)
    else:
        xi, shares = _gauss_rule()
        factors = lengths[:, None] * shares * load.factors(_arc_coordinates(load.beam, xi))
        points = position_weights(xi, lengths[:, None], kind.is_string)
        weights = np.einsum("eg,egk->ek", factors, points)
    return np.stack(each, axis=1).transpose(2, 0, 1).reshape(load.beam.dim, -1), weights.ravel()
