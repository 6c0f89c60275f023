"""Suggest alternatives after a run that failed or gained energy."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from ancfsparse.integrators import Implicit
from ancfsparse.scene import Scene

SUGGESTED_DAMPINGS = (0.8, 0.5)  # spectral radius at infinite frequency
MIN_DAMPING_DIFFERENCE = 0.05  # of spectral radii: less makes hardly any difference
SUGGESTED_ACCURACY = 1e-3  # over the extent of the scene


def hint_for_fixed_steps(
    scene: Scene,
    integrator: Implicit,
    max_halvings: int,
    dt: float = 0.0,
    resolving_step: tuple[float, str] = (math.inf, ""),
) -> str:
    """Suggest alternatives to a run with fixed steps.

    Parameters
    ----------
    scene : Scene
        Its extent is the scale of an accuracy.
    integrator : Implicit
        The failed one, which is replaced or gets more damping.
    max_halvings : int
        Allowed halvings of a step.
    dt : float, optional
        Step [s].
    resolving_step : tuple, optional
        Longest step that resolves the impacts of a contact [s], and its name.
    """
    tries = _more_damping(integrator)
    if not integrator.keeps_energy:
        tries.append("EnergyMomentum()")
    longest, what = resolving_step
    tries.append(
        f"a dt of at most {longest:.1e} s, which resolves the impacts of {what}"
        if longest < dt
        else "a smaller dt"
    )
    if not max_halvings:
        tries.append("max_halvings=5 to subdivide such steps")
    low = np.min([body.corners.min(axis=0) for body in scene.bodies], axis=0)
    high = np.max([body.corners.max(axis=0) for body in scene.bodies], axis=0)
    tries.append(f"accuracy={SUGGESTED_ACCURACY * float(np.max(high - low)):.0e} [m] instead of dt")
    return _join_hints(tries)


def hint_for_accuracy(scene: Scene, integrator: Implicit) -> str:
    """Suggest alternatives to a run to an accuracy; parameters as of `hint_for_fixed_steps`."""
    tries = ["a smaller accuracy", *_more_damping(integrator)]
    if any(callable(load.value) for load in scene.loads):
        tries.append("smooth loads instead of those that jump")
    return _join_hints(tries)


def _more_damping(integrator: Implicit) -> list[str]:
    """Return generalised-alpha methods with more damping than an integrator."""
    excess = integrator.gamma - 0.5
    radius = (1.0 - excess) / (1.0 + excess)  # of Newmark's family, HHT and generalised-alpha
    steps = " for long steps" if radius > SUGGESTED_DAMPINGS[0] + MIN_DAMPING_DIFFERENCE else ""
    strong = [rho for rho in SUGGESTED_DAMPINGS if rho + MIN_DAMPING_DIFFERENCE < radius]
    names = [f"integrator=GeneralizedAlpha({rho:g})" for rho in strong[:1]]
    names += [f"or {rho:g}{steps}" for _, rho in pairwise(strong)]
    return [f"{', '.join(names)}, which damps unresolved vibrations"] if names else []


def _join_hints(tries: list[str]) -> str:
    *others, last = tries
    return f"Try {', '.join(others)}, or {last}." if others else f"Try {last}."
