"""Tables and the last state of a run in a file, read on demand."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.results.data.hdf5_format import describe_damage, open_file, read_text
from ancfsparse.system.coordinates.state import State
from ancfsparse.system.system import System

# Names of data sets.
STATISTICS = "stats"
LAST_STATE = "last"  # vectors of the last state
LAST_MULTIPLIERS = "last_lam"  # its multipliers
MEMORY = "memory"  # its other data, as text
REFERENCE = "reference"  # stress-free shape of a run that started elsewhere
SCENE_RECORDS = "records"  # the scene, as the text of a scene file


@dataclass(frozen=True, eq=False)
class StoredTable:
    """A table in an HDF5 file, which is open only while it is read.

    Parameters
    ----------
    path : Path
        Absolute path of the file, because the working folder may change.
    name : str
        Name of the data set.
    run : str
        Identifier of its run: a later run may have replaced the file.
    shape : (int, int)
        Numbers of rows and columns.  Incomplete rows at the end are not counted.
    """

    path: Path
    name: str
    run: str
    shape: tuple[int, int]

    def __len__(self) -> int:
        """Return the number of rows."""
        return self.shape[0]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Vector:
        """Read the entire table."""
        return np.asarray(self[:], dtype=dtype)

    def __getitem__(self, key: Any) -> Vector:
        """Read rows, or with ``[rows, places]`` columns, in any order and shape."""
        of_rows, of_columns = key if isinstance(key, tuple) else (key, ...)
        rows, row = _cover(of_rows, self.shape[0])
        columns, column = _cover(of_columns, self.shape[1])
        if not isinstance(rows, slice) and not isinstance(columns, slice):
            rows, row = slice(None, self.shape[0]), of_rows  # HDF5 takes one list, not two
        with open_file(self.path, self.run) as file:
            values = check_values(self.path, self.name, file[self.name][rows, columns])
        return np.asarray(values[row][..., column])


def check_values(path: Path, name: str, values: Vector) -> Vector:
    """Return values read from a table, after a check for lost parts.

    Raises
    ------
    InputError
        If values are not finite, as in lost parts of a file.
    """
    if not np.isfinite(values).all():
        raise InputError(describe_damage(path, f": a part of {name} is lost"))
    return values


def _cover(key: Any, n: int) -> tuple[Any, Any]:
    """Return the indices to read of an axis of length n, and the key relative to them."""
    if key is Ellipsis:
        key = slice(None)
    if isinstance(key, slice) and (key.step is None or key.step > 0):
        return slice(*key.indices(n)), slice(None)
    selected = np.arange(n)[key]
    unique, inverse = np.unique(selected, return_inverse=True)
    if not len(unique):
        return slice(0, 0), selected
    first, last = int(unique[0]), int(unique[-1])
    if last - first < 4 * len(unique):  # faster than a list
        return slice(first, last + 1), selected - first
    return unique, inverse.reshape(selected.shape)


@dataclass(frozen=True, eq=False)
class StoredState:
    """The last state of a run in an HDF5 file, with the data to continue it.

    Parameters
    ----------
    path : Path
        Absolute path of the file.
    run : str
        Identifier of its run.
    """

    path: Path
    run: str

    def read(self, system: System) -> State:
        """Read the state.

        Raises
        ------
        InputError
            If the file is damaged or was replaced.
        """
        import json  # not needed by runs in memory

        with open_file(self.path, self.run) as file:
            rows = check_values(self.path, LAST_STATE, file[LAST_STATE][:])
            texts = json.loads(read_text(file, MEMORY))
            lam = check_values(self.path, LAST_MULTIPLIERS, file[LAST_MULTIPLIERS][:])
        memory = texts["memory"]
        memory |= dict(zip(texts["vectors"], rows[3:], strict=True))
        for name, value in memory.items():
            if isinstance(value, list):
                memory[name] = np.array(value, dtype=float)
        b = memory.pop("b0", None)
        q, v, a = rows[:3]
        return system.state(texts["t"], q, v, a, lam, b=b, memory=memory)


def encode_state(state: State) -> tuple[Vector, Vector, str]:
    """Return the stored form of a last state: vectors (k, n), multipliers (m,), and a text."""
    import json

    memory: dict[str, Any] = dict(state.memory)
    vectors = {} if state.b is None else {"b0": state.b}
    for name in [name for name in memory if np.shape(memory[name]) == state.q.shape]:
        vectors[name] = memory.pop(name)
    rows = np.stack([state.q, state.v, state.a, *vectors.values()])
    rest = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in memory.items()}
    text = json.dumps({"t": state.t, "vectors": list(vectors), "memory": rest})
    return rows, state.lam, text
