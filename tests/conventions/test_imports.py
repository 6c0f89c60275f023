"""A run loads what it needs and nothing else: imports take much of the time of a short one."""

import json
import subprocess
import sys

import pytest

HEAVY = {"h5py", "hashlib", "matplotlib", "numpy.ma", "scipy", "sksparse", "sympy", "tqdm", "typer"}
# Not counted, since some versions of NumPy or an editable install load them: parts of the
# standard library.
STANDARD = "dataclasses, importlib.util, pathlib, threading"
# Our own modules that only other kinds of runs need.
OTHERS = {
    "ancfsparse.solve.error_control.select_solution",
    "ancfsparse.results.plotting.plot",
    "ancfsparse.seeds.ordering.cholmod",
}

SCENE = """
import ancfsparse as ancf
scene = ancf.Scene(gravity=(0, -9.81))
beam = scene.add_beam("thin", (0, 0), (2, 0), 10, ancf.Circle(0.005), ancf.Material(1e8, 4000))
scene.pin(beam.start)
"""
RUN = "ancf.simulate(scene, 0.01, 5e-4)"


def loaded_by(code):
    code += "\nimport json, sys; print(json.dumps(sorted(sys.modules)))"
    run = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return set(json.loads(run.stdout.splitlines()[-1]))


@pytest.mark.parametrize("code", ["import ancfsparse", SCENE, SCENE + RUN])
def test_a_short_run_needs_numpy_alone(code):
    before, after = loaded_by(f"import numpy, {STANDARD}"), loaded_by(code)
    assert not after & (HEAVY | OTHERS)
    # 640 besides those of NumPy when everything was loaded at once; 199 now.
    assert len(after - before) < 212


def test_what_is_left_out_is_loaded_where_it_is_needed(tmp_path):
    file = tmp_path / "run.h5"
    after = loaded_by(SCENE + f"ancf.simulate(scene, 0.01, 5e-4, output={str(file)!r})")
    assert (after & HEAVY) - {"hashlib"} == {"h5py"}
    assert "scipy" in loaded_by(SCENE + "scene.rod(beam.end, (2, 1))\n" + RUN)
    assert "tqdm" in loaded_by(SCENE + "ancf.simulate(scene, 0.01, 5e-4, progress=True)")
