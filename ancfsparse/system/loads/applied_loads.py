"""Applied forces: one vector of constant forces, and amplitudes of time-dependent ones."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
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
        first = out.n_amplitudes
        if isinstance(load, PointMoment):
            width = 1 if scene.dim == 2 else 3
            out.moment_place.append(system.frame(load.node))
            out.moment_column.append(list(range(first, first + width)))
            out.moment_axes.append(_frame_indices(load, system) if load.follow else None)
            out.sources.append(FunctionAmplitude(load))
            continue
        if isinstance(load, ChangingGravity):
            out.gravity_column.append(list(range(first, first + scene.dim)))
            out.sources.append(FunctionAmplitude(load))
            continue
        if load.follow:
            out.followers.append(_make_follower(load, system, first))
            out.sources.append(FunctionAmplitude(load))
            continue
        if isinstance(load, PointForce):
            places, weights = system.point(load.node)
        else:
            places, weights = _integrate_load(load, system.elements(load.beam))
        if not callable(load.value):
            np.add.at(out.constant, places, load.at(0.0)[:, None] * weights)
            continue
        for d in range(scene.dim):
            out.place += [int(p) for p in places[d]]
            out.weight += [float(w) for w in weights]
            out.column += [first + d] * len(weights)
        out.sources.append(FunctionAmplitude(load))
    return out


def _frame_indices(load: PointMoment, system: Places) -> NDArray[np.int32] | None:
    """Return the indices (3, 3) of r_x, r_y and r_z of a follower moment in space."""
    kind, row = load.node.beam.kind, system.place(load.node)
    if kind.dim == 2:
        return None
    return np.stack([row[kind.columns(name)] for name in ("r_x", "r_y", "r_z")])


def _make_follower(
    load: PointForce | DistributedForce, system: Places, first: int
) -> loads.Follower:
    """Return a follower force at its points of action."""
    column = np.full(system.dim, -1)
    width = load.shape[0] if load.shape else 1
    column[:width] = np.arange(first, first + width)
    if isinstance(load, DistributedForce):
        beam, kind = load.beam, load.beam.kind
        xi, shares = _gauss_rule()
        n, points = beam.n_elements, len(xi)
        ends = system.elements(beam).reshape(n, 2, -1).repeat(points, axis=0)
        lengths = beam.lengths.repeat(points)
        place, weight = loads.follower_inside(kind, ends, np.tile(xi, n), lengths)
        factor = (beam.lengths[:, None] * shares * load.factors(_arc_coordinates(beam, xi))).ravel()
    else:
        node, kind, factor = load.node, load.node.beam.kind, np.ones(1)
        if not node.xi:
            place, weight = loads.follower_at_node(kind, system.place(node), node.offsets)
        else:
            ends = system.elements(node.beam)[node.index].reshape(1, 2, -1)
            length = node.beam.lengths[[node.index]]
            place, weight = loads.follower_inside(
                kind, ends, np.array([node.xi]), length, node.offsets
            )
    return loads.Follower(place, weight, np.tile(column, (len(place), 1)), factor)


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
