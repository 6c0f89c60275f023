"""Other codes find the same motion, and what is not installed is named in a sentence."""

import sys

import numpy as np
import pytest

from ancfsparse.errors import InputError
from ancfsparse.system import System
from benchmarks.accuracy.models import MODELS, distance
from benchmarks.accuracy.other_code_tasks import (
    EXUDYN,
    EXUDYN_MODEL,
    SUNDIALS,
    exudyn_tasks,
    missing,
    other_code_tasks,
)
from benchmarks.accuracy.references import converged, converged_in_time
from benchmarks.accuracy.timed_runs import FailedError
from benchmarks.common.first_order import FirstOrder, OutOfTimeError
from benchmarks.other_codes import elastica as elastica_code, sundials as sundials_code
from benchmarks.other_codes.exudyn import ExudynError, Setting
from benchmarks.other_codes.exudyn_pendulum import run_exudyn
from benchmarks.other_codes.sundials import integrate_sundials

T_END = 0.2
COMPILED = "benchmarks.other_codes._sundials"


@pytest.fixture(scope="module")
def reference():
    return converged_in_time(EXUDYN_MODEL, 4, T_END, 5e-5).tip


def test_what_is_missing_is_said(monkeypatch):
    for name in ("exudyn", "benchmarks.other_codes._sundials", "elastica"):
        monkeypatch.setitem(sys.modules, name, None)
    reasons = missing()
    assert len(reasons) == 3
    assert all("ancfsparse[peers]" in each or "make peers" in each for each in reasons)
    assert {t.program for t in other_code_tasks(EXUDYN_MODEL, 4, T_END, 1.0)} == {"SciPy"}
    with pytest.raises(InputError, match="SUNDIALS"):
        sundials_code.load()


def test_every_method_of_exudyn_finds_the_same_motion(reference):
    pytest.importorskip("exudyn")
    for (method, solver), (setting, _) in EXUDYN.items():
        (task,) = exudyn_tasks(4, T_END, {(method, solver): (setting, (1e-4,))})
        sample = task.run()
        assert distance(sample.tip, reference) < 1e-5, method
        assert sample.counts["steps"] == 2000


def test_exudyn_that_fails_is_a_reason_and_prints_nothing(capfd):
    pytest.importorskip("exudyn")
    problem = MODELS[EXUDYN_MODEL].problem(10)
    with pytest.raises(ExudynError, match=r"gave up at t = 1\.\d s"):
        run_exudyn(problem, Setting("", 0.02), 2.0, 2e-2, 0.5)
    assert capfd.readouterr().out == ""
    (task,) = exudyn_tasks(10, 2.0, {("RK44", ""): (Setting("", explicit="RK44"), (5e-4,))})
    with pytest.raises(FailedError, match="unstable"):
        task.run()


@pytest.mark.parametrize("method", SUNDIALS)
def test_sundials_finds_the_same_motion(method, reference):
    pytest.importorskip(COMPILED)
    problem = MODELS[EXUDYN_MODEL].problem(4)
    system = System(problem.scene)
    t = np.linspace(0.0, T_END, 5)
    run = integrate_sundials(FirstOrder(system), method, t, 1e-9, 1e-11)
    places, weights = system.point(problem.rod.end)
    assert distance((run.q[:, places] @ weights)[1:], reference) < 1e-7
    assert run.evaluations > 100


def test_cap_stops_sundials():
    pytest.importorskip(COMPILED)
    equations = FirstOrder(System(MODELS[EXUDYN_MODEL].problem(10).scene))
    with pytest.raises(OutOfTimeError, match=r"longer than 0\.01 s"):
        integrate_sundials(equations, "CVODE BDF", np.linspace(0.0, 2.0, 3), 1e-6, 1e-8, cap=0.01)


@pytest.mark.slow
def test_elastica_converges_to_the_same_motion():
    pytest.importorskip("elastica")
    problem = MODELS[EXUDYN_MODEL].problem(4)
    exact = converged(EXUDYN_MODEL, 40, 0.4, 1e-3).tip
    coarse, fine = (
        distance(elastica_code.run_elastica(problem, n, 0.4, 5e-5, 4)[1], exact) for n in (16, 64)
    )
    assert fine < 1e-3
    assert coarse / fine > 8.0  # near second order in the mesh
