"""The file of a sweep: a line for each point that is done, so that an ended sweep goes on."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any, TextIO

from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.sweeps.point import Row, Task
from ancfsparse.sweeps.samples import ParameterPoint

# First key of the first line.
MARK = "ancfsparse sweep"


class Ledger:
    """Rows that are known, and the file they are added to.

    Parameters
    ----------
    task : Task
        What is done at every point; a file of another task is refused.
    path : Path or None
        The file, in JSON lines; None keeps the rows in memory alone.

    Raises
    ------
    InputError
        If the file is of something else.
    """

    def __init__(self, task: Task, path: Path | None) -> None:
        self._rows: dict[str, Row] = {}
        self._path = path
        self._file: TextIO | None = None
        self._head = {
            MARK: 1,
            "build": getattr(task.build, "__qualname__", None) or _written("build", task.build),
            "quantities": list(task.quantities),
            "t_end": task.t_end,
            "options": {
                name: _written(name, value) for name, value in sorted(task.options.items())
            },
        }
        if path is not None and path.exists():
            self._read(path)

    def _read(self, path: Path) -> None:
        """Take the rows of a file; a last line that was cut off is dropped."""
        try:
            lines = path.read_bytes().split(b"\n")
        except OSError as error:
            raise InputError(f"{path} cannot be read: {error.strerror}") from error
        whole, rest = lines[:-1], lines[-1]
        try:
            entries = [json.loads(line) for line in whole]
        except ValueError as error:
            raise InputError(f"{path} is damaged or no file of a sweep: choose another") from error
        if not entries and not rest:
            return
        head: Any = entries[0] if entries else None
        if not isinstance(head, dict) or MARK not in head:
            raise InputError(f"{path} is no file of a sweep: choose another")
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
                file.truncate(sum(len(line) + 1 for line in whole))

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Keep the file open for new rows."""
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
        """Whether a point is done."""
        return key(point) in self._rows

    def __getitem__(self, point: ParameterPoint) -> Row:
        """Return the row of a point."""
        return self._rows[key(point)]

    def add(self, point: ParameterPoint, row: Row) -> None:
        """Add a row, and write it at once."""
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
            f"{self._path} cannot be written ({error.strerror}): choose another file; what it "
            "contains is kept"
        )


def key(point: ParameterPoint) -> str:
    """Return a text that is equal for equal points alone."""
    return json.dumps(point, sort_keys=True)


def _written(name: str, option: object) -> str:
    """Write an option whole, which shows whether it has changed."""
    try:
        return repr(option)
    except Exception as error:  # a repr of the caller's may raise anything
        raise InputError(
            f"{name} of a sweep cannot be written: it is {format_value(option)}"
        ) from error
