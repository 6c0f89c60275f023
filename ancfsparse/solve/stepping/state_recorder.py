"""Store the states of a run in memory (all or selected coordinates) or in an HDF5 file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np

from ancfsparse.array_types import Indices, Vector
from ancfsparse.errors import AncfError, InputError
from ancfsparse.messages import format_value
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.results.data.selected_columns import SelectedColumns
from ancfsparse.scene import Point
from ancfsparse.solve import stepping
from ancfsparse.system import System
from ancfsparse.system.coordinates.state import State
from ancfsparse.system_memory import GIGABYTE

BUFFER_BYTES = 2**24  # of states before they are passed on; as many may wait for the file


class StateRecorder(Protocol):
    """Stores saved states in order of time."""

    @property
    def rows(self) -> int:
        """Number of stored states."""

    def append(
        self,
        t: Vector,
        q: Vector,
        v: Vector,
        a: Vector,
        lam: Vector,
        history: Vector | None = None,
        *,
        begin: int | None = None,
    ) -> bool:
        """Store states of the times `t`; from a row `begin` on they replace those stored.

        Returns True if the arrays must not change until the next call.
        """
        ...

    def finish(self, stats: RunStats, last: State | None = None) -> None:
        """Store the statistics of the run at its end, and its last state if that is known."""
        ...


class FileRecorder(StateRecorder, Protocol):
    """Stores states in a file, with checkpoints."""

    def keep_checkpoint(self, data: bytes) -> None:
        """Make the present states, with other data, the last checkpoint."""


class NoRecorder:
    """Recorder that stores no states: a simulation has its present one only."""

    rows = 1

    def append(self, *tables: object, begin: int | None = None) -> bool:
        """Discard the states."""
        return False

    def finish(self, stats: RunStats, last: State | None = None) -> None:
        """Discard the statistics."""


class MemoryRecorder:
    """Stores states in memory.

    Parameters
    ----------
    rows : int
        Number of states.
    n, m : int
        Coordinates of the system, multipliers.
    columns : (c,) int array or None
        Indices of the saved coordinates; None saves all.
    n_history : int, optional
        Number of history variables.
    """

    def __init__(
        self, rows: int, n: int, m: int, columns: Indices | None, n_history: int = 0
    ) -> None:
        self._columns, self._n, self.rows = columns, n, 0
        width = n if columns is None else len(columns)
        self._stats, self._last = RunStats(), cast(State | None, None)
        self._tables = [np.empty((rows, *shape)) for shape in ((), *[(width,)] * 3, (m,))]
        self._tables.append(np.empty((rows, n_history)))

    def append(
        self,
        t: Vector,
        q: Vector,
        v: Vector,
        a: Vector,
        lam: Vector,
        history: Vector | None = None,
        *,
        begin: int | None = None,
    ) -> bool:
        """Store states of the times `t`; from a row `begin` on they replace those stored."""
        self.rows = self.rows if begin is None else begin
        selected = [x if self._columns is None else x[:, self._columns] for x in (q, v, a)]
        for table, rows in zip(self._tables, (t, *selected, lam, history), strict=True):
            if rows is None:
                continue
            table[self.rows : self.rows + len(t)] = rows
        self.rows += len(t)
        return False

    def finish(self, stats: RunStats, last: State | None = None) -> None:
        """Store the statistics of the run at its end, and its last state if that is known."""
        self._stats, self._last = stats, last

    def trajectory(self, system: System, settings: Mapping[str, Any]) -> Trajectory:
        """Return the stored states."""
        t, q, v, a, lam, history = (table[: self.rows] for table in self._tables)
        if self._columns is not None:
            q, v, a = (cast(Vector, SelectedColumns(x, self._columns, self._n)) for x in (q, v, a))
        return Trajectory(system, t, q, v, a, lam, self._stats, settings, self._last, history)


class TrialRecorder:
    """Stores states on trial, as many as come.

    Parameters
    ----------
    rows : int
        Number of states before.
    """

    def __init__(self, rows: int) -> None:
        self.rows = rows
        self._parts: list[list[Vector]] = []

    def append(
        self,
        t: Vector,
        q: Vector,
        v: Vector,
        a: Vector,
        lam: Vector,
        history: Vector | None = None,
        *,
        begin: int | None = None,
    ) -> bool:
        """Store copies of states at the times `t`, after the others."""
        assert begin is None
        tables = [t, q, v, a, lam]
        if history is not None and history.shape[1]:
            tables.append(history)
        self._parts.append([np.array(table) for table in tables])
        self.rows += len(t)
        return False

    def finish(self, stats: RunStats, last: State | None = None) -> None:
        """Not for states on trial."""
        raise AssertionError

    def states(self) -> list[Vector]:
        """Return the arguments of `append` for all states, none without states."""
        return [np.concatenate(tables) for tables in zip(*self._parts, strict=True)]


class RunStorage:
    """Storage for the states of one run.

    Parameters
    ----------
    system : System
        The moving system.
    rows : int
        Number of states.
    nodes : sequence of Point, or None
        Points to save; None saves all coordinates.
    output : str, Path or None
        HDF5 file; None stores the states in memory.
    settings : mapping
        Settings of the run.
    head : bytes, optional
        The run as stored in every checkpoint; None for a run without checkpoints.
    records : str, optional
        The scene as the text of a file, if that is known.
    is_resumed : bool, optional
        Whether the file has the states up to the last checkpoint.
    """

    def __init__(
        self,
        system: System,
        rows: int,
        nodes: Sequence[Point] | None,
        output: str | Path | None,
        settings: Mapping[str, Any],
        head: bytes | None = None,
        records: str | None = None,
        is_resumed: bool = False,
    ) -> None:
        self._system, self._rows, self._settings = system, rows, settings
        self._head, self._records, self._is_resumed = head, records, is_resumed
        # The working folder may change before the states are read.
        self._output = None if output is None else Path(output).absolute()
        self._columns = None if nodes is None else coordinates_of_points(system, nodes)
        self._memory: MemoryRecorder | None = None
        if self._output is not None:
            self._check_room(self._output)

    def _check_room(self, output: Path) -> None:
        """Check that the states fit on the disk."""
        width = self._system.n_all if self._columns is None else len(self._columns)
        others = self._system.n_multipliers + self._system.assembly.n_history + 1
        needed = 8.0 * self._rows * (3 * width + others)
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
        """Yield the recorder, and close the file afterwards.

        Any exception, be it an interruption, a full disk or a failing load, gets the trajectory up
        to it as its attribute ``trajectory``.
        """
        recorder = None
        try:
            with self._recorder() as recorder:
                yield recorder
        except BaseException as stop:  # raised again with the stored states
            if recorder is not None and recorder.rows:
                self._hand_over(stop)
            raise

    def _hand_over(self, stop: BaseException) -> None:
        path = self._recorded()
        stop.trajectory = path  # type: ignore[attr-defined]
        if not isinstance(stop, AncfError):
            verb = "interrupted" if isinstance(stop, KeyboardInterrupt) else "ended"
            stop.add_note(
                f"The run was {verb}: its states up to t = {path.t[-1]:.6g} s are in the "
                "attribute `trajectory` of this exception"
                + ("" if self._output is None else f" and in {self._output}")
                + "; at a prompt take sys.last_value.trajectory."
            )

    @contextmanager
    def _recorder(self) -> Iterator[StateRecorder]:
        n, m = self._system.n_all, self._system.n_multipliers
        if self._output is None:
            history = self._system.assembly.n_history
            self._memory = MemoryRecorder(self._rows, n, m, self._columns, history)
            yield self._memory
        else:
            if self._is_resumed:
                begun = stepping.continue_file(self._output, self._head)
            else:
                begun = stepping.record_to_file(
                    self._system,
                    self._output,
                    self._columns,
                    self._settings,
                    self._head,
                    self._records,
                )
            with begun as writer:
                yield writer

    def remove_checkpoint(self) -> None:
        """Remove the last checkpoint of a finished run."""
        if self._head is not None and self._output is not None:
            stepping.remove_checkpoint(self._output)

    def trajectory(self) -> Trajectory:
        """Return the stored states; an interruption meanwhile gets them too."""
        try:
            return self._recorded()
        except KeyboardInterrupt as stop:
            self._hand_over(stop)
            raise

    def _recorded(self) -> Trajectory:
        if self._memory is not None:
            return self._memory.trajectory(self._system, self._settings)
        assert self._output is not None
        return stepping.read_recorded(self._output, self._system)


def check_nodes(nodes: object) -> None:
    """Check that `save_nodes` is a list of points."""
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


def coordinates_of_points(system: System, nodes: Sequence[Point]) -> Indices:
    """Return the indices of the coordinates on which the positions of points depend, ascending."""
    indices = [system.point(node)[0].ravel() for node in nodes]
    return np.unique(np.concatenate([np.empty(0, np.int32), *indices]))


def buffer_rows(n_all: int, limit: int) -> int:
    """Return the number of states in a buffer, 1 to `limit`."""
    return int(min(limit, max(1, BUFFER_BYTES // (3 * 8 * n_all))))
