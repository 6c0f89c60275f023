"""Record the states of a run in an HDF5 file, and read them back."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.file_names import check_file_name, check_folder
from ancfsparse.results import Trajectory
from ancfsparse.results.data.checkpoint_file import checkpoint_of
from ancfsparse.results.data.output_lock import check_replaceable
from ancfsparse.results.export.background_writer import BackgroundWriter
from ancfsparse.results.export.hdf5_writer import Writer
from ancfsparse.results.geometry.scene_outline import make_outline
from ancfsparse.results.hdf5_reader import read_run
from ancfsparse.scene.storage.json_file import written
from ancfsparse.system import System


def check_file(output: object) -> None:
    """Check that a file can be written, or replaced if it exists."""
    path = check_file_name("output", output)
    check_folder(path)
    check_replaceable(path)


@contextmanager
def record_to_file(
    system: System,
    output: Path,
    columns: NDArray[np.integer[Any]] | None,
    settings: Mapping[str, Any],
    head: bytes | None = None,
    records: str | None = None,
) -> Iterator[BackgroundWriter]:
    """Open a file for the states of a run, and write the scene into it.

    Parameters
    ----------
    system : System
        The moving system.
    output : Path
        The file.
    columns : (c,) int array or None
        Indices of the coordinates to be saved; None saves all.
    settings : mapping
        Settings of the run.
    head : bytes, optional
        The run as stored in every checkpoint; None for a run without checkpoints.
    records : str, optional
        The scene as the text of a file, if that is known.
    """
    n, m = system.n_all, system.n_multipliers
    history = system.assembly.n_history
    with Writer(output, n, m, columns, settings, system.description, history) as writer:
        writer.head = head or b""
        if settings["t_start"] is not None:
            writer.add_reference(system.q_ref)
        if columns is None:
            writer.add_outline(make_outline(system))
        with suppress(InputError):  # functions that a file cannot distinguish
            records = written(system.scene) if records is None else records
        if records:
            writer.add_records(records)
        with BackgroundWriter(writer) as recorder:
            yield recorder


@contextmanager
def continue_file(output: Path, head: bytes | None) -> Iterator[BackgroundWriter]:
    """Open the file of a run at its last checkpoint; parameters as for `record_to_file`."""
    with Writer.reopen(output) as writer:
        writer.head = head or b""
        with BackgroundWriter(writer) as recorder:
            yield recorder


def remove_checkpoint(output: Path) -> None:
    """Remove the checkpoint of a file."""
    checkpoint_of(output).unlink(missing_ok=True)


def read_recorded(output: Path, system: System) -> Trajectory:
    """Return the trajectory in a file that a run of this system has written."""
    return read_run(output, system)
