"""Check that options of a run are compatible with an accuracy."""

from __future__ import annotations

from string import Formatter

import numpy as np

from ancfsparse.checks import check_positive
from ancfsparse.errors import InputError, Parameter
from ancfsparse.integrators import Explicit, Implicit, Newmark
from ancfsparse.nonlinear import Method
from ancfsparse.solve.stepping.explicit_setup import (
    check_explicit_scene,
    check_no_equations_options,
)
from ancfsparse.solve.stepping.remedies import SUGGESTED_ACCURACY
from ancfsparse.solve.stepping.sampled_states import largest_coordinate
from ancfsparse.system import System

# Rounding of a position after many steps, over the size of the scene: n steps leave the root of n
# units, 1e-13 after 2e5 steps.
ROUNDING_RATIO = 1e-13


def check_accuracy(
    system: System,
    accuracy: float,
    tolerance: str | float,
    integrator: Implicit | Explicit | None,
    solver: Method | str,
    max_halvings: int = 0,
) -> None:
    """Check that options of a run are compatible with an accuracy.

    Raises
    ------
    InputError
        For an accuracy larger than the scene or below rounding; a tolerance or halvings; an inverse
        that is never renewed; an integrator of first order; the trapezoidal rule with multipliers,
        in which the effect of a step-size change never decays; an explicit one that cannot handle
        multipliers or damping of the scene.
    """
    check_positive("accuracy", accuracy, "m")
    if isinstance(integrator, Explicit):
        check_no_equations_options(integrator, solver, "default")
        check_explicit_scene(system, integrator)
    extent, size = _extent(system), largest_coordinate(system)
    constraints, motion = system.constraints.labels, system.prescribed.differences
    method = None if isinstance(solver, str) else solver
    refusals: tuple[tuple[object, str], ...] = (
        (
            accuracy > extent,
            "{meters} exceeds the size of the scene ({extent:.6g} m): use a smaller value, such as "
            "{less:.1g} m",
        ),
        (
            accuracy < ROUNDING_RATIO * size,
            "{meters} is below the rounding of double precision in a scene of {size:.3g} m, about "
            "{least:.2g} m: use a larger value",
        ),
        (
            max_halvings,
            "{accuracy} shortens steps as needed: leave out max_halvings={halvings}, or give {dt} "
            "and no {name}",
        ),
        (
            tolerance != "default",
            "{accuracy} sets the tolerance of the iteration: leave out tolerance={tolerance!r}, or "
            "give {dt} and no {name}",
        ),
        (
            integrator is not None and integrator.order == 1,
            "{integrator!r} is of first order and has no error estimate: use HHT(alpha), "
            "{implicit} or Newmark(0)",
        ),
        (
            motion,
            "{accuracy} needs the rates of prescribed motions, and {motion} has none: give rate "
            "and second_rate, or a smooth Ramp or Sine",
        ),
        (
            constraints and integrator == Newmark(0.0),
            "{accuracy} changes steps, and with the trapezoidal rule the effect on the forces of "
            "the {first} never decays: use {damped}",
        ),
        (
            method is not None and method.is_dense,
            "{accuracy} needs a factor that is renewed during the motion, and {solver!r} keeps its "
            "first: use solver='auto' or a number of pairs",
        ),
    )
    message = next((text for is_refused, text in refusals if is_refused), None)
    if message is None:
        return
    values = {
        "meters": Parameter("accuracy", f"{accuracy:.6g} m"),
        "accuracy": Parameter("accuracy", f"{accuracy:g}", "="),
        "implicit": Parameter("integrator", "GeneralizedAlpha(rho_inf)", separator=""),
        "damped": Parameter("integrator", "GeneralizedAlpha(0.9)", "="),
        "dt": Parameter("dt"),
        "name": Parameter("accuracy"),
        **{"extent": extent, "less": SUGGESTED_ACCURACY * extent},
        **{"size": size, "least": ROUNDING_RATIO * size},
        **{"integrator": integrator, "solver": solver, "tolerance": tolerance},
        **{"halvings": max_halvings, "motion": motion, "first": next(iter(constraints), None)},
    }
    used = {name for _, name, _, _ in Formatter().parse(message)}
    raise InputError(message, **{name: x for name, x in values.items() if name in used})


def _extent(system: System) -> float:
    """Return the largest side of the box around all nodes in the reference shape [m]."""
    corners = [body.corners for body in system.scene.bodies]
    low = np.min([points.min(axis=0) for points in corners], axis=0)
    high = np.max([points.max(axis=0) for points in corners], axis=0)
    return float(np.max(high - low))
