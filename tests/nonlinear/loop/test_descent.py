"""Steps with saddles, where cables buckle: they are solved as minima."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.nonlinear import Attempt, Outcome
from ancfsparse.problems import lattice
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.system import System
from tests.nonlinear.loop.handmade import Equations, between_wells

STEEL = {"youngs_modulus": 2.1e11, "density": 7800.0}


def shaken():
    """An irregular lattice of steel, in rough motion."""
    return lattice(5, "rough", **STEEL, jitter=0.3).scene


def test_the_minimum_is_found_where_newton_s_corrections_lead_nowhere():
    equations = between_wells(material=lambda x: np.diag(3.0 * x**2 + 1.0))
    loop = equations.loop(max_iterations=6)
    assert loop.solve() == Outcome.CONVERGED
    assert equations.x[0] == pytest.approx(np.roots([1, 0, -2, 2]).real.min(), rel=1e-9)
    assert [event[1] for event in loop.events][-1] == Attempt.DESCENT
    assert loop.counts["recoveries_newton"] == 1


def test_a_step_too_long_by_far_is_shortened():
    # The seed is a millionth of the stiffness: its step is a million times too long.
    equations = between_wells(material=lambda x: np.diag(0.0 * x + 1e-6))
    assert equations.loop(max_iterations=6).solve() == Outcome.CONVERGED
    assert equations.x[0] == pytest.approx(np.roots([1, 0, -2, 2]).real.min(), rel=1e-9)


def test_without_a_definite_seed_or_without_saddles_there_is_none():
    loop = between_wells().loop(max_iterations=6)  # no material part: the seed leads upwards
    loop.solve()
    assert [event[1] for event in loop.events[-2:]] == [Attempt.DESCENT, Attempt.LONG_NEWTON]
    mild = Equations(lambda x: np.arctan(x), lambda x: np.diag(1.0 / (1.0 + x**2)), [9.0])
    loop = mild.loop(max_iterations=1)
    assert loop.solve() != Outcome.CONVERGED
    assert Attempt.DESCENT not in [event[1] for event in loop.events]


def test_multipliers_leave_no_potential():
    equations = Equations(
        lambda x: np.array([x[0] ** 3 - 2.0 * x[0] + 2.0 + x[1], x[0] ** 2 + 1.0]),
        lambda x: np.array([[3.0 * x[0] ** 2 - 2.0, 2.0 * x[0]], [2.0 * x[0], 0.0]]),
        [0.5, 0.0],
        n_multipliers=1,
    )
    loop = equations.loop(max_iterations=6)
    assert loop.solve() != Outcome.CONVERGED
    assert loop.counts["indefinite"] > 0
    assert Attempt.DESCENT not in [event[1] for event in loop.events]


def test_shaken_lattices_move_alike_on_all_seeds():
    # Every one of these failed in its first or second step, with Newton's method too.
    runs = [
        ancf.simulate(shaken(), 0.02, 5e-3, **options)
        for options in (
            {"factorization": "complete"},
            {"factorization": "incomplete"},
            {"solver": ancf.Newton()},
        )
    ]
    moved = np.abs(runs[0].q[-1] - runs[0].q[0]).max()
    for run in runs:
        assert "descent" in {event.rung for event in run.stats.events}
        assert np.abs(run.q - runs[0].q).max() <= 1e-3 * moved


def test_what_is_found_is_a_minimum():
    dt, n = 5e-3, 3
    system = System(shaken())
    march, loop, *_ = prepare_implicit(
        system, dt, ancf.GeneralizedAlpha(0.9), "auto", "default", np.inf
    )
    tangent = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
    loads, width = np.zeros((1, 0)), system.n_all
    for _ in range(n):
        rows = [np.zeros((2, width)) for _ in range(3)] + [np.zeros((2, 0))]
        assert march.advance(loop, 1, loads, 1, 0, *rows) == (1, Outcome.CONVERGED)
        assert tangent.factor(march.matrix()) == 0  # no pivot is negative
    assert Attempt.DESCENT in [event[1] for event in loop.events]
