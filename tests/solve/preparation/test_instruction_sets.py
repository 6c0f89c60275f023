"""Every build of the compiled loops finds the same motion."""

import os
import subprocess
import sys

import numpy as np
import pytest

from ancfsparse.dispatch import ENVIRONMENT_VARIABLE
from ancfsparse.instruction_sets import REQUIRED_FLAGS
from tests.instruction_sets import require

PROGRAM = """
import ancfsparse as ancf
from ancfsparse.problems import pendulum
for solver in ancf.QuasiNewton("bfgs"), ancf.QuasiNewton("broyden", 10), ancf.Newton():
    for options in {}, {"as_constraint": True}:
        scene, rod = pendulum("thin", **options)
        run = ancf.simulate(scene, 0.5, 5e-4, solver=solver, tolerance=1e-8, save_every=100)
        print(*run.position(rod.end).ravel())
"""


def motion(instruction_set):
    found = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env={**os.environ, ENVIRONMENT_VARIABLE: instruction_set},
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    return np.array([line.split() for line in found.stdout.splitlines()], dtype=float)


@pytest.fixture(scope="module")
def baseline():
    require("x86_64")
    return motion("x86_64")


@pytest.mark.parametrize("name", [name for name in REQUIRED_FLAGS if name != "x86_64"])
def test_wider_instruction_sets_agree_with_the_baseline(name, baseline):
    require(name)
    np.testing.assert_allclose(motion(name), baseline, rtol=0, atol=1e-10)
