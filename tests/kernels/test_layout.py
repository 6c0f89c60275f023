"""Blocks: any number of elements, padding, shared parameters, and the same answer on every set."""

import numpy as np
import pytest

from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import InputError
from ancfsparse.instruction_sets import REQUIRED_FLAGS
from ancfsparse.kernels.catalog import element_kind
from ancfsparse.kernels.layout import pack
from tests.instruction_sets import require
from tests.kernels.bench import VALUES
from tests.kernels.reference_energies import ENERGIES
from tests.kernels.states import STATES
from tests.operations import operations


@pytest.mark.parametrize("name", ENERGIES)
@pytest.mark.parametrize("instruction_set", REQUIRED_FLAGS)
def test_instruction_sets_agree(name, instruction_set, bench, rng):
    narrowest = next(iter(REQUIRED_FLAGS))
    require(narrowest, instruction_set)
    baseline, element = bench(name, narrowest), bench(name, instruction_set)
    states = [STATES["uneven stretch"](element.labels, VALUES["length"], rng) for _ in range(11)]
    q, a = np.array(states), rng.normal(size=(11, element.n))
    for kernel in element.kind.kernels:
        expected = baseline.run(kernel, q, a)
        found = element.run(kernel, q, a)
        assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max()


@pytest.mark.parametrize("extra", [-1, 0, 1, "one"])
def test_any_number_of_elements_fits(extra, bench, rng):
    element = bench("thin_spatial_green")
    n = 1 if extra == "one" else element.kind.lanes + extra
    q = np.array([STATES["uneven stretch"](element.labels, 0.7, rng) for _ in range(n)])
    base = rng.uniform(0.5, 2.0, size=(n, len(element.kind.parameters)))
    together = element.run("force", q, base=base)
    alone = [element.run("force", q[i], base=base[i : i + 1])[0] for i in range(n)]
    np.testing.assert_array_equal(together, alone)


@pytest.mark.parametrize("name", ENERGIES)
def test_padding_adds_exact_zeros(name, bench, rng):
    """An element with every parameter zero except its length adds nothing at all."""
    element = bench(name)
    q, a = rng.normal(size=(2, 3, element.n))
    base = np.array([[0.7 * (p == "length") for p in element.kind.parameters]] * 3)
    for kernel in element.kind.kernels:
        assert not element.run(kernel, q, a, base=base).any()


def test_padding_repeats_the_last_element():
    kind = element_kind("l2t2", 2)
    base = np.full((1, 4), 2.0)
    layout = pack(kind, np.arange(8)[None], np.arange(8)[None], base)
    assert layout.gather.shape == layout.scatter.shape == (1, 8, kind.lanes)
    assert (layout.gather == np.arange(8)[None, :, None]).all()
    expected = kind.prepare(np.array([[2.0, 2, 2, 2]] + [[2.0, 0, 0, 0]] * (kind.lanes - 1)))
    np.testing.assert_array_equal(layout.parameters[0], expected.T)


def test_equal_parameters_are_stored_once():
    kind = element_kind("l2t2", 2)
    n = 10 * kind.lanes
    base = np.ones((n, 4))
    base[5 * kind.lanes : 6 * kind.lanes] = 2.0
    places = np.zeros((n, 8), dtype=int)
    layout = pack(kind, places, places, base)
    assert len(layout.parameters) == 2
    sets = np.where(layout.set_of < 0, ~layout.set_of, layout.set_of)
    by_block = layout.parameters[sets]
    np.testing.assert_array_equal(by_block[5], np.broadcast_to(
        kind.prepare(np.full((1, 4), 2.0)).T, by_block[5].shape))  # fmt: skip
    others = np.delete(sets, 5)
    assert (others == others[0]).all()


def test_neighbours_in_one_block_add_to_their_shared_node(rng):
    """A chain: elements of one block write to the same places."""
    kind = element_kind("thin", 2)
    call = compiled_module("kernel_call").call
    n = 2 * kind.lanes + 1
    places = np.arange(n)[:, None] * 4 + np.arange(8)
    q = rng.normal(size=4 * (n + 1))
    base = np.tile([VALUES[p] for p in kind.parameters], (n, 1))
    layout = pack(kind, places, places, base)
    out = np.zeros_like(q)
    call(kind.kernels["force"], layout.gather, layout.scatter, layout.set_of, layout.parameters,
         q, q, out)  # fmt: skip
    expected = np.zeros_like(q)
    for row in places:
        one = pack(kind, np.arange(8)[None], np.arange(8)[None], base[:1])
        part = np.zeros(8)
        local = np.ascontiguousarray(q[row])
        call(kind.kernels["force"], one.gather, one.scatter, one.set_of, one.parameters,
             local, local, part)  # fmt: skip
        expected[row] += part
    np.testing.assert_allclose(out, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


def test_chains_are_marked_and_nothing_else():
    kind = element_kind("thin", 2)
    if kind.lanes == 1:
        pytest.skip("one lane has no neighbour")
    n = 3 * kind.lanes
    places = np.arange(n)[:, None] * 4 + np.arange(8)
    places[kind.lanes + 1 :] += 4  # a gap inside the second block
    base = np.ones((n, len(kind.parameters)))
    np.testing.assert_array_equal(pack(kind, places, places, base).set_of < 0, [True, False, True])
    # A scatter of as many numbers as coordinates must be a chain too.
    apart = np.arange(8 * n).reshape(n, 8)
    assert (pack(kind, places, apart, base).set_of >= 0).all()


def test_no_elements_make_no_blocks():
    kind = element_kind("l2t2", 2)
    empty = np.zeros((0, 8), dtype=int)
    layout = pack(kind, empty, empty, np.zeros((0, 4)))
    assert len(layout.set_of) == 0
    out = np.zeros(1)
    compiled_module("kernel_call").call(
        kind.kernels["force"], layout.gather, layout.scatter, layout.set_of, layout.parameters,
        out, out, out,
    )  # fmt: skip
    assert out[0] == 0


def test_packing_has_no_loop_over_elements(rng):
    kind = element_kind("thin", 2)

    def cost(n):
        places = np.arange(n)[:, None] * 4 + np.arange(8)
        base = rng.uniform(1, 2, size=(n, 4))
        return operations(lambda: pack(kind, places, places, base))

    _, few, many = (cost(n) for n in (10, 100, 10_000))
    assert many < 1.1 * few


@pytest.mark.parametrize(
    ("places", "base", "words"),
    [
        (np.zeros((2, 8)), np.ones((2, 4)), "whole numbers"),
        (-np.ones((2, 8), dtype=int), np.ones((2, 4)), "between 0 and"),
        (np.zeros((2, 8), dtype=int), np.ones((2, 3)), r"shape \(2, 4\), not \(2, 3\)"),
        (np.zeros((2, 8), dtype=int), np.zeros((2, 4)), "Element 0 has length 0"),
    ],
)
def test_tables_that_do_not_fit_are_refused(places, base, words):
    with pytest.raises(InputError, match=words):
        pack(element_kind("l2t2", 2), places, np.zeros((2, 8), dtype=int), base)


def expanded(layout, name, base):
    """The tables of every block as `pack` made them."""
    tables = getattr(layout, name)
    if not len(layout.table_of):
        return tables
    return tables[layout.table_of] + getattr(layout, base)[:, None, None]


def test_blocks_of_a_chain_share_tables():
    kind = element_kind("l2t2", 2)
    n = 300 * kind.lanes + 1
    places = 4 * np.arange(n)[:, None] + np.arange(8)
    places[0, :2] = 4 * n + 4 + np.arange(2)  # held, and so at the end
    scatter = 26 * np.arange(n)[:, None] + np.arange(36)
    scatter[0, 5] = 26 * n + 36  # the bin
    layout = pack(kind, places, scatter, np.full((n, 4), 2.0))
    packed = layout.compress()
    assert len(packed.gather) == len(packed.scatter) == 3  # the first, the last and the others
    assert packed.nbytes < 0.1 * layout.nbytes
    whole = pack(kind, places, scatter, np.full((n, 4), 2.0))
    np.testing.assert_array_equal(expanded(packed, "gather", "base"), whole.gather)
    np.testing.assert_array_equal(expanded(packed, "scatter", "scatter_base"), whole.scatter)


def test_blocks_that_differ_keep_their_tables(rng):
    kind = element_kind("l2t2", 2)
    n = 300 * kind.lanes
    places, scatter = rng.integers(0, 10**6, (n, 8)), rng.integers(0, 10**6, (n, 36))
    whole = pack(kind, places, scatter, np.full((n, 4), 2.0))
    same = pack(kind, places, scatter, np.full((n, 4), 2.0)).compress()
    assert len(same.table_of) == 0
    np.testing.assert_array_equal(same.gather, whole.gather)
    np.testing.assert_array_equal(same.scatter, whole.scatter)
