"""Access to runs in HDF5 files, whose states are read on demand."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.file_names import check_file_name
from ancfsparse.results.data.hdf5_format import (
    describe_damage,
    open_file,
    read_text,
)
from ancfsparse.results.data.run_statistics import RunStats
from ancfsparse.results.data.selected_columns import SelectedColumns
from ancfsparse.results.data.stored_tables import (
    LAST_STATE,
    REFERENCE,
    SCENE_RECORDS,
    STATISTICS,
    StoredState,
    StoredTable,
    check_values,
)
from ancfsparse.results.geometry.scene_outline import Outline
from ancfsparse.results.solutions.trajectory import Trajectory
from ancfsparse.scene import Scene, check_scene
from ancfsparse.scene.storage.digest import difference
from ancfsparse.scene.storage.json_file import built
from ancfsparse.system import System

if TYPE_CHECKING:
    import h5py

ROUNDING = 1e-9  # difference of two equal scenes, over their largest coordinate


def load(
    path: str | Path, scene: Scene | None = None, *, own: Mapping[str, Any] | None = None
) -> Trajectory:
    """Open the file that ``simulate(..., output=path)`` wrote.

    Parameters
    ----------
    path : str or Path
        The file.
    scene : Scene, optional
        The scene of the run, or one built by the same calls, whose handles then address the
        trajectory.  By default it is rebuilt from the file;
        ``run.system.scene.body(name)`` gives its handles.
    own : dict of str to object, optional
        User functions and elements of a scene that is rebuilt from the file, as in `Scene.load`.

    Returns
    -------
    Trajectory
        Its states stay in the file and are read on demand.  The trajectory of an interrupted run is
        marked as unfinished.

    Raises
    ------
    InputError
        If this is not such a file, or of another scene.  Of loads that are functions of time only
        the positions are compared.
    """
    path = check_file_name("the file of a run", path)
    if scene is None:
        scene = _rebuild_scene(path, {} if own is None else own)
    check_scene(scene)
    system = System(scene)
    run = read_run(path, system)
    with open_file(path) as file:
        stored = dict(json.loads(read_text(file, "scene")))
        reference = np.asarray(file[REFERENCE]) if REFERENCE in file else None
    other = difference(stored, scene.digest())
    if other is None and (
        run.q.shape[1] != system.n_all or run.lam.shape[1] != system.n_multipliers
    ):
        other = f"coordinates there: {run.q.shape[1]}; here: {system.n_all}"
    n_internal, expected = run.internal.shape[1], system.assembly.n_history
    if other is None and n_internal not in (0, expected):
        other = f"internal variables of contacts there: {n_internal}; here: {expected}"
    if other is None and reference is not None:
        if not agree(reference, system.q_ref):
            other = "the stress-free shape"
    elif other is None:
        n_compared = (
            system.n_all - system.prescribed.n
        )  # prescribed coordinates start at their functions
        for name, table, start in (("shape", run.q, system.q0), ("velocity", run.v, system.v0)):
            if other is None and not _starts_at(table, start, n_compared):
                other = f"the {name} at t = 0"
    if other is not None:
        raise InputError(f"{path} was written for another scene. What differs is {other}")
    return run


def _rebuild_scene(path: Path, own: Mapping[str, Any]) -> Scene:
    """Rebuild the scene of a file."""
    with open_file(path) as file:
        text = read_text(file, SCENE_RECORDS, "")
    if not text:
        raise InputError(
            f"{path} does not contain its scene, because functions of it have the same name or "
            "because an earlier version wrote it: give the scene, as in load(path, scene)"
        )
    return built(Scene, text, path, own)


def _starts_at(table: Any, start: Vector, n: int) -> bool:
    """Return True if the first row of a table equals a state in its first n coordinates."""
    if isinstance(table, SelectedColumns):
        mine = table.places < n
        return agree(table.values[0][mine], start[table.places[mine]])
    return agree(table[0][:n], start[:n])


def agree(there: Vector, here: Vector) -> bool:
    """Return True if two states are equal up to rounding errors."""
    if there.shape != here.shape:
        return False
    with np.errstate(over="ignore"):  # a file without checksums may contain any number
        distance = np.max(np.abs(there - here), initial=0.0)
    return bool(distance <= ROUNDING * np.max(np.abs(here), initial=0.0))


def read_run(path: str | Path, system: System) -> Trajectory:
    """Open the file of a run of this system, without checks."""
    path = Path(path)
    with open_file(path) as file:
        absolute = path.absolute()
        ending = StoredState(absolute, read_text(file, "run")) if LAST_STATE in file else None
        stored = _read_states(absolute, file)
        if system.prescribed.differences and "dt" in stored.settings:  # as in the run
            end = stored.settings.get("t_end", stored.t[-1])
            system.prescribed.resolve(stored.settings["dt"], stored.t[0], end)
        history = np.empty((0, 0))
        if "history" in file:
            history = check_values(path, "history", np.asarray(file["history"])[: len(stored.t)])
        return Trajectory(system, *stored, ending, history)


class StoredRun(NamedTuple):
    """Times, tables of states, statistics and settings in a file, as in `Trajectory`."""

    t: Vector
    q: Vector
    v: Vector
    a: Vector
    lam: Vector
    stats: RunStats
    settings: dict[str, Any]


def read_contents(path: str | Path) -> tuple[StoredRun, dict[str, str]]:
    """Read a run from a file, and the description of its scene, see `Scene.digest`.

    Raises
    ------
    InputError
        If this is not the file of a run.
    """
    path = check_file_name("the file of a run", path)
    with open_file(path) as file:
        return _read_states(path.absolute(), file), dict(json.loads(read_text(file, "scene")))


def read_outline(path: str | Path) -> tuple[Outline, Vector, Vector, Vector]:
    """Read outline, times and coordinates of a file, without its scene.

    Returns
    -------
    outline : Outline
        Outline of the scene.
    t : ndarray, shape (k,)
        Times [s].
    q, v : table, shape (k, n)
        Coordinates and velocities, which stay in the file.

    Raises
    ------
    InputError
        If this is not such a file, or has only some points of the scene.
    """
    path = check_file_name("the file of a run", path)
    with open_file(path) as file:
        outline = Outline.read(path, file)
        run = _read_states(path.absolute(), file)
    if outline is None:
        raise InputError(
            f"{path} does not contain the outline of its scene: it is of a run with save_nodes or "
            "of an earlier version; open it in Python with ancfsparse.load(path, scene)"
        )
    return outline, run.t, run.q, run.v


def _read_states(path: Path, file: h5py.File) -> StoredRun:
    t = np.asarray(file["t"])
    settings = dict(json.loads(read_text(file, "settings")))
    # Unknown counts of a later version are ignored.
    known = {each.name for each in fields(RunStats)}
    counts = json.loads(read_text(file, STATISTICS, "{}"))
    stats = RunStats(**{name: value for name, value in counts.items() if name in known})
    n = int(file.attrs["coordinates"])
    places = np.asarray(file["places"]) if "places" in file else None
    if not len(t):
        raise InputError(f"{path} contains no states: its run ended before the first one")
    begin = settings.get("t_start") or 0.0
    if t[0] != begin or not (np.diff(t) > 0.0).all():  # also refuses NaN
        first = "zero" if begin == 0.0 else f"{begin:.6g} s"
        raise InputError(describe_damage(path, f": its times do not increase from {first}"))
    shape = len(t), n if places is None else len(places)
    for name in "qva":
        if len(file[name]) < shape[0] or file[name].shape[1:] != shape[1:]:
            raise InputError(
                describe_damage(
                    path, f": {name} has shape {file[name].shape} where {shape} is needed"
                )
            )
    lam = np.empty((len(t), 0))
    if "lam" in file:
        lam = check_values(path, "lam", np.asarray(file["lam"])[: len(t)])
        if len(lam) != len(t):
            raise InputError(
                describe_damage(path, f": lam has {len(lam)} rows where {len(t)} are needed")
            )
    mark = read_text(file, "run")
    tables: list[Any] = [StoredTable(path, name, mark, shape) for name in "qva"]
    if places is not None:
        tables = [SelectedColumns(table, places, n) for table in tables]
    q, v, a = (cast(Vector, table) for table in tables)  # are read like arrays
    return StoredRun(t, q, v, a, lam, stats, settings)
