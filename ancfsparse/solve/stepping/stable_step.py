"""The stable step of an explicit integrator."""

from __future__ import annotations

from ancfsparse.errors import InputError
from ancfsparse.integrators import Explicit
from ancfsparse.integrators.names import EXPLICIT_EXAMPLES
from ancfsparse.messages import format_value
from ancfsparse.nonlinear import Newton
from ancfsparse.scene import Scene, check_scene
from ancfsparse.solve.linearization.matrices import highest_initial_frequency, mass_seed
from ancfsparse.solve.preparation.memory_estimate import estimate_memory, within_memory
from ancfsparse.solve.stepping.explicit_setup import check_explicit_scene
from ancfsparse.system import System

# Arrays of values on the pattern: two whole matrices, each from its triangle, with their indices.
MATRICES = 10


def stable_step(scene: Scene, integrator: Explicit) -> float:
    """Return the longest stable step of an explicit integrator at the start of the motion [s].

    ``interval / omega``, with the fastest vibration omega of the scene and what the method can
    follow, 2 for central differences.  Beams that are stretched vibrate faster, so stay below it.

    Parameters
    ----------
    scene : Scene
        Without joints that need multipliers for `RungeKuttaNystrom`, and without damping but for
        `DormandPrince`.
    integrator : CentralDifference, RungeKuttaNystrom or DormandPrince
        The method.

    Raises
    ------
    InputError
        If the integrator is not explicit or does not take the scene, or the factor of its masses
        cannot fit in memory.
    """
    check_explicit(integrator)
    check_scene(scene)
    with within_memory(estimate_memory(scene, 1, 0, False, Newton(), matrices=MATRICES)):
        system = System(scene)
        check_explicit_scene(system, integrator)
        omega = highest_initial_frequency(system, mass_seed(system), integrator)
    return integrator.tableau.interval / omega


def check_explicit(integrator: object) -> None:
    """Refuse what is not an explicit integrator."""
    if not isinstance(integrator, Explicit):
        *others, last = EXPLICIT_EXAMPLES
        raise InputError(
            f"only {', '.join(others)} and {last} have a stable step, got "
            f"{format_value(integrator)}"
        )
