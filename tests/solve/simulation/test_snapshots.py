"""A simulation returns to snapshots bit for bit, with any integrator and solver."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import lattice
from ancfsparse.solve.preparation import choose_factorization
from ancfsparse.solve.preparation.switch_to_direct import SwitchToDirect
from tests.solve.simulation.scenes import (
    INTEGRATORS,
    SCENES,
    SOLVERS,
    crossing_cables,
    pendulum,
    same,
)


@pytest.mark.parametrize("solver", SOLVERS, ids=repr)
@pytest.mark.parametrize("integrator", INTEGRATORS[::2], ids=repr)
@pytest.mark.parametrize("name", SCENES)
def test_a_snapshot_is_returned_to_bit_for_bit(name, integrator, solver):
    make, dt = SCENES[name]
    sim = ancf.Simulation(make(), dt, integrator=integrator, solver=solver)
    sim.step(57)
    before = sim.snapshot()
    sim.step(60)
    first = sim.state
    sim.restore(before)
    assert sim.t == before.t
    sim.step(23)
    sim.step(37)
    assert same(sim.state, first)


@pytest.mark.parametrize("name", ["pendulum", "body"])
def test_incomplete_seeds_are_returned_to_bit_for_bit(name):
    make, dt = SCENES[name]
    sim = ancf.Simulation(make(), dt, factorization="incomplete")
    sim.step(20)
    before = sim.snapshot()
    sim.step(40)
    first = sim.state
    sim.restore(before)
    sim.step(40)
    assert same(sim.state, first)


def test_costs_of_seeds_are_compared_again_at_the_steps_after_a_snapshot(monkeypatch):
    monkeypatch.setattr(choose_factorization, "_may_fill_in", lambda *_: True)
    monkeypatch.setattr(choose_factorization, "_fills_in", lambda *_: True)
    sim, compared = ancf.Simulation(pendulum()[0], 1e-3), []
    monkeypatch.setattr(
        SwitchToDirect, "is_cheaper", lambda *_: compared.append(sim.steps) and False
    )
    sim.step(4)
    before = sim.snapshot()
    sim.step(50)
    first, steps = sim.state, compared.copy()
    assert steps[:3] == [5, 15, 35]
    compared.clear()
    sim.restore(before)
    sim.step(50)
    assert same(sim.state, first)
    assert compared == steps


def test_a_complete_factorization_stays():
    sim = ancf.Simulation(lattice(5, youngs_modulus=2.1e11, density=7800.0).scene, 0.05)
    sim.step(3)
    before = sim.snapshot()
    sim.step(12)
    first = sim.state
    assert "from step 6 with a complete factorization" in sim.stats.solver
    sim.restore(before)
    sim.step(12)
    np.testing.assert_allclose(sim.state.q, first.q, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize(
    ("integrator", "damping"),
    [
        (ancf.CentralDifference(), 0.0),
        (ancf.RungeKuttaNystrom(), 0.0),
        (ancf.DormandPrince(), 0.0),
        (ancf.DormandPrince(), 1e-4),
    ],
)
def test_explicit_integrators_return_to_snapshots_bit_for_bit(integrator, damping):
    scene = ancf.Scene((0, -9.81))
    material = ancf.Material(1e7, 1e3, bending_damping=damping)
    rod = scene.add_beam("thin", (0, 0), (1, 0), 8, ancf.Circle(0.01), material)
    scene.pin(rod.start)
    scene.point_force(rod.end, ancf.Sine((0.0, 1.0), 3.0))
    sim = ancf.Simulation(scene, 1e-5, integrator=integrator)
    sim.step(57)
    before = sim.snapshot()
    sim.step(60)
    first = sim.state
    sim.restore(before)
    sim.step(60)
    assert same(sim.state, first)


def test_a_snapshot_changes_results_by_rounding_alone():
    steady, watched = (ancf.Simulation(crossing_cables(), 1e-3, tolerance=1e-8) for _ in range(2))
    steady.step(60)
    for _ in range(6):
        watched.step(10)
        watched.snapshot()
    assert np.max(np.abs(steady.q - watched.q)) < 1e-11


def test_a_snapshot_of_another_simulation_is_refused():
    one, other = (ancf.Simulation(pendulum()[0], 1e-3) for _ in range(2))
    with pytest.raises(ancf.InputError, match="snapshot of this simulation"):
        one.restore(other.snapshot())
