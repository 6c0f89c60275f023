"""Applied forces: what is constant becomes one vector, what changes columns of amplitudes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import LoadFailure
from ancfsparse.kernels.hermite import integral_weights
from ancfsparse.scene import DistributedForce, Node, PointForce, PointMoment, Scene
from ancfsparse.system.amplitudes import Clock, Source

Vector = NDArray[np.float64]
Points = Callable[[Node], tuple[NDArray[np.int32], Vector]]


@dataclass
class Loads:
    """Loads of a scene on its coordinates.

    Attributes
    ----------
    constant : (n_all,) float
        Constant forces without gravity [N, N m].
    place, weight, column : lists
        Changing forces: ``force[place] += weight * amplitude[column]``.
    moment_place : list of (3, dim) int
        Places of those of r_x, r_y and r_z that a moment acts on; -1 for the others.
    moment_column : list of (1,) or (3,) int
        Their amplitudes [N m].
    sources : list of Source or Clock
        Where the amplitudes come from, in order.
    """

    constant: Vector
    place: list[int] = field(default_factory=list)
    weight: list[float] = field(default_factory=list)
    column: list[int] = field(default_factory=list)
    moment_place: list[NDArray[np.int32]] = field(default_factory=list)
    moment_column: list[list[int]] = field(default_factory=list)
    sources: list[Source | Clock] = field(default_factory=list)

    @property
    def n_amplitudes(self) -> int:
        """Number of amplitudes."""
        return sum(source.width for source in self.sources)

    def tabulate(self, times: Vector) -> tuple[Vector, LoadFailure | None]:
        """Return the amplitudes up to the first time at which a load fails, and how it fails.

        Parameters
        ----------
        times : (k,) float
            Times [s].

        Returns
        -------
        table : (j, n_amplitudes) float
            j is k if nothing fails [N or N m].
        failure : LoadFailure or None
            What happened at time j.
        """
        table, failure, start = np.empty((len(times), self.n_amplitudes)), None, 0
        for source in self.sources:
            rows, failed = source.tabulate(times[: len(table)])
            table, failure = table[: len(rows)], failed or failure
            table[:, start : start + source.width] = rows
            start += source.width
        return table, failure

    def amplitudes(self, times: Vector) -> Vector:
        """Return the amplitudes at the given times [s], shape (k, n_amplitudes) [N or N m].

        Raises
        ------
        LoadFailure
            If a load fails at one of them.
        """
        table, failure = self.tabulate(times)
        if failure is not None:
            raise failure
        return table


def loads_of(
    scene: Scene,
    n_all: int,
    point: Points,
    frame: Callable[[Node], NDArray[np.int32]],
    elements: Callable[[Any], NDArray[np.int32]],
) -> Loads:
    """Spread the loads of a scene over its coordinates.

    Parameters
    ----------
    scene : Scene
        The loads.
    n_all : int
        Number of coordinates.
    point : callable
        Gives places (dim, p) and weights (p,) of the position of a node.
    frame : callable
        Gives places (3, dim) of those of r_x, r_y and r_z of a node that a moment acts on, or -1.
    elements : callable
        Gives the places (n_e, n_c) of a beam's elements.
    """
    out = Loads(np.zeros(n_all))
    for load in scene.loads:
        if isinstance(load, PointMoment):
            first, width = out.n_amplitudes, 1 if scene.dim == 2 else 3
            out.moment_place.append(frame(load.node))
            out.moment_column.append(list(range(first, first + width)))
            out.sources.append(Source(load))
            continue
        if isinstance(load, PointForce):
            places, weights = point(load.node)
        else:
            places, weights = _distributed(load, elements(load.beam))
        if not callable(load.value):
            np.add.at(out.constant, places, load.at(0.0)[:, None] * weights)
            continue
        first = out.n_amplitudes
        for d in range(scene.dim):
            out.place += [int(p) for p in places[d]]
            out.weight += [float(w) for w in weights]
            out.column += [first + d] * len(weights)
        out.sources.append(Source(load))
    return out


def _distributed(
    load: DistributedForce, places: NDArray[np.int32]
) -> tuple[NDArray[np.int32], Vector]:
    """Places (dim, p) and weights (p,) of a force per length: integrated shape functions."""
    ends, kind = places.reshape(len(places), 2, -1), load.beam.kind
    each = [ends[:, end, kind.columns(name)] for end in (0, 1) for name in kind.axis]
    weights = integral_weights(load.beam.lengths, kind.is_string)
    return np.stack(each, axis=1).transpose(2, 0, 1).reshape(load.beam.dim, -1), weights.ravel()
