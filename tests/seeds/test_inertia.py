"""Negative pivots are counted, and are as many as the negative eigenvalues (Sylvester)."""

import numpy as np
import pytest

from ancfsparse.seeds import SparseSeed
from tests.seeds.matrices import chain, lower_csc, lower_laplacian, net, random_spd, saddle


@pytest.mark.parametrize("make", [chain, net, random_spd, saddle])
def test_negative_pivots_are_negative_eigenvalues(make):
    a = make(np.random.default_rng(5))
    indptr, indices, _ = lower_csc(a)
    seed = SparseSeed(indptr, indices, len(a))
    eigenvalues = np.linalg.eigvalsh(a)
    for k in (0, 1, 3, len(a) // 2):
        shift = 0.5 * (eigenvalues[k] + eigenvalues[k + 1]) if k else eigenvalues[0] - 1.0
        seed.factor(lower_csc(a - shift * np.eye(len(a)))[2])
        assert seed.negative_pivots == np.count_nonzero(eigenvalues < shift)


def test_a_factor_that_does_not_exist_has_no_count():
    indptr, indices, values = lower_csc(np.diag([1.0, 0.0, -1.0]))
    seed = SparseSeed(indptr, indices, 3)
    assert seed.factor(values) > 0
    assert seed.negative_pivots is None


def test_a_supernodal_factor_counts_as_ours_does():
    lower = lower_laplacian(40, 3)
    seed = SparseSeed(lower.indptr, lower.indices, lower.shape[0])
    assert seed.supernodal
    assert seed.factor(lower.data) == 0
    assert seed.negative_pivots == 0
    # Eigenvalues are sums of three of 2 - 2 cos(pi k / 41).
    each = 2.0 - 2.0 * np.cos(np.pi * np.arange(1, 41) / 41)
    all_of_them = np.add.outer(np.add.outer(each, each), each).ravel()
    lower.data[lower.indptr[:-1]] -= 0.05
    assert seed.factor(lower.data) > 0
    assert seed.negative_pivots == np.count_nonzero(all_of_them < 0.05) == 4
