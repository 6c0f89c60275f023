"""Frames: beams that are welded at common nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_count
from ancfsparse.errors import InputError
from ancfsparse.scene.bodies.beam import Beam
from ancfsparse.scene.bodies.body import Point


@dataclass(frozen=True, eq=False, repr=False)
class Frame:
    """Beams that are welded at their ends, as `Scene.add_frame` returns them.

    Attributes
    ----------
    positions : ndarray, shape (n, dim)
        The nodes [m].
    edges : ndarray of int, shape (m, 2)
        Nodes at the start and the end of every beam.
    beams : tuple of Beam
        One for each edge.
    """

    positions: Vector
    edges: NDArray[np.int32]
    beams: tuple[Beam, ...]

    def __repr__(self) -> str:
        """Return the numbers of nodes and beams."""
        length = sum(beam.length for beam in self.beams)
        return f"frame: {len(self.positions)} nodes, {len(self.beams)} beams, {length:.6g} m"

    def ends(self, node: int) -> list[Point]:
        """Return the ends of all beams that meet at a node.

        Parameters
        ----------
        node : int
            Number of the node, in the order given.
        """
        number = check_count("the number of a node", node, 0)
        if number >= len(self.positions):
            raise InputError(
                f"the frame has nodes 0 to {len(self.positions) - 1}, there is no node {number}"
            )
        pairs = zip(self.beams, self.edges, strict=True)
        ends = [(beam, end) for beam, edge in pairs for end in (0, 1) if edge[end] == number]
        return [beam.end if end else beam.start for beam, end in ends]

    def node(self, node: int) -> Point:
        """Return the handle of a node, for joints, loads and results.

        Parameters
        ----------
        node : int
            Number of the node, in the order given.
        """
        return self.ends(node)[0]

    def at(self, edge: int, s: float) -> Point:
        """Return the point of a beam at an arc coordinate.

        Parameters
        ----------
        edge : int
            Number of the beam.
        s : float
            Distance from its start [m].
        """
        number = check_count("the number of an edge", edge, 0)
        if number >= len(self.beams):
            raise InputError(
                f"the frame has edges 0 to {len(self.beams) - 1}, there is no edge {number}"
            )
        return self.beams[number].at(s)
