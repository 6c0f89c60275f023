"""Files that are replaced, of another scene, damaged, unfinished, or without room."""

import dataclasses
import json
import subprocess
import sys

import h5py
import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.results.hdf5_reader import load
from ancfsparse.scene import Scene

SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)


def pendulum(
    *, element="thin", gravity=(0.0, -9.81), material=MATERIAL, section=SECTION, joint=Scene.pin,
    force=(0.0, 0.0), velocity=None, end=(2.0, 0.0),
):  # fmt: skip
    scene = ancf.Scene(gravity)
    rod = scene.add_beam(element, (0, 0), end, 3, section, material, velocity=velocity)
    joint(scene, rod.start)
    scene.point_force(rod.end, force)
    return scene, rod


def run_to(path, n_steps=10, **changes):
    scene, rod = pendulum(**changes)
    return scene, rod, ancf.simulate(scene, n_steps * 1e-3, 1e-3, output=path)


def test_a_trajectory_whose_file_was_rewritten_says_so(tmp_path):
    path = tmp_path / "run.h5"
    _, rod, first = run_to(path)
    tip = first.position(rod.end)
    _, twin, second = run_to(path, 20, gravity=(9.81, 0.0))
    with pytest.raises(InputError, match=r"run\.h5 was rewritten by a later run"):
        first.position(rod.end)
    assert first.q.shape[0] == len(first.t) == 11
    assert len(second.position(twin.end)) == 21
    assert not np.allclose(second.position(twin.end)[-1], tip[-1])


@pytest.mark.parametrize("content", [b"a diary", b"\x89HDF\r\n\x1a\n and no more", None])
def test_files_of_others_are_not_replaced(tmp_path, content):
    path = tmp_path / "precious.txt"
    if content is None:
        with h5py.File(path, "w") as file:
            file["mine"] = 1
        content = path.read_bytes()
    path.write_bytes(content)
    message = r"precious.txt' exists and is not replaced: .*; take another name"
    with pytest.raises(InputError, match=message):
        run_to(path)
    assert path.read_bytes() == content


def test_an_empty_file_is_taken_and_a_folder_refused(tmp_path):
    (tmp_path / "new").touch()
    run_to(tmp_path / "new")
    with pytest.raises(InputError, match=r"it is a folder; give the name of a file in it, such as"):
        run_to(tmp_path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"material": ancf.Material(2e11, 7800.0)},
            r"material of body 0 there: Material\(youngs_modulus=100000000",
        ),
        ({"section": ancf.Circle(0.01)}, "section of body 0 there: Rectangle.*; here: Circle"),
        ({"gravity": (5.0, 0.0)}, r"gravity there: \(0, -9.81\); here: \(5, 0\)"),
        ({"element": "l2t2"}, "element of body 0 there: thin green; here: l2t2"),
        ({"joint": Scene.clamp}, r"joints there: pin \(body 0, 0\); here: clamp \(body 0, 0\)"),
        ({"force": (1.0, 0.0)}, r"loads there: PointForce \(body 0, 3\): \(0, 0\); here: .*\(1, 0"),
        ({"end": (2.1, 0.0)}, "the shape at t = 0"),
        ({"velocity": lambda x: x @ [[0, 1], [-1, 0]]}, "the velocity at t = 0"),
    ],
)
def test_a_file_of_a_scene_that_differs_is_refused(tmp_path, changes, message):
    run_to(tmp_path / "run.h5")
    load(tmp_path / "run.h5", pendulum()[0])
    with pytest.raises(InputError, match=f"written for another scene. What differs is {message}"):
        load(tmp_path / "run.h5", pendulum(**changes)[0])


def text(name, value):
    def replace(file):
        del file[name]
        file[name] = np.frombuffer(value.encode(), np.uint8)

    return replace


@pytest.mark.parametrize(
    ("break_it", "message"),
    [
        (text("settings", "{"), "is damaged: copy it again, or run again"),
        (text("settings", "3"), "is damaged"),
        (text("stats", '{"events": 3}'), "is damaged"),
        (text("scene", "["), "is damaged"),
        (lambda file: file.__delitem__("q"), "is damaged"),
        (lambda file: file["v"].resize(3, axis=0), r"v has shape \(3, 16\) where \(11, 16\) is"),
        (lambda file: file["q"].write_direct(np.full((11, 16), np.nan)), "a part of q is lost"),
        (lambda file: file["t"].resize(0, axis=0), "contains no states"),
        (lambda file: file["t"].write_direct(np.ones(11)), "its times do not increase from zero"),
        (lambda file: file.attrs.__setitem__("format", 4), "by a later version of ancfsparse"),
    ],
)
def test_damaged_files_are_reported(tmp_path, break_it, message):
    path = tmp_path / "run.h5"
    scene, _, _ = run_to(path)
    with h5py.File(path, "r+") as file:
        break_it(file)
    with pytest.raises(InputError, match=message):
        load(path, scene)


def test_damage_that_is_met_later_is_told(tmp_path):
    _, rod, run = run_to(tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5", "r+") as file:
        del file["q"]
    with pytest.raises(InputError, match=r"run\.h5 is damaged: copy it again"):
        run.position(rod.end)


def test_counts_of_later_versions_are_passed_over(tmp_path):
    path = tmp_path / "run.h5"
    scene, _, run = run_to(path)
    with h5py.File(path, "r+") as file:
        text("stats", json.dumps(dataclasses.asdict(run.stats) | {"new": 3}))(file)
    assert load(path, scene).stats == run.stats


def test_the_file_is_found_from_other_folders_and_missed_when_gone(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    _, rod, run = run_to("run.h5")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir("elsewhere")
    assert run.position(rod.end).shape == (11, 2)
    (tmp_path / "run.h5").unlink()
    with pytest.raises(InputError, match=r"there is no file .*run\.h5: it was moved, removed or"):
        run.position(rod.end)


def test_rows_of_a_file_are_read_as_those_of_an_array(tmp_path):
    _, _, run = run_to(tmp_path / "run.h5")
    whole = np.asarray(run.q)
    some, scattered = [[7, 2], [2, 3]], [10, 0]
    for key in (3, -1, slice(2, 5), slice(-3, None, 2), slice(None, None, -1), scattered, []):
        np.testing.assert_array_equal(run.q[key], whole[key])
        for places in (3, slice(4, 6), some, [15, 0], np.empty((2, 0), int)):
            np.testing.assert_array_equal(run.q[key, places], whole[key][..., places])
    with pytest.raises(IndexError):
        run.q[11]


FULL = """
import resource, sys
import ancfsparse as ancf
from ancfsparse.errors import OutputError
from ancfsparse.results.export import background_writer
from ancfsparse.results.hdf5_reader import load
scene = ancf.Scene()
background_writer.MIN_THREAD_BYTES = int(sys.argv[3])
rod = scene.add_beam("thin", (0, 0), (2, 0), 100, ancf.Circle(0.01), ancf.Material(1e8, 4000.0))
scene.pin(rod.start)
limit = int(sys.argv[2])
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
try:
    ancf.simulate(scene, 0.5, 1e-3, output=sys.argv[1])
except OutputError as full:
    print(full)
    run = load(sys.argv[1], scene)
    print(len(full.trajectory.t), run.position(rod.end).shape[0], run.stats.steps)
"""


@pytest.mark.parametrize("thread_bytes", [0, 2**40])
def test_a_full_disk_is_told_and_what_was_written_is_kept(tmp_path, thread_bytes):
    pytest.importorskip("resource")
    path = tmp_path / "run.h5"
    command = [sys.executable, "-c", FULL, str(path), "3000000", str(thread_bytes)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    message, counts = done.stdout.splitlines()
    assert "run.h5 cannot take the states after t = 0." in message
    assert "s: File too large. Free some space" in message
    kept, read, steps = map(int, counts.split())
    assert steps >= kept - 1  # counted, although there is no room for more
    # A state has 3 x 404 numbers; half a megabyte is set aside for the counts.
    assert kept == read > (3e6 - 2**19) / (3 * 404 * 8) * 0.8
    assert path.stat().st_size <= 3_000_000


def test_states_that_no_disk_can_take_are_refused_at_once(tmp_path, monkeypatch):
    usage = type("Usage", (), {"free": 1000})()
    monkeypatch.setattr("shutil.disk_usage", lambda _: usage)
    message = r"states would take .* GB, but only 1e-06 GB are free in .*: try a larger save_every"
    with pytest.raises(InputError, match=message):
        run_to(tmp_path / "run.h5")


@pytest.mark.parametrize("to_file", [False, True])
def test_an_interrupted_run_hands_its_states_over(tmp_path, monkeypatch, to_file):
    def interrupted(_):
        raise KeyboardInterrupt

    path = tmp_path / "run.h5" if to_file else None
    scene, rod = pendulum(force=lambda t: (0.0, 0.0) if t < 0.0505 else interrupted(t))
    monkeypatch.setattr(
        sys.modules["ancfsparse.solve.motion.fixed_step_run"], "MAX_CHUNK_COORDINATES", 160
    )
    with pytest.raises(KeyboardInterrupt) as caught:
        ancf.simulate(scene, 1.0, 1e-3, output=path)
    run = caught.value.trajectory
    assert run.position(rod.end).shape == (51, 2)
    assert not run.finished
    assert "interrupted: its states up to t = 0.05 s" in caught.value.__notes__[0]
    assert "unfinished: t_end is 1 s; 50 steps, " in repr(run)
    if to_file:
        assert repr(load(path, scene)) == repr(run)


def test_a_run_that_is_interrupted_before_it_marks_its_file_can_be_repeated(tmp_path, monkeypatch):
    """HDF5 completes such a file when it is closed, and the mark was cleared."""
    make = h5py.File

    def interrupted(*arguments, **options):
        make(*arguments, **options).close()
        raise KeyboardInterrupt

    path = tmp_path / "run.h5"
    with monkeypatch.context() as patch:
        patch.setattr(h5py, "File", interrupted)
        with pytest.raises(KeyboardInterrupt):
            run_to(path)
    assert path.stat().st_size > 0
    run_to(path)
    assert len(load(path).t) > 1


def test_a_killed_run_is_told_to_be_unfinished(tmp_path):
    path = tmp_path / "run.h5"
    code = (
        "import os, sys, ancfsparse as ancf\n"
        "scene = ancf.Scene()\n"
        "rod = scene.add_beam('thin', (0, 0), (2, 0), 3, ancf.Rectangle(0.01, 0.01),\n"
        "    ancf.Material(1e8, 4000.0))\n"
        "scene.pin(rod.start)\n"
        "end = lambda t: (0.0, 0.0) if t < 3.0 else os._exit(9)\n"
        "scene.point_force(rod.end, end)\n"
        "ancf.simulate(scene, 5.0, 1e-3, output=sys.argv[1])\n"
    )
    done = subprocess.run([sys.executable, "-c", code, str(path)], check=False)
    assert done.returncode == 9
    scene, _ = pendulum(force=lambda _: (0.0, 0.0))
    run = load(path, scene)
    assert not run.finished
    assert len(run.t) == len(run.q) == 2001
    assert "unfinished: t_end is 5 s" in repr(run)
