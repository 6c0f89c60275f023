"""Checkpoints in files: runs are resumed to the last bit, and refused in a sentence."""

import errno
import os
import shutil
import signal
from pathlib import Path

import h5py
import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.results.data import checkpoint_file, recoverable_file
from ancfsparse.results.data.checkpoint_file import checkpoint_of
from ancfsparse.results.data.output_lock import OutputLock
from ancfsparse.results.data.recoverable_file import RecoverableFile, journal_of, recover
from ancfsparse.results.export.hdf5_writer import Writer
from tests.cli.command import run as run_command
from tests.solve.simulation.scenes import INTEGRATORS, SCENES, SOLVERS, pendulum

DT = 1e-3  # s
STEPS = 60


def moved_pendulum():
    return pendulum(ancf.Sine((0.0, 1.0), 3.0))[0]


def equal(one, other):
    """Return whether two runs have the same states and counts."""
    tables = ("t", "q", "v", "a", "lam")
    counts = "steps", "iterations", "factorizations", "events", "checkpoints", "solver"
    return all(
        np.array_equal(np.array(getattr(one, k)[:]), np.array(getattr(other, k)[:])) for k in tables
    ) and all(repr(getattr(one.stats, k)) == repr(getattr(other.stats, k)) for k in counts)


def interrupt(monkeypatch, path, scene, number, **options):
    """Run to a file until a checkpoint of a number, and interrupt the run there."""
    keep, count = Writer.keep_checkpoint, 0

    def counted(writer, data):
        nonlocal count
        keep(writer, data)
        count += 1
        if count > number:
            raise KeyboardInterrupt

    options = {"checkpoint": 10} | options
    with monkeypatch.context() as patch:
        patch.setattr(Writer, "keep_checkpoint", counted)
        with pytest.raises(KeyboardInterrupt) as stop:
            ancf.simulate(scene, STEPS * DT, DT, output=path, **options)
    return stop.value.trajectory


@pytest.mark.parametrize("solver", SOLVERS, ids=repr)
@pytest.mark.parametrize("name", SCENES)
def test_an_interrupted_run_is_resumed_to_the_last_bit(monkeypatch, tmp_path, name, solver):
    make, _ = SCENES[name]
    integrator = INTEGRATORS[SOLVERS.index(solver) % len(INTEGRATORS)]
    options = {"solver": solver, "integrator": integrator, "max_energy_gain": np.inf}
    whole = ancf.simulate(
        make(), STEPS * DT, DT, output=tmp_path / "whole.h5", checkpoint=10, **options
    )
    begun = interrupt(monkeypatch, tmp_path / "run.h5", make(), 3, **options)
    assert begun.t[-1] == pytest.approx(30 * DT)
    again = ancf.resume(tmp_path / "run.h5")
    assert again.finished
    assert equal(whole, again)
    assert whole.stats.checkpoints == [10, 20, 30, 40, 50]
    assert sorted(os.listdir(tmp_path)) == ["run.h5", "whole.h5"]


def test_a_run_with_checkpoints_is_one_without_them_within_the_tolerance(tmp_path):
    runs = [
        ancf.simulate(
            moved_pendulum(), STEPS * DT, DT, tolerance=1e-8, output=tmp_path / f"{k}.h5", **given
        )
        for k, given in enumerate(({}, {"checkpoint": 7}))
    ]
    np.testing.assert_allclose(runs[1].q[:], runs[0].q[:], rtol=0.0, atol=1e-10)


def test_checkpoints_after_times_can_be_repeated_by_their_steps(tmp_path):
    options = {"integrator": ancf.GeneralizedAlpha(0.5), "save_every": 10}
    timed = ancf.simulate(
        moved_pendulum(), 4.1, DT, output=tmp_path / "timed.h5", checkpoint="1e-9 s", **options
    )
    steps = timed.stats.checkpoints
    assert steps == [2000, 4000]  # the longest times between two looks at the clock
    again = ancf.simulate(
        moved_pendulum(), 4.1, DT, output=tmp_path / "again.h5", checkpoint=steps, **options
    )
    assert equal(timed, again)


def test_every_cut_of_the_writes_is_restored(tmp_path, monkeypatch, rng):
    path, states = tmp_path / "run.h5", rng.normal(size=(40, 50))
    path.touch()
    disk = RecoverableFile(path)
    file = h5py.File(disk, "w", libver=("v108", "v108"), userblock_size=512)
    table = file.create_dataset("q", (0, 50), float, maxshape=(None, 50), chunks=(7, 20))
    for row in range(20):
        table.resize(row + 1, axis=0)
        table[row] = states[row]
    file.flush()
    size = file.id.get_filesize()
    disk.seal(size)
    sealed, cuts = path.read_bytes()[:size], []
    write = recoverable_file._write_all

    def cutting(target, data):
        for part in (0, len(data) // 2):
            write(target, memoryview(data)[:part])
            cuts.append((path.read_bytes(), journal_of(path).read_bytes()))
            target.seek(-part, os.SEEK_CUR)
        write(target, data)

    monkeypatch.setattr(recoverable_file, "_write_all", cutting)
    for row in range(20, 40):
        table.resize(row + 1, axis=0)
        table[row] = states[row]
        if row % 5 == 0:
            file.flush()
    file.close()
    disk.close()
    monkeypatch.undo()
    assert len(cuts) > 50
    changed = 0
    for data, journal in cuts:
        path.write_bytes(data)
        journal_of(path).write_bytes(journal)
        changed += data[:size] != sealed
        recover(path)
        assert path.read_bytes() == sealed
        assert not journal_of(path).exists()
    assert changed > 10


@pytest.fixture
def interruptible():
    """Let an interruption raise an error, which a shell ignores in background processes."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_signals_wait_until_hdf5_has_written(monkeypatch, tmp_path):
    whole = ancf.simulate(
        moved_pendulum(), STEPS * DT, DT, output=tmp_path / "whole.h5", checkpoint=10
    )
    write, count = RecoverableFile.write, 0

    def signalling(disk, data):
        nonlocal count
        count += disk._seal > 4  # after the first states
        if count == 20:
            os.kill(os.getpid(), signal.SIGINT)
        return write(disk, data)

    path = tmp_path / "run.h5"
    with monkeypatch.context() as patch:
        patch.setattr(RecoverableFile, "write", signalling)
        with pytest.raises(KeyboardInterrupt) as stop:
            ancf.simulate(moved_pendulum(), STEPS * DT, DT, output=path, checkpoint=10)
    assert len(stop.value.trajectory.t) > 1
    assert np.array_equal(ancf.load(path).q[:], stop.value.trajectory.q[:])
    assert equal(ancf.resume(path), whole)


def test_a_full_disk_leaves_the_last_checkpoint(monkeypatch, tmp_path):
    whole = ancf.simulate(
        moved_pendulum(), STEPS * DT, DT, output=tmp_path / "whole.h5", checkpoint=10
    )
    name, count = checkpoint_file._name, 0

    def full(path):
        nonlocal count
        count += 1
        if count == 4:
            raise OSError(errno.ENOSPC, "")
        return name(path)

    path = tmp_path / "run.h5"
    with monkeypatch.context() as patch:
        patch.setattr(checkpoint_file, "_name", full)
        with pytest.raises(ancf.OutputError):
            ancf.simulate(moved_pendulum(), STEPS * DT, DT, output=path, checkpoint=10)
    assert equal(ancf.resume(path), whole)


def test_the_command_resumes_a_run(monkeypatch, capsys, tmp_path):
    path = tmp_path / "run.h5"
    interrupt(monkeypatch, path, moved_pendulum(), 2)
    code, out, _ = run_command(capsys, "resume", path, "--no-progress")
    assert code == 0
    assert out.startswith("Trajectory: 61 states from t = 0 s to 0.06 s")
    code, out, err = run_command(capsys, "resume", path)
    assert (code, out) == (2, "")
    assert f"the run of {path} is finished, at t = 0.06 s" in err


def test_a_scene_with_functions_is_given_again(monkeypatch, tmp_path):
    def force(t):
        return (0.0, np.sin(t))

    path = tmp_path / "run.h5"
    interrupt(monkeypatch, path, pendulum(force)[0], 2)
    with pytest.raises(ancf.InputError, match=r"cannot be rebuilt: .*record 3: .*force.* scene=sc"):
        ancf.resume(path)
    assert ancf.resume(path, pendulum(force)[0]).finished


def test_another_scene_is_refused_and_the_file_stays(monkeypatch, tmp_path):
    path = tmp_path / "run.h5"
    interrupt(monkeypatch, path, moved_pendulum(), 2)
    before = path.read_bytes()
    with pytest.raises(ancf.InputError, match=r"written for another scene\. What differs is loads"):
        ancf.resume(path, pendulum((0.0, 2.0))[0])
    other = ancf.Scene((0, -9.81))
    with pytest.raises(ancf.InputError, match="written for another scene"):
        ancf.resume(path, other)
    assert path.read_bytes() == before


def test_files_without_their_checkpoint_are_refused(monkeypatch, tmp_path):
    path, other = tmp_path / "run.h5", tmp_path / "other.h5"
    for folder in (tmp_path, ".", Path()):
        with pytest.raises(ancf.InputError, match="is a folder: give the name of a file in it"):
            ancf.resume(folder)
    with pytest.raises(ancf.InputError, match="does not exist: it was moved"):
        ancf.resume(path)
    ancf.simulate(moved_pendulum(), STEPS * DT, DT, output=path)
    with pytest.raises(ancf.InputError, match=r"is finished, at t = 0.06 s: open it by ancf.load"):
        ancf.resume(path)
    for file in (path, other):
        interrupt(monkeypatch, file, moved_pendulum(), 2)
    shutil.copy(checkpoint_of(other), checkpoint_of(path))
    with pytest.raises(ancf.InputError, match="is the checkpoint of another run than"):
        ancf.resume(path)
    data = bytearray(checkpoint_of(other).read_bytes())
    data[500] ^= 1
    checkpoint_of(other).write_bytes(data)
    with pytest.raises(ancf.InputError, match="is damaged, or not the checkpoint of a run"):
        ancf.resume(other)
    checkpoint_of(other).unlink()
    with pytest.raises(ancf.InputError, match=r"has no checkpoint, because .* start=ancf.load"):
        ancf.resume(other)


def test_a_later_run_removes_the_checkpoint_of_an_earlier_one(monkeypatch, tmp_path):
    path = tmp_path / "run.h5"
    interrupt(monkeypatch, path, moved_pendulum(), 2)
    ancf.simulate(moved_pendulum(), DT, DT, output=path)
    assert os.listdir(tmp_path) == ["run.h5"]


def test_files_in_use_and_without_permission_are_refused(monkeypatch, tmp_path):
    path = tmp_path / "run.h5"
    interrupt(monkeypatch, path, moved_pendulum(), 2)
    lock = OutputLock(path)
    with pytest.raises(ancf.InputError, match="is being written by another run"):
        ancf.resume(path)
    lock.release()

    def refuse(*_):
        raise PermissionError(errno.EACCES, "")

    with monkeypatch.context() as patch:  # the owner of a test may have all permissions
        patch.setattr(OutputLock, "__init__", refuse)
        with pytest.raises(ancf.InputError, match="cannot be written: Permission denied"):
            ancf.resume(path)
    assert ancf.resume(path).finished


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"checkpoint": 0}, "checkpoint must be"),
        ({"checkpoint": "5 parsecs"}, "a time such as '5 min', got '5 parsecs': units are s, min"),
        ({"checkpoint": "-1 s"}, "a time such as '5 min'"),
        ({"checkpoint": [20, 10]}, "the steps in checkpoint must increase"),
        ({"checkpoint": 10, "output": None}, "checkpoint needs the file of the run: give output="),
        ({"checkpoint": 10, "accuracy": 1e-3}, "has no checkpoints: take dt in place of accuracy"),
    ],
)
def test_invalid_checkpoints_are_refused(tmp_path, options, message):
    options = {"output": tmp_path / "run.h5"} | options
    with pytest.raises(ancf.InputError, match=message):
        ancf.simulate(moved_pendulum(), STEPS * DT, DT, **options)
    assert not os.listdir(tmp_path)


def test_the_progress_of_a_resumed_run_is_true_or_false(tmp_path):
    (tmp_path / "run.h5").touch()
    with pytest.raises(ancf.InputError, match="progress must be True or False"):
        ancf.resume(tmp_path / "run.h5", progress=np.zeros(0))
