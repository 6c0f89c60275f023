"""What becomes of the states of a run: kept in memory, whole or in part, or written to a file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import AncfError, InputError
from ancfsparse.messages import format_value
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.results.data.stored_tables import SelectedColumns
from ancfsparse.scene import Point
from ancfsparse.solve import stepping
from ancfsparse.system import System
from ancfsparse.system.coordinates.state import State
from ancfsparse.system_memory import GIGABYTE

Vector = NDArray[np.float64]
Places = NDArray[np.integer[Any]]

# Bytes of states that are collected before they are passed on.
BUFFER_BYTES = 2**25


class StateRecorder(Protocol):
    """Takes saved states in order of time.

    Attributes
    ----------
    rows : int
        Number of states taken.
    """

    rows: int

    def append(
        self, t: Vector, q: Vector, v: Vector, a: Vector, lam: Vector, *, begin: int | None = None
    ) -> None:
        """Take rows for the times `t`; from a row on, they take the place of all after it."""
        ...

    def finish(self, stats: RunStats, last: State | None = None) -> None:
        """Take the counts of the run at its end, and all of its last state if that is known."""
        ...


class MemoryRecorder:
    """States in memory.

    Parameters
    ----------
    rows : int
        Number of states to come.
    n, m : int
        Coordinates of the system, multipliers.
    places : (c,) int array or None
        The coordinates to be kept; None keeps all.
    """

    def __init__(self, rows: int, n: int, m: int, places: Places | None) -> None:
        self._places, self._n, self.rows = places, n, 0
        width = n if places is None else len(places)
        self._stats, self._last = RunStats(), cast(State | None, None)
        self._tables = [np.empty((rows, *shape)) for shape in ((), *[(width,)] * 3, (m,))]

    def append(
        self, t: Vector, q: Vector, v: Vector, a: Vector, lam: Vector, *, begin: int | None = None
    ) -> None:
        """Take rows for the times `t`; from a row on, they take the place of all after it."""
        self.rows = self.rows if begin is None else begin
        kept = [x if self._places is None else x[:, self._places] for x in (q, v, a)]
        for table, rows in zip(self._tables, (t, *kept, lam), strict=True):
            table[self.rows : self.rows + len(t)] = rows
        self.rows += len(t)

    def finish(self, stats: RunStats, last: State | None = None) -> None:
        """Take the counts of the run at its end, and all of its last state if that is known."""
        self._stats, self._last = stats, last

    def trajectory(self, system: System, settings: Mapping[str, Any]) -> Trajectory:
        """Hand back what was taken."""
        t, q, v, a, lam = (table[: self.rows] for table in self._tables)
        if self._places is not None:
            q, v, a = (cast(Vector, SelectedColumns(x, self._places, self._n)) for x in (q, v, a))
        return Trajectory(system, t, q, v, a, lam, self._stats, settings, self._last)


class RunStorage:
    """Where the states of one run go.

    Parameters
    ----------
    system : System
        What moves.
    rows : int
        Number of states to come.
    nodes : sequence of Point, or None
        Points to keep; None keeps all coordinates.
    output : str, Path or None
        HDF5 file; None keeps the states in memory.
    settings : mapping
        What the run is started with.
    """

    def __init__(
        self,
        system: System,
        rows: int,
        nodes: Sequence[Point] | None,
        output: str | Path | None,
        settings: Mapping[str, Any],
    ) -> None:
        self._system, self._rows, self._settings = system, rows, settings
        # The working folder may change before the states are read.
        self._output = None if output is None else Path(output).absolute()
        self._places = None if nodes is None else coordinates_of_points(system, nodes)
        self._kept: MemoryRecorder | None = None
        if self._output is not None:
            self._check_room(self._output)

    def _check_room(self, output: Path) -> None:
        """Refuse a run whose states cannot fit on the disk."""
        width = self._system.n_all if self._places is None else len(self._places)
        needed = 8.0 * self._rows * (3 * width + self._system.n_multipliers + 1)
        import shutil  # loads compression

        free = shutil.disk_usage(output.parent).free
        free += output.stat().st_size if output.exists() else 0  # it is replaced
        if needed > free:
            raise InputError(
                f"the states would take {needed / GIGABYTE:.3g} GB, but only {free / GIGABYTE:.3g} "
                f"GB are free in {output.parent}: try a larger save_every, save_nodes=[...], or an "
                "output on another disk"
            )

    @contextmanager
    def open(self) -> Iterator[StateRecorder]:
        """Give the recorder, and close the file after use.

        Whatever ends a run early, be it an interruption, a full disk or a load that fails, takes
        what there is of the trajectory along as its attribute ``trajectory``.
        """
        recorder = None
        try:
            with self._recorder() as recorder:
                yield recorder
        except BaseException as stop:  # raised again, with the states there are
            if recorder is not None and recorder.rows:
                self._hand_over(stop)
            raise

    def _hand_over(self, stop: BaseException) -> None:
        path = self._recorded()
        stop.trajectory = path  # type: ignore[attr-defined]
        if not isinstance(stop, AncfError):
            what = "interrupted" if isinstance(stop, KeyboardInterrupt) else "ended"
            stop.add_note(
                f"The run was {what}: its states up to t = {path.t[-1]:.6g} s are in the "
                "attribute `trajectory` of this exception"
                + ("" if self._output is None else f" and in {self._output}")
                + "; at a prompt take sys.last_value.trajectory."
            )

    @contextmanager
    def _recorder(self) -> Iterator[StateRecorder]:
        n, m = self._system.n_all, self._system.n_multipliers
        if self._output is None:
            self._kept = MemoryRecorder(self._rows, n, m, self._places)
            yield self._kept
        else:
            with stepping.record_to_file(
                self._system, self._output, self._places, self._settings
            ) as writer:
                yield writer

    def trajectory(self) -> Trajectory:
        """Hand back what was recorded; an interruption meanwhile takes it along."""
        try:
            return self._recorded()
        except KeyboardInterrupt as stop:
            self._hand_over(stop)
            raise

    def _recorded(self) -> Trajectory:
        if self._kept is not None:
            return self._kept.trajectory(self._system, self._settings)
        assert self._output is not None
        return stepping.read_recorded(self._output, self._system)


def check_nodes(nodes: object) -> None:
    """Refuse what is not a list of points."""
    if nodes is None:
        return
    if isinstance(nodes, Point) or not isinstance(nodes, Sequence) or not nodes:
        raise InputError(f"save_nodes must be a list such as [rod.end], got {format_value(nodes)}")
    for node in nodes:
        if not isinstance(node, Point):
            raise InputError(
                f"save_nodes must hold points such as rod.end, got {format_value(node)}"
            )


def check_output(output: object) -> None:
    """Check that a file can be written, before the set-up and not after it."""
    if output is not None:
        stepping.check_file(output)


def coordinates_of_points(system: System, nodes: Sequence[Point]) -> Places:
    """Return the coordinates that the positions of points are made of, ascending."""
    places = [system.point(node)[0].ravel() for node in nodes]
    return np.unique(np.concatenate([np.empty(0, np.int32), *places]))


def buffer_rows(n_all: int, most: int) -> int:
    """Return how many states to collect before they are passed on, 1 to `most`."""
    return int(min(most, max(1, BUFFER_BYTES // (3 * 8 * n_all))))
