"""Conjugate gradients with coarse modes: right solutions, few sweeps, and signs of the matrix."""

import numpy as np
import pytest
import scipy.sparse as sp

from ancfsparse.seeds import DeflatedSeed, Groups
from ancfsparse.seeds.incomplete import deflated_gradients as module
from tests.seeds.matrices import on_grid


def springs(n, ground=1e-6):
    """A cube of masses in three directions on springs, hardly tied to the ground."""
    line = sp.diags_array([[-1.0] * (n - 1), [2.0] * n, [-1.0] * (n - 1)], offsets=[-1, 0, 1])
    line = line.tolil()
    line[0, 0] = line[n - 1, n - 1] = 1.0
    cube = on_grid(line, 3) + ground * sp.eye_array(n**3)
    return sp.csc_array(sp.kron(cube, np.diag([1.0, 2.0, 3.0])))


def factored(matrix, modes):
    """Return a seed of a matrix with coarse modes, and its values."""
    lower = sp.csc_array(sp.tril(matrix))
    lower.sort_indices()
    n = matrix.shape[0]
    members = np.arange(n).reshape(-1, 3)
    groups = Groups.from_matrix(lower.indptr, lower.indices, members, np.arange(n // 3))
    seed = DeflatedSeed(lower.indptr, lower.indices, groups)
    seed.factor(lower.data, modes)
    return seed


def assert_small_rest(matrix, seed, r):
    rest = np.linalg.norm(matrix @ seed.solve(r) - r)
    assert rest <= 30.0 * module.RESIDUAL_RATIO * np.linalg.norm(r)


def blocks(n_unknowns, width):
    """Modes that move stretches of unknowns alike, each direction apart."""
    unknown = np.arange(n_unknowns)
    column = 3 * (unknown // (3 * width)) + unknown % 3
    return sp.csc_array((np.ones(n_unknowns), (unknown, column)))


def test_solutions_are_those_of_the_matrix(monkeypatch):
    monkeypatch.setattr(module, "RESIDUAL_RATIO", 1e-12)
    matrix = springs(6)
    seed = factored(matrix, blocks(matrix.shape[0], 36))
    r = np.random.default_rng(3).standard_normal(matrix.shape[0])
    exact = np.linalg.solve(matrix.toarray(), r)
    np.testing.assert_allclose(seed.solve(r), exact, rtol=0, atol=1e-9 * np.abs(exact).max())
    assert seed.negative_pivots == 0


def test_a_solution_leaves_a_small_share(rng):
    matrix = springs(8)
    seed = factored(matrix, blocks(matrix.shape[0], 64))
    assert_small_rest(matrix, seed, rng.standard_normal(matrix.shape[0]))


def test_what_the_modes_can_do_takes_no_products():
    matrix = springs(5, ground=0.01)
    modes = blocks(matrix.shape[0], 25)
    seed = factored(matrix, modes)
    x = modes @ np.random.default_rng(4).standard_normal(modes.shape[1])
    np.testing.assert_allclose(seed.solve(matrix @ x), x, rtol=1e-6)
    assert seed.inner[1] == 0


def test_modes_save_sweeps(rng):
    matrix = springs(12)
    r = rng.standard_normal(matrix.shape[0])
    one = sp.csc_array(([1.0], ([0], [0])), shape=(matrix.shape[0], 1))  # of no use
    sweeps = []
    for modes in (one, blocks(matrix.shape[0], 72)):
        seed = factored(matrix, modes)
        seed.solve(r)
        sweeps.append(seed.inner[0])
    assert sweeps[1] < 0.7 * sweeps[0]


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_negative_curvature_is_counted(share):
    # The smallest eigenvalue but those of the ground, which modes cannot make alone.
    matrix = springs(6, ground=1.0)
    smallest = np.linalg.eigvalsh(matrix.toarray())[0]
    shifted = matrix - share * smallest * sp.eye_array(matrix.shape[0])
    seed = factored(shifted, blocks(matrix.shape[0], 36))
    x = seed.solve(np.random.default_rng(6).standard_normal(matrix.shape[0]))
    assert seed.negative_pivots == (share > 1.0)
    assert np.isfinite(x).all()
    assert np.any(x != 0.0)


def test_modes_that_are_sums_of_others_do_no_harm(rng):
    matrix = springs(5)
    modes = blocks(matrix.shape[0], 25)
    seed = factored(matrix, sp.csc_array(sp.hstack([modes, modes[:, :1] + modes[:, 3:4]])))
    assert seed.negative_pivots == 0
    assert_small_rest(matrix, seed, rng.standard_normal(matrix.shape[0]))
