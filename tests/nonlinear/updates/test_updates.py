"""The compiled updates against the paper's formulas, on a saddle-point system."""

import numpy as np
import pytest

from ancfsparse.dispatch import compiled_module
from ancfsparse.nonlinear import methods
from tests.nonlinear.formulas import UPDATES, broyden, compact
from tests.nonlinear.updates.drive import (
    Problem,
    dense,
    iterate,
    learn_pair,
    limited,
    matrix_of,
    seed_of,
)

RULES = tuple(UPDATES)
SYMMETRIC = ("davidon", "dfp", "bfgs")
TOLERANCE = 1e-10


def test_every_rule_that_can_be_asked_for_has_terms_and_a_formula():
    assert set(methods.UPDATES) == set(RULES) == set(compiled_module("dense").RULES)


@pytest.fixture
def problem(rng):
    return Problem(rng)


def build(memory, rule, problem, **options):
    make = dense if memory == "dense" else limited
    return make(rule, problem.a, problem.n, **options)


def assert_close(found, expected, tolerance=TOLERANCE):
    assert np.abs(found - expected).max() <= tolerance * np.abs(expected).max()


@pytest.mark.parametrize("pairs", [1, 2, 5, 9])
@pytest.mark.parametrize("memory", ["dense", "limited"])
@pytest.mark.parametrize("rule", RULES)
def test_update_is_the_papers_formula(rule, memory, pairs, problem, rng):
    inverse = build(memory, rule, problem)
    _, s, y = iterate(inverse, problem.residual, np.zeros(len(problem.b)), pairs)
    expected = problem.h0
    for each in zip(s, y, strict=True):
        expected = UPDATES[rule](expected, *each)
    assert_close(matrix_of(inverse, len(problem.b)), expected)
    if memory == "dense":
        assert_close(inverse.matrix, expected)


@pytest.mark.parametrize("memory", ["dense", "limited"])
@pytest.mark.parametrize("rule", RULES)
def test_every_pair_satisfies_the_secant_equation(rule, memory, problem):
    inverse = build(memory, rule, problem)
    x, r, residual = np.zeros(len(problem.b)), -problem.b, problem.residual
    z = inverse.apply(r)
    for _ in range(6):
        s = -z
        x = x + s
        r_new = residual(x)
        z, accepted = inverse.learn(s, r_new - r, r_new)
        assert accepted
        assert_close(inverse.apply(r_new - r), s)
        # What comes back is the new H times the new residual: next step without another solve.
        assert_close(z, inverse.apply(r_new))
        r = r_new


@pytest.mark.parametrize("memory", ["dense", "limited"])
@pytest.mark.parametrize("rule", RULES)
def test_recursion_equals_compact_form(rule, memory, problem):
    inverse = build(memory, rule, problem)
    _, s, y = iterate(inverse, problem.residual, np.zeros(len(problem.b)), 6)
    expected = compact(rule, problem.h0, np.column_stack(s), np.column_stack(y))
    assert_close(matrix_of(inverse, len(problem.b)), expected)


@pytest.mark.parametrize("rule", RULES)
def test_pairs_that_no_function_has(rule, problem, rng):
    # Differences of residuals with noise: no symmetric matrix explains them all.
    n = len(problem.b)
    inverses = [build(memory, rule, problem) for memory in ("dense", "limited")]
    h = problem.h0
    for _ in range(5):
        s = rng.normal(size=n)
        y = problem.j @ s + 0.05 * rng.normal(size=n)
        for inverse in inverses:
            _, accepted = learn_pair(inverse, h, s, y)
            assert accepted
        h = UPDATES[rule](h, s, y)
    for inverse in inverses:
        assert_close(matrix_of(inverse, n), h)


@pytest.mark.parametrize("rule", RULES)
def test_limited_takes_the_same_steps_as_dense(rule, problem):
    ends = [
        iterate(build(memory, rule, problem), problem.residual, np.zeros(len(problem.b)), 8)[0]
        for memory in ("dense", "limited")
    ]
    assert_close(ends[1], ends[0])


def test_a_negative_curvature_is_no_reason_to_refuse(problem):
    # On a saddle point s.y < 0 is right for some s: here J has negative eigenvalues.
    values, vectors = np.linalg.eigh(problem.j)
    s = vectors[:, 0].copy()
    y = problem.j @ s
    assert values[0] < 0
    assert s @ y < 0
    for rule in RULES:
        for memory in "dense", "limited":
            inverse = build(memory, rule, problem)
            _, accepted = learn_pair(inverse, problem.h0, s, y)
            assert accepted, rule
            assert_close(inverse.apply(y), s)


def transformed_steps(rule, problem, t, weights=None, pairs=6):
    """Iterates in x = T x~, r~ = T^T r, given back as x."""
    a = t.T @ problem.a @ t
    if weights is None:
        inverse = dense(rule, a, problem.n)
    else:
        inverse = limited(rule, a, problem.n, weights=weights)

    def residual(x):
        return t.T @ problem.residual(t @ x)

    _, s, _ = iterate(inverse, residual, np.zeros(len(t)), pairs)
    return np.column_stack([t @ each for each in s])


def congruence(problem, rng):
    """Another scale for every unknown, as metres beside slopes and newtons, and some mixing."""
    n, m = problem.n, problem.m
    t = np.diag(10.0 ** rng.uniform(-1, 1, n + m))
    t[:n, :n] += 0.05 * rng.normal(size=(n, n))
    return t


@pytest.mark.parametrize("rule", SYMMETRIC)
def test_symmetric_updates_do_not_see_a_congruence(rule, problem, rng):
    t = congruence(problem, rng)
    expected = transformed_steps(rule, problem, np.eye(len(t)))
    assert_close(transformed_steps(rule, problem, t), expected, 1e-9)


def test_broyden_sees_a_congruence(problem, rng):
    t = congruence(problem, rng)
    expected = transformed_steps("broyden", problem, np.eye(len(t)))
    found = transformed_steps("broyden", problem, t)
    assert_close(found[:, 0], expected[:, 0], 1e-9)  # the first step is the seed's
    assert np.abs(found - expected).max() > 1e-4 * np.abs(expected).max()


def test_weighted_broyden_is_equation_13_in_that_inner_product(problem, rng):
    weights = rng.uniform(0.1, 10.0, len(problem.b))
    weights[problem.n :] = 0.0  # multipliers have no mass
    inverse = limited("broyden", problem.a, problem.n, weights=weights)
    _, s, y = iterate(inverse, problem.residual, np.zeros(len(problem.b)), 6)
    expected = problem.h0
    for each in zip(s, y, strict=True):
        expected = broyden(expected, *each, d=weights)
    assert_close(matrix_of(inverse, len(problem.b)), expected)


def test_broyden_weighted_by_the_metric_does_not_see_a_congruence(problem, rng):
    # In x~ the inner product x^T D x is x~^T (T^T D T) x~: the weights must change with the scales.
    scales = 10.0 ** rng.uniform(-1, 1, len(problem.b))
    weights = rng.uniform(0.5, 2.0, len(problem.b))
    one = transformed_steps("broyden", problem, np.eye(len(scales)), weights)
    other = transformed_steps("broyden", problem, np.diag(scales), weights * scales**2)
    assert_close(other, one, 1e-9)


@pytest.mark.parametrize("capacity", [1, 3])
@pytest.mark.parametrize("rule", RULES)
def test_a_full_memory_is_flushed_not_rolled(rule, capacity, problem):
    n = len(problem.b)
    inverse = limited(rule, problem.a, problem.n, capacity)
    x, s, y = iterate(inverse, problem.residual, np.zeros(n), capacity)
    r = problem.residual(x)
    step = -inverse.apply(r)
    r_new = problem.residual(x + step)
    z, _ = inverse.learn(step, r_new - r, r_new)
    # No room for this pair: all are dropped and the seed is alone again.
    assert_close(matrix_of(inverse, n), problem.h0)
    assert_close(z, problem.h0 @ r_new)
    _, s, y = iterate(inverse, problem.residual, x + step, 1)
    assert_close(matrix_of(inverse, n), UPDATES[rule](problem.h0, s[0], y[0]))


def test_no_memory_is_the_chord_method(problem):
    inverse = limited("broyden", problem.a, problem.n, 0)
    x, _, _ = iterate(inverse, problem.residual, np.zeros(len(problem.b)), 4)
    expected = np.zeros(len(problem.b))
    for _ in range(4):
        expected = expected - problem.h0 @ problem.residual(expected)
    assert_close(x, expected)
    assert_close(matrix_of(inverse, len(problem.b)), problem.h0)


@pytest.mark.parametrize("memory", ["dense", "limited"])
@pytest.mark.parametrize("rule", RULES)
def test_rounding_is_not_learned(rule, memory, problem, rng):
    n = len(problem.b)
    inverse = build(memory, rule, problem)
    inverse.set_guard(np.ones(n), 1e-9)
    _, s, y = iterate(inverse, problem.residual, np.zeros(n), 2)
    before = matrix_of(inverse, n)
    for bad in (np.zeros(n), 1e-10 * rng.normal(size=n) / np.sqrt(n), np.full(n, np.nan)):
        z, accepted = learn_pair(inverse, before, rng.normal(size=n), bad)
        assert not accepted
        np.testing.assert_array_equal(matrix_of(inverse, n), before)
    r_new = rng.normal(size=n)
    z, accepted = inverse.learn(-before @ r_new, np.zeros(n), r_new)
    assert not accepted
    assert_close(z, before @ r_new)  # the step goes on with the old H
    z, accepted = learn_pair(inverse, before, s[0], y[0])
    assert accepted


def degenerate_pair(rule, h, rng):
    """A pair whose denominator in the formula of ``rule`` is zero but for rounding."""
    n = len(h)
    s, y = rng.normal(size=(2, n))
    if rule == "davidon":  # (s - H y).y = 0
        y *= (s @ y) / (y @ h @ y)
    elif rule == "broyden":  # s.H y = 0
        y -= (s @ h @ y) / (s @ h @ h @ s) * (h @ s)
    elif rule == "bfgs":  # s.y = 0
        y -= (s @ y) / (s @ s) * s
    else:  # y.H y = 0, which an indefinite H has
        assert rule == "dfp"
        values, vectors = np.linalg.eigh(h)
        y = vectors[:, 0] / np.sqrt(-values[0]) + vectors[:, -1] / np.sqrt(values[-1])
    return s, y


@pytest.mark.parametrize("memory", ["dense", "limited"])
@pytest.mark.parametrize("rule", RULES)
def test_a_degenerate_pair_is_skipped(rule, memory, problem, rng):
    n = len(problem.b)
    inverse = build(memory, rule, problem)
    iterate(inverse, problem.residual, np.zeros(n), 2)
    before = matrix_of(inverse, n)
    s, y = degenerate_pair(rule, before, rng)
    z, accepted = learn_pair(inverse, before, s, y)
    assert not accepted
    np.testing.assert_array_equal(matrix_of(inverse, n), before)
    # z goes on with the old H: H r_new = H y - s.
    assert_close(z, before @ y - s)


@pytest.mark.parametrize("memory", ["dense", "limited"])
@pytest.mark.parametrize("rule", SYMMETRIC)
def test_units_do_not_decide_which_pairs_are_skipped(rule, memory, problem, rng):
    # A pair whose denominator is 1e-6 of the norms: just so good, in whatever units.
    n = len(problem.b)
    s, y = degenerate_pair(rule, problem.h0, rng)
    y = y + 1e-5 * rng.normal(size=n)
    scales = 10.0 ** rng.uniform(-8, 8, n)
    for smallest, taken in ((0.0, True), (2.0 * np.linalg.norm(y), False)):
        for t in (np.ones(n), scales):  # x = t x~, r~ = t r
            inverse = build(memory, rule, problem)
            if memory == "dense":
                inverse.matrix = problem.h0 / np.outer(t, t)
            else:
                inverse = limited(rule, problem.a * np.outer(t, t), problem.n)
            inverse.set_guard(t**2, smallest)
            r_old = -np.linalg.solve(problem.h0, s)
            assert inverse.learn(s / t, t * y, t * (r_old + y))[1] == taken


@pytest.mark.parametrize("memory", ["dense", "limited"])
@pytest.mark.parametrize("rule", ["dfp", "bfgs"])
def test_a_curvature_far_from_that_of_the_inverse_is_skipped(rule, memory, problem, rng):
    # s.y and y.H y are one number when H is right; here s.y is `ratio` times the other.
    s, y = rng.normal(size=(2, len(problem.b)))
    expected = y @ problem.h0 @ y
    for ratio, taken in ((0.2, True), (5.0, True), (0.05, False), (20.0, False), (-1.0, False)):
        inverse = build(memory, rule, problem)
        inverse.set_guard(np.ones(len(s)), 0.0, 10.0)
        moved = s + (ratio * expected - s @ y) / (y @ y) * y
        _, accepted = learn_pair(inverse, problem.h0, moved, y)
        assert accepted == taken


def test_dfp_skips_on_either_denominator(problem, rng):
    s, y = rng.normal(size=(2, len(problem.b)))
    y -= (s @ y) / (s @ s) * s
    for memory in "dense", "limited":
        inverse = build(memory, "dfp", problem)
        assert not learn_pair(inverse, problem.h0, s, y)[1]


def rank_deficient(rng, p, from_range=False):
    """A linear saddle-point problem whose seed is wrong by a matrix of rank p."""
    problem = Problem(rng, curved=0.0, off=0.0, epsilon=0.0)
    u = rng.normal(size=(len(problem.b), p)) / np.sqrt(len(problem.b))
    signs = np.where(np.arange(p) % 2 == 0, 1.0, -1.0)
    problem.a = problem.j + 0.5 * u * signs @ u.T
    if from_range:
        problem.b = u @ rng.normal(size=p)
    return problem


def iterations_to_solve(rule, problem):
    # The inverse is set from outside: this a need not have a factor without pivoting.
    inverse = compiled_module("dense").Dense(seed_of(np.eye(len(problem.b)), len(problem.b)), rule)
    inverse.matrix = np.linalg.inv(problem.a)
    r = problem.residual(np.zeros(len(problem.b)))
    first = np.linalg.norm(r)
    x, z = np.zeros(len(problem.b)), inverse.apply(r)
    for k in range(1, 40):
        x = x - z
        r_new = problem.residual(x)
        if np.linalg.norm(r_new) <= 1e-10 * first:
            return k
        z, _ = inverse.learn(-z, r_new - r, r_new)
        r = r_new
    return k


@pytest.mark.parametrize("p", [1, 2, 4])
def test_davidon_and_broyden_end_on_a_linear_problem(p, rng):
    # Davidon learns rank p from p independent pairs; one more step lands.
    assert iterations_to_solve("davidon", rank_deficient(rng, p)) <= p + 1
    # Gay, SIAM J. Numer. Anal. 16 (1979) 623: Broyden takes 2 p steps within the p-dimensional
    # space in which all residuals lie after the first step, so 2 p if b lies there, or 2 p + 1.
    assert iterations_to_solve("broyden", rank_deficient(rng, p, from_range=True)) <= 2 * p
    assert iterations_to_solve("broyden", rank_deficient(rng, p)) <= 2 * p + 1


@pytest.mark.parametrize("rule", RULES)
def test_odd_sizes_are_padded_right(rule, rng):
    # Columns of the dense inverse are padded to cache lines: every remainder must work.
    for n in range(1, 19):
        problem = Problem(rng, n=n, m=0)
        inverse = dense(rule, problem.a, n)
        pairs = min(3, n)
        x, r = np.zeros(n), -problem.b
        z, expected = inverse.apply(r), problem.h0
        for _ in range(pairs):
            s, x = -z, x - z
            r_new = problem.residual(x)
            z, accepted = inverse.learn(s, r_new - r, r_new)
            if accepted:
                expected = UPDATES[rule](expected, s, r_new - r)
            r = r_new
        assert_close(inverse.matrix, expected, 1e-8)
        assert_close(matrix_of(inverse, n), expected, 1e-8)
