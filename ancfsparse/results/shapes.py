"""Deformed shapes as points on every element."""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import NDArray

from ancfsparse.kernels.hermite import position_weights
from ancfsparse.machine import check_room
from ancfsparse.results.source import Array, SolvedSystem
from ancfsparse.results.tables import Chosen, Readable
from ancfsparse.scene import Body, Mesh, Node

# Pieces of an element in a picture: the most, and how many all elements have together.
FINEST, PIECES = 12, 2400


def rows_of(q: Readable, rows: NDArray[np.intp]) -> Array:
    """Read some rows of a table of states, all columns that it has."""
    if isinstance(q, Chosen):  # read like an array, though it is none
        return cast(Array, Chosen(np.asarray(q.values[rows]), q.places, q.n))
    return np.asarray(q[rows])


def shapes(system: SolvedSystem, q: Array, body: Body, pieces: int) -> Array:
    """Trace every element of a body.

    Parameters
    ----------
    system : SolvedSystem
        The system the states belong to.
    q : table, shape (j, n)
        Coordinates.
    body : Beam or Mesh
        One of its bodies.
    pieces : int
        Pieces per element.

    Returns
    -------
    ndarray, shape (j, n_elements, pieces + 1, dim)
        Points [m], from the first end of each element or, in a mesh, each edge as given: the cubic
        through positions and slopes at both ends.
    """
    numbers = float(q.shape[0]) * body.n_elements * (pieces + 1) * body.dim
    check_room("a picture of so many points", 8.0 * numbers, "a smaller per_element")
    # Inside an element, a position always depends on both ends, at a node on that node alone.
    middles = [Node(body, e, 0.5) for e in range(body.n_elements)]
    places = np.stack([system.point(each)[0] for each in middles])
    ends = np.asarray(q[..., places])
    weights = position_weights(np.linspace(0.0, 1.0, pieces + 1), body.lengths[:, None])
    lines: Array = np.einsum("epc,jedc->jepd", weights, ends)
    if isinstance(body, Mesh):
        lines[:, body.flipped] = lines[:, body.flipped, ::-1]
    return lines


def pieces_for(bodies: list[Body]) -> int:
    """Return how many pieces per element make a smooth picture that is quick to draw."""
    return int(np.clip(PIECES // sum(body.n_elements for body in bodies), 1, FINEST))
