"""Runs in HDF5 files: written while they last, read without taking up memory."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Any, Self, cast

import h5py
import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.results.source import Array
from ancfsparse.results.stats import RunStats
from ancfsparse.results.tables import Chosen, Stored
from ancfsparse.results.trajectory import Trajectory
from ancfsparse.scene import Scene
from ancfsparse.system import System

# Numbers in one chunk of a data set (32 KiB), the most columns of it, and the columns of a table
# from which on a chunk has one row, so that appending a row does not read chunks back.
CHUNK, WIDE, VERY_WIDE = 2**12, 1024, 2**20


class Writer:
    """Append saved states to an HDF5 file; what was appended stays readable whatever comes.

    Data sets ``t`` (k,) [s]; ``q``, ``v``, ``a`` (k, c); ``lam`` (k, m) if there are
    multipliers; and ``places`` (c,) if only some coordinates are kept.  Attributes ``settings``
    and ``stats`` are JSON.

    Parameters
    ----------
    path : str or Path
        The file; one that exists is replaced.
    n, m : int
        Coordinates of the system, multipliers.
    places : (c,) int array or None
        The coordinates to be kept; None keeps all.
    settings : mapping
        What the run was started with.
    """

    def __init__(
        self,
        path: str | Path,
        n: int,
        m: int,
        places: NDArray[np.integer[Any]] | None,
        settings: Mapping[str, Any],
    ) -> None:
        try:
            self._file = h5py.File(path, "w")
        except OSError as refused:
            raise InputError(f"output {str(path)!r} cannot be written: {refused}") from None
        self._places = places
        width = n if places is None else len(places)
        widths = {"q": width, "v": width, "a": width, **({"lam": m} if m else {})}
        for name, columns in widths.items():
            wide = min(columns, WIDE)
            high = max(1, min(CHUNK // wide, VERY_WIDE // columns))
            self._file.create_dataset(
                name, (0, columns), float, maxshape=(None, columns), chunks=(high, wide)
            )
        self._file.create_dataset("t", (0,), float, maxshape=(None,), chunks=(CHUNK,))
        if places is not None:
            self._file["places"] = places
        self._file.attrs["coordinates"] = n
        self._file.attrs["settings"] = json.dumps(dict(settings), default=str)

    def append(self, t: Array, q: Array, v: Array, a: Array, lam: Array) -> None:
        """Add rows for the times `t`."""
        kept = [x if self._places is None else x[:, self._places] for x in (q, v, a)]
        for name, rows in zip(("t", "q", "v", "a", "lam"), (t, *kept, lam), strict=True):
            if name not in self._file:
                continue  # no multipliers
            table = self._file[name]
            size = len(table)
            table.resize(size + len(rows), axis=0)
            table[size:] = rows
        self._file.flush()

    def finish(self, stats: RunStats) -> None:
        """Add the counts of the run."""
        self._file.attrs["stats"] = json.dumps(asdict(stats))

    def __enter__(self) -> Self:
        """Give itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the file."""
        self._file.close()


def load(path: str | Path, scene: Scene) -> Trajectory:
    """Open the file that ``simulate(..., output=path)`` wrote.

    Parameters
    ----------
    path : str or Path
        The file.
    scene : Scene
        The scene of the run, or one said in the same words: its handles are what the trajectory
        is asked with.

    Returns
    -------
    Trajectory
        Its states stay in the file and are read as they are asked for.

    Raises
    ------
    InputError
        If this is no such file, or of another scene.
    """
    system = System(scene)
    run = read(path, system)
    kept, table = (
        (run.q.places, run.q.values) if isinstance(run.q, Chosen) else (slice(None), run.q)
    )
    same = run.q.shape[1] == system.n_all and run.lam.shape[1] == system.n_multipliers
    if not same or not np.array_equal(table[0], system.q0[kept]):
        raise InputError(
            f"{path} was written for another scene: it begins in another shape or has another "
            f"number of coordinates ({run.q.shape[1]}, this scene has {system.n_all})"
        )
    return run


def read(path: str | Path, system: System) -> Trajectory:
    """Open a file for a system it is known to belong to."""
    path = Path(path)
    try:
        with h5py.File(path, "r") as file:
            t = np.asarray(file["t"])
            settings = json.loads(file.attrs["settings"])
            stats = RunStats(**json.loads(file.attrs.get("stats", "{}")))
            n = int(file.attrs["coordinates"])
            places = np.asarray(file["places"]) if "places" in file else None
            lam = np.asarray(file["lam"]) if "lam" in file else np.empty((len(t), 0))
    except (OSError, KeyError) as missing:
        raise InputError(f"{path} is not a file that simulate wrote: {missing}") from None
    tables: list[Any] = [Stored(path, name) for name in ("q", "v", "a")]
    if places is not None:
        tables = [Chosen(table, places, n) for table in tables]
    q, v, a = (cast(Array, table) for table in tables)  # read like arrays, see `tables`
    return Trajectory(system, t, q, v, a, lam, stats, settings)
