"""What to try after a run that could not be solved or gained energy, for the scene at hand."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ancfsparse.integrators import Implicit
from ancfsparse.scene import Scene

# Amplitude that a step leaves of vibrations which it cannot follow, in what may be advised; less
# damping than this much is hardly felt.
SUGGESTED_DAMPINGS, APART = (0.8, 0.5), 0.05
# Share of the extent of a scene that is a modest accuracy.
SUGGESTED_ACCURACY = 1e-3


def hint_for_fixed_steps(scene: Scene, integrator: Implicit, max_halvings: int) -> str:
    """Advise what to try instead of a run with fixed steps.

    Parameters
    ----------
    scene : Scene
        Its extent is the measure of an accuracy.
    integrator : Implicit
        What failed: advice is another one, or more damping.
    max_halvings : int
        How often a step could be halved.
    """
    tries = _more_damping(integrator)
    if not integrator.keeps_energy:
        tries.append("EnergyMomentum()")
    tries.append("a smaller dt")
    if not max_halvings:
        tries.append("max_halvings=5 to cross such steps in shorter ones")
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
    """Return generalised-alpha methods that damp more than an integrator does."""
    excess = integrator.gamma - 0.5
    left = (1.0 - excess) / (1.0 + excess)  # of Newmark's family, HHT and generalised-alpha
    steps = " for long steps" if left > SUGGESTED_DAMPINGS[0] + APART else ""
    strong = [rho for rho in SUGGESTED_DAMPINGS if rho + APART < left]
    names = [f"integrator=GeneralizedAlpha({rho:g})" for rho in strong[:1]]
    names += [f"or {rho:g}{steps}" for _, rho in pairwise(strong)]
    return [f"{', '.join(names)}, which damps what steps cannot follow"] if names else []


def _join_hints(tries: list[str]) -> str:
    *others, last = tries
    return f"Try {', '.join(others)}, or {last}." if others else f"Try {last}."
