"""The bound on the energy that rounding adds: of a step, and of motions at rest."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.solve.stepping.energy_rounding import estimate_energy_rounding
from ancfsparse.system import System
from tests.beams import build_beam


def build_bar(hold=""):
    return build_beam(
        "thin", (100.0, 0.0, 3.0), (100.3, 0.4, 3.0), 4, ancf.Rectangle(0.1, 0.1),
        ancf.Material(2e11, 7800.0), hold, hold, gravity=(0.0, 0.0, 0.0),
    )[0]  # fmt: skip


def build_cantilever(hold=""):
    return build_beam(
        "thin", (0.0, 0.0), (1.0, 0.0), 30, ancf.Rectangle(0.01, 0.01),
        ancf.Material(1e8, 4000.0), hold, gravity=(0.0, 0.0),
    )[0]  # fmt: skip


def rounding_of(system, dt=1e-3):
    return estimate_energy_rounding(system, system.stiffness_diagonal(system.q0), dt)


@pytest.mark.parametrize("make", [build_bar, build_cantilever])
def test_errors_of_a_step_have_the_energy_of_relative_errors_of_the_coordinates(make):
    system, rng, factor = System(make()), np.random.default_rng(0), 1e-10
    signs = rng.choice([-1.0, 1.0], (2000, system.n_all))
    moved = system.q0 * (1.0 + factor * signs)
    energy = np.mean([system.assembly.strain_energy(np.ascontiguousarray(q)) for q in moved])
    found = math.sqrt(energy) * 2.0**-52 / factor
    assert rounding_of(system).step == pytest.approx(found, rel=0.05)


@pytest.mark.parametrize("make", [build_bar, build_cantilever])
@pytest.mark.parametrize("hold", ["", "pin"])
@pytest.mark.parametrize("dt", [1e-3, 1e-5])
@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.Newmark()], ids=repr)
def test_bodies_at_rest_gain_less_than_the_bound(make, hold, dt, integrator):
    run = ancf.simulate(make(hold), 1000 * dt, dt, integrator=integrator, max_energy_gain=math.inf)
    energy, bound = run.energy, rounding_of(run.system)
    gain = np.abs(energy.total - energy.total[0])
    exchanged = np.maximum.accumulate(np.maximum(energy.kinetic, gain))
    errors = bound.step * (1.0 + np.arange(len(gain)))
    allowed = bound.total + errors * (errors + 2.0 * np.sqrt(energy.elastic[0] + 2.0 * exchanged))
    assert 0.0 < gain.max()
    assert np.all(gain <= 0.2 * allowed)


def test_constrained_positions_have_the_energy_of_their_rounding_in_a_step():
    scene = ancf.Scene((0.0, 0.0, 0.0))
    scene.add_body(ancf.Box(length=1.0, height=1.0, width=1.0), mass=3.0, position=(300.0, 0, 0))
    units, mean_speed = 100.0, 2.0**-52 * 300.0 / 1e-3
    energy = 0.5 * 3.0 * (2.0 * units * mean_speed) ** 2
    assert rounding_of(System(scene)).total == pytest.approx(energy, rel=1e-12)


def test_dead_loads_do_work_on_rounding():
    scene, _ = build_beam(
        "thin", (3.0, -7.0), (2.0, -7.0), 1, ancf.Rectangle(0.1, 0.1), ancf.Material(1e8, 1000.0)
    )
    weight = 0.1 * 0.1 * 1.0 * 1000.0 * 9.81  # slopes across it have no length, loads on them none
    found = rounding_of(System(scene)).total
    assert found == pytest.approx(100.0 * 2.0**-52 * weight * 7.0, rel=1e-12)
