"""Tables of states that are read like arrays, also with selected columns.

They support ``shape``, rows ``[i]`` and ``[i:j]``, and columns ``[..., places]``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError


class Readable(Protocol):
    """The common interface of an array and a stored table."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of rows and columns."""
        ...

    def __getitem__(self, key: Any, /) -> Any:
        """Read rows or columns."""
        ...


@dataclass(frozen=True, eq=False)
class SelectedColumns:
    """Selected columns of a table of states.

    Parameters
    ----------
    values : table, shape (k, c)
        The stored columns.
    places : ndarray, shape (c,)
        Their indices in the full table, ascending.
    n : int
        Number of columns of the full table.
    """

    values: Readable
    places: NDArray[np.integer[Any]]
    n: int

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of rows and columns of the full table."""
        return self.values.shape[0], self.n

    def __len__(self) -> int:
        """Return the number of rows."""
        return self.shape[0]

    def __getitem__(self, key: Any) -> Vector:
        """Read columns ``[..., places]``.

        Raises
        ------
        InputError
            If they are not stored, or complete rows are requested.
        """
        if not (isinstance(key, tuple) and len(key) == 2 and key[0] is Ellipsis):
            raise InputError(
                "this needs all coordinates, but the run kept only those of save_nodes: run "
                "without save_nodes, or with output='run.h5' to keep them in a file"
            )
        where = np.asarray(key[1])
        column = np.minimum(np.searchsorted(self.places, where), max(len(self.places) - 1, 0))
        if len(self.places) == 0 or (self.places[column] != where).any():
            raise InputError(
                "the run did not keep this: save_nodes keeps position, velocity and acceleration "
                "of the points in it and nothing else; add the point, or run without save_nodes"
            )
        return np.asarray(self.values[..., column])
