"""Which seed a run is on: by counts of fill and of what steps take, and by memory."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import chain, lattice, net, net_on_sphere
from ancfsparse.seeds import Groups
from ancfsparse.solve.preparation import choose_factorization, memory_estimate, switch_to_direct
from ancfsparse.solve.recovery import checkpoints
from ancfsparse.system import System
from ancfsparse.system.coordinates.nodal_vectors import vectors_of
from tests.solve.preparation.factors import seed_of

STEEL = {"youngs_modulus": 2.1e11, "density": 7800.0}
INCOMPLETE = "with an incomplete factorization"


def comb(teeth=60):
    """A tree: cables that hang on one."""
    scene = ancf.Scene(gravity=(0.0, 0.0, -9.81))
    section, material = ancf.Circle(0.01), ancf.Material(1e8, 1000.0)
    back = scene.add_beam("thin", (0, 0, 0), (teeth, 0, 0), teeth, section, material)
    for k in range(teeth):
        tooth = scene.add_beam("thin", (k, 0, 0), (k, 0, -1), 4, section, material)
        scene.connect(back.node(k), tooth.start)
    scene.pin(back.start)
    scene.pin(back.end)
    return scene


def solver_of(scene, **options):
    return ancf.simulate(scene, 2e-3, 1e-3, **options).stats.solver


def groups_of(system):
    indptr, indices = system.pattern.indptr, system.pattern.indices
    return Groups.from_matrix(
        indptr, indices, *vectors_of(system.places, system.kinds, system.n_free)
    )


@pytest.mark.parametrize("make", [lambda: lattice(6).scene, lambda: net(20).scene])
def test_where_the_factor_fills_in_it_is_incomplete(make):
    method = solver_of(make())
    assert INCOMPLETE in method
    assert "more than 3 blocks for each of the matrix" in method


@pytest.mark.parametrize(
    "make", [lambda: chain(500).scene, comb, lambda: lattice(3).scene, lambda: net(5).scene]
)
def test_where_it_hardly_does_it_is_exact(make):
    assert INCOMPLETE not in solver_of(make())


def test_contacts_take_it_up_to_a_larger_fill():
    """Long steps of a net on a ball need several times as many factors on incomplete seeds."""
    scene = net_on_sphere(20).scene
    fill = groups_of(System(scene)).exact_fill(choose_factorization.MAX_CONTACT_FILL)
    assert fill is not None
    assert choose_factorization.MAX_FILL < fill.nnz / System(scene).pattern.indptr[-1]
    options = {"dt": 4e-3, "integrator": ancf.GeneralizedAlpha(0.5)}
    runs = [
        ancf.simulate(net_on_sphere(20).scene, 0.4, factorization=kind, **options)
        for kind in ("auto", "incomplete")
    ]
    assert [INCOMPLETE in run.stats.solver for run in runs] == [False, True]
    assert 2 * runs[0].stats.factorizations < runs[1].stats.factorizations
    assert runs[0].stats.recoveries < runs[1].stats.recoveries


def test_solvers_and_accuracies_that_are_asked_for_get_the_exact_one():
    assert INCOMPLETE not in solver_of(lattice(5).scene, solver=ancf.ModifiedNewton())
    assert INCOMPLETE not in solver_of(lattice(5).scene, factorization="complete")
    run = ancf.simulate(lattice(3).scene, 1e-3, accuracy=1e-4)
    assert INCOMPLETE not in run.stats.solver


def on_a_rod(n):
    scene, mesh = lattice(n)
    scene.rod(mesh.node(0), (0.0, 0.0, -1.0))
    return scene


def test_multipliers_get_the_exact_one_up_to_twice_the_fill():
    assert INCOMPLETE in solver_of(lattice(5).scene)
    assert INCOMPLETE not in solver_of(on_a_rod(5))
    told = solver_of(on_a_rod(9))
    assert INCOMPLETE in told
    assert "more than 6 blocks for each of the matrix" in told


def test_too_many_multipliers_get_the_exact_one(monkeypatch):
    for module in (choose_factorization, memory_estimate):
        monkeypatch.setattr(module, "MAX_EQUATIONS", 0)
    assert INCOMPLETE not in solver_of(on_a_rod(9))
    with pytest.raises(ancf.InputError, match=r"at most 0 equations, and this scene has 1, the"):
        solver_of(on_a_rod(4), factorization="incomplete")


def test_cycles_are_those_of_the_graph():
    n = 4
    assert groups_of(System(lattice(n).scene)).cycles == 3 * n * n * (n - 1) - n**3 + 1
    assert groups_of(System(comb())).cycles == 0


@pytest.mark.parametrize("make", [lambda: lattice(7).scene, lambda: net(25).scene])
def test_fill_is_that_of_the_exact_factor(make):
    scene = make()
    exact, groups = seed_of(scene), groups_of(System(scene))
    fill = groups.exact_fill(np.inf)
    # Ordered by vectors and not by coordinates, which fills in a little more.
    assert fill.nnz == pytest.approx(exact.nnz, rel=0.2)
    assert fill.factor_flops == pytest.approx(exact.factor_flops, rel=0.3)
    assert fill.solve_flops == pytest.approx(exact.solve_flops, rel=0.2)
    ratio = fill.nnz / groups.nnz
    assert groups.exact_fill(1.1 * ratio) == fill
    assert groups.exact_fill(0.9 * ratio) is None
    assert groups.exact_fill(0.1 * ratio) is None


def test_what_does_not_fit_exactly_is_marched(monkeypatch):
    scene = lattice(9).scene
    estimated = memory_estimate.estimate_memory(scene, 3, None, False, "auto", incomplete=True)
    for module in (memory_estimate, choose_factorization, switch_to_direct):
        monkeypatch.setattr(module, "available_memory", lambda: 1.2 * estimated.total)
    with pytest.raises(ancf.InputError, match="would need about"):
        solver_of(scene, factorization="complete")
    assert INCOMPLETE in solver_of(scene)
    assert INCOMPLETE in solver_of(scene, solver=ancf.ModifiedNewton())


def test_if_neither_fits_both_are_named(monkeypatch):
    scene = lattice(9).scene
    estimated = memory_estimate.estimate_memory(scene, 3, None, False, "auto", incomplete=True)
    monkeypatch.setattr(memory_estimate, "available_memory", lambda: 0.5 * estimated.total)
    sentence = r"the factor .* GB as an incomplete one, and as a complete one up to .* GB"
    with pytest.raises(ancf.InputError, match=sentence):
        solver_of(scene)
    exact = seed_of(scene)
    assert exact.nbytes <= estimated.complete <= 8.0 * exact.nbytes


def test_the_estimate_is_near_what_an_incomplete_factor_takes():
    system = System(lattice(12).scene)
    estimated = memory_estimate.estimate_memory(
        system.scene, 1, 0, False, ancf.ModifiedNewton(), incomplete=True
    )
    made, _ = choose_factorization.make_seed(
        system, "incomplete", "auto", 1, memory_estimate.NO_MEMORY
    )
    assert made.own.nbytes <= 1.05 * estimated.factor
    assert estimated.factor <= 1.5 * made.own.nbytes
    # What learns on it keeps two pairs of two terms of two vectors beside.
    learning = memory_estimate.estimate_memory(system.scene, 1, 0, False, "auto", incomplete=True)
    assert learning.factor - estimated.factor == pytest.approx(8 * 8 * system.n_free, rel=0.01)


def test_long_steps_go_back_to_exact_seeds_where_those_cost_less():
    run = ancf.simulate(lattice(5, **STEEL).scene, 1.25, 0.05)
    assert "from step 6 with a complete factorization (which cost less)" in run.stats.solver
    assert run.stats.steps == 25
    incomplete = ancf.simulate(lattice(5, **STEEL).scene, 1.25, 0.05, factorization="incomplete")
    assert run.stats.sweeps < incomplete.stats.sweeps  # none after the change
    assert run.stats.iterations > 0
    assert np.abs(run.q - incomplete.q).max() <= 1e-6


def test_short_steps_stay_on_incomplete_seeds():
    run = ancf.simulate(lattice(6).scene, 0.05, 1e-3)
    assert "a complete factorization" not in run.stats.solver


def test_a_step_that_fails_is_solved_on_an_exact_seed(monkeypatch):
    scene, t_end, dt = lattice(5, "rough", **STEEL).scene, 0.25, 0.05
    monkeypatch.setattr(checkpoints, "MIN_REPEATED_CHUNK", math.inf)  # Newton's method completes
    with pytest.raises(ancf.StepError):
        ancf.simulate(scene, t_end, dt, factorization="incomplete")
    run = ancf.simulate(scene, t_end, dt)
    assert run.stats.steps == 5
    (event,) = [event for event in run.stats.events if event.rung == "complete seed"]
    assert f"from step {event.step} with a complete factorization" in run.stats.solver
    # Without room for it the run ends as it would have.
    monkeypatch.setattr(switch_to_direct, "available_memory", lambda: 1e5)
    with pytest.raises(ancf.StepError):
        ancf.simulate(scene, t_end, dt)


def test_rough_steps_of_steel_are_solved_on_incomplete_seeds():
    run = ancf.simulate(lattice(8, "rough", **STEEL).scene, 0.03, 3e-3)
    assert run.stats.steps == 10
    assert {event.rung for event in run.stats.events} == {"new seed", "descent"}
    assert "a complete factorization" not in run.stats.solver


def test_runs_repeat_bit_for_bit():
    runs = [ancf.simulate(lattice(5, **STEEL).scene, 1.25, 0.05) for _ in range(2)]
    assert np.array_equal(runs[0].q, runs[1].q)


@pytest.mark.parametrize(
    ("motion", "dt", "most"), [("rest", 1e-3, 0.8), ("smooth", 1e-3, 0.9), ("rest", 2e-4, 1.0)]
)
def test_pairs_are_taken_where_sweeps_contract_slowly(motion, dt, most):
    def work(**options):
        stats = ancf.simulate(lattice(8, motion, **STEEL).scene, 30 * dt, dt, **options).stats
        return stats.residual_evaluations + stats.sweeps + stats.products, stats

    pairs, stats = work(factorization="incomplete")
    chord, _ = work(factorization="incomplete", solver=ancf.ModifiedNewton())
    assert "quasi-Newton (bfgs, 2 pairs) where sweeps contract slowly" in stats.solver
    if most == 1.0:
        assert pairs == chord  # nothing is learnt where little is left to learn
    assert pairs <= most * chord
