"""Symmetric matrices of the kinds that beams lead to, as dense arrays."""

import functools

import numpy as np
import scipy.sparse as sp


def chain(rng, n_nodes=12, per_node=4):
    """Block-tridiagonal and positive definite, as the mass and stiffness of a cable."""
    n = n_nodes * per_node
    a = np.zeros((n, n))
    for k in range(n_nodes - 1):
        rows = slice(k * per_node, (k + 2) * per_node)
        factor = rng.normal(size=(2 * per_node, 2 * per_node))
        a[rows, rows] += factor @ factor.T
    return a + 0.1 * np.eye(n)


def random_spd(rng, n=40, density=0.08):
    """Positive definite with entries anywhere."""
    factor = sp.random(n, n, density, random_state=rng, data_rvs=rng.standard_normal).toarray()
    return factor @ factor.T + np.diag(rng.uniform(0.5, 2.0, n))


def saddle(rng, n=32, m=6, epsilon=1e-3):
    """Quasi-definite, [S G^T; G -epsilon]: n coordinates, then m multipliers."""
    a = np.zeros((n + m, n + m))
    a[:n, :n] = chain(rng, n // 4)
    for k in range(m):
        where = rng.choice(n, 3, replace=False)
        a[n + k, where] = a[where, n + k] = rng.normal(size=3)
    a[n:, n:] = -epsilon * np.eye(m)
    return a


def net(rng, side=10, per_node=3):
    """Positive definite, every node of a square grid coupled to its neighbours."""
    n = side * side * per_node
    a = np.zeros((n, n))
    for i in range(side):
        for j in range(side):
            here = i * side + j
            for there in [here + 1] * (j + 1 < side) + [here + side] * (i + 1 < side):
                ends = np.concatenate([per_node * e + np.arange(per_node) for e in (here, there)])
                factor = rng.normal(size=(2 * per_node, 2 * per_node))
                a[np.ix_(ends, ends)] += factor @ factor.T
    return a + 0.1 * np.eye(n)


def lower_csc(a, also=()):
    """Lower triangle by columns as (indptr, indices, values), the diagonal always stored.

    ``also`` are pairs (i, j) that are stored although their value is zero.
    """
    stored = np.tril(a != 0) | np.eye(len(a), dtype=bool)
    for i, j in also:
        stored[max(i, j), min(i, j)] = True
    column, row = np.nonzero(stored.T)
    indptr = np.searchsorted(column, np.arange(len(a) + 1)).astype(np.int64)
    return indptr, row.astype(np.int32), np.ascontiguousarray(a[row, column], dtype=np.float64)


def on_grid(line, dim):
    """Sum of a matrix of a line along each axis of a square or a cube."""
    one = sp.eye_array(line.shape[0])
    factors = [[line if k == axis else one for k in range(dim)] for axis in range(dim)]
    return sum(functools.reduce(sp.kron, each) for each in factors)


def lower_laplacian(n, dim, ground=0.0):
    """Lower triangle of springs between the neighbours of a grid whose edges are held."""
    line = sp.diags_array([2.0, -1.0, -1.0], offsets=[0, 1, -1], shape=(n, n))
    lower = sp.csc_array(sp.tril(on_grid(line, dim) + ground * sp.eye_array(n**dim)))
    lower.sort_indices()
    return lower


def dense_factor(seed):
    """L, D and the permutation of the compiled factor as dense arrays."""
    start, row, lower, pivot, permutation = seed.columns()
    n = len(pivot)
    full = np.eye(n)
    full[row, np.repeat(np.arange(n), np.diff(start))] = lower
    return full, pivot, permutation


def assert_factors(seed, a):
    """Assert that the factor of a seed is one of a matrix."""
    full, pivot, permutation = dense_factor(seed)
    permute_upper = a[np.ix_(permutation, permutation)]
    error = np.abs(full * pivot @ full.T - permute_upper).max()
    assert error <= 1e-13 * np.abs(full * np.abs(pivot) @ np.abs(full.T)).max()
