"""Files are known for those of runs, are written by one run at a time, and are checked as read."""

import dataclasses
import errno
import io
import json
import multiprocessing
import os
import re
import subprocess
import sys
import threading
import uuid
from pathlib import Path

import h5py
import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.results.data import recoverable_file
from ancfsparse.results.data.hdf5_format import open_file
from ancfsparse.results.data.output_lock import check_replaceable
from ancfsparse.results.data.recoverable_file import journal_of
from ancfsparse.results.export import background_writer
from ancfsparse.results.export.hdf5_writer import Writer
from ancfsparse.results.hdf5_reader import load
from tests.soak.trials import files


def pendulum(modulus=1e8, diameter=0.01):
    scene = ancf.Scene()
    circle, material = ancf.Circle(diameter), ancf.Material(modulus, 4000.0)
    rod = scene.add_beam("thin", (0, 0), (2, 0), 3, circle, material)
    scene.rod(rod.start, (0, 1))
    return scene, rod


def run_to(path, n_steps=10):
    return ancf.simulate(pendulum()[0], n_steps * 1e-3, 1e-3, output=path)


def test_a_file_of_others_with_attributes_like_ours_is_not_replaced(tmp_path):
    path = tmp_path / "mine.h5"
    with h5py.File(path, "w") as file:
        file["precious"] = np.arange(5.0)
        for name in ("settings", "scene", "run", "coordinates", "stats"):
            file.attrs[name] = "of my own program"
    content = path.read_bytes()
    with pytest.raises(InputError, match=r"exists and is not replaced: .* not a file that simul"):
        run_to(path)
    with pytest.raises(InputError, match="is not a file that simulate wrote"):
        load(path, pendulum()[0])
    assert path.read_bytes() == content


def write_first_format(path, run):
    """Write a run as version 0.1.0 did: no mark, no checksums, texts as attributes."""
    with h5py.File(path, "w") as file:
        for name in ("q", "v", "a", "lam", "t"):
            values = np.asarray(getattr(run, name))
            limits = (None, *values.shape[1:])
            file.create_dataset(name, data=values, maxshape=limits, chunks=values.shape)
        scene = run.system.scene.digest()
        scene["material of body 0"] = (
            "Material(youngs_modulus=100000000, density=np.float64(4000.0), poisson_ratio=0.3, "
            "axial_damping=0.0, bending_damping=0.0, rayleigh=(0.0, 0.0))"
        )
        scene["section of body 0"] = "Circle(diameter=array(0.01))"
        file.attrs["coordinates"] = run.q.shape[1]
        file.attrs["settings"] = json.dumps(dict(run.settings))
        file.attrs["scene"] = json.dumps(scene)
        file.attrs["run"] = uuid.uuid4().hex
        file.attrs["stats"] = json.dumps(dataclasses.asdict(run.stats))


def test_files_of_version_0_1_0_are_read_and_replaced(tmp_path):
    path = tmp_path / "old.h5"
    scene, rod = pendulum()
    run = ancf.simulate(scene, 0.01, 1e-3)
    write_first_format(path, run)
    old = load(path, scene)
    np.testing.assert_array_equal(old.position(rod.end), run.position(rod.end))
    np.testing.assert_array_equal(old.reaction(rod.start), run.reaction(rod.start))
    assert repr(old.stats) == repr(run.stats)
    with pytest.raises(InputError, match=r"What differs is material of body 0 there: .*000000, "):
        load(path, pendulum(100_000_001)[0])
    run_to(path, 20)
    assert len(load(path, scene).t) == 21
    write_first_format(path, run)
    with h5py.File(path, "r+") as file:
        file["q"][0, 0] = 1.7e308
    with pytest.raises(InputError, match="the shape at t = 0"):
        load(path, scene)


@pytest.mark.parametrize("size", [20, 600, 5000])
def test_a_run_whose_file_was_cut_off_can_be_run_again(tmp_path, size):
    path = tmp_path / "run.h5"
    run_to(path)
    path.write_bytes(path.read_bytes()[:size])
    with pytest.raises(InputError, match=f"cut off or damaged after {size} bytes: copy it again"):
        load(path, pendulum()[0])
    run_to(path)
    assert load(path, pendulum()[0]).finished


KILLED_WITH_ROOM = """
take = writer.allocate_disk
def with_room(*arguments):
    take(*arguments)
    os._exit(9)
writer.allocate_disk = with_room
"""
KILLED_WITHOUT_MARK = """
make = h5py.File
def without_mark(*arguments, **options):
    file = make(*arguments, **options)
    os._exit(9)
h5py.File = without_mark
"""


@pytest.mark.parametrize("how", [KILLED_WITH_ROOM, KILLED_WITHOUT_MARK])
def test_a_run_that_is_killed_while_it_makes_its_file_can_be_run_again(tmp_path, how):
    path = tmp_path / "run.h5"
    code = "import os, sys, h5py\n"
    code += "from ancfsparse.results.export import hdf5_writer as writer\n" + how
    code += "writer.Writer(sys.argv[1], 3, 0, None, {}, {})"
    done = subprocess.run([sys.executable, "-c", code, str(path)], check=False)
    assert done.returncode == 9
    assert path.stat().st_size > 0
    with pytest.raises(InputError):
        load(path, pendulum()[0])
    run_to(path)
    assert load(path, pendulum()[0]).finished


@pytest.mark.parametrize("thread_bytes", [0, 2**40])
def test_a_run_that_is_killed_at_any_write_leaves_the_states_that_were_passed_on(
    tmp_path, monkeypatch, thread_bytes
):
    """Without the journal, HDF5 could not read some of these files."""
    monkeypatch.setattr(background_writer, "MIN_THREAD_BYTES", thread_bytes)
    path, copy, cuts = tmp_path / "run.h5", tmp_path / "copy.h5", []
    write, append, passed = recoverable_file._write_all, Writer.append, [0]

    def cutting(target, data):
        for part in (0, len(data) // 2):
            write(target, memoryview(data)[:part])
            if passed[-1]:
                cuts.append((path.read_bytes(), journal_of(path).read_bytes(), passed[-1]))
            target.seek(-part, os.SEEK_CUR)
        write(target, data)

    def counted(writer, *rows, **where):
        append(writer, *rows, **where)
        passed.append(writer.rows)

    with monkeypatch.context() as patch:
        patch.setattr(recoverable_file, "_write_all", cutting)
        patch.setattr(Writer, "append", counted)
        whole = ancf.simulate(pendulum()[0], 4.0, 1e-3, save_every=7, output=path)
    assert len(cuts) > 100
    unreadable = 0
    for content, journal, rows in cuts[:: len(cuts) // 30]:
        copy.write_bytes(content)
        try:
            load(copy)
        except InputError:
            unreadable += 1
        journal_of(copy).write_bytes(journal)
        kept = load(copy)
        assert len(kept.t) >= rows
        assert np.array_equal(kept.q[:], whole.q[: len(kept.t)])
        assert not journal_of(copy).exists()
    assert unreadable > 0


def test_the_journal_of_another_run_changes_no_file(tmp_path, monkeypatch):
    path, other, journals = tmp_path / "run.h5", tmp_path / "other.h5", []
    append = Writer.append

    def copied(writer, *rows, **where):
        append(writer, *rows, **where)
        journals.append(journal_of(other).read_bytes())

    monkeypatch.setattr(Writer, "append", copied)
    run_to(other)
    monkeypatch.undo()
    run_to(path)
    content = path.read_bytes()
    journal_of(path).write_bytes(journals[-1])
    assert load(path).finished
    assert path.read_bytes() == content


def test_a_killed_run_in_a_folder_that_cannot_be_written_asks_for_a_copy(tmp_path, monkeypatch):
    path = tmp_path / "run.h5"
    run_to(path)
    journal_of(path).touch()
    begin = Path.open

    def refuse(file, mode="r", *rest, **options):
        if "+" in mode:
            raise PermissionError(errno.EACCES, "Permission denied")
        return begin(file, mode, *rest, **options)

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(InputError, match=r"run.h5 is of a run that was killed, .* copy both files"):
        load(path)
    monkeypatch.undo()
    assert load(path).finished
    assert not journal_of(path).exists()


def test_no_damage_of_a_file_is_read_as_a_run():
    reports = [files.run(20260722, k) for k in range(120)]
    assert [report.finds for report in reports if report.finds] == []
    refused = sum(report.outcome == "refused" for report in reports)
    assert refused > 90  # some places of a file hold nothing


def test_zeros_in_place_of_a_part_of_a_file_are_not_read_as_numbers(tmp_path):
    # Fletcher's checksum of zeros is zero, and equal for the words 0 and 0xffff.
    path = tmp_path / "run.h5"
    data, _ = files.good_file()
    chunks, erased = parts_of(data), []
    assert {"q", "v", "a", "lam", "last", "last_lam", "stats"} <= {name for name, *_ in chunks}
    for _, begin, end in chunks:
        begins = [k for k in range(begin, end - 1) if data[k : k + 2] == b"\xff\xff"]
        for start, stop in ((begin, end), *((k, k + 2) for k in begins[:20])):
            damaged = bytearray(data)
            damaged[start:stop] = bytes(stop - start)
            path.write_bytes(damaged)
            erased.append(stop - start)
            with pytest.raises(InputError, match="damaged"):
                read_everything(path)
    assert erased.count(2) > 10


def parts_of(data):
    """Return name, begin and end of the chunks of all tables of a file, in bytes."""
    parts = []
    with h5py.File(io.BytesIO(data), "r") as file:
        for table in tables_of(file):
            for k in range(table.id.get_num_chunks()):
                chunk = table.id.read_direct_chunk(table.id.get_chunk_info(k).chunk_offset)[1]
                assert data.count(chunk) == 1
                begin = data.index(chunk)
                parts.append((table.name.removeprefix("/"), begin, begin + len(chunk)))
    return parts


def tables_of(file):
    items = []
    file.visit(lambda name: items.append(file[name]))
    return [item for item in items if isinstance(item, h5py.Dataset)]


def read_everything(path):
    with open_file(path) as file:
        for table in tables_of(file):
            table[()]


def test_a_motion_without_velocities_is_read_as_it_was_written(tmp_path):
    path = tmp_path / "run.h5"
    scene = ancf.Scene((0.0, 0.0))
    scene.add_beam("thin", (0, 0), (2, 0), 2, ancf.Circle(0.01), ancf.Material(1e8, 4000.0))
    ancf.simulate(scene, 0.01, 1e-3, output=path)
    assert not load(path).v[:].any()


def load_with_damaged_chunks(path):
    """Load a file with sizes and filter masks of chunks that no file has, in all its tables."""
    data, _ = files.good_file()
    indices = [m.start() for m in re.finditer(b"TREE\x01", data)]
    assert len(indices) > 15
    for place in indices:
        for size, mask in ((0, 0), (1, 0), (4, 0), (2**31, 0), (None, 1), (None, 2**32 - 1)):
            damaged = bytearray(data)
            if size is not None:
                damaged[place + 24 : place + 28] = size.to_bytes(4, "little")
            damaged[place + 28 : place + 32] = mask.to_bytes(4, "little")
            path.write_bytes(damaged)
            with pytest.raises(InputError, match="damaged"):
                load(path, files.pendulum()[0])


def test_damaged_chunks_are_refused_before_hdf5_reads_them(tmp_path):
    # HDF5 ended the process.
    process = multiprocessing.get_context("spawn").Process(
        target=load_with_damaged_chunks, args=(tmp_path / "run.h5",)
    )
    process.start()
    process.join()
    assert process.exitcode == 0


def test_a_file_is_written_by_one_run_at_a_time(tmp_path):
    path = tmp_path / "run.h5"
    message = r"run.h5' is being written by another run: take another name, or wait for its end"
    with Writer(path, 4, 0, None, {}, {}):
        for start in (lambda: Writer(path, 4, 0, None, {}, {}), lambda: run_to(path)):
            with pytest.raises(InputError, match=message):
                start()
        with pytest.raises(InputError, match="because a run is writing to it: wait for its"):
            load(path, pendulum()[0])
    check_replaceable(path)
    run_to(path)


def test_of_runs_that_start_together_one_gets_the_file(tmp_path):
    def start():
        barrier.wait()
        try:
            with Writer(path, 4, 0, None, {}, {}) as writer:
                barrier.wait()
                row = np.zeros((1, 4))
                writer.append(np.zeros(1), row, row, row, np.zeros((1, 0)))
                ends.append("")
        except InputError as refused:
            ends.append(str(refused))
            barrier.wait()

    for k in range(20):
        path, ends, barrier = tmp_path / f"run{k}.h5", [], threading.Barrier(3, timeout=300)
        threads = [threading.Thread(target=start) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert sum("is being written by another run" in end for end in ends) == 2
        with h5py.File(path) as file:
            assert file["q"].shape == (1, 4)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("x" * 300, "cannot be the file 'xxx.*: File name too long"),
        ("a\0b", r"cannot be the file 'a\\x00b': it has a NUL character"),
        (None, "the file of a run must be the name of a file such as 'run.h5', got None"),
        (b"run.h5", "must be the name of a file such as 'run.h5', got b'run.h5'"),
    ],
)
def test_names_that_no_file_can_have(tmp_path, monkeypatch, name, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=message):
        load(name, pendulum()[0])
    if name is not None:
        with pytest.raises(InputError, match=message):
            run_to(name)


def test_a_file_is_loaded_with_a_scene():
    with pytest.raises(InputError, match="a Scene is needed, got 3"):
        load("run.h5", 3)


@pytest.mark.parametrize(
    ("modulus", "diameter"),
    [(100_000_000, np.float32(0.01)), (np.float64(1e8), np.array(0.01)), (np.int64(10**8), 0.01)],
)
def test_numbers_of_a_scene_are_compared_by_value(tmp_path, modulus, diameter):
    run_to(tmp_path / "run.h5")
    scene, _ = pendulum(modulus, diameter)
    assert load(tmp_path / "run.h5", scene).finished
    (beam,) = scene.beams
    assert hash(beam.section) == hash(ancf.Circle(0.01))
    assert repr(beam.material) == repr(ancf.Material(1e8, 4000.0))


def gust(t):
    return (t, 0.0)


def test_a_file_brings_its_scene_along(tmp_path):
    scene, rod = pendulum()
    scene.point_force(rod.at(0.7), gust)
    path = tmp_path / "run.h5"
    run = ancf.simulate(scene, 5e-3, 1e-3, output=path)
    with pytest.raises(InputError, match=r"run\.h5, record 3: it needs '.*_runs\.gust'"):
        load(path)
    again = load(path, own={f"{gust.__module__}.gust": gust})
    assert again.system.scene == scene
    end = again.system.scene.body("beam 0").end
    np.testing.assert_array_equal(again.position(end), run.position(rod.end))
    np.testing.assert_array_equal(again.energy.total, run.energy.total)
    uses = (
        lambda: again.position(rod.end),
        lambda: again.reaction(rod.start),
        lambda: again.section_force(rod),
        lambda: again.plot("shape", rod),
        lambda: again.joint_force(scene.joints[0]),
    )
    for use in uses:
        with pytest.raises(InputError, match=r"run\.system\.scene\..* as in .*load\(path, scene\)"):
            use()


def test_a_file_without_its_scene_asks_for_it(tmp_path):
    scene, rod = pendulum()
    for factor in (1.0, 2.0):
        scene.point_force(rod.end, lambda t, factor=factor: (factor * t, 0.0))
    path = tmp_path / "run.h5"
    run = ancf.simulate(scene, 5e-3, 1e-3, output=path)
    with pytest.raises(
        InputError, match=r"run\.h5 does not contain its scene, because functions of"
    ):
        load(path)
    np.testing.assert_array_equal(load(path, scene).q, run.q)
    write_first_format(tmp_path / "old.h5", run)
    with pytest.raises(InputError, match=r"old\.h5 does not contain its scene, .* an earlier ver"):
        load(tmp_path / "old.h5")
