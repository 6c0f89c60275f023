"""Check solver, tolerance and energy bound of a run before its set-up."""

from __future__ import annotations

import math

from ancfsparse.checks import check_finite, check_positive
from ancfsparse.errors import InputError, Parameter
from ancfsparse.messages import format_value
from ancfsparse.nonlinear.methods import BY_NAME, UPDATES, NonlinearMethod

# Solvers by name, as on the command line.
SOLVERS = {
    "auto": "'auto'",
    **{
        name: f"QuasiNewton({name!r})" if name in UPDATES else f"{make.__name__}()"
        for name, make in BY_NAME.items()
    },
}


def check_solver(solver: object) -> None:
    """Check that a solver is a method or ``"auto"``."""
    if isinstance(solver, NonlinearMethod):
        return
    name = solver if isinstance(solver, str) else ""
    if name == "auto":
        return
    import difflib  # for this message alone

    near = difflib.get_close_matches(name.lower(), SOLVERS, 1, 0.5)
    raise InputError(
        "solver must be 'auto', Newton(), ModifiedNewton() or QuasiNewton(...), got "
        f"{format_value(solver)}" + (f": did you mean {SOLVERS[near[0]]}?" if near else "")
    )


def check_tolerance(tolerance: object) -> str | float:
    """Return a tolerance after checking that it is a name or a positive number."""
    if not isinstance(tolerance, str):
        return check_positive("tolerance", tolerance, "m/s2")
    if tolerance not in ("default", "paper"):
        raise InputError(
            "{tolerance} must be 'default', 'paper' or a number in m/s2, got {given}",
            tolerance=Parameter("tolerance"),
            given=format_value(tolerance),
        )
    return tolerance


def check_max_energy_gain(ratio: object) -> float:
    """Return the largest relative energy increase, possibly infinite, after checking it."""
    if isinstance(ratio, float) and ratio == math.inf:
        return math.inf
    number = check_finite("max_energy_gain", ratio)
    if number < 0.0:
        raise InputError(
            f"max_energy_gain must not be negative, got {number:g}: 0.01 is one percent"
        )
    return number
