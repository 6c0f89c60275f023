"""The compiled factor L D L^T against CHOLMOD's, against the matrix itself and against NumPy."""

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given, settings, strategies as st

from ancfsparse.dispatch import compiled_module
from ancfsparse.seeds import SparseSeed
from tests.seeds.matrices import (
    assert_factors,
    chain,
    dense_factor,
    lower_csc,
    lower_laplacian,
    net,
    random_spd,
    saddle,
)

KINDS = {
    "chain": (chain, 48),
    "anywhere": (random_spd, 40),
    "saddle": (saddle, 32),
    "net": (net, 300),
}
"""How to make a matrix, and how many of its pivots are positive."""


def seed_of(a, n_positive, also=()):
    indptr, indices, _ = lower_csc(a, also)
    return SparseSeed(indptr, indices, n_positive)


@pytest.mark.parametrize("kind", KINDS)
def test_factor_is_the_one_of_cholmod(kind, rng):
    analyze = pytest.importorskip("sksparse.cholmod").analyze
    make, n_positive = KINDS[kind]
    a = make(rng)
    seed = seed_of(a, n_positive)
    assert seed.factor(lower_csc(a)[2]) == 0
    full, pivot, permutation = dense_factor(seed)
    # CHOLMOD again, asked here and not through the package, for the matrix in the order found.
    permute_upper = sp.csc_matrix(a[np.ix_(permutation, permutation)])
    cholmod = analyze(permute_upper, mode="simplicial", ordering_method="natural")
    cholmod.cholesky_inplace(permute_upper)
    lower, diagonal = cholmod.L_D()
    order = cholmod.P()
    assert (order == np.arange(len(a))).all()
    np.testing.assert_allclose(full, lower.toarray(), rtol=0, atol=1e-11)
    np.testing.assert_allclose(pivot, diagonal.diagonal(), rtol=1e-11)
    assert seed.nnz == lower.nnz - len(a)
    assert_factors(seed, a)


def test_a_chain_keeps_its_order_and_others_get_one_with_less_fill(rng):
    a = chain(rng)
    seed = seed_of(a, len(a))
    assert seed.ordering == "both ends"
    assert sorted(seed.columns()[-1]) == list(range(len(a)))
    assert seed.nnz == np.count_nonzero(np.tril(a, -1))
    # An arrow that points the wrong way fills up unless it is turned around.
    n = 30
    arrow = np.diag(np.full(n, 10.0))
    arrow[0, 1:] = arrow[1:, 0] = 1.0
    seed = seed_of(arrow, n)
    assert seed.nnz == n - 1
    assert sorted(seed.columns()[-1]) == list(range(n))
    assert seed.ordering in ("amd", "metis")
    assert seed.solve_flops == 4 * (n - 1) + 2 * n


def test_a_multiplier_comes_after_what_it_holds_and_leaves_the_stiffness_its_digits(rng):
    # As a rod at the end of a fine mesh of steel: stiff beside the mass, tiny regularization.
    n = 40
    stiff = 1e12 * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    stiff[0, 0] = stiff[-1, -1] = 1e12  # free ends: rows sum to the mass
    a = np.zeros((n + 2, n + 2))
    a[:n, :n] = stiff + np.eye(n)
    for row, place, epsilon in ((n, n - 1, 1e-22), (n + 1, 0, 1e-22)):
        a[row, place] = a[place, row] = 1.0
        a[row, row] = -epsilon
    seed = seed_of(a, n)
    place = np.argsort(seed.columns()[-1])
    assert place[n] > place[n - 1]
    assert place[n + 1] > place[0]
    assert seed.ordering == "both ends"
    assert seed.factor(lower_csc(a)[2]) == 0
    # Both ends are held and a uniform force pulls: x_i = f i (n - 1 - i) / 2 k, exactly.
    x = seed.solve(np.append(np.ones(n), [0.0, 0.0]))
    inner = np.arange(n)
    np.testing.assert_allclose(x[:n], inner * (n - 1 - inner) / 2e12, rtol=1e-9, atol=1e-20)
    np.testing.assert_allclose(x[n:], n / 2, rtol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_solve_is_numpys_and_new_values_stay_on_the_old_pattern(kind, rng):
    make, n_positive = KINDS[kind]
    a = make(rng)
    seed = seed_of(a, n_positive)
    scale = rng.uniform(0.5, 2.0, len(a))
    for k in range(4):
        assert seed.factor(lower_csc(a)[2]) == 0
        assert_factors(seed, a)
        for _ in range(3):  # more than once: work space must come back cleared
            r = rng.normal(size=len(a))
            expected = np.linalg.solve(a, r)
            size = np.abs(expected).max()
            assert np.abs(seed.solve(r) - expected).max() <= (1e-9 if k else 1e-10) * size
        a = scale[:, None] * a * scale  # a congruence keeps pattern and signs


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("width", [1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 13, 18])
def test_nodes_of_any_width(width, threads, rng):
    # Loops of known length for some, vectors with a rest for others.
    a = chain(rng, 20, width)
    indptr, indices, values = lower_csc(a)
    seed = SparseSeed(indptr, indices, len(a), threads)
    assert seed.factor(values) == 0
    assert_factors(seed, a)
    r = rng.normal(size=len(a))
    expected = np.linalg.solve(a, r)
    assert np.abs(seed.solve(r) - expected).max() <= 1e-11 * np.abs(expected).max()


@pytest.mark.parametrize("grade", [1e4, 1e8])
def test_stiff_nodes_cost_no_more_digits_than_block_elimination_must(grade, rng):
    # Axial stiffness beside bending in one node.  Demmel, Higham and Schreiber (1995): block LU of
    # a definite matrix is stable up to the root of its condition.
    scale = np.tile([grade, 1.0, np.sqrt(grade), 1.0], 12)
    a = chain(rng)
    turn = np.kron(np.eye(12), np.linalg.qr(rng.normal(size=(4, 4)))[0])
    a = turn @ (np.sqrt(scale)[:, None] * a * np.sqrt(scale)) @ turn.T
    seed = seed_of(a, len(a))
    assert seed.factor(lower_csc(a)[2]) == 0
    r = rng.normal(size=len(a))
    x = seed.solve(r)
    bound = np.finfo(float).eps * np.linalg.norm(a, 2) * np.linalg.norm(x)
    assert np.linalg.norm(a @ x - r) <= np.sqrt(grade) * bound


def test_zeros_among_the_first_values_are_places_for_later(rng):
    # A straight beam has zero couplings that fill up as it bends.
    a = chain(rng, 8)
    later = [(k, k + 5) for k in range(0, 24, 3)]
    first = a.copy()
    for i, j in later:
        first[i, j] = first[j, i] = 0.0
    seed = seed_of(first, len(a), later)
    for matrix in (first, a, first):
        assert seed.factor(lower_csc(matrix, later)[2]) == 0
        assert_factors(seed, matrix)


def test_multipliers_that_touch_nothing_at_first(rng):
    # phi_q of a quadratic constraint can have zeros at the start.
    a = saddle(rng)
    first = a.copy()
    first[32, :32] = first[:32, 32] = 0.0
    places = [(32, int(j)) for j in np.flatnonzero(a[32, :32])]
    seed = seed_of(first, 32, also=places)
    assert seed.factor(lower_csc(first, places)[2]) == 0
    assert seed.factor(lower_csc(a, places)[2]) == 0
    assert_factors(seed, a)


@pytest.mark.parametrize("where", [0, 7, 31])
def test_a_wrong_sign_is_found_and_named(where, rng):
    a = chain(rng, 8)
    seed = seed_of(a, len(a))
    stored = _entries(a)
    # One coordinate alone is pulled below zero, uncoupled: its pivot is the entry itself.
    a[_cross(len(a), where)] = 0.0
    a[where, where] = -1.0
    assert seed.factor(lower_csc(a, stored)[2]) == where + 1


@pytest.mark.parametrize("kind", KINDS)
def test_the_named_unknown_has_the_first_wrong_pivot(kind, rng):
    make, n_positive = KINDS[kind]
    a = make(rng)
    seed = seed_of(a, n_positive)
    a = a - 1.5 * np.diag(np.arange(len(a)) % 3 == 0) * np.abs(a).max()
    bad = seed.factor(lower_csc(a)[2])
    _, pivot, permutation = dense_factor(seed)
    wanted = np.where(permutation < n_positive, 1, -1)
    wrong = np.flatnonzero(pivot * wanted <= 0)
    assert bad == 1 + permutation[wrong[0]]
    # Sylvester: L D L^T of any matrix shows its inertia.
    assert (pivot < 0).sum() == (np.linalg.eigvalsh(a) < 0).sum()
    # A wrong sign is a warning, the factor is still the factor.
    r = rng.normal(size=len(a))
    expected = np.linalg.solve(a, r)
    assert np.abs(seed.solve(r) - expected).max() <= 1e-8 * np.abs(expected).max()


def test_multipliers_must_have_negative_pivots(rng):
    a = saddle(rng)
    seed = seed_of(a, 32)
    assert seed.factor(lower_csc(a)[2]) == 0
    a[35, 35] = 1e3  # a constraint block of the wrong sign
    assert seed.factor(lower_csc(a)[2]) == 36
    as_coordinates = seed_of(saddle(rng), 38)
    assert as_coordinates.factor(lower_csc(saddle(rng))[2]) != 0


@pytest.mark.parametrize("value", [np.nan, 0.0])
def test_an_unusable_pivot_is_reported_and_forgotten(value, rng):
    a = chain(rng)
    seed = seed_of(a, len(a))
    values = lower_csc(a)[2]
    for place in (0, len(a) // 2, len(a) - 1):
        # The whole row and column, so that a zero pivot is exactly zero.
        broken = lower_csc(np.where(_cross(len(a), place), value, a), _entries(a))[2]
        assert len(broken) == len(values) or np.isnan(value)
        assert seed.factor(broken) != 0
        assert seed.factor(values) == 0
        assert_factors(seed, a)


def _cross(n, place):
    at = np.arange(n) == place
    return at[:, None] | at


def _entries(a):
    return list(zip(*np.nonzero(np.tril(a)), strict=True))


@given(st.data())
@settings(deadline=None, max_examples=60, derandomize=True)
def test_any_pattern(data):
    n = data.draw(st.integers(1, 14), label="unknowns")
    n_positive = data.draw(st.integers(0, n), label="coordinates")
    pairs = data.draw(st.sets(st.tuples(st.integers(0, n - 1), st.integers(0, n - 1))))
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1), label="seed"))
    a = np.zeros((n, n))
    for i, j in sorted(pairs):
        a[i, j] = a[j, i] = rng.choice([0.0, rng.normal()])
    # Dominant blocks on the diagonal make it quasi-definite: any order of elimination works.
    sign = np.where(np.arange(n) < n_positive, 1.0, -1.0)
    np.fill_diagonal(a, sign * (np.abs(a).sum(axis=1) + 0.5))
    seed = seed_of(a, n_positive, also=pairs)
    values = lower_csc(a, pairs)[2]
    assert seed.factor(values) == 0
    assert_factors(seed, a)
    r = rng.normal(size=n)
    np.testing.assert_allclose(seed.solve(r), np.linalg.solve(a, r), rtol=1e-9, atol=1e-11)


def test_cholmod_factors_where_dense_blocks_pay():
    pytest.importorskip("sksparse.cholmod")
    lower = lower_laplacian(40, 3, ground=0.1)
    seed = SparseSeed(lower.indptr, lower.indices, lower.shape[0])
    assert seed.supernodal
    whole = lower + sp.tril(lower, -1).T
    r = np.random.default_rng(7).normal(size=seed.n)
    assert seed.factor(lower.data) == 0
    np.testing.assert_allclose(whole @ seed.solve(r), r, rtol=0, atol=1e-11)
    # An indefinite matrix is not refused: our own factor takes it and names a wrong pivot.
    shifted = lower.copy()
    shifted.data[lower.indptr[:-1]] -= 0.15  # past the lowest eigenvalue, 0.118; more costs digits
    assert seed.factor(shifted.data) > 0
    np.testing.assert_allclose(
        (whole - 0.15 * sp.eye_array(seed.n)) @ seed.solve(r), r, rtol=0, atol=1e-9
    )
    assert seed.factor(lower.data) == 0
    np.testing.assert_allclose(whole @ seed.solve(r), r, rtol=0, atol=1e-11)


def test_an_exception_in_cholmod_reaches_the_caller(monkeypatch):
    pytest.importorskip("sksparse.cholmod")
    lower = lower_laplacian(40, 3, ground=0.1)
    seed = SparseSeed(lower.indptr, lower.indices, lower.shape[0])
    inverse = compiled_module("limited").Limited(seed, "broyden", 0)

    def fail(_):
        raise MemoryError("no room")

    monkeypatch.setattr(seed, "solve", fail)
    assert np.isnan(inverse.apply(np.ones(seed.n))).all()
    assert isinstance(seed.error, MemoryError)
