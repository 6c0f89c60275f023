"""The incomplete factor against one in NumPy, on trees against the inverse, and its solves."""

import numpy as np
import pytest

from ancfsparse.errors import InputError
from ancfsparse.seeds import Groups, IncompleteSeed
from ancfsparse.seeds.ordering import unknown_groups as groups_module
from tests.grids import grid
from tests.seeds.matrices import lower_csc

ROUNDING = 2.0**-24
"""Of a number in single precision (IEEE 754)."""


def coupled(rng, n, edges, width=3, weight=0.5):
    """Positive definite matrix of n groups of unknowns, of which some meet; and the groups."""
    a = weight * np.eye(n * width)
    for i, j in edges:
        ends = np.concatenate([width * e + np.arange(width) for e in (i, j)])
        factor = rng.normal(size=(2 * width, 2 * width))
        a[np.ix_(ends, ends)] += factor @ factor.T
    groups = np.full((n, 3), -1)
    groups[:, :width] = np.arange(n * width).reshape(n, width)
    return a, groups


def springs(rng, n, edges, weight):
    """Springs between points in space, which hardly anything holds; and the groups."""
    a = weight * np.eye(3 * n)
    for i, j in edges:
        ends = np.concatenate([3 * e + np.arange(3) for e in (i, j)])
        factor = rng.normal(size=(3, 3))
        a[np.ix_(ends, ends)] += np.kron([[1.0, -1.0], [-1.0, 1.0]], factor @ factor.T)
    return a, np.arange(3 * n).reshape(n, 3)


def tree(rng, n):
    return [(int(rng.integers(k)), k) for k in range(1, n)]


def seed_of(a, groups, node=None):
    indptr, indices, values = lower_csc(a)
    node = np.arange(len(groups)) if node is None else node
    return IncompleteSeed(
        indptr, indices, Groups.from_matrix(indptr, indices, groups, node)
    ), values


def inverse_of(seed):
    """What a sweep multiplies by, column by column."""
    return np.column_stack([seed.own.sweep(unit) for unit in np.eye(seed.n)])


def blocks_of(seed, a):
    """The matrix and the seed's own factor as arrays of blocks, in its order and scale."""
    unknown, start, row, blocks, scale = seed.own.columns()
    n = len(unknown)
    whole = np.zeros((n, n, 3, 3))
    for i in range(n):
        for j in range(n):
            for k, p in enumerate(unknown[i]):
                for m, q in enumerate(unknown[j]):
                    if p >= 0 and q >= 0:
                        whole[i, j, k, m] = a[p, q] * scale[p] * scale[q]
                    elif i == j and k == m:
                        whole[i, j, k, m] = 1.0
    lower = np.zeros((n, n, 3, 3))
    for j in range(n):
        for b in range(start[j], start[j + 1]):
            lower[row[b], j] = blocks[n + b]
    return whole, blocks[:n], lower


def by_the_book(whole):
    """Cholesky in blocks without fill, written down as it is defined."""
    a, n = whole.copy(), len(whole)
    kept = np.abs(whole).max(axis=(2, 3)) > 0.0
    pivots, lower = np.zeros((n, 3, 3)), np.zeros_like(a)
    for j in range(n):
        pivots[j] = np.linalg.inv(a[j, j])
        below = [i for i in range(j + 1, n) if kept[i, j]]
        for i in below:
            lower[i, j] = a[i, j] @ pivots[j]
        for i in below:
            for k in below:
                if kept[i, k]:
                    a[i, k] -= lower[i, j] @ a[k, j].T
    return pivots, lower


def two_fronts(monkeypatch):
    """Divide factors however small they are."""
    monkeypatch.setattr(groups_module, "MIN_TWO_FRONTS", 2)
    monkeypatch.setattr(groups_module, "MIN_CYCLES", 1e-9)  # all but trees


@pytest.mark.parametrize("fronts", [1, 2])
@pytest.mark.parametrize("width", [1, 2, 3])
def test_factor_is_cholesky_without_fill(width, fronts, rng, monkeypatch):
    if fronts == 2:
        two_fronts(monkeypatch)
    a, groups = coupled(rng, 49, grid(7)[1], width, 3.0)
    seed, values = seed_of(a, groups)
    assert seed.factor(values) == 0
    whole, pivots, lower = blocks_of(seed, a)
    expected = by_the_book(whole)
    assert np.abs(pivots - expected[0]).max() <= 2.0 * ROUNDING * np.abs(expected[0]).max()
    assert np.abs(lower - expected[1]).max() <= 2.0 * ROUNDING * np.abs(expected[1]).max()
    # Something was dropped, or this would be no test of it.
    exact = np.linalg.inv(a)
    assert np.abs(inverse_of(seed) - exact).max() > 1e-3 * np.abs(exact).max()
    r = rng.normal(size=len(a))
    np.testing.assert_allclose(seed.solve(r), exact @ r, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("width", [1, 2, 3])
@pytest.mark.parametrize("kind", ["chain", "tree", "trees"])
def test_nothing_is_dropped_on_trees(kind, width, rng):
    n = 40
    edges = [(k, k + 1) for k in range(n - 1)] if kind == "chain" else tree(rng, n)
    edges = edges[: n // 2] + edges[n // 2 + 1 :] if kind == "trees" else edges
    a, groups = coupled(rng, n, edges, width)
    order = rng.permutation(n)  # whatever the order of the groups
    seed, values = seed_of(a, groups[order])
    assert seed.factor(values) == 0
    exact = np.linalg.inv(a)
    assert np.abs(inverse_of(seed) - exact).max() <= 1e-4 * np.abs(exact).max()


def test_a_sweep_is_symmetric_and_positive(rng):
    a, groups = coupled(rng, 25, grid(5)[1])
    seed, values = seed_of(a, groups)
    assert seed.factor(values) == 0
    h = inverse_of(seed)
    assert np.abs(h - h.T).max() <= 2.0 * ROUNDING * np.abs(h).max()
    assert np.linalg.eigvalsh(h).min() > 0.0


@pytest.mark.parametrize("unit", [1.0, 1e-25, 1e25])
def test_solve_is_numpys_whatever_the_units(unit, rng):
    a, groups = coupled(rng, 49, grid(7)[1])
    d = 10.0 ** rng.uniform(-6, 6, len(a))  # each unknown in a unit of its own
    seed, values = seed_of(unit * d[:, None] * a * d, groups)
    assert seed.factor(values) == 0
    r = rng.normal(size=len(a)) * d
    x = seed.solve(r) * d * unit
    expected = np.linalg.solve(a, r / d)
    assert np.abs(x - expected).max() <= 1e-10 * np.abs(expected).max()


@pytest.mark.parametrize("size", [1e-150, 1e-30, 1e30, 1e150])
def test_residuals_of_any_size_fit_single_precision(size, rng):
    a, groups = coupled(rng, 400, grid(20)[1])
    seed, values = seed_of(a, groups)
    assert seed.factor(values) == 0
    r = rng.normal(size=len(a))
    r[:1000] *= 1e-12  # some unknowns tell the size of all
    expected = seed.own.sweep(r)
    assert np.abs(seed.own.sweep(size * r) - size * expected).max() <= (
        1e-5 * size * np.abs(expected).max()
    )
    r[:] = 0.0
    assert not seed.own.sweep(r).any()
    r[1] = size  # which is none of those that are looked at first
    assert seed.own.sweep(r)[1] > 0.0


def test_unknowns_that_are_held_leave_their_places_free(rng):
    a, groups = coupled(rng, 16, grid(4)[1])
    held = np.array([0, 1, 2, 7, 20, 30, 31])  # a whole group, and some of others
    free = np.setdiff1d(np.arange(len(a)), held)
    number = np.full(len(a), -1)
    number[free] = np.arange(len(free))
    triples = number[groups]
    triples = triples[(triples >= 0).any(axis=1)]
    a = a[np.ix_(free, free)]
    seed, values = seed_of(a, triples)
    assert seed.factor(values) == 0
    r = rng.normal(size=len(a))
    np.testing.assert_allclose(seed.solve(r), np.linalg.solve(a, r), rtol=1e-10, atol=1e-12)


def test_members_of_a_node_come_one_after_the_other_in_their_order(rng):
    a, groups = coupled(rng, 36, grid(6)[1])
    node = np.repeat(np.arange(12), 3)
    seed, values = seed_of(a, groups, node)
    assert seed.factor(values) == 0
    order = seed.own.columns()[0][:, 0] // 3
    assert (node[order].reshape(12, 3) == node[order][::3, None]).all()
    assert (np.diff(order.reshape(12, 3), axis=1) == 1).all()


def test_a_share_is_kept_and_a_first_solve_decides(rng):
    a, groups = springs(rng, 100, grid(10)[1], 1e-3)
    seed, values = seed_of(a, groups)
    assert seed.factor(values) == 0
    r = rng.normal(size=len(a))
    h = inverse_of(seed)

    def left(x):
        rest = r - a @ x
        return np.sqrt(rest @ h @ rest / (r @ h @ r))

    assert left(seed.own.solve(r)) <= 0.1
    assert not seed.own.plain  # so hard a matrix takes more than three sweeps
    assert not seed.own.refine(0.1)
    assert seed.own.refine(1e-3)
    assert left(seed.own.solve(r)) <= 1.1e-3
    # Beside a large diagonal one sweep is enough, until something else is asked for.
    easy = a + 50.0 * np.eye(len(a))
    assert seed.factor(lower_csc(easy)[2]) == 0
    seed.own.solve(r)
    assert seed.own.plain
    before = seed.own.sweeps
    seed.own.solve(r)
    assert seed.own.sweeps == before + 1
    assert seed.own.refine(0.1)
    assert not seed.own.plain
    assert not seed.own.refine(0.1)


def test_what_breaks_down_gets_a_larger_diagonal(rng):
    a, groups = coupled(rng, 36, grid(6)[1], weight=0.5)
    indefinite = a - 1.2 * np.linalg.eigvalsh(a).min() * np.eye(len(a)) - 2.0 * np.eye(len(a))
    assert np.linalg.eigvalsh(indefinite).min() < 0.0
    seed, values = seed_of(indefinite, groups)
    assert seed.own.factor(values) > 0
    assert np.isnan(seed.own.solve(np.ones(len(a)))).all()  # no factor, no numbers
    assert seed.own.mend(values)
    assert np.isfinite(seed.own.solve(np.ones(len(a)))).all()
    assert np.linalg.eigvalsh(inverse_of(seed)).min() > 0.0


def test_what_is_no_number_is_not_mended(rng):
    a, groups = coupled(rng, 16, grid(4)[1])
    seed, values = seed_of(a, groups)
    values[5] = np.nan
    assert seed.own.factor(values) > 0
    assert not seed.own.mend(values)
    assert np.isnan(seed.own.solve(np.ones(len(a)))).all()


def test_too_many_blocks_are_refused(rng, monkeypatch):
    a, groups = coupled(rng, 16, grid(4)[1])
    monkeypatch.setattr("ancfsparse.seeds.incomplete.incomplete_seed.MAX_BLOCKS", 30)
    with pytest.raises(InputError, match="at most 30 blocks, and this one would have 41"):
        seed_of(a, groups)


def test_two_fronts_meet_in_the_middle_alone(rng, monkeypatch):
    two_fronts(monkeypatch)
    components = [grid(8)[1] + 64 * k for k in range(3)]  # the cut is inside the second
    a, groups = coupled(rng, 192, np.concatenate(components), 3, 3.0)
    indptr, indices, _ = lower_csc(a)
    order, first = Groups.from_matrix(indptr, indices, groups, np.arange(192)).fronts()
    assert sorted(order) == list(range(192))
    part = np.empty(192, dtype=int)
    part[order] = np.repeat([0, 1, 2], np.diff(first))
    assert first[0] == 0
    assert first[3] == 192
    assert np.diff(first).min() > 0
    assert first[3] - first[2] < 20
    for i, j in np.concatenate(components):
        assert {part[i], part[j]} != {0, 1}


def test_threads_do_not_change_a_digit(rng, monkeypatch):
    two_fronts(monkeypatch)
    a, groups = springs(rng, 400, grid(20)[1], 1e-3)
    indptr, indices, values = lower_csc(a)
    made = Groups.from_matrix(indptr, indices, groups, np.arange(400))
    r, found = rng.normal(size=len(a)), []
    for threads in (1, 2):
        seed = IncompleteSeed(indptr, indices, made, threads)
        assert seed.threads == threads
        assert seed.factor(values) == 0
        solutions = seed.own.sweep(r), seed.own.solve(r), *seed.own.solve_to(r, 1e-4, 99)
        found.append([seed.own.columns()[3], *solutions])
    for one, two in zip(*found, strict=True):
        assert np.array_equal(one, two)


def test_what_is_small_or_a_tree_is_one_front(rng, monkeypatch):
    a, groups = coupled(rng, 36, grid(6)[1])
    indptr, indices, _ = lower_csc(a)
    made = Groups.from_matrix(indptr, indices, groups, np.arange(36))
    assert made.fronts()[1] == (0, 36, 36, 36)
    assert IncompleteSeed(indptr, indices, made, 2).threads == 1
    two_fronts(monkeypatch)
    assert IncompleteSeed(indptr, indices, made, 2).threads == 2
    a, groups = coupled(rng, 40, tree(rng, 40))
    indptr, indices, _ = lower_csc(a)
    made = Groups.from_matrix(indptr, indices, groups, np.arange(40))
    assert IncompleteSeed(indptr, indices, made, 2).threads == 1


@pytest.mark.parametrize(("dim", "side", "parts"), [(2, 9, 1), (3, 8, 3)])
def test_nets_are_eliminated_in_one_front_and_lattices_in_two(rng, monkeypatch, dim, side, parts):
    # In nets two fronts take more than twice the sweeps.
    monkeypatch.setattr(groups_module, "MIN_TWO_FRONTS", 2)
    number = np.arange(side**dim).reshape((side,) * dim)
    edges = [
        np.stack(
            [number.take(range(side - 1), k).ravel(), number.take(range(1, side), k).ravel()], 1
        )
        for k in range(dim)
    ]
    a, groups = coupled(rng, side**dim, np.concatenate(edges), 3, 3.0)
    indptr, indices, _ = lower_csc(a)
    _, first = Groups.from_matrix(indptr, indices, groups, np.arange(side**dim)).fronts()
    assert np.count_nonzero(np.diff(first)) == parts
