"""Damped vibrations, flutter and divergence of a scene about a state."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.checks import check_count
from ancfsparse.errors import InputError
from ancfsparse.nonlinear import Newton
from ancfsparse.results import Equilibrium
from ancfsparse.results.solutions.complex_modes import ComplexModes
from ancfsparse.scene import Scene
from ancfsparse.solve.linearization.linearized_system import linearize, scene_to_linearize
from ancfsparse.solve.preparation.memory_estimate import (
    NO_MEMORY,
    check_factor_fits,
    estimate_memory,
    within_memory,
)
from ancfsparse.solve.vibration.quadratic_eigenproblem import nearest
from ancfsparse.solve.vibration.symmetric_eigenproblem import (
    BEYOND,
    VECTORS,
    all_motions,
    lowest,
    most_modes,
)
from ancfsparse.system import State

if TYPE_CHECKING:
    from ancfsparse.results.solutions.complex_modes import ComplexModes

# Arrays of values on the pattern: six matrices, from their triangles, with indices.
MATRICES = 20


def complex_modes(
    of: Scene | Equilibrium, n: int = 10, *, at: State | Equilibrium | None = None
) -> ComplexModes:
    """Find the n slowest motions ``x exp(w t)`` of a scene with damping, with complex w and x.

    The equations of motion are linearised about the state, which is taken to be at rest, with all
    of their damping, with forces that have no potential, such as those that follow a section, and
    with the Coriolis forces of a rotating frame.  So damping ratios are exact, also of dashpots and
    of motions without oscillation, flutter is detected, and frequencies about a steady rotation
    (`Scene.rotating_frame`) are those in the frame.

    Parameters
    ----------
    of : Scene or Equilibrium
        A scene, about its stress-free shape and without loads; or what `solve_static` has returned.
    n : int, optional
        How many motions, those with the smallest ``|w|``; a vibration counts once, and so does
        every motion without oscillation.  Of a scene with more than 100 degrees of freedom at most
        a quarter of all.
    at : State or Equilibrium, optional
        Another state, such as ``run.last``.

    Returns
    -------
    ComplexModes
        Eigenvalues [1/s], frequencies [Hz], damping ratios, growth rates, complex shapes.

    Raises
    ------
    InputError
        If an argument is invalid, there are fewer modes, or the factor cannot fit in memory.
    ModesError
        If the modes cannot be found to working accuracy.

    Notes
    -----
    Arnoldi's method on the linearised quadratic eigenvalue problem, inverted with one sparse factor
    at a real rate.  Derivatives of forces without a potential are taken by differences, to some ten
    digits.  The theory is in docs/theory.md.
    """
    n = check_count("n", n)
    scene = scene_to_linearize(of, at)
    with within_memory(estimate_memory(scene, 0, 0, False, Newton(), matrices=MATRICES)):
        pencil = linearize(of, at)
        vectors = 8.0 * VECTORS * 8 * (n + BEYOND) * pencil.seed.n
        check_factor_fits(replace(NO_MEMORY, vectors=vectors), pencil.seed)
        motions = all_motions(pencil)
        most = most_modes(pencil, motions)
        most = most if motions is not None else most // 2
        if n > most:
            raise InputError(f"n must be at most {most} in this scene, got {n}")
        squares = lowest(pencil, n, motions)[0]
        roots = nearest(pencil, n, float(np.sqrt(np.abs(squares).max())), motions)
    system = pencil.system
    shapes = np.zeros((n, system.n_all), dtype=complex)
    shapes[:, : system.n_free] = roots.motions
    return ComplexModes(system, pencil.state, roots.values, shapes, roots.rounding)
