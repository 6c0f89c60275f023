"""Tables of states that are not whole in memory, but are read as if they were.

They know what results ask of an array: ``shape``, rows ``[i]`` and ``[i:j]``, and columns
``[..., places]``.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.results.opening import opened
from ancfsparse.results.source import Array


class Readable(Protocol):
    """What an array and a stored table have in common."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of rows and columns."""
        ...

    def __getitem__(self, key: Any, /) -> Any:
        """Read rows or columns."""
        ...


@dataclass(frozen=True, eq=False)
class Stored:
    """A table in an HDF5 file, which is open only while it is read.

    Parameters
    ----------
    path : Path
        The file, absolute: the working folder may change.
    name : str
        Name of the data set.
    run : str
        The mark of the run it is of: a later one may have replaced the file.
    shape : (int, int)
        Numbers of rows and columns.  Rows beyond were written in part, and do not count.
    """

    path: Path
    name: str
    run: str
    shape: tuple[int, int]

    def __len__(self) -> int:
        """Return the number of rows."""
        return self.shape[0]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        """Read all of it."""
        return np.asarray(self[:], dtype=dtype)

    def __getitem__(self, key: Any) -> Array:
        """Read rows, or with ``[..., places]`` columns in any order and shape."""
        with opened(self.path, self.run) as file:
            table, rows = file[self.name], slice(0, len(self))
            if isinstance(key, tuple) and len(key) == 2 and key[0] is Ellipsis:
                unique, inverse = np.unique(key[1], return_inverse=True)
                if len(unique) and unique[-1] - unique[0] < 4 * len(unique):  # faster than a list
                    values = table[rows, unique[0] : unique[-1] + 1][:, unique - unique[0]]
                else:
                    values = table[rows, unique] if len(unique) else np.empty((len(self), 0))
                return np.asarray(values[:, inverse.reshape(np.shape(key[1]))])
            if isinstance(key, slice):
                return np.asarray(table[slice(*key.indices(len(self)))])
            return np.asarray(table[range(len(self))[key]])


@dataclass(frozen=True, eq=False)
class Chosen:
    """Some columns of a table of states.

    Parameters
    ----------
    values : table, shape (k, c)
        What was kept.
    places : ndarray, shape (c,)
        The columns they are in the whole table, ascending.
    n : int
        Number of columns of the whole table.
    """

    values: Readable
    places: NDArray[np.integer[Any]]
    n: int

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of rows and columns of the whole table."""
        return self.values.shape[0], self.n

    def __len__(self) -> int:
        """Return the number of rows."""
        return self.shape[0]

    def __getitem__(self, key: Any) -> Array:
        """Read columns ``[..., places]``.

        Raises
        ------
        InputError
            If they were not kept, or whole rows are asked for.
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
