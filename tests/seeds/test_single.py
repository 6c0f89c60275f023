"""The factor rounded to single precision: how far off it is, and when runs keep such seeds."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import chain as cable, elastic_four_bar, pendulum
from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.complete import sparse_seed
from tests.seeds.matrices import chain, lower_csc, net, random_spd, saddle

ROUNDING = 2.0**-24
"""Of a number in single precision (IEEE 754)."""

WIDTHS = [1, 3, 4, 5, 6, 9, 12, 13]


def cases():
    yield from ((f"chain of {w}", lambda rng, w=w: chain(rng, 20, w), None) for w in WIDTHS)
    yield "anywhere", random_spd, None
    yield "net", lambda rng: net(rng, 12), None
    yield "saddle", saddle, 32


CASES = {name: (make, n_positive) for name, make, n_positive in cases()}


@pytest.fixture
def always_single(monkeypatch):
    monkeypatch.setattr(sparse_seed, "MIN_SINGLE_BYTES", 0.0)


def factored(name, threads, rng):
    make, n_positive = CASES[name]
    a = make(rng)
    indptr, indices, values = lower_csc(a)
    seed = SparseSeed(indptr, indices, n_positive or len(a), threads)
    assert seed.factor(values) == 0
    return a, values, seed


@pytest.mark.parametrize("name", CASES)
def test_the_inverse_is_that_of_the_factor(name, rng):
    """Four columns at a time, of which the parts before their diagonal follow by symmetry."""
    a, _, seed = factored(name, 1, rng)
    expected = np.linalg.inv(a)
    size = np.abs(expected).max()
    np.testing.assert_allclose(seed.own.inverse(), expected, rtol=0.0, atol=1e-11 * size)
    seed.own.round_to_single()
    found = seed.own.inverse()
    solved = np.stack([seed.solve(unit) for unit in np.eye(len(a))], axis=1)
    np.testing.assert_allclose(found, solved, rtol=0.0, atol=1e-11 * size)
    assert np.abs(found - expected).max() > 1e-11 * size


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("name", CASES)
def test_a_rounded_factor_loses_the_digits_that_the_condition_costs(name, threads, rng):
    a, values, seed = factored(name, threads, rng)
    r = rng.normal(size=len(a))
    before = seed.solve(r)
    seed.own.round_to_single()
    expected = np.linalg.solve(a, r)
    x = seed.solve(r)
    error = np.linalg.norm(x - expected) / np.linalg.norm(expected)
    # Wilkinson's kind of bound: three factors, each rounded, in the scaling of the diagonal.
    scale = 1.0 / np.sqrt(np.abs(np.diag(a)))
    assert 1e-12 < error <= 3.0 * ROUNDING * np.linalg.cond(scale[:, None] * a * scale)
    # Once is enough, and the next factor has all digits again.
    seed.own.round_to_single()
    assert (seed.solve(r) == x).all()
    assert seed.factor(values) == 0
    assert (seed.solve(r) == before).all()


@pytest.mark.parametrize("name", CASES)
def test_a_rounded_factor_is_symmetric(name, rng):
    # Both sweeps read the same numbers: BFGS and DFP presume a symmetric seed.
    a, _, seed = factored(name, 1, rng)
    seed.own.round_to_single()
    inverse = np.column_stack([seed.solve(column) for column in np.eye(len(a))])
    assert np.abs(inverse - inverse.T).max() <= 1e-13 * np.abs(inverse).max()


def test_a_rounded_factor_cannot_be_looked_at(rng):
    _, _, seed = factored("net", 1, rng)
    seed.own.round_to_single()
    with pytest.raises(ValueError, match="factor again"):
        seed.columns()


@pytest.mark.parametrize(
    "solver",
    [ancf.ModifiedNewton(), ancf.QuasiNewton("bfgs", memory=5), ancf.QuasiNewton("broyden", 5)],
    ids=str,
)
@pytest.mark.parametrize("young", [1e8, 2.1e11])
def test_runs_with_rounded_seeds_do_the_same_and_take_no_more(young, solver, monkeypatch):
    # Not Davidon's: its denominators let the last digits decide on iterations, also in double.
    runs = []
    for smallest in (np.inf, 0.0):
        monkeypatch.setattr(sparse_seed, "MIN_SINGLE_BYTES", smallest)
        scene = pendulum(youngs_modulus=young).scene
        runs.append(ancf.simulate(scene, 0.2, 5e-4, solver=solver))
    double, single = runs
    assert double.stats.single_seeds == 0
    assert single.stats.single_seeds == single.stats.factorizations - single.stats.indefinite > 0
    assert single.stats.iterations <= 1.02 * double.stats.iterations
    # Rounding moves where in the tolerance a step ends: 1e-3 m/s2 for 0.2 s moves 2e-5 m at most.
    assert np.abs(single.q - double.q).max() <= 2e-5


@pytest.mark.parametrize("solver", [ancf.Newton(), ancf.QuasiNewton("broyden")], ids=str)
def test_newton_and_dense_inverses_keep_their_digits(solver, always_single):
    run = ancf.simulate(cable(50).scene, 0.01, 1e-3, solver=solver)
    assert run.stats.factorizations > 0
    assert run.stats.single_seeds == 0


@pytest.mark.parametrize(
    "solver", [ancf.ModifiedNewton(), ancf.QuasiNewton("bfgs", memory=5)], ids=str
)
@pytest.mark.parametrize("make", [lambda: pendulum(as_constraint=True), elastic_four_bar])
def test_multipliers_need_no_more_corrections(make, solver, monkeypatch):
    runs = []
    for smallest in (np.inf, 0.0):
        monkeypatch.setattr(sparse_seed, "MIN_SINGLE_BYTES", smallest)
        runs.append(ancf.simulate(make().scene, 0.2, 1e-3, solver=solver))
    double, single = runs
    assert single.lam.shape[1] > 0
    assert double.stats.single_seeds == 0
    assert single.stats.single_seeds == single.stats.factorizations > 0
    assert single.stats.iterations <= 1.02 * double.stats.iterations
    assert np.abs(single.q - double.q).max() <= 2e-5


def test_small_systems_keep_their_digits():
    run = ancf.simulate(cable(50).scene, 0.01, 1e-3, solver=ancf.ModifiedNewton())
    assert run.stats.factorizations > 0
    assert run.stats.single_seeds == 0


def test_large_systems_are_rounded_unasked():
    # 26 numbers of a factor for an element: 6 MB.
    run = ancf.simulate(cable(30_000).scene, 1e-3, 5e-4, save_every=2)
    assert run.stats.single_seeds == run.stats.factorizations > 0
