"""Orderings that are kept: matrices of one pattern are ordered once, and never get another's."""

import numpy as np
import pytest

from ancfsparse.seeds.ordering import elimination_order


def pattern(n, extra=()):
    """Lower triangle by columns of a chain, with more couplings."""
    pairs = sorted({(k, k) for k in range(n)} | {(k, k + 1) for k in range(n - 1)} | set(extra))
    columns = np.array([c for c, _ in pairs])
    rows = np.array([r for _, r in pairs], dtype=np.int32)
    return np.append(0, np.cumsum(np.bincount(columns, minlength=n))).astype(np.int64), rows


@pytest.fixture(params=[0, elimination_order.MAX_KEY_BYTES], ids=["by digest", "whole"])
def orders(request, monkeypatch):
    monkeypatch.setattr(elimination_order, "MAX_KEY_BYTES", request.param)
    made = []
    find = elimination_order._cheapest
    monkeypatch.setattr(elimination_order, "_KNOWN", {})
    monkeypatch.setattr(elimination_order, "_cheapest", lambda *args: made.append(1) or find(*args))
    return made


def test_equal_patterns_are_ordered_once(orders):
    ring = pattern(12, [(0, 11), (2, 9)])
    first = elimination_order.cheapest(*ring, 12)
    first[1][:] = first[1][::-1].copy()  # what a caller does to its own does not matter
    again = elimination_order.cheapest(*(each.copy() for each in ring), 12)
    fresh = elimination_order._cheapest(*ring, 12)
    assert len(orders) == 2
    assert again[0] == fresh[0]
    np.testing.assert_array_equal(again[1], fresh[1])
    for one, other in zip(again[2], fresh[2], strict=True):
        np.testing.assert_array_equal(one, other)


def test_other_patterns_and_other_multipliers_are_ordered_again(orders):
    chain, ring = pattern(12), pattern(12, [(0, 11)])
    for given, positive in ((chain, 12), (ring, 12), (chain, 11)):
        name, permutation, _ = elimination_order.cheapest(*given, positive)
        assert sorted(permutation) == list(range(12))
        assert name
    assert len(orders) == 3


def test_few_are_kept_and_no_large_ones(orders, monkeypatch):
    monkeypatch.setattr(elimination_order, "MAX_CACHED_UNKNOWNS", 20)
    for n in range(5, 5 + 2 * elimination_order.CACHE_SIZE):
        elimination_order.cheapest(*pattern(n), n)
        elimination_order.cheapest(*pattern(5), 5)  # in use, so kept
    assert len(elimination_order._KNOWN) == elimination_order.CACHE_SIZE
    assert len(orders) == 2 * elimination_order.CACHE_SIZE
    elimination_order.cheapest(*pattern(30), 30)
    elimination_order.cheapest(*pattern(30), 30)
    assert len(orders) == 2 * elimination_order.CACHE_SIZE + 2
