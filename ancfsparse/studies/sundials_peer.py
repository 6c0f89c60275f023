"""SUNDIALS' CVODE on our right-hand side, through scikit-sundae."""

from __future__ import annotations

import time
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.studies.ode import FirstOrder, OdeRun, OutOfTimeError

Vector = NDArray[np.float64]

# Internal steps allowed between two instants.
MOST_STEPS = 10_000_000


def load() -> Any:
    """Return the module.

    Raises
    ------
    InputError
        If it is not installed.
    """
    try:
        return import_module("sksundae.cvode")
    except ImportError as error:
        raise InputError(
            f"SUNDIALS cannot be reached ({error}): install scikit-sundae, "
            "pip install 'ancfsparse[peers]'"
        ) from None


def integrate_cvode(
    equations: FirstOrder,
    method: str,
    t: Vector,
    rtol: float,
    atol: float,
    cap: float = np.inf,
) -> OdeRun:
    """Run CVODE against the clock, with the Jacobian from the generated tangent.

    Parameters
    ----------
    equations : FirstOrder
        The right-hand side and the start.
    method : {"Adams", "BDF"}
        Family of multistep formulas.
    t : (k,) float
        Times to report [s], from the first to the last.
    rtol, atol : float
        Relative and absolute tolerance.
    cap : float, optional
        Wall time it may take [s].

    Returns
    -------
    OdeRun
        Coordinates and cost.

    Raises
    ------
    OutOfTimeError
        When the cap is reached.
    RuntimeError
        When CVODE gives up.
    """
    cvode = load()
    evaluations = 0
    begin = time.perf_counter()

    def rate(now: float, y: Vector, yp: Vector) -> None:
        nonlocal evaluations
        evaluations += 1
        if time.perf_counter() - begin > cap:
            raise OutOfTimeError(f"CVODE took longer than {cap:g} s")
        yp[:] = equations(now, y)

    def jacobian(now: float, y: Vector, yp: Vector, out: Vector) -> None:
        out[:, :] = equations.jacobian(now, y)

    solver = cvode.CVODE(
        rate, method=method, rtol=rtol, atol=atol, max_num_steps=MOST_STEPS, jacfn=jacobian
    )
    solution = solver.solve(t, equations.y0)
    seconds = time.perf_counter() - begin
    if not solution.success:
        raise RuntimeError(f"CVODE gave up: {solution.message}")
    counts = {"jacobians": int(solution.njev)}
    return OdeRun(equations.coordinates(solution.y.T), seconds, evaluations, counts)
