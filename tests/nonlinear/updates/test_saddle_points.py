"""Saddle points: which pairs constraints make, and what a quasi-definite seed costs."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import pendulum
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.system import System
from tests.matrices import full
from tests.nonlinear.updates.drive import Problem, dense, limited


def curvatures(with_rod, steps=150, dt=5e-4):
    """Cosines of s and y over the pairs of BFGS on the seed of t = 0, step by step."""
    scene, rod = pendulum("l2t2", as_constraint=True)
    if with_rod:
        scene.rod(rod.end, (2.0, 1.0))
    system = System(scene)
    march, iteration, *_ = prepare_implicit(
        system, dt, ancf.Newmark(0.05), ancf.Newton(), 1e-9, math.inf
    )
    none = np.zeros((1, 0))
    march.prepare(none)
    h = np.linalg.inv(full(system, march.matrix()))
    out = [np.zeros((2, system.n_all)) for _ in range(3)] + [np.zeros((2, system.n_multipliers))]
    found = []
    for _ in range(steps):
        march.prepare(none)
        r = march.residual()
        start = np.abs(r).max()
        for _ in range(6):
            s = -h @ r
            march.correct(s)
            new = march.residual()
            y, r = new - r, new
            if np.abs(r).max() < 1e-8 * start:  # below, pairs are rounding
                break
            found.append(s @ y / np.linalg.norm(s) / np.linalg.norm(y))
            hy, sy = h @ y, s @ y
            if abs(sy) > 1e-8 * np.linalg.norm(s) * np.linalg.norm(y):
                h += (1.0 + y @ hy / sy) * np.outer(s, s) / sy
                h -= (np.outer(hy, s) + np.outer(s, hy)) / sy
        taken, outcome = march.advance(iteration, 1, none, 1, 0, *out)
        assert (taken, outcome) == (1, 0)
    return np.array(found)


def test_a_pin_leaves_all_pairs_of_positive_curvature():
    found = curvatures(with_rod=False)
    assert len(found) > 200
    assert found.min() > 0.0


def test_a_constraint_that_turns_makes_pairs_of_negative_curvature():
    found = curvatures(with_rod=True)
    assert (found < 0.0).mean() > 0.05


@pytest.mark.parametrize("make", [dense, limited])
@pytest.mark.parametrize("epsilon", [1e-8, 1e-4, 1e-2, 1.0])
def test_davidon_repairs_a_quasi_definite_seed_in_one_correction_per_constraint(make, epsilon):
    # On linear equations the seed is off by a matrix of rank m: m + 1 corrections are enough.
    problem = Problem(np.random.default_rng(3), m=4, curved=0.0, off=0.0, epsilon=epsilon)
    inverse = make("davidon", problem.a, problem.n)
    x = np.zeros(problem.n + problem.m)
    r = problem.residual(x)
    start = np.abs(r).max()
    z = inverse.apply(r)
    for _ in range(problem.m + 1):
        x = x - z
        new = problem.residual(x)
        if np.abs(new).max() < 1e-10 * start:
            r = new
            break
        z, _ = inverse.learn(-z, new - r, new)
        r = new
    assert np.abs(r).max() < 1e-9 * start
    np.testing.assert_allclose(x, np.linalg.solve(problem.j, problem.b), rtol=0, atol=1e-7)
