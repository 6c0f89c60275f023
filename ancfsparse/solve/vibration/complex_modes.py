"""Damped vibrations, flutter and divergence of a scene about a state."""

from __future__ import annotations

import numpy as np

from ancfsparse.checks import check_count
from ancfsparse.errors import InputError
from ancfsparse.results import Equilibrium
from ancfsparse.results.solutions.complex_modes import ComplexModes
from ancfsparse.scene import Scene
from ancfsparse.solve.linearization.linearized_system import linearized_in_memory
from ancfsparse.solve.vibration.quadratic_eigenproblem import smallest_roots
from ancfsparse.solve.vibration.symmetric_eigenproblem import (
    N_EXTRA_MODES,
    VECTORS_PER_MODE,
    admissible_motions,
    lowest_modes,
    max_modes,
)
from ancfsparse.system import State

N_MATRICES = 20  # arrays on the pattern: six matrices with their triangles and indices


def complex_modes(
    of: Scene | Equilibrium, n: int = 10, *, at: State | Equilibrium | None = None
) -> ComplexModes:
    """Find the n slowest motions ``x exp(w t)`` of a damped scene, with complex w and x.

    The equations of motion are linearized about the state, which is assumed to be at rest, with all
    damping, with nonconservative forces such as follower loads, and with the Coriolis forces of a
    rotating frame.  So damping ratios are exact, also of dashpots and of overdamped motions,
    flutter is detected, and frequencies about a steady rotation (`Scene.rotating_frame`) are those
    in the frame.

    Parameters
    ----------
    of : Scene or Equilibrium
        A scene, about its stress-free shape and without loads; or a result of `solve_static`.
    n : int, optional
        Number of motions, those with the smallest ``|w|``; a vibration counts as one, and so does
        each motion without oscillation; an overdamped degree of freedom has two.  Of a scene with
        more than 100 degrees of freedom at most a quarter of all.
    at : State or Equilibrium, optional
        Another state, such as ``run.last``.

    Returns
    -------
    ComplexModes
        Eigenvalues [1/s], frequencies [Hz], damping ratios, growth rates, complex shapes.

    Raises
    ------
    InputError
        If an argument is invalid, there are fewer modes, a force that couples points is not
        `coupled`, or the factor cannot fit in memory.
    ModesError
        If the modes cannot be found to working accuracy.

    Notes
    -----
    Arnoldi's method on the linearized quadratic eigenvalue problem, inverted with one sparse factor
    at a real rate.  Derivatives of nonconservative forces are finite differences, accurate to some
    ten digits.  The theory is in docs/theory.md.
    """
    n = check_count("n", n)
    n_vectors = 8 * VECTORS_PER_MODE * (n + N_EXTRA_MODES)
    with linearized_in_memory(of, at, N_MATRICES, n_vectors) as linearized:
        motions = admissible_motions(linearized)
        limit = max_modes(linearized, motions)
        if motions is None and n > limit // 2:
            raise InputError(f"n must be at most {limit // 2} in this scene, got {n}")
        squares = lowest_modes(linearized, min(n, limit), motions)[0]
        roots = smallest_roots(linearized, n, float(np.sqrt(np.abs(squares).max())), motions)
    system = linearized.system
    shapes = np.zeros((n, system.n_all), dtype=complex)
    shapes[:, : system.n_free] = roots.motions
    return ComplexModes(system, linearized.state, shapes, roots.values, roots.rounding)
