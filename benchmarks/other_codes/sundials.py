"""SUNDIALS' CVODE and ARKODE with the compiled forces and factors, without Python in between."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.seeds import SparseSeed
from benchmarks.common.first_order import FirstOrder, OdeRun, OutOfTimeError


def load() -> Any:
    """Return the compiled module.

    Raises
    ------
    InputError
        If it is not built.
    """
    try:
        return import_module("benchmarks.other_codes._sundials")
    except ImportError as error:
        raise InputError(
            f"the module of SUNDIALS is not built ({error}): `make peers` installs its headers and "
            "builds it"
        ) from None


def integrate_sundials(
    equations: FirstOrder, method: str, t: Vector, rtol: float, atol: float, cap: float = np.inf
) -> OdeRun:
    """Run one of SUNDIALS' integrators, a method of `other_code_tasks.SUNDIALS`, against the clock.

    Multistep formulas, Adams with fixed-point iteration and BDF with sparse factors of our
    tangents; or embedded Runge-Kutta formulas of Dormand and Prince, Verner, and Fehlberg.
    Arguments and errors are those of `first_order.integrate`.
    """
    system = equations.system
    pattern = (system.pattern.indptr.astype(np.int32), system.pattern.indices.astype(np.int32))
    iteration = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
    y, seconds, evaluations, jacobians, steps, reason = load().integrate(
        system.assembly, equations.mass, iteration, pattern, equations.mass_values, system.q0,
        equations.y0, system.dead_load, np.append(equations.amplitudes, 0.0), t, method, rtol,
        atol, cap,
    )  # fmt: skip
    if reason == "late":
        raise OutOfTimeError(f"{method} took longer than {cap:g} s")
    if reason:
        raise RuntimeError(f"{method} failed: {reason}")
    counts = {"steps": steps, "jacobians": jacobians}
    return OdeRun(equations.coordinates(y.T), seconds, evaluations, counts)
