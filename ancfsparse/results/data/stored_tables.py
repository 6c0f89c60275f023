"""Tables of states that are not whole in memory, but are read as if they were.

They support what results need of an array: ``shape``, rows ``[i]`` and ``[i:j]``, and columns
``[..., places]``.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.results.data.hdf5_format import damaged, opened, text_of
from ancfsparse.results.data.interpolation import Array
from ancfsparse.system.coordinates.state import State
from ancfsparse.system.system import System

# Data sets of the last state: vectors, multipliers, and the rest as text.
LAST, LAST_LAM, MEMORY = "last", "last_lam", "memory"
# That of the stress-free shape of a run that started elsewhere.
REFERENCE = "reference"
# That of the scene, as the text of a file of its own.
RECORDS = "records"


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
        """Read rows, or with ``[rows, places]`` columns of them, in any order and shape."""
        of_rows, of_columns = key if isinstance(key, tuple) else (key, ...)
        rows, row = _cover(of_rows, self.shape[0])
        columns, column = _cover(of_columns, self.shape[1])
        if not isinstance(rows, slice) and not isinstance(columns, slice):
            rows, row = slice(None, self.shape[0]), of_rows  # HDF5 takes one list, not two
        with opened(self.path, self.run) as file:
            values = whole(self.path, self.name, file[self.name][rows, columns])
        return np.asarray(values[row][..., column])


def whole(path: Path, name: str, values: Array) -> Array:
    """Return what was read of a table, and refuse numbers that no run writes.

    Raises
    ------
    InputError
        If some are not finite, as where a part of the file is lost.
    """
    if not np.isfinite(values).all():
        raise InputError(damaged(path, f": a part of {name} is lost"))
    return values


def _cover(key: Any, n: int) -> tuple[Any, Any]:
    """Return what to read of an axis of length n, and where in it is what the key asks for."""
    if key is Ellipsis:
        key = slice(None)
    if isinstance(key, slice) and (key.step is None or key.step > 0):
        return slice(*key.indices(n)), slice(None)
    places = np.arange(n)[key]
    unique, inverse = np.unique(places, return_inverse=True)
    if not len(unique):
        return slice(0, 0), places
    first, last = int(unique[0]), int(unique[-1])
    if last - first < 4 * len(unique):  # faster than a list
        return slice(first, last + 1), places - first
    return unique, inverse.reshape(places.shape)


@dataclass(frozen=True, eq=False)
class StoredState:
    """The last state of a run in an HDF5 file, with what the steps after it depend on.

    Parameters
    ----------
    path : Path
        The file, absolute.
    run : str
        The mark of the run it is of.
    """

    path: Path
    run: str

    def read(self, system: System) -> State:
        """Read it.

        Raises
        ------
        InputError
            If the file is damaged or was replaced.
        """
        import json  # what runs in memory do not need

        with opened(self.path, self.run) as file:
            rows = whole(self.path, LAST, file[LAST][:])
            texts = json.loads(text_of(file, MEMORY))
            lam = whole(self.path, LAST_LAM, file[LAST_LAM][:])
        memory = texts["memory"]
        memory |= dict(zip(texts["vectors"], rows[3:], strict=True))
        for name, value in memory.items():
            if isinstance(value, list):
                memory[name] = np.array(value, dtype=float)
        b = memory.pop("b0", None)
        q, v, a = rows[:3]
        return system.state(texts["t"], q, v, a, lam, b=b, memory=memory)


def state_as_stored(state: State) -> tuple[Array, Array, str]:
    """Return what a file keeps of a last state: vectors (k, n), multipliers (m,), and a text."""
    import json

    memory: dict[str, Any] = dict(state.memory)
    vectors = {} if state.b is None else {"b0": state.b}
    for name in [name for name in memory if np.shape(memory[name]) == state.q.shape]:
        vectors[name] = memory.pop(name)
    rows = np.stack([state.q, state.v, state.a, *vectors.values()])
    rest = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in memory.items()}
    text = json.dumps({"t": state.t, "vectors": list(vectors), "memory": rest})
    return rows, state.lam, text


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
