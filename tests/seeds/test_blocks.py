"""The inverse in dense blocks is the inverse."""

import numpy as np
import pytest
import scipy.linalg

from ancfsparse.dispatch import available_instruction_sets, compiled_module
from ancfsparse.problems import pendulum
from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.dense.block_inverse import BlockInverse
from ancfsparse.system import System
from tests.seeds.matrices import lower_csc


def mixed(rng, sizes):
    """A matrix of independent blocks whose unknowns are shuffled; zeros between them are stored."""
    blocks = [factor @ factor.T + np.eye(n) for n in sizes for factor in [rng.normal(size=(n, n))]]
    a, order = scipy.linalg.block_diag(*blocks), rng.permutation(sum(sizes))
    return a[np.ix_(order, order)]


@pytest.mark.parametrize("sizes", [(1,), (2,), (7,), (8, 1), (16, 16), (21, 21), (5, 33, 12)])
def test_products_are_solutions(sizes):
    rng = np.random.default_rng(sum(sizes))
    a = mixed(rng, sizes)
    inverse = BlockInverse(*lower_csc(a, also=[(len(a) - 1, 0)]))
    for _ in range(3):  # the second product must not see what the first left behind
        r = rng.normal(size=len(a))
        np.testing.assert_allclose(a @ inverse.solve(r), r, rtol=0, atol=1e-11)
    assert inverse.solve_flops == 2 * sum(n * n for n in sizes)
    assert inverse.error is None


@pytest.mark.parametrize("name", available_instruction_sets())
@pytest.mark.parametrize("size", [1, 3, 8, 13])
def test_every_instruction_set_gives_the_same(name, size):
    rng = np.random.default_rng(size)
    a, r = mixed(rng, (size, 2)), rng.normal(size=size + 2)
    members = [np.arange(size), np.arange(size, size + 2)]
    whole = [a[np.ix_(m, m)] for m in members]
    found = compiled_module("blocks", name).Blocks(members, whole).solve(r)
    expected = np.concatenate([b @ r[m] for b, m in zip(whole, members, strict=True)])
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max() * size)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_mass_matrix_has_one_block_for_each_direction(dim):
    system = System(pendulum("thin", 10, dim).scene)
    pattern = system.pattern
    inverse = BlockInverse(pattern.indptr, pattern.indices, system.assembly.mass)
    assert inverse.solve_flops == 2 * dim * 21**2
    seed = SparseSeed(pattern.indptr, pattern.indices, system.n_free)
    seed.factor(system.assembly.mass)
    r = np.random.default_rng(0).normal(size=system.n_free)
    np.testing.assert_allclose(inverse.solve(r), seed.solve(r), rtol=1e-12)
