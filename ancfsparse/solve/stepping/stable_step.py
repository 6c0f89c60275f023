"""The stable step of an explicit integrator."""

from __future__ import annotations

from ancfsparse.errors import InputError
from ancfsparse.integrators import Explicit
from ancfsparse.integrators.names import EXPLICIT_EXAMPLES
from ancfsparse.messages import format_value
from ancfsparse.scene import Scene, check_scene
from ancfsparse.solve.initial_conditions.consistent_accelerations import load_amplitudes_at_start
from ancfsparse.solve.linearization.matrices import (
    check_coupling,
    highest_initial_frequency,
    mass_seed,
)
from ancfsparse.solve.preparation.memory_estimate import estimate_memory, within_memory
from ancfsparse.solve.stepping.explicit_setup import check_explicit_scene
from ancfsparse.system import System

N_MATRICES = 10  # arrays on the pattern: two full matrices with their triangles and indices


def stable_step(scene: Scene, integrator: Explicit) -> float:
    """Return the longest stable step of an explicit integrator at the start of the motion [s].

    ``interval / omega`` with the highest frequency omega of the scene and the stability interval of
    the method, 2 for central differences.  Stretched beams vibrate faster, so stay below it.  It is
    at most the longest step that `simulate` admits with the contacts of the scene, also if they
    begin later: ``interval`` times the square root of mass per length over stiffness, and with a
    restitution the step that resolves an impact.

    Parameters
    ----------
    scene : Scene
        Without joints that need multipliers for `RungeKuttaNystrom`, and without damping except for
        `DormandPrince`.
    integrator : CentralDifference, RungeKuttaNystrom or DormandPrince
        The method.

    Raises
    ------
    InputError
        If the integrator is not explicit or cannot handle the scene, a force that couples points is
        not `coupled`, or the factor of its mass matrix cannot fit in memory.
    """
    check_explicit(integrator)
    check_scene(scene)
    with within_memory(estimate_memory(scene, 1, matrices=N_MATRICES)):
        system = System(scene)
        check_explicit_scene(system, integrator)
        check_coupling(system, system.q0, load_amplitudes_at_start(system))
        omega = highest_initial_frequency(system, mass_seed(system), integrator)
        interval = integrator.tableau.interval
        contacts = [each.longest_step(interval) for each in system.contributions]
    return min([interval / omega, *contacts])


def check_explicit(integrator: object) -> None:
    """Check that an integrator is explicit."""
    if not isinstance(integrator, Explicit):
        *others, last = EXPLICIT_EXAMPLES
        raise InputError(
            f"only {', '.join(others)} and {last} have a stable step, got "
            f"{format_value(integrator)}"
        )
