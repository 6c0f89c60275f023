"""Runs of other codes against the clock: Exudyn, SciPy and SUNDIALS, each with its best settings.

SciPy and SUNDIALS have the compiled forces and tangents of this package, so that integrators are
compared.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ancfsparse.errors import InputError
from ancfsparse.results.data.interpolation import interpolate
from ancfsparse.system import System
from benchmarks.accuracy.models import MODELS, OUTPUTS, meets_outputs, output_times
from benchmarks.accuracy.timed_runs import FailedError, Sample, Task
from benchmarks.common.first_order import FirstOrder, OdeRun, OutOfTimeError, integrate
from benchmarks.other_codes import (
    elastica as elastica_code,
    exudyn as exudyn_code,
    sundials as sundials_code,
)
from benchmarks.other_codes.exudyn import ExudynError, Setting
from benchmarks.other_codes.exudyn_pendulum import run_exudyn
from benchmarks.other_codes.sundials import integrate_sundials

EXUDYN_MODEL = "Thin, Biot"
"""The model with Exudyn's discretisation."""

IMPLICIT_DTS = (2e-2, 1e-2, 4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4)

EXUDYN: dict[tuple[str, str], tuple[Setting, tuple[float, ...]]] = {
    ("trapezoidal", "modified 0.02"): (Setting("", 0.02), IMPLICIT_DTS),
    ("trapezoidal", "modified 0.5"): (Setting("", 0.5), IMPLICIT_DTS),
    ("trapezoidal", "full Newton"): (Setting(""), IMPLICIT_DTS),
    ("generalised-alpha 0.9", "modified 0.02"): (
        Setting("", 0.02, spectral_radius=0.9),
        IMPLICIT_DTS,
    ),
    ("VelocityVerlet", ""): (
        Setting("", explicit="VelocityVerlet"),
        (4e-4, 2.5e-4, 1.25e-4, 6.25e-5, 3.125e-5),
    ),
    ("RK44", ""): (Setting("", explicit="RK44"), (5e-4, 0.5 / 1400, 2.5e-4, 1.25e-4, 6.25e-5)),
    ("RK67", ""): (Setting("", explicit="RK67"), (2.5e-4, 2e-4, 1.25e-4, 6.25e-5)),
}
"""Methods and solvers of Exudyn that were fastest of all that were tried, with their steps [s]."""

ATOL_PER_RTOL = 1e-2  # absolute over relative tolerances [m]

SCIPY = {"DOP853": (1e-2, 1e-3, 1e-5, 1e-7, 1e-9), "Radau": (1e-1, 1e-2, 1e-3, 1e-5)}
"""Its fastest explicit and implicit method, with relative tolerances."""

SUNDIALS = {
    method: (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
    for method in ("CVODE Adams", "CVODE BDF", "ARKODE 5(4)", "ARKODE 8(7)")
}
"""CVODE's two families and two of ARKODE's explicit formulas, with relative tolerances."""


def missing() -> list[str]:
    """State the codes that are not installed, one sentence each."""
    sentences = []
    for load in (exudyn_code.load, sundials_code.load, elastica_code.load):
        try:
            load()
        except InputError as error:
            sentences.append(str(error))
    return sentences


def installed(load: Callable[[], Any]) -> bool:
    """Return True if the module of another code can be imported."""
    try:
        load()
    except InputError:
        return False
    return True


def other_code_tasks(model: str, elements: int, t_end: float, cap: float) -> list[Task]:
    """Return the tasks of the installed codes; Exudyn only has those of its own model.

    SciPy and SUNDIALS are stopped after `cap` seconds a run.
    """
    tasks = []
    if model == EXUDYN_MODEL and installed(exudyn_code.load):
        tasks += exudyn_tasks(elements, t_end)
    tasks += [
        _on_our_forces("SciPy", method, model, elements, t_end, rtol, cap)
        for method, tolerances in SCIPY.items()
        for rtol in tolerances
    ]
    if installed(sundials_code.load):
        tasks += [
            _on_our_forces("SUNDIALS", method, model, elements, t_end, rtol, cap)
            for method, tolerances in SUNDIALS.items()
            for rtol in tolerances
        ]
    return tasks


def exudyn_tasks(elements: int, t_end: float, chosen: dict[Any, Any] | None = None) -> list[Task]:
    """Return Exudyn's tasks: every method, solver and step of `EXUDYN`, or of a part of it."""
    return [
        _exudyn_task(method, solver, setting, elements, t_end, dt)
        for (method, solver), (setting, dts) in (EXUDYN if chosen is None else chosen).items()
        for dt in dts
        if meets_outputs(dt, t_end)
    ]


def _exudyn_task(
    method: str, solver: str, setting: Setting, elements: int, t_end: float, dt: float
) -> Task:
    problem = MODELS[EXUDYN_MODEL].problem(elements)

    def run() -> Sample:
        try:
            done = run_exudyn(problem, setting, t_end, dt, t_end / OUTPUTS)
        except ExudynError as failure:
            raise FailedError(str(failure)) from failure
        if not np.isfinite(done.tip).all():
            raise FailedError("unstable, the tip is not finite")
        return Sample(done.seconds, done.tip, done.counts)

    return Task("Exudyn", method, solver, EXUDYN_MODEL, elements, "dt", dt, run)


def _on_our_forces(
    program: str, method: str, model: str, elements: int, t_end: float, rtol: float, cap: float
) -> Task:
    problem = MODELS[model].problem(elements)
    t = np.concatenate([[0.0], output_times(t_end)])

    def run() -> Sample:
        system = System(problem.scene)
        equations = FirstOrder(system)
        atol = ATOL_PER_RTOL * rtol
        try:
            if program == "SciPy":
                implicit = method == "Radau"
                done: OdeRun = integrate(
                    equations, method, t, rtol, atol, cap, with_jacobian=implicit
                )
            else:
                done = integrate_sundials(equations, method, t, rtol, atol, cap)
        except (OutOfTimeError, RuntimeError) as failure:
            raise FailedError(str(failure)) from failure
        tip = interpolate(system.point(problem.rod.end), done.q)[1:]
        return Sample(done.seconds, tip, {"residuals": done.evaluations, **done.counts})

    return Task(program, method, "", model, elements, "rtol", rtol, run)
