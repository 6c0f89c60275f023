"""Mass matrices, their factors, and the highest frequency of a system."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ancfsparse.array_types import Indices, Vector
from ancfsparse.errors import InputError
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


MAX_DENSE_COORDINATES = 100  # up to which a dense eigenproblem is faster than Lanczos' method
EIGENVALUE_TOLERANCE = 1e-4  # relative, of the square of the highest frequency
# Each takes a solution for each evaluation of the forces, all together a small dense matrix.
MAX_PROJECTED_CONSTRAINTS = 12  # that are satisfied by their accelerations alone
# Ten times the rounding of a factor; it is the relative error of accelerations across constraints.
SADDLE_REGULARIZATION = 1e-13  # over the smallest phi_q M^-1 phi_q^T


def mass_matrix(system: System) -> sp.csc_array:
    """Return the lower triangle of the mass matrix over the free coordinates."""
    return free_submatrix(system, system.assembly.mass)


def definite_mass(system: System, q: Vector) -> sp.csc_array:
    """Return `mass_matrix` with the masses of equations, which make it definite."""
    if not any(system.constraints.mass):
        return mass_matrix(system)
    zero = np.zeros(max(system.n_multipliers, system.loads.n_amplitudes))
    return free_submatrix(system, system.assembly.matrix(1.0, 0.0, q, zero, zero))


def mass_seed(system: System) -> SparseSeed:
    """Factor the mass matrix."""
    mass = definite_mass(system, system.q0)
    seed = SparseSeed(mass.indptr, mass.indices, system.n_free)
    check_factor_fits(NO_MEMORY, seed)
    seed.factor(mass.data)
    return seed


def saddle_seed(system: System) -> SparseSeed:
    """Return the seed of the saddle-point matrix of masses and constraints, not factored yet."""
    regularize(system, 0.0, SADDLE_REGULARIZATION)
    seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
    check_factor_fits(NO_MEMORY, seed)
    return seed


def constraint_magnitudes(system: System) -> Vector:
    """Return the sizes of the terms of the constraints, to which rounding is relative, (m,) [m].

    They belong to the reference shape, so that they do not depend on the start of a motion.
    """
    q, positions = system.q_ref, np.concatenate([np.ravel(x) for x in system.vectors("r")])
    magnitude = np.full(system.n_all, np.max(np.abs(np.delete(q, positions)), initial=1.0))
    shortest = min(body.shortest for body in system.scene.bodies)
    magnitude[positions] = np.max(np.abs(q[positions]), initial=shortest)
    return np.asarray(system.constraints.sizes(q) + abs(system.constraints.jacobian(q)) @ magnitude)


def needs_saddle_point_factor(system: System, integrator: Explicit) -> bool:
    """Return whether number or kind of the constraints require a saddle-point factor."""
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

    Or the highest rate of ``C x = omega M x`` if larger: no vibration, damped or not, has an
    eigenvalue above both.  Constraints only lower frequencies.

    Parameters
    ----------
    system : System
        The moving system.
    seed : SparseSeed or BlockInverse
        Inverse of its mass matrix.
    q : (n_all,) float
        Coordinates.
    amplitudes : (n_amplitudes,) float
        Amplitudes of the loads, because moments have a stiffness.
    lam : (m,) float, optional
        Multipliers [N], by which rotation of a rigid body is a vibration; by default zero.
    """
    lam = np.zeros(system.n_multipliers) if lam is None else lam
    if isinstance(seed, SparseSeed) and any(system.constraints.mass):
        seed.factor(definite_mass(system, q).data)
    stiffness = system.assembly.matrix(0.0, 1.0, q, lam, amplitudes)
    omega = highest_frequency_of(system, seed, stiffness, q, system.coupling_stiffness(q))
    if system.damped:
        damping = system.assembly.matrix(0.0, 0.0, q, lam, amplitudes, damping_factor=1.0)
        omega = max(omega, highest_frequency_of(system, seed, damping, q) ** 2)
    return omega


def highest_frequency_of(
    system: System,
    seed: SparseSeed | BlockInverse,
    values: Vector,
    q: Vector | None = None,
    coupling: sp.csr_array | None = None,
) -> float:
    """Return the highest angular frequency for a stiffness on the pattern [rad/s].

    The seed is the inverse of the masses at q, by default at the start; the stiffness between
    elements is added if given.
    """
    mass = symmetric_from_lower(definite_mass(system, system.q0 if q is None else q))
    stiffness = symmetric_from_lower(free_submatrix(system, values))
    if coupling is not None:
        stiffness = stiffness + coupling
    square = _highest_eigenvalue(stiffness, mass, seed)
    return math.sqrt(max(square, np.finfo(float).tiny))


def highest_initial_frequency(system: System, mass: SparseSeed, integrator: Explicit) -> float:
    """Return the highest angular frequency at the start, with rotations of rigid bodies [rad/s]."""
    lam = None
    if needs_saddle_point_factor(system, integrator):
        lam = initial_multipliers(system, saddle_seed(system))
    return highest_frequency(system, mass, system.q0, load_amplitudes_at_start(system), lam)


def initial_multipliers(system: System, seed: SparseSeed) -> Vector:
    """Return the multipliers at the start [N]; `seed` of the saddle-point matrix is factored."""
    zero = np.zeros(system.n_multipliers)
    seed.factor(system.assembly.matrix(1.0, 0.0, system.q0, zero, load_amplitudes_at_start(system)))
    return initial_acceleration(system, seed, system.v0)[1]


def _highest_eigenvalue(
    matrix: sp.csr_array, mass: sp.csr_array, seed: SparseSeed | BlockInverse
) -> float:
    """Return the largest eigenvalue of a symmetric matrix with respect to the masses."""
    from scipy.linalg import eigh
    from scipy.sparse.linalg import LinearOperator, eigsh

    n = mass.shape[0]
    if not matrix.data.any():  # such as that of friction before a contact; ARPACK refuses it
        return 0.0
    if n <= MAX_DENSE_COORDINATES:
        # A search for the largest alone fails where many are equal or zero.
        eigenvalues = eigh(matrix.toarray(), mass.toarray(), eigvals_only=True)
    else:
        eigenvalues = eigsh(
            matrix,
            k=1,
            M=mass,
            Minv=LinearOperator((n, n), matvec=lambda r: seed.solve(np.ravel(r)), dtype=float),
            which="LA",
            v0=np.random.default_rng(0).standard_normal(n),  # reproducible
            tol=EIGENVALUE_TOLERANCE,
            return_eigenvectors=False,
        )
    return float(eigenvalues[-1])


def free_submatrix(system: System, values: Vector) -> sp.csc_array:
    """Return the lower triangle over the free coordinates of values on the pattern."""
    import scipy.sparse as sp

    pattern, n = system.pattern, system.n_free
    lower = sp.csc_array((values, pattern.indices, pattern.indptr))
    return lower if lower.shape[0] == n else lower[:n, :n].tocsc()


def symmetric_from_lower(lower: sp.csc_array) -> sp.csr_array:
    """Return a symmetric matrix from its lower triangle."""
    import scipy.sparse as sp

    return (lower + sp.tril(lower, -1).T).tocsr()


def coupled_seed(
    indptr: Indices, indices: Indices, values: Vector, coupling: Any, n_positive: int | None = None
) -> tuple[SparseSeed, Vector]:
    """Return a seed of a matrix with the stiffness between elements, and the values it factors.

    Parameters
    ----------
    indptr, indices, values
        Lower triangle of the matrix by columns.
    coupling : sparse
        See `System.coupling_stiffness`; of the first unknowns.
    n_positive : int, optional
        See `SparseSeed`; by default all.
    """
    import scipy.sparse as sp

    n, added = len(indptr) - 1, sp.coo_array(sp.tril(coupling))
    # Joined, not added: a sum of sparse matrices would lose zeros on the diagonal.
    columns = np.repeat(np.arange(n), np.diff(indptr))
    rows = np.concatenate([indices, added.coords[0]])
    entries = np.concatenate([values, added.data])
    columns = np.concatenate([columns, added.coords[1]])
    lower = sp.coo_array((entries, (rows, columns)), shape=(n, n)).tocsc()
    lower.sort_indices()
    seed = SparseSeed(lower.indptr, lower.indices, n if n_positive is None else n_positive)
    return seed, lower.data


def omitted_coupling(system: System, q: Vector, amplitudes: Vector) -> str:
    """Return a sentence if a matrix leaves out how points affect each other, else an empty one."""
    sentences = (term.omitted_coupling(q, amplitudes) for term in system.contributions)
    return next(filter(None, sentences), "")


def check_coupling(system: System, q: Vector, amplitudes: Vector) -> None:
    """Refuse a system whose matrix leaves out how points affect each other."""
    omitted = omitted_coupling(system, q, amplitudes)
    if omitted:
        raise InputError(omitted)
