"""Factors in parts for several threads: the same matrix, the same answers, the same bits again."""

from itertools import pairwise

import numpy as np
import pytest

from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.complete.supernodes import SupernodeTree, divide_among_threads
from tests.seeds.matrices import assert_factors, chain, lower_csc, lower_laplacian, net


def star(rng, arms=6, length=20):
    """Chains that meet in one node."""
    n = 1 + arms * length
    a = np.zeros((n, n))
    for arm in range(arms):
        nodes = np.append(0, 1 + arm * length + np.arange(length))
        for i, j in pairwise(nodes):
            a[i, j] = a[j, i] = rng.normal()
    return a + np.diag(np.abs(a).sum(axis=1) + 0.1)


def forest(rng):
    """Two chains that do not meet."""
    a, b = chain(rng, 20), chain(rng, 20)
    return np.block([[a, np.zeros((80, 80))], [np.zeros((80, 80)), b]])


def mixed(rng):
    """A chain whose last pivot is negative."""
    a = chain(rng, 60)
    a[239, 239] = -1e3
    return a


CASES = {
    "chain": (lambda rng: chain(rng, 60), 240, (2,)),
    "star": (star, 121, (2, 3)),
    "forest": (forest, 160, (2,)),
    "net": (lambda rng: net(rng, 16), 768, (2,)),
    "mixed": (mixed, 239, (2,)),
}
"""How to make a matrix, how many of its pivots are positive, and numbers of threads."""


@pytest.mark.parametrize(("case", "threads"), [(case, t) for case in CASES for t in CASES[case][2]])
def test_parts_factor_the_same_matrix(case, threads, rng):
    make, n_positive, _ = CASES[case]
    a = make(rng)
    indptr, indices, values = lower_csc(a)
    seed = SparseSeed(indptr, indices, n_positive, threads)
    alone = SparseSeed(indptr, indices, n_positive)
    assert (seed.threads, alone.threads) == (threads, 1)
    assert seed.nnz == alone.nnz  # another order among subtrees does not fill in
    for _ in range(2):
        assert seed.factor(values) == 0
        assert_factors(seed, a)
        r = rng.normal(size=seed.n)
        expected = np.linalg.solve(a, r)
        x = seed.solve(r)
        assert np.abs(x - expected).max() <= 1e-10 * np.abs(expected).max()
        assert seed.factor(values) == 0
        np.testing.assert_array_equal(seed.solve(r), x)


def test_parts_name_a_wrong_pivot_wherever_it_is(rng):
    a = chain(rng, 60)
    values = lower_csc(a)
    seed = SparseSeed(*values[:2], len(a), 2)
    assert seed.threads == 2
    for where in (0, 100, 120, 239):
        broken = a.copy()
        broken[where, where] = -1e3
        bad = seed.factor(lower_csc(broken)[2])
        assert abs(bad - 1 - where) < 8  # its own pivot, or one beside it that comes later
        # A wrong sign is a warning, the factor is still the factor.
        r = rng.normal(size=len(a))
        np.testing.assert_allclose(broken @ seed.solve(r), r, rtol=0, atol=1e-9)
    values[2][values[0][120]] = np.nan
    assert seed.factor(values[2]) != 0
    assert seed.factor(lower_csc(a)[2]) == 0


@pytest.mark.parametrize("threads", [3, 4, 7])
def test_a_chain_takes_two_threads_of_many(threads, rng):
    a = chain(rng, 60)
    indptr, indices, values = lower_csc(a)
    seed = SparseSeed(indptr, indices, len(a), threads)
    assert seed.threads in (2, 3)
    assert seed.factor(values) == 0
    r = rng.normal(size=len(a))
    np.testing.assert_allclose(a @ seed.solve(r), r, rtol=0, atol=1e-10)


def test_a_chain_in_its_natural_order_cannot_be_divided():
    n = 100
    parent = np.append(np.arange(1, n), -1).astype(np.int32)
    first = np.arange(n + 1, dtype=np.int32)
    shape = SupernodeTree(
        first, first[:-1], parent, np.minimum(first, n - 1).astype(np.int64), first, 0, 0
    )
    assert divide_among_threads(shape, 2) is None


def test_parts_are_even_and_do_not_update_one_another():
    lower = lower_laplacian(120, 2)
    seed = SparseSeed(lower.indptr, lower.indices, lower.shape[0], 2)
    assert seed.threads == 2
    start, row, *_ = seed.columns()
    ends = np.asarray(seed.shape.first)[seed.shape.part]
    column = np.repeat(np.arange(seed.n), np.diff(start))
    part = np.searchsorted(ends, column, side="right")
    of_row = np.searchsorted(ends, row, side="right")
    assert np.all((of_row == part) | (of_row == 3))
    work = np.bincount(part, minlength=4)[1:]
    assert max(work[:2]) <= 1.2 * min(work[:2])
