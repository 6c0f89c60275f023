"""A saddle-point system, and quasi-Newton iterations on it that are driven from Python."""

import numpy as np

from ancfsparse.dispatch import compiled_module
from ancfsparse.seeds import SparseSeed


class Problem:
    """r(x) = J x - b + curved terms, with J = [S G^T; G 0] and symmetric derivative.

    The seed is the factor of a neighbour of J, made quasi-definite.
    """

    def __init__(self, rng, n=26, m=4, curved=0.05, off=0.15, epsilon=1e-2):
        factor = rng.normal(size=(n, n))
        stiffness = factor @ factor.T / n + np.eye(n)
        g = rng.normal(size=(m, n)) / np.sqrt(n)
        self.n, self.m = n, m
        self.j = np.block([[stiffness, g.T], [g, np.zeros((m, m))]])
        self.b = rng.normal(size=n + m)
        self.curved = curved
        change = rng.normal(size=(n, n))
        near = stiffness + off * (change + change.T) / np.sqrt(n)
        self.a = np.block([[near, g.T], [g, -epsilon * np.eye(m)]])

    @property
    def h0(self):
        return np.linalg.inv(self.a)

    def residual(self, x):
        r = self.j @ x - self.b
        r[: self.n] += self.curved * x[: self.n] ** 3
        return r


def seed_of(a, n_positive):
    """The compiled factor of a dense symmetric matrix."""
    row, column = np.tril_indices(len(a))
    order = np.lexsort((row, column))
    row, column = row[order], column[order]
    indptr = np.searchsorted(column, np.arange(len(a) + 1))
    values = np.ascontiguousarray(a[row, column])
    seed = SparseSeed(indptr, row.astype(np.int32), n_positive)
    seed.factor(values)
    return seed


def dense(rule, a, n_positive):
    inverse = compiled_module("dense").Dense(seed_of(a, n_positive), rule)
    inverse.matrix = np.linalg.inv(a)
    return inverse


def limited(rule, a, n_positive, n_pairs=20, weights=None):
    return compiled_module("limited").Limited(seed_of(a, n_positive), rule, n_pairs, weights)


def matrix_of(inverse, n):
    """H, column by column."""
    return np.column_stack([inverse.apply(e) for e in np.eye(n)])


def iterate(inverse, residual, x, steps):
    """Full quasi-Newton steps; return x and the lists of s and y."""
    s_list, y_list = [], []
    r = residual(x)
    z = inverse.apply(r)
    for _ in range(steps):
        s = -z
        x = x + s
        r_new = residual(x)
        y = r_new - r
        z, accepted = inverse.learn(s, y, r_new)
        assert accepted
        s_list.append(s)
        y_list.append(y)
        r = r_new
    return x, s_list, y_list


def learn_pair(inverse, h, s, y):
    """Offer any pair, not only one that an iteration has found: r_old is what makes s a step."""
    r_old = -np.linalg.solve(h, s)
    return inverse.learn(s, y, r_old + y)
