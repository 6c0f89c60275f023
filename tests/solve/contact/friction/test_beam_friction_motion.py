"""Cables that rub on each other: momentum, losses, the balance, and deceleration by mu p."""

import dataclasses
import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.results.fields import energy_balance

RADIUS = 0.005
SECTION, MATERIAL = ancf.Circle(2.0 * RADIUS), ancf.Material(1e8, 5e3)
CONSERVING = ancf.EnergyMomentum()
FRICTION, SLIP_SPEED = 0.3, 1e-3


def rub(stiffness=1e7, friction=FRICTION, slip_speed=0.05, velocity=(2.0, 0.7, -1.0), **law):
    """Two free cables that meet at a right angle; the upper one moves askew."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    lower = scene.add_beam("thin", (-0.4, 0.05, 0), (0.6, 0.05, 0), 6, SECTION, MATERIAL)
    upper = scene.add_beam(
        "thin", (0, -0.5, 0.0105), (0, 0.5, 0.0105), 6, SECTION, MATERIAL, velocity=velocity
    )
    options = {"stiffness": stiffness, "friction": friction, "slip_speed": slip_speed, **law}
    return scene, scene.contact(lower, upper, **options)


def momenta(run, k):
    """Momentum and moment of momentum of a state, (6,)."""
    system, q, v = run.system, run.q[k], run.v[k]
    p = system.assembly.inertia(v)
    turning = np.zeros(3)
    for name in ("r", "r_x"):
        for places in system.vectors(name):
            turning += np.cross(q[places], p[places]).sum(axis=0)
    return np.array([*(p @ system.uniform(c) for c in range(3)), *turning])


@pytest.mark.parametrize("dt", [5e-5, 2e-4])
def test_rubbing_keeps_momentum_and_its_loss_is_in_the_balance(dt):
    scene, contact = rub()
    run = ancf.simulate(scene, 4e-3, dt, integrator=CONSERVING, tolerance=1e-12, max_halvings=4)
    force, energy = run.contact_force(contact), run.energy
    largest = energy.kinetic.max()
    assert force.size.max() > 10.0
    assert np.all(force.friction <= FRICTION * force.size)
    assert force.friction.max() > 0.9 * FRICTION * force.size.max()
    assert energy.friction[-1] > 1e-2 * largest
    assert np.diff(energy.friction).min() >= 0.0
    held = energy.total + energy.friction
    assert np.abs(held - held[0]).max() < 1e-9 * largest
    assert run.last.memory["watch"]["work"] == pytest.approx(-energy.friction[-1], rel=1e-9)
    change = momenta(run, -1) - momenta(run, 0)
    assert np.abs(change[:3]).max() < 1e-12 * np.abs(momenta(run, 0)[:3]).max()


def test_friction_turns_the_cables_by_its_lever_alone():
    """A distance of both axes times the change of momentum along the surface."""
    scene, _ = rub()
    run = ancf.simulate(scene, 4e-3, 1e-4, integrator=CONSERVING, tolerance=1e-12, max_halvings=4)
    change = momenta(run, -1) - momenta(run, 0)
    system, body = run.system, np.zeros(run.system.n_all, dtype=bool)
    body[system.vectors("r")[1].ravel()] = True
    body[system.vectors("r_x")[1].ravel()] = True
    p = [system.assembly.inertia(run.v[k]) * body for k in (0, -1)]
    impulse = np.array([(p[1] - p[0]) @ system.uniform(c) for c in range(3)])
    lever = np.array([0.0, 0.0, 2.0 * RADIUS])
    expected = np.cross(lever, impulse)[:2]  # on the upper one, which is above
    assert np.hypot(*expected) > 1e-4
    assert np.hypot(*(change[3:5] - expected)) < 0.1 * np.hypot(*expected)


@pytest.mark.parametrize(
    ("integrator", "drift"), [(ancf.GeneralizedAlpha(0.9), 2e-3), (ancf.HHT(0.1), 2e-3)]
)
def test_other_schemes_count_friction_by_the_trapezoidal_rule(integrator, drift, monkeypatch):
    scene, _ = rub()
    run = ancf.simulate(scene, 4e-3, 2.5e-5, integrator=integrator)
    energy = run.energy
    assert energy.friction[-1] > 1e-2 * energy.kinetic.max()
    assert energy.drift < drift
    watched = run.last.memory["watch"]["work"]
    assert watched == pytest.approx(-energy.friction[-1], rel=1e-9)
    monkeypatch.setattr(energy_balance, "BLOCK_SIZE", 3 * run.q.shape[1])
    again = dataclasses.replace(run).energy
    for name in ("friction", "impact_damping"):
        np.testing.assert_allclose(getattr(again, name), getattr(energy, name), rtol=1e-12)


def test_explicit_runs_lose_the_same_to_friction():
    scene, _ = rub(1e6)
    lost = ancf.simulate(scene, 4e-3, 2e-5, integrator=CONSERVING).energy.friction[-1]
    run = ancf.simulate(scene, 4e-3, 1e-6, integrator=ancf.DormandPrince())
    assert run.energy.friction[-1] == pytest.approx(lost, rel=1e-3)
    assert run.energy.drift < 1e-4


def test_a_cable_that_slides_across_others_decelerates_by_mu_times_its_weight():
    """On two rails, where it lies in equilibrium; the speed is far above the slip speed."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    rails = []
    for y in (-0.2, 0.2):
        rail = scene.add_beam("thin", (-0.3, y, 0), (0.5, y, 0), 4, SECTION, MATERIAL)
        for k in range(5):
            scene.clamp(rail.node(k))
        rails.append(rail)
    stiff = ancf.Material(1e11, 5e3)
    weight = stiff.density * SECTION.area * 0.8 * 9.81
    # Two crossings at a right angle that bear it: 4/3 sqrt(2 d) k e^1.5 each.
    stiffness, depth = 1e8, 0.0
    for _ in range(50):
        d = 2.0 * RADIUS - depth
        depth = (0.5 * weight / (4.0 / 3.0 * math.sqrt(2.0 * d) * stiffness)) ** (2.0 / 3.0)
    z = 2.0 * RADIUS - depth
    rod = scene.add_beam("thin", (0, -0.4, z), (0, 0.4, z), 8, SECTION, stiff, velocity=(1.0, 0, 0))
    options = {"stiffness": stiffness, "friction": FRICTION, "slip_speed": SLIP_SPEED}
    contacts = [scene.contact(rail, rod, **options) for rail in rails]
    run = ancf.simulate(scene, 0.2, 2e-4, integrator=CONSERVING)
    momentum = np.array([momenta(run, k)[0] for k in (0, -1)])
    mass = weight / 9.81
    assert momentum[0] - momentum[1] == pytest.approx(FRICTION * weight * 0.2, rel=1e-2)
    assert momentum[1] / mass > 100.0 * SLIP_SPEED
    forces = [run.contact_force(each) for each in contacts]
    assert sum(each.force[-100:, 0].mean() for each in forces) == pytest.approx(
        FRICTION * sum(each.size[-100:].mean() for each in forces), rel=1e-2
    )
    table = run.contacts()
    assert sum(each.friction for each in table) == pytest.approx(
        sum(each.friction[-1] for each in forces), rel=1e-12
    )
    assert [each.sliding_speed for each in table] == pytest.approx(
        [momentum[1] / mass] * len(table), rel=1e-2
    )


@pytest.mark.parametrize("slip_speed", [0.01, None])
def test_a_loop_rubs_on_itself(slip_speed):
    scene = ancf.Scene((0.0, 0.0, 0.0))
    height = 7.2 * RADIUS
    loop = scene.add_beam(
        "thin", curve=ancf.Helix(0.1, pitch=6.0 * RADIUS, turns=1.2), rest="straight",
        n_elements=44, section=SECTION, material=MATERIAL,
        velocity=lambda x: np.outer(1.0 - 2.0 * x[:, 2] / height, (0.0, 0.0, 1.0)),
    )  # fmt: skip
    contact = scene.contact(loop, loop, stiffness=1e7, friction=0.4, slip_speed=slip_speed)
    run = ancf.simulate(scene, 0.04, 2e-4, integrator=CONSERVING, max_halvings=6)
    force, energy = run.contact_force(contact), run.energy
    assert force.friction.max() > 0.1
    assert np.allclose(force.force, 0.0, atol=1e-12 * force.size.max())
    assert energy.friction[-1] > 1e-6 * energy.kinetic.max()
    assert energy.drift < 1e-6


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), CONSERVING], ids=repr)
def test_a_run_in_two_parts_is_one_run_bit_for_bit(integrator):
    options = {"integrator": integrator, "solver": ancf.Newton(), "max_halvings": 4}
    whole = ancf.simulate(rub()[0], 4e-3, 1e-4, **options)
    scene, contact = rub()
    first = ancf.simulate(scene, 1e-3, 1e-4, **options)
    assert first.contact_force(contact).friction[-1] > 0.0
    second = ancf.simulate(scene, 4e-3, 1e-4, start=first.last, **options)
    assert np.array_equal(second.q[-1], whole.q[-1])
    works = (each.last.memory["watch"]["work"] for each in (whole, second))
    assert next(works) == next(works)
