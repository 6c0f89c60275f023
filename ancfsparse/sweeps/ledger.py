"""The file of a sweep: one line for each finished point, from which a sweep can be resumed."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any, TextIO

from ancfsparse.errors import InputError
from ancfsparse.file_names import SWEEP_MARK
from ancfsparse.messages import format_value
from ancfsparse.sweeps.point import Row, Task
from ancfsparse.sweeps.samples import ParameterPoint

"""First key of the first line."""


class Ledger:
    """Results of finished points, and their file.

    Parameters
    ----------
    task : Task
        The computation at a point; a file of another task is refused.
    path : Path or None
        The file, in JSON lines; None keeps the results in memory only.

    Raises
    ------
    InputError
        If the file does not belong to this task.
    """

    def __init__(self, task: Task, path: Path | None) -> None:
        self._rows: dict[str, Row] = {}
        self._path = path
        self._file: TextIO | None = None
        self._head = {
            SWEEP_MARK: 1,
            "build": getattr(task.build, "__qualname__", None) or _describe("build", task.build),
            "quantities": list(task.quantities),
            "t_end": task.t_end,
            "options": {
                name: _describe(name, value) for name, value in sorted(task.options.items())
            },
        }
        if path is not None and path.exists():
            self._read(path)

    def _read(self, path: Path) -> None:
        """Read the results of a file; an incomplete last line is deleted."""
        try:
            lines = path.read_bytes().split(b"\n")
        except OSError as error:
            raise InputError(f"{path} cannot be read: {error.strerror}") from error
        complete, rest = lines[:-1], lines[-1]
        try:
            entries = [json.loads(line) for line in complete]
        except ValueError as error:
            raise InputError(
                f"{path} is damaged or not a file of a sweep: choose another"
            ) from error
        if not entries and not rest:
            return
        head: Any = entries[0] if entries else None
        if not isinstance(head, dict) or SWEEP_MARK not in head:
            raise InputError(f"{path} is not a file of a sweep: choose another")
        for name, value in self._head.items():
            if head.get(name) != value:
                raise InputError(
                    f"{path} is of another sweep, whose {name} was {head.get(name)!r} and not "
                    f"{value!r}: choose another file, or delete it"
                )
        try:
            for entry in entries[1:]:
                row = Row(entry["values"], entry["reason"], entry["seconds"])
                self._rows[key(entry["point"])] = row
        except (KeyError, TypeError) as error:
            raise InputError(f"{path} is damaged: choose another file, or delete it") from error
        if rest:
            with path.open("r+b") as file:
                file.truncate(sum(len(line) + 1 for line in complete))

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Open the file for new results."""
        if self._path is None:
            yield
            return
        try:
            file = self._path.open("a", encoding="utf-8")
        except OSError as error:
            raise self._unwritable(error) from error
        with file:
            self._file = file
            try:
                if file.tell() == 0:
                    self._write(self._head)
                yield
            finally:
                self._file = None

    def __contains__(self, point: ParameterPoint) -> bool:
        """Return True for a finished point."""
        return key(point) in self._rows

    def __getitem__(self, point: ParameterPoint) -> Row:
        """Return the result of a point."""
        return self._rows[key(point)]

    def add(self, point: ParameterPoint, row: Row) -> None:
        """Add a result, and write it immediately."""
        self._rows[key(point)] = row
        self._write({"point": point, **asdict(row)})

    def _write(self, entry: dict[str, Any]) -> None:
        if self._file is None:
            return
        try:
            self._file.write(json.dumps(entry) + "\n")
            self._file.flush()
        except OSError as error:
            raise self._unwritable(error) from error

    def _unwritable(self, error: OSError) -> InputError:
        return InputError(
            f"{self._path} cannot be written ({error.strerror}): choose another file; its "
            "results are kept"
        )


def key(point: ParameterPoint) -> str:
    """Return a text that identifies a point."""
    return json.dumps(point, sort_keys=True)


def _describe(name: str, option: object) -> str:
    """Return the complete text of an option, by which changes are detected."""
    try:
        return repr(option)
    except Exception as error:  # a repr of the caller's may raise anything
        raise InputError(
            f"{name} of a sweep cannot be written: it is {format_value(option)}"
        ) from error
