"""Continue the run of a file from its last checkpoint."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ancfsparse.checks import check_flag
from ancfsparse.errors import InputError
from ancfsparse.file_names import check_file_name
from ancfsparse.results import Trajectory
from ancfsparse.results.data.checkpoint_file import checkpoint_of, read_checkpoint
from ancfsparse.results.data.output_lock import check_replaceable
from ancfsparse.results.hdf5_reader import agree, read_contents
from ancfsparse.scene import Scene, check_scene
from ancfsparse.scene.storage.digest import difference
from ancfsparse.scene.storage.json_file import built
from ancfsparse.solve.motion.checkpoint_files import make_request, unpack
from ancfsparse.solve.motion.simulate import build_system_at_start, run_request
from ancfsparse.solve.preparation.memory_estimate import check_memory
from ancfsparse.system import System


def resume(
    path: str | Path,
    scene: Scene | None = None,
    *,
    own: Mapping[str, Any] | None = None,
    progress: bool = False,
) -> Trajectory:
    """Continue a run that was killed or interrupted, from its last checkpoint to its end.

    On one thread the states equal an uninterrupted run to the last bit.

    Parameters
    ----------
    path : str or Path
        The file that ``simulate(..., output=path, checkpoint=...)`` wrote, with the file of the
        same name and the ending ``.checkpoint``.
    scene : Scene, optional
        The scene of the run, built by the same calls; needed if it has functions of Python, which
        no file can hold.  By default it is rebuilt from the checkpoint.
    own : dict of str to object, optional
        User functions and elements of a scene that is rebuilt, as in `Scene.load`.
    progress : bool, optional
        Whether to show a progress bar.

    Returns
    -------
    Trajectory
        All states, those before the checkpoint included; counts and times are sums over all parts.

    Raises
    ------
    InputError
        If the file has no checkpoint, cannot be written, or is of a finished run or of another
        scene.
    AncfError
        As in `simulate`.
    """
    file = check_file_name("the file of a run", path)
    check_flag("progress", progress)
    if not file.exists():
        raise InputError(
            f"{file.absolute()} does not exist: it was moved, removed or never written"
        )
    if file.is_dir():
        raise InputError(f"{file.absolute()} is a folder: give the name of a file in it")
    if not checkpoint_of(file).exists():
        raise InputError(_describe_missing(file))
    check_replaceable(file)
    head, rest = unpack(memoryview(read_checkpoint(file).data))
    resumed, _ = unpack(rest)
    if scene is None:
        scene = _rebuild_scene(file, head["records"], {} if own is None else own)
    check_scene(scene)
    other = difference(head["scene"], scene.digest())
    if other is None:
        system = System(scene)
        if not agree(head["shape"], system.q_ref):
            other = "the stress-free shape"
    if other is not None:
        raise InputError(f"{file} was written for another scene. What differs is {other}")
    request = make_request(head, scene, file, progress)
    check_memory(request.memory())
    system = build_system_at_start(request)
    if not agree(head["velocities"], system.v0):
        raise InputError(
            f"{file} was written for another scene. What differs is the velocity at the start"
        )
    return run_request(request, system, resumed)


def _describe_missing(file: Path) -> str:
    """Return the reason why a file cannot be resumed that has no checkpoint."""
    settings = read_contents(file)[0]
    t, t_end = settings.t[-1], settings.settings.get("t_end")
    if t_end is not None and t >= t_end * (1.0 - 1e-9):
        return (
            f"the run of {file} is finished, at t = {t:.6g} s: open it by ancf.load({str(file)!r})"
        )
    return (
        f"{file} has no checkpoint, because {checkpoint_of(file)} does not exist: its run had no "
        "checkpoint=..., or that file was not moved with it; to begin again from its last state at "
        f"t = {t:.6g} s, call simulate with start=ancf.load({str(file)!r}).last"
    )


def _rebuild_scene(file: Path, records: str, own: Mapping[str, Any]) -> Scene:
    """Rebuild the scene of a checkpoint."""
    again = f"give the scene again, as in ancf.resume({str(file)!r}, scene=scene)"
    if not records:
        raise InputError(
            f"the scene of {file} has several functions of one name, which a checkpoint cannot "
            f"distinguish: {again}"
        )
    try:
        return built(Scene, records, file, own)
    except InputError as refused:
        raise InputError(f"the scene of {file} cannot be rebuilt: {refused}; or {again}") from None
