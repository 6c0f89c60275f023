"""Matrices of systems, from the values on their patterns."""

import numpy as np
import scipy.sparse as sp


def symmetric(system, values):
    """Return a sparse symmetric matrix from its values on the pattern of a system."""
    p = system.pattern
    lower = sp.csc_array((values, p.indices, p.indptr), shape=(p.n, p.n))
    return sp.csc_array(lower + sp.tril(lower, -1).T)


def full(system, values):
    """Return a dense symmetric matrix from its values on the pattern of a system."""
    return symmetric(system, values).toarray()


def stiffness(system, q, lam=None, amplitudes=None):
    """Return the sparse stiffness with the gradients of constraints; no loads by default."""
    lam = np.zeros(system.n_multipliers) if lam is None else lam
    if amplitudes is None:
        amplitudes = np.zeros(system.loads.n_amplitudes)
    return symmetric(system, system.assembly.matrix(0.0, 1.0, q, lam, amplitudes))


def derivative_of_step(march, n, size=1e-8):
    """Return the derivative of a step's residual by its first n unknowns, by differences."""

    def residual(move):
        march.correct(move)
        r = march.residual()
        march.correct(-move)
        return r

    return np.array([residual(e) - residual(-e) for e in size * np.eye(n)]).T / (2.0 * size)
