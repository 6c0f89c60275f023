"""Conjugate gradients with coarse modes: right solutions, few sweeps, and signs of the matrix."""

import numpy as np
import pytest
import scipy.sparse as sp

from ancfsparse.seeds import DeflatedSeed, Groups
from ancfsparse.seeds.incomplete import deflated_gradients as module


def springs(n, ground=1e-6):
    """A cube of masses in three directions on springs, hardly tied to the ground."""
    chain = sp.diags_array([[-1.0] * (n - 1), [2.0] * n, [-1.0] * (n - 1)], offsets=[-1, 0, 1])
    chain = chain.tolil()
    chain[0, 0] = chain[n - 1, n - 1] = 1.0
    one = sp.eye_array(n)
    cube = sum(
        sp.kron(sp.kron(*pair[:2]), pair[2])
        for pair in ((chain, one, one), (one, chain, one), (one, one, chain))
    )
    return sp.csc_array(sp.kron(cube + ground * sp.eye_array(n**3), np.diag([1.0, 2.0, 3.0])))


def seed_of(matrix):
    lower = sp.csc_array(sp.tril(matrix))
    lower.sort_indices()
    n = matrix.shape[0]
    members = np.arange(n).reshape(-1, 3)
    groups = Groups.from_matrix(lower.indptr, lower.indices, members, np.arange(n // 3))
    return DeflatedSeed(lower.indptr, lower.indices, groups), lower.data


def blocks(n_unknowns, width):
    """Modes that move stretches of unknowns alike, each direction apart."""
    unknown = np.arange(n_unknowns)
    column = 3 * (unknown // (3 * width)) + unknown % 3
    return sp.csc_array((np.ones(n_unknowns), (unknown, column)))


def test_solutions_are_those_of_the_matrix(monkeypatch):
    monkeypatch.setattr(module, "RESIDUAL_RATIO", 1e-12)
    matrix = springs(6)
    seed, values = seed_of(matrix)
    seed.factor(values, blocks(matrix.shape[0], 36))
    r = np.random.default_rng(3).standard_normal(matrix.shape[0])
    exact = np.linalg.solve(matrix.toarray(), r)
    np.testing.assert_allclose(seed.solve(r), exact, rtol=0, atol=1e-9 * np.abs(exact).max())
    assert seed.negative_pivots == 0


def test_a_solution_leaves_a_small_share():
    matrix = springs(8)
    seed, values = seed_of(matrix)
    seed.factor(values, blocks(matrix.shape[0], 64))
    r = np.random.default_rng(3).standard_normal(matrix.shape[0])
    assert np.linalg.norm(
        matrix @ seed.solve(r) - r
    ) <= 30.0 * module.RESIDUAL_RATIO * np.linalg.norm(r)


def test_what_the_modes_can_do_takes_no_products():
    matrix = springs(5, ground=0.01)
    modes = blocks(matrix.shape[0], 25)
    seed, values = seed_of(matrix)
    seed.factor(values, modes)
    x = modes @ np.random.default_rng(4).standard_normal(modes.shape[1])
    np.testing.assert_allclose(seed.solve(matrix @ x), x, rtol=1e-6)
    assert seed.inner[1] == 0


def test_modes_save_sweeps():
    matrix = springs(12)
    r = np.random.default_rng(5).standard_normal(matrix.shape[0])
    seed, values = seed_of(matrix)
    one = sp.csc_array(([1.0], ([0], [0])), shape=(matrix.shape[0], 1))  # of no use
    sweeps = []
    for modes in (one, blocks(matrix.shape[0], 72)):
        seed.factor(values, modes)
        before = seed.inner[0]
        seed.solve(r)
        sweeps.append(seed.inner[0] - before)
    assert sweeps[1] < 0.7 * sweeps[0]


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_negative_curvature_is_counted(share):
    # The smallest eigenvalue but those of the ground, which modes cannot make alone.
    matrix = springs(6, ground=1.0)
    smallest = np.linalg.eigvalsh(matrix.toarray())[0]
    seed, values = seed_of(matrix - share * smallest * sp.eye_array(matrix.shape[0]))
    seed.factor(values, blocks(matrix.shape[0], 36))
    x = seed.solve(np.random.default_rng(6).standard_normal(matrix.shape[0]))
    assert seed.negative_pivots == (share > 1.0)
    assert np.isfinite(x).all()
    assert np.any(x != 0.0)


def test_modes_that_are_sums_of_others_do_no_harm():
    matrix = springs(5)
    modes = blocks(matrix.shape[0], 25)
    seed, values = seed_of(matrix)
    seed.factor(values, sp.csc_array(sp.hstack([modes, modes[:, :1] + modes[:, 3:4]])))
    r = np.random.default_rng(7).standard_normal(matrix.shape[0])
    assert seed.negative_pivots == 0
    assert np.linalg.norm(
        matrix @ seed.solve(r) - r
    ) <= 30.0 * module.RESIDUAL_RATIO * np.linalg.norm(r)
