"""Blocks of touching elements in the factor: against differences of the residual, and in runs."""

import gc
import weakref
from itertools import pairwise

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.dispatch import compiled_module
from ancfsparse.nonlinear import Newton
from ancfsparse.nonlinear.methods import UPDATES
from ancfsparse.seeds import CoupledSeed, SparseSeed
from ancfsparse.seeds.complete import sparse_seed
from ancfsparse.solve.preparation.choose_factorization import make_complete_seed
from tests.matrices import full
from tests.seeds.matrices import lower_csc, random_spd
from tests.system.contributions import test_beam_bristles as bristles
from tests.system.contributions.test_beam_contacts import lowered
from tests.system.contributions.test_beam_friction import rubbing


def residual(system, q, v):
    rest, none = np.zeros(system.n_all), np.zeros(0)
    return system.assembly.residual(q, v, rest, none, rest, none)[0][: system.n_free]


def coupled_matrix(system, seed, q, v, stiffness, damping):
    """The dense matrix that compiled callers factor: M + stiffness K + damping C."""
    none = np.zeros(0)
    values = system.assembly.coupled_matrix(
        1.0, stiffness, q, none, none, damping_factor=damping, v=v
    )
    assert seed.compiled.factor(values) == 0
    units = np.eye(system.n_free)
    return np.linalg.inv(np.array([seed.compiled.solve(each) for each in units]))


def differences(system, q, v, of, size):
    """The derivative of the residual by the free coordinates, or by their velocities."""
    columns = []
    for move in size * np.eye(system.n_all)[: system.n_free]:
        ends = [(q + s * move, v) if of == "q" else (q, v + s * move) for s in (1.0, -1.0)]
        columns.append((residual(system, *ends[0]) - residual(system, *ends[1])) / (2.0 * size))
    return np.array(columns).T


def test_a_pattern_grows_by_entries_of_either_triangle(rng):
    indptr, indices, _ = lower_csc(random_spd(rng))
    row, column = (rng.integers(-1, 40, 200).astype(np.int32) for _ in range(2))
    start, rows, slot, of_more = compiled_module("coupled").grow_pattern(
        indptr, indices, row, column
    )
    column_of = np.repeat(np.arange(40), np.diff(start))
    assert all(np.all(np.diff(rows[a:b]) > 0) for a, b in pairwise(start))
    assert np.array_equal(rows[slot], indices)
    assert np.array_equal(column_of[slot], np.repeat(np.arange(40), np.diff(indptr)))
    fixed = (row < 0) | (column < 0)
    assert np.all(of_more[fixed] == len(rows))
    at = np.where(of_more < 0, -1 - of_more, of_more)[~fixed]
    assert np.array_equal(rows[at], np.maximum(row, column)[~fixed])
    assert np.array_equal(column_of[at], np.minimum(row, column)[~fixed])
    assert np.array_equal(of_more[~fixed] < 0, (row == column)[~fixed])
    entries = np.concatenate([slot, at])
    assert set(entries) == set(range(len(rows)))


@pytest.mark.parametrize("element", ["thin", "string"])
def test_the_matrix_couples_elements_that_touch(element):
    """But for the derivative of normals, 0.5 % of it with a penetration of 0.5 % of the reach."""
    system, _, q = lowered(0.7, 5e-5, element=element)
    seed, rest = make_complete_seed(system, 1), np.zeros(system.n_all)
    assert isinstance(seed, CoupledSeed)
    scale = 1e-4
    residual(system, q, rest)  # lists the pairs
    matrix = coupled_matrix(system, seed, q, rest, scale, 0.0)
    assert seed.renewals == 1
    mass = full(system, system.assembly.mass)
    exact = mass + scale * differences(system, q, rest, "q", 1e-9)
    own = mass + scale * full(system, system.assembly.matrix(0.0, 1.0, q, np.zeros(0), np.zeros(0)))
    missing = np.abs(own - exact).max()
    assert np.abs(matrix - exact).max() < 0.02 * missing


def test_a_common_motion_of_elements_that_touch_meets_no_stiffness():
    system, _, q = lowered(0.7, 1e-3)
    seed, rest = make_complete_seed(system, 1), np.zeros(system.n_all)
    residual(system, q, rest)
    matrix = coupled_matrix(system, seed, q, rest, 1e-4, 0.0)
    up = system.uniform(2)
    force = system.assembly.inertia(up)
    assert np.allclose(matrix @ up, force, atol=1e-9 * np.abs(matrix).max())


def test_the_matrix_couples_elements_by_friction(rng):
    system, _, q, v = rubbing(rng)
    seed = make_complete_seed(system, 1)
    residual(system, q, v)
    with_it = coupled_matrix(system, seed, q, v, 0.0, 1.0)
    exact = full(system, system.assembly.mass) + differences(system, q, v, "v", 1e-6)
    assert np.abs(with_it - exact).max() < 1e-6 * np.abs(exact).max()


@pytest.mark.parametrize("friction", [0.3, 0.003], ids=["sticks", "slides"])
def test_the_matrix_couples_elements_by_bristles(friction):
    """A common motion meets no stiffness, and a relative one that of the bristle."""
    system, _, q = bristles.crossed(friction)
    without, _, _ = bristles.crossed(friction=0.0)
    rest, along = np.zeros(system.n_all), np.array([0.6, 0.8, 0.0])
    q1, matrices = bristles.moved(system, q, 1e-5 * along), []
    for each in (system, without):
        bristles.rest_at(each, q)
        each.assembly.set_step(bristles.STEP)
        seed = make_complete_seed(each, 1)
        residual(each, q1, rest)
        matrices.append(coupled_matrix(each, seed, q1, rest, 1.0, 0.0))
    found, n, step = matrices[0] - matrices[1], system.n_free, 1e-8
    for axis in range(3):
        force = found @ system.uniform(axis)[:n]
        assert np.abs(force).max() < 1e-5 * np.abs(found).max()
    across = bristles.moved(system, rest, (-0.8, 0.6, 0.0))
    ends = [
        [residual(each, q1 + sign * step * across, rest) for each in (system, without)]
        for sign in (1.0, -1.0)
    ]
    one, other = (with_it - without_it for with_it, without_it in ends)
    expected = (one - other) / (2.0 * step)
    np.testing.assert_allclose(found @ across[:n], expected, atol=1e-3 * np.abs(expected).max())


def test_callers_from_python_factor_the_matrix_without_pairs():
    system, _, q = lowered(0.7, 1e-3)
    seed, rest = make_complete_seed(system, 1), np.zeros(system.n_all)
    residual(system, q, rest)
    coupled_matrix(system, seed, q, rest, 1e-4, 0.0)
    values = system.assembly.matrix(1.0, 1e-4, q, np.zeros(0), np.zeros(0))
    assert len(values) == system.pattern.n_values
    assert seed.factor(values) == 0
    r = np.arange(system.n_free, dtype=float)
    assert np.allclose(full(system, values) @ seed.solve(r), r, rtol=1e-6, atol=1e-6)


def resting(stiffness=1e6):
    """A rope that lies on another one, both on a floor that holds them in turn."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    section, material = ancf.Circle(0.01), ancf.Material(1e7, 5e3)
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 20, section, material)
    upper = scene.add_beam("thin", (-0.49, 0, 0.0102), (0.49, 2e-3, 0.0102), 20, section, material)
    floor = ancf.HalfSpace((0, 0, -0.0051), (0, 0, 1))
    for rope in (lower, upper):
        scene.contact(rope, floor, stiffness=1e5)
    scene.contact(lower, upper, stiffness=stiffness)
    return scene


def test_a_rope_that_lies_on_another_takes_few_iterations():
    """Without the coupling Newton's method takes 49 iterations per step, the default solver 73."""
    for solver, most in ((Newton(), 4.0), ("auto", 10.0)):
        run = ancf.simulate(
            resting(), 0.1, 1e-3, integrator=ancf.GeneralizedAlpha(0.5), solver=solver
        )
        assert run.stats.iterations < most * run.stats.steps
        assert 1 <= run.stats.pattern_changes < 50


def test_beams_that_never_touch_keep_their_pattern():
    scene = resting()
    run = ancf.simulate(scene, 1e-3, 1e-4)
    assert run.stats.pattern_changes == 0


@pytest.mark.parametrize("update", UPDATES)
def test_steps_that_a_dense_inverse_fails_are_solved_by_the_coupled_matrix(update):
    """Without the coupling Davidon and DFP end in step 11, since Newton's attempts fail too."""
    solver = ancf.QuasiNewton(update)
    run = ancf.simulate(resting(), 0.1, 1e-3, integrator=ancf.GeneralizedAlpha(0.5), solver=solver)
    assert run.stats.pattern_changes > 0
    assert run.stats.iterations < 15.0 * run.stats.steps


def listed_pairs(system, part, q):
    """The pairs that the matrix couples after a residual in a state."""
    residual(system, q, np.zeros(system.n_all))
    return part.compiled.coupled_pairs


def test_pairs_of_a_trial_far_from_the_last_state_are_not_coupled():
    system, part, q = lowered(0.7, 1e-3)
    make_complete_seed(system, 1)
    apart = q.copy()
    for indices in system.vectors("r")[1:]:
        apart[indices[:, 2]] += 0.1
    system.assembly.accept(apart)
    assert len(part.compiled.touches(q)[0])
    assert len(listed_pairs(system, part, q)) == 0
    system.assembly.accept(q)
    assert len(listed_pairs(system, part, q)) > 0


def test_pairs_that_no_longer_touch_are_dropped_once_they_are_the_majority():
    system, part, q = lowered(0.0, 1e-4)  # side by side: many pairs
    make_complete_seed(system, 1)
    system.assembly.accept(q)
    n = len(listed_pairs(system, part, q))
    assert n > 8
    system.assembly.accept(q)
    assert len(part.compiled.coupled_pairs) == n
    apart = q.copy()
    for indices in system.vectors("r")[1:]:
        apart[indices[:, 2]] += 0.02
    assert len(listed_pairs(system, part, apart)) == n
    system.assembly.accept(apart)
    assert len(part.compiled.coupled_pairs) == 0


def test_a_released_factor_of_cholmod_leaves_memory_at_once(monkeypatch, rng):
    pytest.importorskip("sksparse.cholmod")
    monkeypatch.setattr(sparse_seed, "MIN_SUPERNODAL_FLOPS", 0.0)
    indptr, indices, values = lower_csc(random_spd(rng))
    seed = SparseSeed(indptr, indices, 40)
    assert seed.supernodal
    assert seed.factor(values) == 0
    alive = weakref.ref(seed)
    gc.disable()
    try:
        seed.release()
        del seed
        assert alive() is None
    finally:
        gc.enable()


def test_an_error_while_the_pattern_is_renewed_ends_the_run(monkeypatch):
    def fail(self):
        raise MemoryError("no room for another pattern")

    monkeypatch.setattr(CoupledSeed, "renew", fail)
    with pytest.raises(MemoryError, match="no room"):
        ancf.simulate(resting(), 0.1, 1e-3, integrator=ancf.GeneralizedAlpha(0.5))
