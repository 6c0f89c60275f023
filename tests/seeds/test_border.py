"""Equations beside an incomplete factor: held in every solve, and solutions those of NumPy."""

import numpy as np
import pytest

from ancfsparse.seeds import Groups, IncompleteSeed
from ancfsparse.seeds.incomplete.constraint_border import Border
from ancfsparse.seeds.interface.index_arrays import leading
from ancfsparse.seeds.ordering import unknown_groups as groups_module
from tests.seeds.matrices import lower_csc, net

SIDE = 12
N = 3 * SIDE * SIDE


def held(rng, m=5, epsilon=1e-9, repeat=False):
    """A net whose nodes are tied by m equations of four coordinates each."""
    a = np.zeros((N + m, N + m))
    a[:N, :N] = net(rng, SIDE)
    for k in range(N, N + m):
        where = rng.choice(N, 4, replace=False)
        a[k, where] = a[where, k] = rng.normal(size=4)
    if repeat:
        a[N + m - 1] = a[N]
        a[:, N + m - 1] = a[:, N]
    a[N:, N:] = -epsilon * np.eye(m)
    return a


def seed_of(a, threads=1):
    indptr, indices, values = lower_csc(a)
    own = leading(indptr, indices, N)
    groups = Groups.from_matrix(*own, np.arange(N).reshape(-1, 3), np.arange(N // 3))
    return IncompleteSeed(indptr, indices, groups, threads), values


def test_the_pattern_of_the_first_unknowns_is_theirs(rng):
    a = held(rng)
    indptr, indices, _ = lower_csc(a)
    expected = lower_csc(a[:N, :N])
    for found, there in zip(leading(indptr, indices, N), expected, strict=False):
        np.testing.assert_array_equal(found, there)


@pytest.mark.parametrize("unit", [1.0, 1e-12, 1e9])
def test_solve_is_numpys_whatever_the_units_of_equations(unit, rng):
    a = held(rng, epsilon=1e-3)
    a[N:] *= unit
    a[:, N:] *= unit
    seed, values = seed_of(a)
    assert (seed.n, seed.n_positive) == (N + 5, N)
    assert seed.factor(values) == 0
    r = rng.normal(size=N + 5)
    r[N:] *= unit
    expected = np.linalg.solve(a, r)
    found = seed.solve(r)
    for part in (slice(N), slice(N, None)):
        error = np.abs(found[part] - expected[part]).max()
        assert error <= 1e-9 * np.abs(expected[part]).max()


@pytest.mark.parametrize("forced", [True, False])
@pytest.mark.parametrize("sweeps", [True, False])
def test_a_correction_of_any_kind_holds_the_equations(sweeps, forced, rng):
    a = held(rng)
    seed, values = seed_of(a)
    assert seed.factor(values) == 0
    r = rng.normal(size=N + 5)
    if not forced:
        r[N:] = 0.0
    seed.own.solve(r)
    assert seed.own.plain
    if not sweeps:
        assert seed.own.refine(0.1)
    before = seed.own.sweeps
    x = seed.own.solve(r)
    assert (seed.own.sweeps == before + 2) == sweeps
    off = a[N:] @ x - r[N:]
    assert np.abs(off).max() <= 1e-5 * np.abs(a[N:]).max() * np.abs(x[:N]).max()


def test_conjugate_gradients_leave_the_share_that_is_asked_for(rng):
    a = held(rng)
    seed, values = seed_of(a)
    assert seed.factor(values) == 0
    r = rng.normal(size=N + 5)
    exact = np.linalg.solve(a, r)
    errors, rounds = zip(
        *(
            (np.abs(x - exact)[:N].max() / np.abs(exact[:N]).max(), k)
            for x, k in (seed.own.solve_to(r, share, 200) for share in (0.1, 1e-2, 1e-3, 1e-4))
        ),
        strict=True,
    )
    assert errors[0] < 0.3
    assert errors[-1] < 1e-3
    assert list(rounds) == sorted(rounds)
    assert rounds[-1] < 40


def test_of_equations_that_repeat_one_another_one_is_enough(rng):
    a = held(rng, repeat=True)
    seed, values = seed_of(a)
    assert seed.factor(values) == 0
    r = rng.normal(size=N + 5)
    r[-1] = r[N]
    expected = np.linalg.solve(a, r)
    found = seed.own.solve_to(r, 1e-5, 200)[0]
    assert np.abs(found - expected)[:N].max() <= 1e-4 * np.abs(expected[:N]).max()
    assert found[-1] == 0.0


def test_threads_do_not_change_a_digit_with_equations(rng, monkeypatch):
    monkeypatch.setattr(groups_module, "MIN_TWO_FRONTS", 2)
    monkeypatch.setattr(groups_module, "MIN_CYCLES", 1e-9)
    a, r, found = held(rng), rng.normal(size=N + 5), []
    for threads in (1, 2):
        seed, values = seed_of(a, threads)
        assert seed.threads == threads
        assert seed.factor(values) == 0
        found.append([seed.own.solve(r), *seed.own.solve_to(r, 1e-4, 99)])
    for one, two in zip(*found, strict=True):
        assert np.array_equal(one, two)


def test_equations_cost_sweeps_and_little_memory(rng):
    a = held(rng)
    with_equations, _ = seed_of(a)
    indptr, indices, _ = lower_csc(a[:N, :N])
    groups = Groups.from_matrix(indptr, indices, np.arange(N).reshape(-1, 3), np.arange(N // 3))
    without = IncompleteSeed(indptr, indices, groups)
    assert with_equations.nnz == without.nnz
    assert with_equations.solve_flops == 2 * without.solve_flops
    assert with_equations.factor_flops == without.factor_flops + 5 * without.solve_flops
    # 24 bytes for each of 20 terms, and their entries and those of E in the pattern; S is dense.
    assert with_equations.nbytes - without.nbytes == 24 * 20 + 4 * 25 + 8 * 5**2
    border = Border.from_matrix(*lower_csc(a)[:2], N, np.arange(N).reshape(-1, 3))
    np.testing.assert_array_equal(border.first, 4 * np.arange(6))
    assert len(border.own) == 5


def test_equations_that_are_no_numbers_give_none(rng):
    a = held(rng)
    seed, values = seed_of(a)
    broken = values.copy()
    broken[0] = np.nan
    assert seed.own.factor(broken) > 0
    assert not seed.own.mend(broken)
    assert np.isnan(seed.own.solve(np.ones(N + 5))[:N]).all()
    assert seed.own.factor(values) == 0
    assert np.isfinite(seed.own.solve(np.ones(N + 5))).all()
