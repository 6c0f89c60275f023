"""Impacts with a coefficient of restitution, against their definition."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ancfsparse as ancf
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.system import System
from ancfsparse.system.contributions.force_elements.contact_steps import (
    RESTITUTION_STEPS,
    SLOW_RATIO,
)
from tests.matrices import derivative_of_step, full
from tests.solve.contact.friction.test_bristles import DEPTH
from tests.solve.contact.test_contact_motion import FLOOR, LINE_MASS, MATERIAL, SECTION, level
from tests.solve.contact.test_moving_obstacles import collision, momenta

INTEGRATORS = [ancf.EnergyMomentum(), ancf.GeneralizedAlpha(0.9), ancf.Newmark(0.0)]


def longest_step(stiffness, restitution):
    return math.pi * math.sqrt(LINE_MASS / stiffness) * restitution / RESTITUTION_STEPS


def rebound(stiffness, restitution, speed, phase, integrator):
    """A level cable without weight hits a floor: a run with the longest steps, and the speed."""
    dt = longest_step(stiffness, restitution)
    scene, y = ancf.Scene((0, 0)), 0.005 + (2.0 + phase) * speed * dt
    rod = scene.add_beam("thin", (0, y), (1, y), 4, SECTION, MATERIAL, velocity=(0, -speed))
    scene.contact(rod, FLOOR, stiffness=stiffness, restitution=restitution)
    steps = math.ceil(1.5 * RESTITUTION_STEPS / restitution**2 + 10)
    run = ancf.simulate(scene, steps * dt, dt, integrator=integrator)
    assert run.position(rod.at(0.5))[-1, 1] > 0.005
    return run, run.velocity(rod.at(0.5))[-1, 1] / speed


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
@pytest.mark.parametrize("restitution", [0.25, 0.5, 0.64, 0.9])
def test_the_longest_steps_return_the_speed_within_a_percent(restitution, integrator):
    """In all phases, with all stiffnesses, at speeds far above that of the layer in the law."""
    for stiffness, speed in ((1e5, 10.0), (1e7, 1.0), (1e9, 1.0)):
        for phase in np.arange(8) / 8:
            run, returned = rebound(stiffness, restitution, speed, phase, integrator)
            assert returned == pytest.approx(restitution, rel=1e-2)
            energy = run.energy
            lost = energy.impact_damping[-1] / energy.total[0]
            closed = 1e-8 if integrator.keeps_energy else 2e-2
            assert lost == pytest.approx(1.0 - returned**2, abs=closed)
            assert np.abs(energy.total + energy.lost - energy.total[0]).max() < (
                closed * energy.total[0]
            )
            assert np.diff(energy.impact_damping).min() >= 0.0


def test_impacts_within_the_layer_follow_the_law():
    """Three layers deep without damping, against the same law by another integrator."""
    eps, k, layer = 0.5, 1e5, 5e-6
    rate = math.sqrt(k / LINE_MASS)
    gamma, speed = (1 - eps**2) / (1 + eps**2), 3.0 * layer * rate

    def law(t, x):
        e, v = max(x[0], 0.0), x[1]
        p = k * (e**3 / layer**2 - e**4 / (2 * layer**3)) if e < layer else k * (e - layer / 2)
        s = v / (SLOW_RATIO * eps * rate * (e + layer))
        return v, -p * (1 + gamma * math.tanh(s)) / LINE_MASS

    scene = ancf.Scene((0, 0))
    rod = scene.add_beam("thin", (0, 0.005), (1, 0.005), 4, SECTION, MATERIAL, velocity=(0, -speed))
    scene.contact(rod, FLOOR, stiffness=k, restitution=eps)
    run = ancf.simulate(scene, 0.02, 2e-5, integrator=ancf.EnergyMomentum(), tolerance=1e-12)
    exact = solve_ivp(law, (0.0, 0.02), (0.0, speed), rtol=1e-9, atol=1e-15)
    returned = run.velocity(rod.at(0.5))[-1, 1]
    assert returned == pytest.approx(-exact.y[1, -1], rel=1e-3)
    assert returned > 1.001 * eps * speed


@pytest.mark.parametrize(
    "options",
    [
        {"dt": 1e-4, "integrator": ancf.EnergyMomentum()},
        {"dt": 1e-4},
        {"dt": 2e-3, "accuracy": 1e-5},
        {"dt": 2e-5, "integrator": ancf.DormandPrince()},
    ],
    ids=["energy", "default", "accuracy", "explicit"],
)
def test_a_cable_bounces_alike_with_all_integrators_and_comes_to_rest(options):
    """The weight also acts during the impact, so it returns with less than half of its speed."""
    scene, rod, _ = level(0.02, 1e5, restitution=0.5)
    run = ancf.simulate(scene, 0.4, **options)
    y = run.position(rod.at(0.5))[:, 1] - 0.005
    assert y[(run.t > 0.08) & (run.t < 0.14)].max() == pytest.approx(0.2126 * 0.02, rel=6e-3)
    assert y[-1] == pytest.approx(-DEPTH, rel=1e-2)
    assert abs(run.velocity(rod.at(0.5))[-1, 1]) < 1e-3


@pytest.mark.parametrize("dim", [2, 3])
def test_momenta_are_kept_in_an_impact_of_two_bodies(dim):
    """With a ball that is part of a rotating body, and with friction."""
    scene, *_ = collision(dim, 0.01, friction=0.4, slip_speed=0.05, restitution=0.5)
    dt = math.pi * math.sqrt(0.01256 / 1e5) * 0.5 / 13.0
    run = ancf.simulate(scene, 400 * dt, dt, integrator=ancf.EnergyMomentum(), tolerance=1e-11)
    for momentum in momenta(scene, run):
        assert np.abs(momentum - momentum[0]).max() < 1e-7 * np.abs(momentum).max()
    energy = run.energy
    assert energy.drift < 1e-7
    assert energy.impact_damping[-1] > 0.005 * energy.kinetic[0]


@pytest.mark.parametrize("integrator", INTEGRATORS[:2], ids=repr)
def test_the_matrix_of_a_step_is_the_derivative(integrator):
    """Near the largest penetration, where the damping depends on the speed."""
    scene, _, _ = level(-2e-4, 1e5, velocity=(0, -1e-4), restitution=0.5)
    system = System(scene)
    march, *_ = prepare_implicit(system, 1e-4, integrator, ancf.Newton(), 1e-9, math.inf)
    march.prepare(np.zeros((1, 0)))
    derivative = derivative_of_step(march, system.n_free, 1e-10)
    march.residual()
    matrix = full(system, march.matrix())
    assert np.abs(matrix - derivative).max() < 1e-4 * np.abs(matrix).max()


@pytest.mark.parametrize("dim", [2, 3])
def test_the_matrix_of_damping_on_a_body_is_the_derivative_by_velocities(dim, rng):
    obstacle = ancf.Block((0.02, 0.0505, *(0.0,) * (dim - 2)), (0.1,) * dim, radius=0.01)
    scene = ancf.Scene((0.0,) * dim)
    pad = (0.0,) * (dim - 2)
    cable = scene.add_beam("thin", (-0.3, 0, *pad), (0.3, 0, *pad), 12, SECTION, MATERIAL)
    body = scene.add_body(
        mass=0.05,
        inertia=2e-5 if dim == 2 else (2e-5,) * 3,
        position=(0.02, 0.0505, *pad),
    )
    scene.contact(cable, obstacle, on=body, stiffness=1e5, radius=1e-3, restitution=0.5)
    system = System(scene)
    none, rest = np.zeros(0), np.zeros(system.n_all)
    q, n = system.q0 + 2e-4 * rng.normal(size=system.n_all), system.n_free
    lam, v = np.zeros(system.n_multipliers), 1e-3 * rng.normal(size=system.n_all)

    def force(v):
        return system.assembly.residual(q, v, rest, lam, rest, none)[0][:n]

    units = 1e-8 * np.eye(system.n_all)[:n]
    expected = np.array([force(v + e) - force(v - e) for e in units]).T / 2e-8
    values = system.assembly.matrix(0.0, 0.0, q, lam, none, damping_factor=1.0, v=v)
    found = full(system, values)[:n, :n]
    assert np.abs(expected).max() > 1e-3
    assert np.abs(found - expected).max() < 1e-5 * np.abs(expected).max()


def test_forces_in_saved_states_contain_the_damping(tmp_path):
    """1 + gamma times the pressure at rest in compression, 1 - gamma times in restitution."""
    eps = 0.5
    scene, rod, contact = level(2e-3, 1e5, velocity=(0, -1), restitution=eps)
    run = ancf.simulate(scene, 0.02, 1e-4, output=tmp_path / "run.h5")
    depth = 0.005 - run.position(rod.at(0.5))[:, 1]
    speed = -run.velocity(rod.at(0.5))[:, 1]
    force = run.contact_force(contact).force[:, 1]
    deep, gamma = depth > 5e-6, (1 - eps**2) / (1 + eps**2)
    s = speed / (SLOW_RATIO * eps * math.sqrt(1e5 / LINE_MASS) * (depth + 5e-6))
    expected = 1e5 * (depth - 2.5e-6) * (1 + gamma * np.tanh(s))
    assert np.allclose(force[deep], expected[deep], rtol=1e-2)
    assert np.ptp(s[deep]) > 20.0
    k = int(np.argmax(force))
    assert run.contacts(run.t[k])[0].normal_force == pytest.approx(force[k], rel=1e-9)
    stored = ancf.load(tmp_path / "run.h5", scene)
    assert np.array_equal(stored.contact_force(contact).force[:, 1], force)


def test_a_saved_scene_has_its_restitution(tmp_path):
    scene, _, _ = level(0.02, 1e5, restitution=0.5)
    scene.save(tmp_path / "drop.json")
    again = ancf.Scene.load(tmp_path / "drop.json")
    assert again.digest() == scene.digest() != level(0.02, 1e5, restitution=0.6)[0].digest()
    assert again.attachments[0].restitution == 0.5


def test_steps_that_do_not_resolve_an_impact_are_refused():
    scene, _, _ = level(0.02, 1e5, restitution=0.5)
    with pytest.raises(ancf.InputError, match=r"restitution of 0.5 needs a dt of at most 0.000259"):
        ancf.simulate(scene, 0.1, 1e-3)
    dt = longest_step(1e5, 0.5)
    ancf.simulate(scene, 4 * dt, dt)


@pytest.mark.parametrize(
    ("value", "message"),
    [(0.0, "must be positive"), (1.5, "at most 1, got 1.5"), ("a", "restitution of the contact")],
)
def test_other_numbers_are_refused(value, message):
    with pytest.raises(ancf.InputError, match=message):
        level(0.02, 1e5, restitution=value)
