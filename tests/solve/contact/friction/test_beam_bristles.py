"""Beams that stick to each other: creep, capstans, momentum, losses and history."""

import dataclasses
import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.results.fields import energy_balance
from tests.solve.contact.friction.test_beam_friction_motion import (
    CONSERVING,
    FRICTION,
    MATERIAL,
    RADIUS,
    SECTION,
    momenta,
    rub,
)

DAMPED = ancf.GeneralizedAlpha(0.5)


def rod_on_rails(pull, friction=FRICTION, speed=0.0, **law):
    """A stiff rod across two rails, pulled along them by a multiple of mu times its weight."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    rails = []
    for y in (-0.2, 0.2):
        rail = scene.add_beam("thin", (-0.3, y, 0), (0.5, y, 0), 4, SECTION, MATERIAL)
        for k in range(5):
            scene.clamp(rail.node(k))
        rails.append(rail)
    stiff, stiffness = ancf.Material(1e11, 5e3), 1e8
    weight = stiff.density * SECTION.area * 0.8 * 9.81
    # Two crossings at a right angle that bear it: 4/3 sqrt(2 d) k e^1.5 each, with d of 2 radii.
    depth = (0.5 * weight / (4.0 / 3.0 * math.sqrt(4.0 * RADIUS) * stiffness)) ** (2.0 / 3.0)
    start, end = (0.03, -0.4, 2.0 * RADIUS - depth), (0.03, 0.4, 2.0 * RADIUS - depth)
    rod = scene.add_beam("thin", start, end, 8, SECTION, stiff, velocity=(speed, 0.0, 0.0))
    force = ancf.Ramp((pull * FRICTION * weight / 0.8, 0.0, 0.0), 0.2, smooth=True)
    scene.distributed_force(rod, force)
    law = {"stiffness": stiffness, "friction": friction, **law}
    return scene, rod, [scene.contact(each, rod, **law) for each in rails], weight


def test_a_rod_that_is_pulled_by_less_than_mu_times_its_weight_does_not_creep():
    """Although it oscillates on its contacts, whose overlaps change in each cycle."""
    scene, rod, contacts, weight = rod_on_rails(0.9)
    run = ancf.simulate(scene, 3.0, 1e-3, integrator=DAMPED)
    x = run.position(rod.at(0.4))[:, 0] - 0.03
    means = x[501:].reshape(10, 250).mean(axis=1)
    assert np.ptp(means) < 2e-7  # it would be 4e-5 if bristles were lost as overlaps shrink
    assert 2e-5 < means[-1] < 1e-4
    forces = [run.contact_force(each) for each in contacts]
    along = sum(each.force[-1000:, 0].mean() for each in forces)  # on the rails
    assert along == pytest.approx(0.9 * FRICTION * weight, rel=1e-3)


def test_a_rod_that_is_pulled_by_more_slides_with_mu_times_the_normal_force():
    scene, rod, contacts, weight = rod_on_rails(1.2)
    run = ancf.simulate(scene, 0.5, 1e-4, integrator=DAMPED)
    assert run.velocity(rod.at(0.4))[-1, 0] > 0.15
    forces = [run.contact_force(each) for each in contacts]
    sizes, friction = (
        np.sum([getattr(each, name) for each in forces], axis=0) for name in ("size", "friction")
    )
    # Friction is limited by the pressure with the numerical damping of impacts.
    ratios = friction[2500:] / (FRICTION * sizes[2500:])
    assert ratios.mean() == pytest.approx(1.0, rel=2e-3)
    assert ratios.max() < 1.0 + 1e-9
    impulse = momenta(run, -1)[0] - momenta(run, 2500)[0]
    pull = 1.2 * FRICTION * weight
    assert impulse == pytest.approx(0.25 * pull - 1e-4 * friction[2501:].sum(), rel=0.05)
    table = run.contacts()
    assert sum(each.friction for each in table) == pytest.approx(friction[-1], rel=1e-12)


@pytest.mark.parametrize(
    ("speed", "dt", "share"), [(0.15, 1e-3, 0.0072), (0.3, 1e-3, 0.016), (0.3, 2e-4, 0.003)]
)
def test_the_damping_of_impacts_brakes_a_crossing_that_slides(speed, dt, share):
    """Without friction, by the fraction of the weight that docs/limits.md states."""
    scene, _, _, weight = rod_on_rails(0.0, 0.0, speed)
    run = ancf.simulate(scene, 0.3, dt, integrator=DAMPED)
    lost = momenta(run, 0)[0] - momenta(run, -1)[0]
    assert lost / (0.3 * weight) == pytest.approx(share, rel=0.1)


@pytest.mark.parametrize("dt", [5e-5, 2e-4])
@pytest.mark.parametrize("velocity", [(2.0, 0.7, -1.0), (0.02, 0.01, -1.0)], ids=["fast", "slow"])
def test_friction_keeps_momentum_and_is_in_the_balance(velocity, dt):
    scene, contact = rub(slip_speed=None, velocity=velocity)
    run = ancf.simulate(scene, 4e-3, dt, integrator=CONSERVING, tolerance=1e-12, max_halvings=4)
    force, energy = run.contact_force(contact), run.energy
    largest = energy.kinetic.max()
    assert force.size.max() > 10.0
    assert np.all(force.friction <= FRICTION * force.size)
    assert force.friction.max() > 0.01 * FRICTION * force.size.max()
    assert energy.friction[-1] > 1e-6 * largest
    held = energy.total + energy.friction
    assert np.abs(held - held[0]).max() < 1e-11 * largest
    assert run.last.memory["watch"]["work"] == pytest.approx(-energy.friction[-1], rel=1e-9)
    change = momenta(run, -1) - momenta(run, 0)
    assert np.abs(change[:3]).max() < 1e-12 * np.abs(momenta(run, 0)[:3]).max()


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.HHT(0.1)], ids=repr)
def test_other_schemes_count_friction_by_the_trapezoidal_rule(integrator, monkeypatch):
    scene, _ = rub(slip_speed=None)
    run = ancf.simulate(scene, 4e-3, 2.5e-5, integrator=integrator)
    energy = run.energy
    assert energy.friction[-1] > 1e-2 * energy.kinetic.max()
    assert energy.drift < 2e-5
    assert run.last.memory["watch"]["work"] == pytest.approx(-energy.friction[-1], rel=1e-9)
    monkeypatch.setattr(energy_balance, "BLOCK_SIZE", 3 * run.q.shape[1])
    again = dataclasses.replace(run).energy
    for name in ("friction", "impact_damping"):
        np.testing.assert_allclose(getattr(again, name), getattr(energy, name), rtol=1e-12)
    rare = ancf.simulate(scene, 4e-3, 2.5e-5, integrator=integrator, save_every=2).energy
    assert rare.friction[-1] == pytest.approx(energy.friction[-1], rel=0.02)


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), CONSERVING], ids=repr)
def test_history_is_stored_with_states_and_a_run_continues_bit_for_bit(tmp_path, integrator):
    options = {"integrator": integrator, "solver": ancf.Newton(), "max_halvings": 4}
    made, contact = rub(slip_speed=None)
    whole = ancf.simulate(made, 4e-3, 1e-4, **options)
    first = ancf.simulate(made, 1e-3, 1e-4, **options)
    assert first.contact_force(contact).friction[-1] > 0.0
    assert first.internal[-1].any()
    second = ancf.simulate(made, 4e-3, 1e-4, start=first.last, **options)
    assert np.array_equal(second.q[-1], whole.q[-1])
    assert np.array_equal(second.internal[-1], whole.internal[-1])
    works = (each.last.memory["watch"]["work"] for each in (whole, second))
    assert next(works) == next(works)
    ancf.simulate(made, 4e-3, 1e-4, output=tmp_path / "run.h5", **options)
    stored = ancf.load(tmp_path / "run.h5", made)
    assert np.array_equal(stored.internal, whole.internal)
    friction = [each.contact_force(contact).friction for each in (stored, whole)]
    assert np.array_equal(*friction)


WIRE, RING_RADIUS = 1e-3, 0.1  # radius of the wire, and of the axis of a ring [m]


@pytest.mark.parametrize(("ratio", "slips"), [(0.98, False), (1.05, True)])
def test_a_wire_around_a_ring_of_wire_holds_up_to_the_load_of_euler_and_eytelwein(ratio, slips):
    """Half a turn: tensions at the ends of up to exp(mu phi), and none moves by a nanometre."""
    mu, phi, tension = 0.3, math.pi, 10.0
    reach = RING_RADIUS + 2.0 * WIRE
    scene = ancf.Scene((0.0, 0.0))
    wire = ancf.Rectangle(2.0 * WIRE, 2.0 * WIRE), ancf.Material(2.5e10, 2.5e4)
    more = 0.3  # of the ring at either end [rad]
    begin = -RING_RADIUS * math.cos(more), -RING_RADIUS * math.sin(more)
    shapes = ancf.Arc((0, 0), begin, -phi - 2.0 * more), ancf.Arc((0, 0), (-reach, 0), -phi)
    ring, arc = (
        scene.add_beam("thin", curve=each, n_elements=n, section=wire[0], material=wire[1])
        for each, n in zip(shapes, (60, 50), strict=True)
    )
    for k in range(61):
        scene.clamp(ring.node(k))
    ends = [scene.add_beam("thin", x, (x[0], -0.05), 4, *wire) for x in ((-reach, 0), (reach, 0))]
    scene.connect(arc.start, ends[0].start)
    scene.connect(arc.end, ends[1].start)
    for end, force in zip(ends, (tension, ratio * tension * math.exp(mu * phi)), strict=True):
        scene.point_force(end.end, ancf.Ramp((0.0, -force), 0.2, smooth=True))
    stiffness = 100.0 * tension / (reach * WIRE) * math.exp(0.5 * mu * phi)
    for part in (arc, *ends):
        scene.contact(part, ring, stiffness=stiffness, radius=WIRE, friction=mu)
    run = ancf.simulate(scene, 1.0, 1e-3, integrator=DAMPED, max_halvings=5)
    way = np.linalg.norm(run.displacement(ends[1].end), axis=1)
    if slips:
        assert way[-1] > 0.01
    else:
        assert way.max() < 1e-3
        assert abs(way[-1] - way[500]) < 1e-8


def test_explicit_integrators_need_a_slip_speed():
    scene, _ = rub(slip_speed=None)
    with pytest.raises(ancf.InputError, match="contacts that stick: give them a slip_speed"):
        ancf.simulate(scene, 1e-3, 1e-6, integrator=ancf.DormandPrince())


def test_the_scene_is_saved_and_names_a_contact_that_sticks(tmp_path):
    scene, _ = rub(slip_speed=None)
    assert "0.3" in str(scene)
    scene.save(tmp_path / "scene.json")
    loaded = ancf.Scene.load(tmp_path / "scene.json")
    assert loaded.attachments[0].sticks
    assert str(loaded) == str(scene)
