"""Cables that slide along themselves, as a coarse space of incomplete seeds."""

import numpy as np
import pytest
import scipy.sparse as sp

import ancfsparse as ancf
from ancfsparse.problems import lattice, octet
from ancfsparse.seeds import Groups, IncompleteSeed
from ancfsparse.seeds.incomplete import incomplete_seed
from ancfsparse.seeds.ordering import unknown_groups as groups_module
from ancfsparse.solve.preparation.deflation_space import sliding_points
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.system import System
from ancfsparse.system.coordinates.nodal_vectors import vectors_of

STEEL = {"youngs_modulus": 2.1e11, "density": 7800.0}
LONG = 0.01  # s: a wave runs along 260 elements


def steel(n, dt, make=lattice):
    """A cube at rest: its system, the matrix of a step as values and whole, and its slides."""
    system = System(make(n, **STEEL).scene)
    march, *_ = prepare_implicit(
        system, dt, ancf.GeneralizedAlpha(0.9), "auto", "default", np.inf, kind="incomplete"
    )
    pattern, values = system.pattern, march.matrix()
    lower = sp.csc_array((values, pattern.indices, pattern.indptr))
    whole = lower + sp.tril(lower, -1).T
    return system, values, whole.tocsr(), sliding_points(system)


def seed_of(system, slides=None, threads=1):
    pattern = system.pattern
    vectors = vectors_of(system.places, system.kinds, system.n_free)
    groups = Groups.from_matrix(pattern.indptr, pattern.indices, *vectors)
    return IncompleteSeed(pattern.indptr, pattern.indices, groups, threads, slides)


def modes_of(slides, n):
    """Z, one column for each cable."""
    column = np.repeat(slides.mode, 3)
    ways = slides.direction.ravel().astype(float), (slides.unknown.ravel(), column)
    return sp.csc_array(ways, shape=(n, slides.mode.max() + 1))


def test_cables_that_are_not_held_slide():
    system, _, _, slides = steel(4, LONG)
    # Of 48 cables 4 upright ones and the 4 edges of the top are held at corners.
    assert len(np.unique(slides.mode)) == slides.mode.max() + 1 == 40
    assert np.bincount(slides.mode).tolist() == [4] * 40
    assert (slides.unknown >= 0).all()
    for mode in range(40):
        here = slides.mode == mode
        ends = system.q0[slides.unknown[here]]
        along = (ends.max(axis=0) - ends.min(axis=0)) / 0.6
        np.testing.assert_allclose(
            np.abs(slides.direction[here]), np.tile(along, (4, 1)), atol=1e-7
        )


# What couples cables at right angles is left out; in octet trusses others at 60 degrees carry it.
@pytest.mark.parametrize(
    ("make", "n", "most"), [(lattice, 5, 0.01), (octet, 3, 0.1)], ids=["lattice", "octet truss"]
)
def test_the_coarse_matrix_is_that_of_the_modes(make, n, most, monkeypatch):
    monkeypatch.setattr(incomplete_seed, "MAX_COARSE_RATIO", 1.0)
    system, values, whole, slides = steel(n, LONG, make)
    seed = seed_of(system, slides)
    assert seed.factor(values) == 0
    z = modes_of(slides, seed.n)
    seed.own.solve(z @ np.random.default_rng(1).normal(size=z.shape[1]))
    assert seed.own.coarse_values.any()
    expected = (z.T @ whole @ z).toarray()
    indptr, indices = seed._coarse.factor._pattern
    found = sp.csc_array((seed.own.coarse_values, indices, indptr)).toarray()
    kept = found != 0.0
    scale = np.sqrt(np.outer(expected.diagonal(), expected.diagonal()))
    assert np.abs((found - expected) / scale)[kept].max() < 2e-4  # of rounded blocks that cancel
    left_out = np.tril(np.where(kept, 0.0, expected / scale))
    assert np.abs(left_out).max() < most
    assert kept.sum() > 2 * len(expected)  # what couples those side by side


def test_long_steps_take_half_the_rounds():
    system, values, whole, slides = steel(8, LONG)
    rng = np.random.default_rng(1)
    r = rng.normal(size=system.n_free) * np.sqrt(whole.diagonal())
    rounds = []
    for each in (None, slides):
        seed = seed_of(system, each)
        assert seed.factor(values) == 0
        for _ in range(3):
            seed.own.solve(r)
        assert seed.own.slides == (each is not None)
        x, count = seed.own.solve_to(r, 1e-3, 200)
        rounds.append(count)
        error = seed.solve(r) - x
        assert error @ (whole @ error) <= 0.05**2 * (x @ r)
        assert np.abs(whole @ seed.solve(r) - r).max() <= 1e-9 * np.abs(r).max()
    assert rounds[1] <= 0.5 * rounds[0]


def test_modes_are_kept_from_seed_to_seed_and_left_where_they_do_not_help():
    system, values, _, slides = steel(6, LONG)
    across = slides._replace(direction=np.roll(slides.direction, 1, axis=1))
    r = np.random.default_rng(1).normal(size=system.n_free)
    for each, helps in ((slides, True), (across, False)):
        seed = seed_of(system, each)
        assert seed.factor(values) == 0
        assert not seed.own.slides
        seed.own.solve(r)  # with and without them
        assert seed.own.slides == helps
        assert seed.factor(values) == 0
        assert seed.own.slides == helps


def test_short_steps_do_not_call_for_modes():
    system, values, _, slides = steel(6, 1e-3)
    assert sliding_points(system, 1e-3) is None  # a wave runs along 26 elements
    assert sliding_points(system, LONG) is not None
    seed = seed_of(system, slides)
    assert seed.factor(values) == 0
    for _ in range(3):
        seed.own.solve(np.ones(seed.n))
    assert not seed.own.slides


def test_cables_that_fill_the_coarse_matrix_in_do_without(monkeypatch):
    system, _, _, slides = steel(5, LONG)
    assert seed_of(system, slides)._coarse is not None
    monkeypatch.setattr(incomplete_seed, "MAX_COARSE_RATIO", 1e-3)
    assert seed_of(system, slides)._coarse is None


def test_threads_do_not_change_a_digit(monkeypatch):
    monkeypatch.setattr(groups_module, "MIN_TWO_FRONTS", 2)
    system, values, whole, slides = steel(6, LONG)
    r = np.random.default_rng(1).normal(size=system.n_free) * np.sqrt(whole.diagonal())
    found = []
    for threads in (1, 2):
        seed = seed_of(system, slides, threads)
        assert seed.threads == threads
        assert seed.factor(values) == 0
        found.append(np.array([seed.own.solve(r) for _ in range(3)]))
        assert seed.own.slides
    assert np.array_equal(*found)


@pytest.mark.parametrize("n", [8, 12])
def test_sweeps_of_long_steps(n):
    run = ancf.simulate(lattice(n, **STEEL).scene, 10 * LONG, LONG, factorization="incomplete")
    assert run.stats.sweeps <= 60 * run.stats.steps  # 100 without modes
    assert run.stats.products <= 2.1 * run.stats.sweeps
