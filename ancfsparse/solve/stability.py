"""How long a step of an explicit integrator may be."""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, eigsh

from ancfsparse.checks import shown
from ancfsparse.errors import InputError
from ancfsparse.integrators.explicit import Explicit
from ancfsparse.nonlinear import Newton
from ancfsparse.scene import Scene, check_scene
from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.blocks import BlockInverse
from ancfsparse.solve.memory import NOTHING, check_factor, estimate, memory_for
from ancfsparse.system import System

Vector = NDArray[np.float64]

# Up to so many coordinates all frequencies together are found sooner than the highest alone.
DENSE = 100
# Arrays of values on the pattern: two whole matrices, each from its triangle, with their indices.
MATRICES = 10
# Relative accuracy of the square of the highest frequency; the limit is half as uncertain.
ACCURACY = 1e-4


def stable_step(scene: Scene, integrator: Explicit) -> float:
    """Return the longest stable step of an explicit integrator at the start of the motion [s].

    ``interval / omega``, with the fastest vibration omega of the scene and what the method can
    follow, 2 for central differences.  Beams that are stretched vibrate faster, so stay below it.

    Parameters
    ----------
    scene : Scene
        Without joints that need multipliers.
    integrator : CentralDifference or RungeKuttaNystrom
        The method.

    Raises
    ------
    InputError
        If the integrator is not explicit, the scene needs multipliers, or the factor of its masses
        cannot fit in memory.
    """
    check_explicit(integrator)
    check_scene(scene)
    with memory_for(estimate(scene, 1, 0, False, Newton(), matrices=MATRICES)):
        system = System(scene)
        check_free(system, integrator)
        mass = mass_seed(system)
        omega = fastest_vibration(system, mass, system.q0, start_load(system))
    return integrator.tableau.interval / omega


def check_explicit(integrator: object) -> None:
    """Refuse what is not an explicit integrator."""
    if not isinstance(integrator, Explicit):
        raise InputError(
            f"only CentralDifference() and RungeKuttaNystrom(order) have a stable step, "
            f"got {shown(integrator)}"
        )


def check_free(system: System, integrator: Explicit) -> None:
    """Refuse multipliers and damping: forces must depend on free positions alone."""
    if system.n_multipliers:
        raise InputError(
            f"{integrator!r} cannot hold constraints by multipliers, and the "
            f"{system.constraints.labels[0]} needs them: make pins, clamps and connections by "
            "numbering, as_constraint=False, or take an implicit integrator such as "
            "GeneralizedAlpha(0.9)"
        )
    if system.damped:
        raise InputError(
            f"{integrator!r} takes forces that depend on positions and time, and the damping of "
            "this scene depends on velocities: take an implicit integrator such as "
            "GeneralizedAlpha(0.9)"
        )


def start_load(system: System) -> Vector:
    """Return the amplitudes of the loads at t = 0."""
    return np.asarray(system.loads.amplitudes(np.zeros(1))[0])


def mass_seed(system: System) -> SparseSeed:
    """Factor the mass matrix."""
    seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
    check_factor(NOTHING, seed)
    seed.factor(system.assembly.mass)
    return seed


def fastest_vibration(
    system: System, seed: SparseSeed | BlockInverse, q: Vector, amplitudes: Vector
) -> float:
    """Return the highest angular frequency of ``K x = omega^2 M x`` at a state [rad/s].

    Parameters
    ----------
    system : System
        Without multipliers.
    seed : SparseSeed or BlockInverse
        Inverse of its mass matrix.
    q : (n_all,) float
        Coordinates.
    amplitudes : (n_amplitudes,) float
        Loads that change, because moments stiffen what they turn.
    """
    n = system.n_free
    stiffness = _symmetric(system, system.assembly.matrix(0.0, 1.0, q, np.zeros(0), amplitudes))
    mass = _symmetric(system, system.assembly.mass)
    if n <= DENSE:
        squares = scipy.linalg.eigh(
            stiffness.toarray(), mass.toarray(), eigvals_only=True, subset_by_index=[n - 1, n - 1]
        )
    else:
        squares = eigsh(
            stiffness,
            k=1,
            M=mass,
            Minv=LinearOperator((n, n), matvec=lambda r: seed.solve(np.ravel(r)), dtype=float),
            which="LA",
            v0=np.random.default_rng(0).standard_normal(n),  # the same in every run
            tol=ACCURACY,
            return_eigenvectors=False,
        )
    return float(np.sqrt(max(squares[0], np.finfo(float).tiny)))


def _symmetric(system: System, values: Vector) -> sp.csr_array:
    """Return the whole matrix whose lower triangle has these values on the pattern."""
    pattern = system.pattern
    lower = sp.csc_array((values, pattern.indices, pattern.indptr))
    return (lower + sp.tril(lower, -1).T).tocsr()
