"""Sweeps: points, tables, failures, files, workers."""

import multiprocessing
import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.sweeps import workers
from ancfsparse.sweeps.forks import can_fork, run_forked
from ancfsparse.sweeps.point import Task

pd = pytest.importorskip("pandas")


def pendulum(length, n_elements=4):
    scene = ancf.Scene()
    material = ancf.Material(youngs_modulus=1e7, density=1000.0)
    rod = scene.add_beam(
        "thin", (0, 0), (length, 0), n_elements, ancf.Rectangle(0.02, 0.02), material
    )
    scene.pin(rod.start)
    return scene, rod


def tip(run, rod):
    return run.position(rod.end)[-1, 1]


def fragile(length):
    if length > 1.5:
        raise ZeroDivisionError("no such rod")
    return pendulum(length)


def deadly(length):
    if length > 1.5:
        os._exit(1)
    return pendulum(length)


QUANTITIES = {"tip": tip, "energy": lambda run, rod: run.energy.total[-1]}
LENGTHS = [1.0, 1.2, 1.4, 1.6, 1.8, 2.0]


def test_a_grid_varies_its_last_parameter_fastest():
    points = ancf.grid(length=[1.0, 2.0], n_elements=range(2))
    assert points == [
        {"length": 1.0, "n_elements": 0},
        {"length": 1.0, "n_elements": 1},
        {"length": 2.0, "n_elements": 0},
        {"length": 2.0, "n_elements": 1},
    ]


def test_a_latin_hypercube_has_one_point_in_every_strip():
    points = ancf.latin_hypercube(20, seed=3, length=(1.0, 3.0), width=(0.1, 0.2))
    assert points == ancf.latin_hypercube(20, seed=3, length=(1.0, 3.0), width=(0.1, 0.2))
    for name, low, high in (("length", 1.0, 3.0), ("width", 0.1, 0.2)):
        strips = np.floor([20 * (each[name] - low) / (high - low) for each in points])
        assert sorted(strips) == list(range(20))


def test_a_table_has_the_numbers_of_single_runs():
    table = ancf.sweep(pendulum, ancf.grid(length=LENGTHS[:3]), QUANTITIES, 0.1, workers=1, dt=1e-3)
    assert list(table.columns) == ["length", "tip", "energy", "reason", "seconds"]
    for length, found in zip(table["length"], table["tip"], strict=True):
        scene, rod = pendulum(length)
        assert found == tip(ancf.simulate(scene, 0.1, dt=1e-3), rod)
    assert (table["reason"] == "").all()


@pytest.mark.parametrize("cluster", [None, pytest.param("local", marks=pytest.mark.slow)])
def test_two_workers_give_the_same_table_bit_for_bit(cluster):
    if cluster:
        pytest.importorskip("dask.distributed")
    points = ancf.grid(length=LENGTHS, n_elements=[3, 4])
    alone = ancf.sweep(pendulum, points, QUANTITIES, 0.1, workers=1, dt=1e-3)
    beside = ancf.sweep(pendulum, points, QUANTITIES, 0.1, workers=2, dt=1e-3, cluster=cluster)
    pd.testing.assert_frame_equal(alone.drop(columns="seconds"), beside.drop(columns="seconds"))


def test_points_that_fail_are_rows_with_a_reason():
    points = ancf.grid(length=LENGTHS)
    table = ancf.sweep(fragile, points, QUANTITIES, 0.1, workers=1, dt=1e-3)
    assert list(np.isnan(table["tip"])) == [False] * 3 + [True] * 3
    assert list(table["reason"][3:]) == ["ZeroDivisionError: no such rod"] * 3
    table = ancf.sweep(
        pendulum, ancf.grid(length=[1.0, -1.0, 0.0]), QUANTITIES, 0.1, workers=1, dt=1e-3
    )
    assert "zero length" in table["reason"][2]


@pytest.mark.parametrize("cluster", [None, pytest.param("local", marks=pytest.mark.slow)])
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_point_that_kills_its_worker_fails_alone(cluster):
    if cluster:
        pytest.importorskip("dask.distributed")
    lengths = LENGTHS[:4] if cluster else LENGTHS  # a cluster tries a deadly point several times
    points = ancf.grid(length=lengths)
    table = ancf.sweep(deadly, points, QUANTITIES, 0.1, workers=2, dt=1e-3, cluster=cluster)
    assert list(table["reason"] == "") == [length <= 1.5 for length in lengths]
    assert table["reason"][3] == "the process of its worker ended"


def test_a_sweep_goes_on_from_its_file(tmp_path):
    file, points, calls = tmp_path / "sweep.jsonl", ancf.grid(length=LENGTHS), []

    def counted(length):
        calls.append(length)
        return pendulum(length)

    options = {"file": file, "workers": 1, "dt": 1e-3}
    whole = ancf.sweep(counted, points, QUANTITIES, 0.1, **options)
    lines = file.read_bytes().splitlines(keepends=True)
    assert len(lines) == 7
    file.write_bytes(b"".join(lines[:4]) + lines[4][:20])  # interrupted while it wrote
    calls.clear()
    again = ancf.sweep(counted, points, QUANTITIES, 0.1, **options)
    assert calls == LENGTHS[3:]
    pd.testing.assert_frame_equal(again.drop(columns="seconds"), whole.drop(columns="seconds"))
    calls.clear()
    ancf.sweep(counted, points, QUANTITIES, 0.1, **options)
    assert calls == []


def test_a_file_of_another_sweep_is_refused(tmp_path):
    file, points = tmp_path / "sweep.jsonl", ancf.grid(length=[1.0])
    ancf.sweep(pendulum, points, QUANTITIES, 0.1, file=file, workers=1, dt=1e-3)
    with pytest.raises(ancf.InputError, match="whose t_end was"):
        ancf.sweep(pendulum, points, QUANTITIES, 0.2, file=file, workers=1, dt=1e-3)
    for text, words in (
        (file.read_text() + '{"point": 3}\n', "is damaged"),
        ("length,tip\n1,2\n", "damaged or not a file of a sweep"),
        ("[1]\n", "not a file of a sweep"),
    ):
        file.write_text(text)
        with pytest.raises(ancf.InputError, match=words):
            ancf.sweep(pendulum, points, QUANTITIES, 0.1, file=file, workers=1, dt=1e-3)
    with pytest.raises(ancf.InputError, match="cannot be written"):
        ancf.sweep(pendulum, points, QUANTITIES, 0.1, file=tmp_path / "no" / "file", workers=1)


SCRIPT = """
    import sys
    import ancfsparse as ancf

    def build(length):
        scene = ancf.Scene()
        material = ancf.Material(youngs_modulus=1e7, density=1000.0)
        section = ancf.Rectangle(0.02, 0.02)
        rod = scene.add_beam("thin", (0, 0), (length, 0), 20, section, material)
        scene.pin(rod.start)
        return scene, rod

    if __name__ == "__main__":
        points = ancf.grid(length=[1.0 + 0.01 * k for k in range(40)])
        quantities = {"tip": lambda run, rod: run.position(rod.end)[-1, 1]}
        table = ancf.sweep(build, points, quantities, 1.0, file=sys.argv[1], workers=2, dt=1e-3)
        table.drop(columns="seconds").to_json(sys.argv[2], double_precision=15)
"""


@pytest.mark.slow
def test_a_sweep_that_was_killed_gives_the_same_table(tmp_path):
    script, file = tmp_path / "script.py", tmp_path / "sweep.jsonl"
    script.write_text(textwrap.dedent(SCRIPT))
    whole, again = tmp_path / "whole.json", tmp_path / "again.json"
    subprocess.run([sys.executable, script, tmp_path / "other.jsonl", whole], check=True)
    process = subprocess.Popen([sys.executable, script, file, again], start_new_session=True)
    while process.poll() is None:
        if file.exists() and file.read_bytes().count(b"\n") > 8:
            os.killpg(process.pid, signal.SIGKILL)
        time.sleep(0.01)
    process.wait()
    done = file.read_bytes().count(b"\n") - 1
    assert 8 <= done < 40
    subprocess.run([sys.executable, script, file, again], check=True)
    assert again.read_text() == whole.read_text()
    assert file.read_bytes().count(b"\n") == 41


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"points": []}, "the sweep has no points"),
        ({"points": {"length": 1.0}}, "must be a list of dictionaries"),
        ({"points": [{"length": 1.0}, {"width": 1.0}]}, "point 1 of the sweep has other param"),
        ({"points": [{"length": (1.0, 2.0)}]}, "length of point 0 must be a number or a string"),
        ({"points": [{"tip": 1.0}]}, "'tip' is the name of a parameter and of another column"),
        ({"quantities": {}}, "quantities must be a dictionary of functions"),
        ({"quantities": {"tip": 3}}, "quantity 'tip' must be a function"),
        ({"build": 3}, "build must be a function"),
        ({"t_end": -1.0}, "t_end must be positive"),
        ({"workers": 0}, "workers must be"),
        ({"dtt": 1.0}, "did you mean 'dt'"),
        ({"file": 3}, "the file of a sweep must be the name of a file"),
        ({"file": "."}, "cannot be read"),
    ],
)
def test_bad_arguments_are_named(changes, words):
    given = {"build": pendulum, "points": ancf.grid(length=[1.0]), "quantities": QUANTITIES}
    given |= {"t_end": 0.1, "workers": 1, "dt": 1e-3} | changes
    with pytest.raises(ancf.InputError, match=words):
        ancf.sweep(**given)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: ancf.grid(), "a grid needs parameters"),
        (lambda: ancf.grid(length=1.0), "the values of length must be a list"),
        (lambda: ancf.grid(length=[]), "length has no values"),
        (lambda: ancf.latin_hypercube(3), "a sample needs parameters"),
        (lambda: ancf.latin_hypercube(3, length=1.0), "the range of length must be two finite"),
        (lambda: ancf.latin_hypercube(3, length=("a", 2.0)), "the range of length must be two"),
        (
            lambda: ancf.latin_hypercube(3, length=np.ma.array([1.0, 2.0], mask=[0, 1])),
            "the range of length must be two numbers",
        ),
        (lambda: ancf.latin_hypercube(3, length=(2.0, 1.0)), "in ascending order"),
        (lambda: ancf.latin_hypercube(3, "a", length=(1.0, 2.0)), "seed must be"),
        (lambda: ancf.latin_hypercube(10**20, length=(1.0, 2.0)), "a smaller n"),
    ],
)
def test_impossible_points_are_refused(call, words):
    with pytest.raises(ancf.InputError, match=words):
        call()


def test_a_cluster_that_is_not_there_is_named(monkeypatch):
    pytest.importorskip("dask.distributed")
    monkeypatch.setattr(workers, "CONNECTION_TIMEOUT", 0.5)
    points = ancf.grid(length=[1.0, 2.0])
    with pytest.raises(ancf.InputError, match="no cluster answers at"):
        ancf.sweep(pendulum, points, QUANTITIES, 0.1, cluster="tcp://127.0.0.1:9", dt=1e-3)


def test_functions_of_a_script_need_not_be_sent():
    """Forked processes have what the one before them had, closures and open handles too."""
    if not can_fork():
        pytest.skip("processes are not forked here")
    factor = 2.0
    quantities = {"twice": lambda run, rod: factor * tip(run, rod)}
    points = ancf.grid(length=LENGTHS)
    table = ancf.sweep(lambda length: pendulum(length), points, quantities, 0.1, workers=2, dt=1e-3)
    once = ancf.sweep(pendulum, points, QUANTITIES, 0.1, workers=1, dt=1e-3)
    np.testing.assert_array_equal(table["twice"], 2.0 * once["tip"])


def test_an_interrupted_sweep_leaves_no_process():
    if not can_fork():
        pytest.skip("processes are not forked here")
    points = ancf.grid(length=[1.0 + 0.01 * k for k in range(40)])
    rows = run_forked(Task(pendulum, QUANTITIES, 0.1, {"dt": 1e-3}), points, 2, 0.01)
    next(rows)
    assert len(multiprocessing.active_children()) == 2
    rows.close()
    assert multiprocessing.active_children() == []


ORPHANS = """
    import os
    import sys
    import time
    import ancfsparse as ancf

    def build(number):
        open(os.path.join(sys.argv[1], str(os.getpid())), "w").close()
        time.sleep(0.05)
        raise ValueError("no scene")

    points = ancf.grid(number=range(1000))
    ancf.sweep(build, points, {"none": lambda run: 0.0}, 1.0, workers=2, dt=1e-3)
"""


def lasts(pid):
    """Whether a process is there and has not ended."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_workers_end_when_the_process_that_sweeps_is_killed(tmp_path):
    if not can_fork():
        pytest.skip("processes are not forked here")
    script, notes = tmp_path / "script.py", tmp_path / "notes"
    script.write_text(textwrap.dedent(ORPHANS))
    notes.mkdir()
    process = subprocess.Popen([sys.executable, script, notes])
    while len(list(notes.iterdir())) < 3 and process.poll() is None:
        time.sleep(0.02)
    process.kill()
    process.wait()
    workers = {int(path.name) for path in notes.iterdir()} - {process.pid}
    assert len(workers) == 2
    deadline = time.monotonic() + 300.0  # they end within a second, but other work can slow them
    while any(map(lasts, workers)) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not any(map(lasts, workers))
