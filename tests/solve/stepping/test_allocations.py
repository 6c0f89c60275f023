"""The hot step takes nothing from the heap: counted, in a process whose allocator counts."""

import json
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent

# Each march advances in one call by some steps, and by three times as many.
CODE = '''
import ctypes, json, math
import numpy as np
import ancfsparse as ancf
from ancfsparse.problems import lattice
from ancfsparse.solve.stepping.explicit_setup import prepare_explicit
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.system import System

so_far = ctypes.CDLL(None).counted_so_far
so_far.restype = ctypes.c_long
FEW, DT = 20, 1e-3

def pendulum(damping=0.0):
    scene = ancf.Scene(gravity=(0.0, -9.81))
    material = ancf.Material(1e7, 4000.0, bending_damping=damping)
    beam = scene.add_beam("thin", (0, 0), (2, 0), 10, ancf.Rectangle(0.01, 0.01), material)
    scene.pin(beam.start)
    scene.point_force(beam.end, lambda t: (0.0, t))
    return scene, beam

def rod():
    scene, beam = pendulum()
    scene.rod(beam.end, (2.0, -1.0))
    return scene

def driven():
    scene = ancf.Scene(gravity=(0.0, -9.81))
    beam = scene.add_beam("thin", (0, 0), (2, 0), 10, ancf.Rectangle(0.01, 0.01),
                          ancf.Material(1e6, 4000.0))
    scene.drive(beam.start, ancf.Ramp((0.5, 0.3), 0.4, smooth=True))
    return scene

def called():
    scene, beam = pendulum()
    scene.force([beam.end], lambda x, v, t: -0.1 * v)
    return scene

def falling():
    """It touches the floor after 14 steps, where it slides, and a pulley that it turns."""
    scene = ancf.Scene(gravity=(0.0, -9.81))
    pulley = scene.add_body(mass=0.5, inertia=2e-3, position=(0.3, -0.1))
    scene.pin(pulley.origin)
    made = ancf.Circle(0.01), ancf.Material(1e8, 5e3)
    beam = scene.add_beam("thin", (0, 0.006), (1, 0.006), 20, *made, velocity=(0.5, 0))
    floor = ancf.HalfSpace((0, 0), (0, 1))
    scene.contact(beam, floor, stiffness=1e5, friction=0.3)
    scene.contact(beam, ancf.Drum((0.3, -0.1), 0.1), on=pulley, stiffness=1e5, friction=0.3)
    return scene

def implicit(scene, integrator, solver, kind="complete", tolerance="default"):
    system = System(scene)
    system.prescribed.resolve(DT, 0.0, 1.0)
    ready = prepare_implicit(system, DT, integrator, solver, tolerance, math.inf, kind=kind)
    return system, ready.time_loop, ready.iteration, np.ones(1)

def explicit(scene, integrator):
    system = System(scene)
    march, _, _ = prepare_explicit(system, 1e-4, 1000, integrator, math.inf)
    return system, march, None, integrator.stages

DEFAULT = ancf.GeneralizedAlpha(0.9)
CASES = {
    "newton": lambda: implicit(pendulum()[0], DEFAULT, ancf.Newton()),
    "modified-newton": lambda: implicit(pendulum(1e-3)[0], DEFAULT, ancf.ModifiedNewton()),
    "pairs": lambda: implicit(pendulum()[0], DEFAULT, ancf.QuasiNewton("bfgs", 5)),
    "dense": lambda: implicit(pendulum()[0], ancf.Newmark(), ancf.QuasiNewton("davidon"),
                              tolerance="paper"),
    "multipliers": lambda: implicit(rod(), DEFAULT, "auto"),
    "driven": lambda: implicit(driven(), ancf.HHT(0.1), "auto"),
    "energy-momentum": lambda: implicit(pendulum()[0], ancf.EnergyMomentum(), ancf.Newton()),
    "contact": lambda: implicit(falling(), DEFAULT, ancf.Newton()),
    "contact, energy-momentum": lambda: implicit(falling(), ancf.EnergyMomentum(), "auto"),
    "incomplete": lambda: implicit(lattice(4).scene, DEFAULT, "auto", kind="incomplete"),
    "python": lambda: implicit(called(), DEFAULT, "auto"),
    "explicit": lambda: explicit(driven(), ancf.RungeKuttaNystrom(4)),
    "explicit with multipliers": lambda: explicit(rod(), ancf.DormandPrince()),
}

def taken(case):
    """Return allocations in 20, again 20, and 60 steps, and factors that were made in them."""
    system, march, loop, stages = CASES[case]()
    n, m = system.n_all, system.n_multipliers
    buffer = [np.zeros((2, width)) for width in (n, n, n, m)]
    taken, factors = [], []
    for count in (FEW, FEW, 3 * FEW):
        times = DT * (march.steps + np.arange(count)[:, None] + stages)
        inputs = system.inputs(times.ravel())[0]
        before, made = so_far(), 0 if loop is None else loop.counts["factorizations"]
        steps, outcome = march.advance(loop, count, inputs, 10**9, 0, *buffer)
        taken.append(so_far() - before)
        factors.append(0 if loop is None else loop.counts["factorizations"] - made)
        assert (steps, outcome) == (count, 0)
    return taken, factors

before = so_far()
kept = [bytearray(9000) for _ in range(1000)]
print(json.dumps({case: taken(case) for case in CASES} | {"control": so_far() - before}))
'''

CASES = [
    *("newton", "modified-newton", "pairs", "dense", "multipliers", "driven", "energy-momentum"),
    *("contact", "contact, energy-momentum"),
    *("incomplete", "python", "explicit", "explicit with multipliers"),
]


@pytest.fixture(scope="module")
def counted(tmp_path_factory):
    """Return what each case takes, where a library that counts can be built and preloaded."""
    compiler = shutil.which("cc")
    if compiler is None or platform.libc_ver()[0] != "glibc" or "LD_PRELOAD" in os.environ:
        pytest.skip("needs a C compiler and glibc, and nothing else preloaded")
    library = tmp_path_factory.mktemp("counted") / "libcounted.so"
    build = [compiler, "-shared", "-fPIC", "-O1", str(HERE / "counted.c"), "-o", str(library)]
    subprocess.run(build, check=True)
    more = {"LD_PRELOAD": str(library), "PYTHONMALLOC": "malloc", "OMP_NUM_THREADS": "1"}
    run = subprocess.run(
        [sys.executable, "-c", CODE], check=True, capture_output=True, text=True,
        env=os.environ | more,
    )  # fmt: skip
    found = json.loads(run.stdout)
    assert found.pop("control") >= 1000  # it does count
    assert list(found) == CASES
    return found


@pytest.mark.parametrize("case", CASES)
def test_steps_allocate_nothing(counted, case):
    (_, few, many), factors = counted[case]
    # A call takes its results and views of its arguments, whatever the number of steps.
    if case == "python":
        assert many > few  # a function of the caller's does allocate
        return
    assert few == many < 60
    if case in ("newton", "energy-momentum"):
        assert factors[2] >= 60  # seeds are renewed in the same room
