"""Static and kinetic coefficients of friction between beams, against closed formulas."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import EquilibriumError, SingularSceneError
from ancfsparse.system.contributions.force_elements.contact_losses import N_LOSSES
from tests.solve.contact.friction.test_beam_friction_at_rest import across_rails as at_rest
from tests.solve.contact.friction.test_beam_friction_motion import (
    MATERIAL,
    RADIUS,
    SECTION,
    momenta,
    rub,
)

STATIC, KINETIC, STIFFNESS = 0.5, 0.3, 1e8
FRICTION = {"friction": KINETIC, "static_friction": STATIC}
STIFF = ancf.Material(1e11, MATERIAL.density)
WEIGHT = STIFF.density * SECTION.area * 0.8 * 9.81
INTEGRATORS = [ancf.EnergyMomentum(), ancf.GeneralizedAlpha(0.9), ancf.GeneralizedAlpha(0.5)]


def on_rails(n=16, law=FRICTION):
    """A stiff rod across two rails of n elements each, along which it slides."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    rails = []
    for y in (-0.2, 0.2):
        rail = scene.add_beam("thin", (-0.3, y, 0), (1.3, y, 0), n, SECTION, MATERIAL)
        for k in range(n + 1):
            scene.clamp(rail.node(k))
        rails.append(rail)
    # Two crossings at a right angle that bear it: 4/3 sqrt(2 d) k e^1.5 each, with d of 2 radii.
    depth = (0.5 * WEIGHT / (4.0 / 3.0 * math.sqrt(4.0 * RADIUS) * STIFFNESS)) ** (2.0 / 3.0)
    ends = [(0.03, y, 2.0 * RADIUS - depth) for y in (-0.4, 0.4)]
    rod = scene.add_beam("thin", *ends, 8, SECTION, STIFF)
    return scene, rod, [scene.contact(rail, rod, stiffness=STIFFNESS, **law) for rail in rails]


def pulled(scene, rod, signal):
    """The scene with a force along the rails, of multiples of the weight."""
    scene.distributed_force(rod, signal)
    return scene


def along(values):
    """Forces per length of multiples of the weight, as vectors along the rails."""
    return np.outer(values, (WEIGHT / 0.8, 0.0, 0.0)).tolist()


def friction_ratio(run, contacts):
    forces = [run.contact_force(each) for each in contacts]
    sums = (
        np.sum([getattr(each, name) for each in forces], axis=0) for name in ("friction", "size")
    )
    return np.divide(*sums)


def speeds(run, rod):
    return run.velocity(rod.at(0.4))[:, 0]


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_a_rod_starts_at_the_static_and_slides_with_the_kinetic_coefficient(integrator):
    """Under a force that grows to 0.6 of its weight within 0.6 s and then drops: it decelerates."""
    scene, rod, contacts = on_rails()
    times, forces = [0.0, 0.6, 0.601, 1.0], [0.0, 0.6, 0.0, 0.0]
    start = ancf.solve_static(scene)
    scene = pulled(scene, rod, ancf.Table(times, along(forces)))
    run = ancf.simulate(scene, 0.7, 2.5e-4, integrator=integrator, start=start)
    v, ratio = speeds(run, rod), friction_ratio(run, contacts)
    assert np.abs(v[run.t < STATIC - 4e-3]).max() < 1e-3
    assert v[run.t > STATIC + 4e-3][0] > 2e-3
    assert ratio.max() == pytest.approx(STATIC, rel=0.03)
    sliding = (run.t > STATIC + 0.02) & (v > 0.01)
    np.testing.assert_allclose(ratio[sliding], KINETIC, rtol=1e-3)
    grows, falls = (run.t > STATIC + 0.02) & (run.t <= 0.6), sliding & (run.t > 0.605)
    exact = 9.81 * 0.5 * ((run.t - KINETIC) ** 2 - (STATIC - KINETIC) ** 2)
    assert np.abs(v - exact)[grows].max() < 0.01
    slope = np.polyfit(run.t[falls], v[falls], 1)[0]
    assert slope == pytest.approx(-KINETIC * 9.81, rel=0.02)


@pytest.mark.parametrize("integrator", INTEGRATORS[::2], ids=repr)
def test_a_rod_that_slides_over_nodes_of_the_rails_does_not_stick_there(integrator):
    """Each element of a rail begins a new pair, which slides as the one before it does."""
    scene, rod, contacts = on_rails(n=40)
    start = ancf.solve_static(scene)
    pulled(scene, rod, ancf.Table([0.0, 0.02, 1.0], along([0.0, 0.8, 0.8])))
    run = ancf.simulate(scene, 0.3, 1e-4, integrator=integrator, start=start)
    ratio, later = friction_ratio(run, contacts), run.t > 0.1
    assert run.position(rod.at(0.4))[-1, 0] > 0.03 + 4 * 0.04
    assert ratio[later].max() < 1.01 * KINETIC
    gained = speeds(run, rod)[-1] - speeds(run, rod)[later][0]
    expected = (0.8 - KINETIC) * 9.81 * (0.3 - run.t[later][0])
    assert gained == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("integrator", INTEGRATORS[::2], ids=repr)
def test_stick_and_slip_of_a_rod_on_a_spring(integrator):
    """Pulled at V: it sticks for 2 A / V with A = (mu_s - mu) w / c, and slides for a time

    2 (pi - atan(A w / V)) / w, as a block on a floor does.
    """
    speed, spring = 0.1, 100.0
    scene, rod, _ = on_rails()
    start, middle = ancf.solve_static(scene), rod.at(0.4)
    x0, *_ = start.position(middle)

    def pull(positions, velocities, t):
        return [(spring * (x0 + speed * t - positions[0, 0]), 0.0, 0.0)]

    scene.force([middle], pull)
    dt = 5e-4
    run = ancf.simulate(scene, 1.8, dt, integrator=integrator, start=start)
    force = spring * (x0 + speed * run.t - run.position(middle)[:, 0]) / WEIGHT
    mass = WEIGHT / 9.81
    amplitude, rate = (STATIC - KINETIC) * WEIGHT / spring, math.sqrt(spring / mass)
    slip = 2.0 * (math.pi - math.atan(amplitude * rate / speed)) / rate
    period = 2.0 * amplitude / speed + slip
    cycles = force[int(np.argmax(force > 0.9 * STATIC)) :]
    largest = math.hypot(amplitude, speed / rate) * spring / WEIGHT
    assert cycles.max() == pytest.approx(KINETIC + largest, rel=0.03)
    falls = np.flatnonzero((cycles[:-1] >= KINETIC) & (cycles[1:] < KINETIC)) * dt
    assert len(falls) >= 4
    np.testing.assert_allclose(np.diff(falls), period, rtol=0.03)


@pytest.mark.parametrize("velocity", [(2.0, 0.7, -1.0), (0.02, 0.01, -1.0)], ids=["fast", "slow"])
def test_momentum_is_kept_and_no_step_gains_energy(velocity):
    scene, contact = rub(slip_speed=None, velocity=velocity, static_friction=0.6)
    integrator = ancf.EnergyMomentum()
    run = ancf.simulate(scene, 4e-3, 5e-5, integrator=integrator, tolerance=1e-12, max_halvings=4)
    force, energy = run.contact_force(contact), run.energy
    assert force.friction.max() > 1e-3 * force.size.max()
    assert np.all(force.friction <= 0.6 * force.size)
    assert energy.friction[-1] > 1e-6 * energy.kinetic[0]
    held = energy.total + energy.friction
    assert np.abs(held - held[0]).max() < 1e-10 * energy.kinetic[0]
    assert energy.friction.min() > -1e-12 * energy.kinetic[0]
    change = momenta(run, -1) - momenta(run, 0)
    assert np.abs(change[:3]).max() < 1e-12 * np.abs(momenta(run, 0)[:3]).max()


def test_a_rod_rests_under_a_force_between_both_coefficients():
    """Where the kinetic one alone would let it slide."""
    ratio, weight = 0.4, at_rest_weight()
    scene, rod, contacts = at_rest(law=FRICTION)
    scene.distributed_force(rod, (ratio * weight / 0.6, 0.0, 0.0))
    rest = ancf.solve_static(scene)
    assert rest.stable
    pull = sum(rest.contact_force(each).force[0] for each in contacts)
    assert pull == pytest.approx(ratio * weight, rel=1e-5)
    run = ancf.simulate(scene, 0.02, 1e-3, start=rest, integrator=ancf.GeneralizedAlpha(0.5))
    assert np.abs(run.q - rest.q).max() < 1e-8
    scene, rod, _ = at_rest(law=FRICTION)
    scene.distributed_force(rod, (1.1 * STATIC * weight / 0.6, 0.0, 0.0))
    with pytest.raises((EquilibriumError, SingularSceneError)):
        ancf.solve_static(scene)


def at_rest_weight():
    return 0.6 * MATERIAL.density * SECTION.area * 9.81


def test_a_rod_that_is_drawn_slowly_resists_with_both_coefficients():
    """Up to mu_s N, then with mu N; after a turn with mu_s N once more, since it has stuck."""
    depth, reach = 1e-4, 1e-3
    scene, rod, _ = at_rest(1e13, 0.0, depth, law=FRICTION)
    for end in (rod.start, rod.end):
        way = np.outer([0.0, reach, -reach], (1.0, 0.0, 0.0))
        scene.drive(end, ancf.Table([0.0, 1.0, 2.0], (end.position + way).tolist(), smooth=True))
    run = ancf.quasi_static(scene, 2.0, 0.02)
    pull = sum(run.reaction(end)[:, 0] for end in (rod.start, rod.end))
    stiffness = 1e6
    normal = 4.0 / 3.0 * math.sqrt(2.0 * (2.0 * RADIUS - depth)) * stiffness * depth**1.5
    scaled = pull / (2.0 * normal)
    assert scaled[:51].max() == pytest.approx(STATIC, rel=0.03)
    np.testing.assert_allclose(scaled[25:35], KINETIC, rtol=1e-2)
    assert scaled[51:].min() == pytest.approx(-STATIC, rel=0.03)
    np.testing.assert_allclose(scaled[85:95], -KINETIC, rtol=1e-2)


def test_a_rod_that_is_drawn_slowly_over_nodes_slides_on():
    """The pair that takes over the overlap does not stick anew, up to mu_s N."""
    depth, stiffness = 1e-4, 1e6
    scene, rod, _ = at_rest(1e13, 0.0, depth, law=FRICTION)
    for end in (rod.start, rod.end):
        way = np.outer([0.0, -0.016], (1.0, 0.0, 0.0))  # past the nodes of both rails at x = 0
        scene.drive(end, ancf.Table([0.0, 1.0], (end.position + way).tolist(), smooth=True))
    run = ancf.quasi_static(scene, 1.0, 0.0125)
    pull = sum(run.reaction(end)[:, 0] for end in (rod.start, rod.end))
    normal = 4.0 / 3.0 * math.sqrt(2.0 * (2.0 * RADIUS - depth)) * stiffness * depth**1.5
    np.testing.assert_allclose(pull[20:] / (2.0 * normal), -KINETIC, rtol=2e-2)


def test_modes_have_the_bristles_of_rods_that_stick_above_the_kinetic_friction():
    """And lack them where a rod slides with it."""
    stuck, rod, _ = on_rails()
    start = ancf.solve_static(stuck)
    pulled(stuck, rod, ancf.Table([0.0, 0.4, 1.0], along([0.0, 0.4, 0.4])))
    run = ancf.simulate(stuck, 0.42, 1e-3, start=start, integrator=ancf.GeneralizedAlpha(0.5))
    sliding, rod, _ = on_rails()
    pulled(sliding, rod, ancf.Table([0.0, 0.02, 1.0], along([0.0, 0.6, 0.6])))
    slid = ancf.simulate(sliding, 0.1, 1e-3, start=start, integrator=ancf.GeneralizedAlpha(0.5))
    assert speeds(slid, rod)[-1] > 0.1
    lowest = [ancf.modes(each.system.scene, 3, at=each.last).frequencies for each in (run, slid)]
    assert lowest[0].min() > 10.0 > lowest[1].min()


def test_whether_pairs_slide_is_stored_with_states(tmp_path):
    def made():
        scene, rod, contacts = on_rails()
        return pulled(scene, rod, ancf.Table([0.0, 0.02, 1.0], along([0.0, 0.6, 0.6]))), contacts

    options = {"integrator": ancf.GeneralizedAlpha(0.5), "solver": ancf.Newton()}
    scene, contacts = made()
    whole = ancf.simulate(scene, 0.03, 5e-4, **options, output=tmp_path / "run.h5")
    slots = whole.internal.reshape(61, len(contacts), -1)[..., :-N_LOSSES].reshape(61, -1, 6)
    touches = slots[..., 0] > 0.0
    assert touches.any(axis=1)[1:].all()
    assert not slots[5, :, 5].any()
    assert (slots[-1, :, 5] == touches[-1]).all()
    first = ancf.simulate(scene, 0.02, 5e-4, **options)
    second = ancf.simulate(scene, 0.03, 5e-4, start=first.last, **options)
    assert np.array_equal(second.q[-1], whole.q[-1])
    stored = ancf.load(tmp_path / "run.h5", scene)
    for each in contacts:
        friction = stored.contact_force(each).friction
        assert np.array_equal(friction, whole.contact_force(each).friction)
    scene.save(tmp_path / "scene.json")
    again = ancf.Scene.load(tmp_path / "scene.json")
    assert again.digest() == scene.digest()
    assert again.attachments[0].static_friction == STATIC


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"friction": 0.5, "static_friction": 0.3}, "at most as large, got 0.5"),
        ({"static_friction": 0.3}, "must be positive and at most as large, got 0"),
        ({"friction": 0.1, "static_friction": -1.0}, "static_friction of the contact of beam 0"),
        ({**FRICTION, "slip_speed": 0.1}, "is for points that stick: leave slip_speed out"),
    ],
)
def test_other_numbers_are_refused(options, message):
    with pytest.raises(ancf.InputError, match=message):
        on_rails(law=options)


def test_equal_coefficients_are_one():
    runs = []
    for more in ({}, {"static_friction": KINETIC}):
        scene, rod, _ = on_rails(law={"friction": KINETIC, **more})
        pulled(scene, rod, ancf.Table([0.0, 0.02, 1.0], along([0.0, 0.6, 0.6])))
        runs.append(ancf.simulate(scene, 0.03, 1e-3))
    assert np.array_equal(runs[0].q, runs[1].q)
