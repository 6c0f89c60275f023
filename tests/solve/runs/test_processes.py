"""Results and errors that go to other processes."""

import copy
import multiprocessing
import os
import pickle
import subprocess
import sys

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError, LoadError, StepError
from tests.beams import build_beam
from tests.pickling import leave_out_cloudpickle

SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)


def swing(output=None, force=None, velocity=None):
    scene, rod = build_beam("thin", (0, 0), (2, 0), 3, SECTION, MATERIAL, velocity=velocity)
    scene.rod(rod.start, (0.0, 1.0))
    if force is not None:
        scene.point_force(rod.end, force)
    return rod, ancf.simulate(scene, 0.01, 1e-3, output=output)


def same(rod, run, twin, again):
    for what in ("position", "velocity"):
        np.testing.assert_array_equal(getattr(run, what)(rod.end), getattr(again, what)(twin.end))
    np.testing.assert_array_equal(run.reaction(rod.start), again.reaction(twin.start))
    np.testing.assert_array_equal(run.energy.total, again.energy.total)


def broken(_):
    swing(force=lambda t: (0.0, 1e200 if t > 0.0045 else 0.0))


@pytest.mark.parametrize("to_file", [False, True])
def test_a_trajectory_comes_back_from_another_process(tmp_path, to_file):
    path = tmp_path / "run.h5" if to_file else None
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        twin, again = pool.apply(swing, [path])
        with pytest.raises(StepError, match=r"^step 5 \(t = 0.005 s") as failed:
            pool.map(broken, [0])
    same(*swing(), twin, again)
    assert len(failed.value.trajectory.t) == 5
    beam = again.system.scene.beams[0]
    np.testing.assert_array_equal(again.position(beam.end), again.position(twin.end))


def test_functions_that_cannot_be_sent_are_missed_only_where_they_are_needed(monkeypatch):
    leave_out_cloudpickle(monkeypatch)
    spin = swing(velocity=lambda x: x @ [[0, 1], [-1, 0]], force=lambda t: (t, 0.0))
    twin, again = pickle.loads(pickle.dumps(spin))
    np.testing.assert_array_equal(spin[1].velocity(spin[0].end), again.velocity(twin.end))
    with pytest.raises(LoadError, match=r"lambda> of this scene was not sent along from"):
        _ = again.energy
    with pytest.raises(InputError, match=r"lambda> of this scene was not sent along from"):
        ancf.simulate(again.system.scene, 0.01, 1e-3)


def test_copies_keep_their_functions():
    rod, run = swing(velocity=lambda x: x @ [[0, 1], [-1, 0]], force=lambda t: (t, 0.0))
    for copied in (copy.copy, copy.deepcopy):
        load = copied(run.system.scene.loads[0])
        assert load.at(2.0)[0] == 2.0
    twin, scene = copy.deepcopy((rod, run.system.scene))
    same(rod, run, twin, ancf.simulate(scene, 0.01, 1e-3))


def test_a_uniform_velocity_can_be_sent_and_results_copied():
    scene = ancf.Scene()
    scene.add_beam("thin", (0, 0), (2, 0), 3, SECTION, MATERIAL, velocity=(1.0, 0.0))
    run = ancf.simulate(copy.deepcopy(scene), 0.01, 1e-3)
    twin = copy.deepcopy(run)
    np.testing.assert_array_equal(run.q, twin.q)
    ancf.simulate(pickle.loads(pickle.dumps(twin)).system.scene, 0.01, 1e-3)


def test_shapes_at_rest_and_meshes_can_be_sent():
    scene = ancf.Scene()
    net = scene.add_mesh([(0, 0), (1, 0), (2, 0)], [(0, 1), (1, 2)], "l2t2", SECTION, MATERIAL)
    scene.clamp(net.node(0), "fixed")
    rest = ancf.solve_static(scene, load_steps=4)
    twin, again = pickle.loads(pickle.dumps((net, rest)))
    np.testing.assert_array_equal(rest.position(net.node(2)), again.position(twin.node(2)))
    assert rest.elastic_energy == again.elastic_energy


FORKED = """
import multiprocessing
import ancfsparse as ancf

def job():
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (1, 0), 6000, ancf.Circle(0.01), ancf.Material(1e8, 1e3))
    scene.pin(rod.start)
    return ancf.simulate(scene, 5e-3, 1e-3, threads=2).stats.threads

def child():
    raise SystemExit(10 + job())

assert job() == 2
process = multiprocessing.get_context("fork").Process(target=child)
process.start()
process.join(60.0)
process.kill()
process.join()
print(process.exitcode)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="nothing forks here")
def test_a_fork_of_a_process_with_threads_runs_on_one():
    command = [sys.executable, "-W", "ignore", "-c", FORKED]
    output = subprocess.run(command, capture_output=True, text=True, timeout=600, check=True).stdout
    assert output.split() == ["11"]


SENT = """
import pickle, sys
import numpy as np
import cloudpickle
import ancfsparse as ancf

def spun():
    scene = ancf.Scene()
    section, material = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)
    spin = lambda x: x @ [[0, 1], [-1, 0]]
    rod = scene.add_beam("thin", (1, 0), (3, 0), 3, section, material, velocity=spin)
    scene.rod(rod.start, (0.0, 0.0), length=lambda t: 1.0 + t**3)
    scene.point_force(rod.end, lambda t: (t, 0.0))
    scene.spring(rod.end, (4.0, 0.0), stiffness=lambda u: 5.0 * u)
    scene.force(rod.end, lambda q, v, t: -scene.beams[0].length * v)
    return scene

if sys.argv[1] == "send":
    scene = spun()
    with open("scene", "wb") as file:
        file.write(PICKLER.dumps(scene))
    np.save("q.npy", ancf.simulate(scene, 0.01, 1e-3).q)
"""
RECEIVED = """
import pickle
import numpy as np
import ancfsparse as ancf
with open("scene", "rb") as file:
    scene = pickle.load(file)
np.testing.assert_array_equal(np.load("q.npy"), ancf.simulate(scene, 0.01, 1e-3).q)
assert scene.refined(1) == scene
"""


@pytest.mark.parametrize("pickler", ["cloudpickle", "pickle"])
def test_functions_go_along_by_their_code_where_cloudpickle_is_loaded(tmp_path, pickler):
    pytest.importorskip("cloudpickle")
    for code, *words in ((SENT.replace("PICKLER", pickler), "send"), (RECEIVED,)):
        command = [sys.executable, "-c", code, *words]
        subprocess.run(command, cwd=tmp_path, check=True, timeout=600)
