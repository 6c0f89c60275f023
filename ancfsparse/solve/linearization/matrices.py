"""Mass matrices, their factors, and the highest frequency of a system."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.integrators.explicit.explicit_methods import Explicit
from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.dense.block_inverse import BlockInverse
from ancfsparse.solve.initial_conditions.consistent_accelerations import (
    initial_acceleration,
    load_amplitudes_at_start,
)
from ancfsparse.solve.initial_conditions.consistent_state import regularize
from ancfsparse.solve.preparation.memory_estimate import NO_MEMORY, check_factor_fits
from ancfsparse.system import System

if TYPE_CHECKING:
    import scipy.sparse as sp

Vector = NDArray[np.float64]

# Up to so many coordinates all frequencies together are found sooner than the highest alone.
MAX_DENSE_COORDINATES = 100
# Relative accuracy of the square of the highest frequency; the limit is half as uncertain.
EIGENVALUE_TOLERANCE = 1e-4
# Constraints that are held by their accelerations alone at most: each costs a solution for each
# evaluation of the forces, and all together a small dense matrix.
MAX_PROJECTED_CONSTRAINTS = 12

# Share of the smallest phi_q M^-1 phi_q^T that makes redundant constraints definite, the error of
# accelerations across them: ten times what rounds in a factor.
SADDLE_REGULARIZATION = 1e-13


def mass_matrix(system: System) -> sp.csc_array:
    """Return the lower triangle of the mass matrix over the free coordinates."""
    return free_submatrix(system, system.assembly.mass)


def definite_mass(system: System, q: Vector) -> sp.csc_array:
    """Return `mass_matrix` with the masses of equations, which motions under constraints lack."""
    if not any(system.constraints.mass):
        return mass_matrix(system)
    none = np.zeros(max(system.n_multipliers, system.loads.n_amplitudes))
    return free_submatrix(system, system.assembly.matrix(1.0, 0.0, q, none, none))


def mass_seed(system: System) -> SparseSeed:
    """Factor the mass matrix."""
    mass = definite_mass(system, system.q0)
    seed = SparseSeed(mass.indptr, mass.indices, system.n_free)
    check_factor_fits(NO_MEMORY, seed)
    seed.factor(mass.data)
    return seed


def saddle_seed(system: System) -> SparseSeed:
    """Return the seed for the matrix of the masses with all constraints, not factored yet."""
    regularize(system, 0.0, SADDLE_REGULARIZATION)
    seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
    check_factor_fits(NO_MEMORY, seed)
    return seed


def constraint_magnitudes(system: System) -> Vector:
    """Return what the rounding of each constraint is proportional to, (m,) [m].

    Of the reference shape, so that it is the same wherever a motion starts.
    """
    q, positions = system.q_ref, np.concatenate([np.ravel(each) for each in system.vectors("r")])
    magnitude = np.full(system.n_all, np.max(np.abs(np.delete(q, positions)), initial=1.0))
    least = min(body.shortest for body in system.scene.bodies)
    magnitude[positions] = np.max(np.abs(q[positions]), initial=least)
    return np.asarray(system.constraints.sizes(q) + abs(system.constraints.jacobian(q)) @ magnitude)


def needs_saddle(system: System, integrator: Explicit) -> bool:
    """Whether the constraints are too many, or of a kind, for their accelerations alone to hold."""
    constraints = system.constraints
    return system.n_multipliers > 0 and (
        not integrator.takes_velocities
        or system.n_multipliers > MAX_PROJECTED_CONSTRAINTS
        or system.prescribed.n_equations > 0
        or any(constraints.mass)
        or bool(constraints.measures)
    )


def highest_frequency(
    system: System,
    seed: SparseSeed | BlockInverse,
    q: Vector,
    amplitudes: Vector,
    lam: Vector | None = None,
) -> float:
    """Return the highest angular frequency of ``K x = omega^2 M x`` at a state [rad/s].

    Or the highest rate of ``C x = omega M x``, if that is more: no vibration, damped or not, has a
    larger eigenvalue than both.  Constraints only slow vibrations down.

    Parameters
    ----------
    system : System
        What moves.
    seed : SparseSeed or BlockInverse
        Inverse of its mass matrix.
    q : (n_all,) float
        Coordinates.
    amplitudes : (n_amplitudes,) float
        Loads that change, because moments stiffen what they turn.
    lam : (m,) float, optional
        Multipliers [N]: those of a rigid body make its rotation a vibration; by default zero.
    """
    lam = np.zeros(system.n_multipliers) if lam is None else lam
    if isinstance(seed, SparseSeed) and any(system.constraints.mass):
        seed.factor(definite_mass(system, q).data)
    omega = highest_frequency_of(
        system, seed, system.assembly.matrix(0.0, 1.0, q, lam, amplitudes), q
    )
    if system.damped:
        damping = system.assembly.matrix(0.0, 0.0, q, lam, amplitudes, damping_factor=1.0)
        omega = max(omega, highest_frequency_of(system, seed, damping, q) ** 2)
    return omega


def highest_frequency_of(
    system: System, seed: SparseSeed | BlockInverse, values: Vector, q: Vector | None = None
) -> float:
    """Return the highest angular frequency of a stiffness given by values on the pattern [rad/s].

    With the masses at q or at the start, of which the seed has the inverse.
    """
    mass = symmetric_from_lower(definite_mass(system, system.q0 if q is None else q))
    square = _highest(symmetric_from_lower(free_submatrix(system, values)), mass, seed)
    return math.sqrt(max(square, np.finfo(float).tiny))


def highest_initial_frequency(system: System, mass: SparseSeed, integrator: Explicit) -> float:
    """Return the highest angular frequency at the start [rad/s], rotations of bodies included."""
    lam = None
    if needs_saddle(system, integrator):
        lam = initial_multipliers(system, saddle_seed(system))
    return highest_frequency(system, mass, system.q0, load_amplitudes_at_start(system), lam)


def initial_multipliers(system: System, seed: SparseSeed) -> Vector:
    """Return the multipliers at the start [N]; `seed` of all constraints is left with a factor."""
    none = np.zeros(system.n_multipliers)
    seed.factor(system.assembly.matrix(1.0, 0.0, system.q0, none, load_amplitudes_at_start(system)))
    return initial_acceleration(system, seed, system.v0)[1]


def _highest(matrix: sp.csr_array, mass: sp.csr_array, seed: SparseSeed | BlockInverse) -> float:
    """Return the highest eigenvalue of a symmetric matrix over that of the masses."""
    from scipy.linalg import eigh
    from scipy.sparse.linalg import LinearOperator, eigsh

    n = mass.shape[0]
    if n <= MAX_DENSE_COORDINATES:
        # All of them: a search for the highest alone fails where many are equal or zero.
        found = eigh(matrix.toarray(), mass.toarray(), eigvals_only=True)
    else:
        found = eigsh(
            matrix,
            k=1,
            M=mass,
            Minv=LinearOperator((n, n), matvec=lambda r: seed.solve(np.ravel(r)), dtype=float),
            which="LA",
            v0=np.random.default_rng(0).standard_normal(n),  # the same in every run
            tol=EIGENVALUE_TOLERANCE,
            return_eigenvectors=False,
        )
    return float(found[-1])


def free_submatrix(system: System, values: Vector) -> sp.csc_array:
    """Return the lower triangle over the free coordinates, from values on the pattern."""
    import scipy.sparse as sp

    pattern, n = system.pattern, system.n_free
    lower = sp.csc_array((values, pattern.indices, pattern.indptr))
    return lower if lower.shape[0] == n else lower[:n, :n].tocsc()


def symmetric_from_lower(lower: sp.csc_array) -> sp.csr_array:
    """Return a symmetric matrix from its lower triangle."""
    import scipy.sparse as sp

    return (lower + sp.tril(lower, -1).T).tocsr()
