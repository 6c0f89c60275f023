"""Natural frequencies and mode shapes of a scene about a state."""

from __future__ import annotations

import warnings

import numpy as np

from ancfsparse.checks import check_count
from ancfsparse.errors import ApproximateModesWarning, InputError
from ancfsparse.results import Equilibrium
from ancfsparse.results.solutions.modes import Modes
from ancfsparse.scene import Scene
from ancfsparse.solve.linearization.linearized_system import linearized_in_memory
from ancfsparse.solve.vibration.symmetric_eigenproblem import (
    N_EXTRA_MODES,
    VECTORS_PER_MODE,
    admissible_motions,
    lowest_modes,
    max_modes,
)
from ancfsparse.system import State

N_MATRICES = 14  # arrays on the pattern: four matrices, three with their triangles and indices


def modes(of: Scene | Equilibrium, n: int = 10, *, at: State | Equilibrium | None = None) -> Modes:
    """Find the n lowest natural frequencies and mode shapes of a scene.

    The equations of motion are linearized about the state, with the stiffness of its stress, loads
    and joint forces.  Prescribed motions and loads keep their values at the time of the state.

    Parameters
    ----------
    of : Scene or Equilibrium
        A scene, about its stress-free shape and without loads; or a result of `solve_static`.
    n : int, optional
        Number of modes, those of lowest frequency, after unstable ones and free rigid motions; of a
        scene with more than 100 degrees of freedom at most half of all.
    at : State or Equilibrium, optional
        Another state, such as ``run.last``.  Its velocities only affect joint forces.

    Returns
    -------
    Modes
        Frequencies [Hz], shapes, damping ratios, and whether the state is `stable`.

    Raises
    ------
    InputError
        If an argument is invalid, there are fewer modes, the scene has a rotating frame, a force
        that couples points is not `coupled`, or the factor cannot fit in memory.
    ModesError
        If the modes cannot be found to working accuracy.

    Warns
    -----
    ApproximateModesWarning
        If some forces have an unsymmetric stiffness or damping, as functions of the motion and
        moments about fixed axes in space may: only its symmetric part is used, see `complex_modes`.

    Notes
    -----
    Lanczos' method with one sparse factor at a shift below all eigenvalues; a second factor counts
    the eigenvalues below a gap, so that none is missing.  The theory is in docs/theory.md.
    """
    n = check_count("n", n)
    n_vectors = VECTORS_PER_MODE * (n + N_EXTRA_MODES)
    with linearized_in_memory(of, at, N_MATRICES, n_vectors) as linearized:
        if linearized.system.gyroscopic is not None:
            raise InputError(
                "vibrations in a rotating frame are not modes with one phase, because of Coriolis "
                "forces: take complex_modes"
            )
        motions = admissible_motions(linearized)
        limit = max_modes(linearized, motions)
        if n > limit:
            raise InputError(f"n must be at most {limit} in this scene, got {n}")
        values, motions, rounding = lowest_modes(linearized, n, motions)
    system = linearized.system
    if linearized.is_unsymmetric(float(np.sqrt(np.abs(values).max()))):
        warnings.warn(ApproximateModesWarning(), stacklevel=2)
    damping = np.zeros(n)
    if system.damped:
        damping = np.sum(motions * (linearized.damping() @ motions.T).T, axis=1)
    shapes = np.zeros((n, system.n_all))
    shapes[:, : system.n_free] = motions
    values[np.abs(values) <= rounding] = 0.0
    forces = [system.assembly.inertia(system.uniform(d)) for d in range(system.dim)]
    masses = np.stack([shapes @ force for force in forces], axis=1) ** 2
    return Modes(system, linearized.state, shapes, values, damping, rounding, masses)
