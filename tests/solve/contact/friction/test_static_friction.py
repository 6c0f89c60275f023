"""Static and kinetic coefficients of friction, against closed formulas."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems.contacts import DRUM_RADIUS, WIRE_RADIUS
from ancfsparse.system.contributions.force_elements.contact_losses import N_LOSSES
from tests.solve.contact.test_contact_motion import LINE_MASS, MATERIAL, SECTION
from tests.solve.contact.test_moving_obstacles import collision, momenta

STATIC, KINETIC, STIFFNESS = 0.5, 0.3, 1e6
FRICTION = {"friction": KINETIC, "static_friction": STATIC}
WEIGHT = LINE_MASS * 9.81
INTEGRATORS = [ancf.EnergyMomentum(), ancf.GeneralizedAlpha(0.9), ancf.GeneralizedAlpha(0.5)]


def block(slope=0.0, modulus=1e13, **friction):
    """A stiff cable of 1 m at rest on a floor, whose points slide together."""
    along = np.array([math.cos(slope), math.sin(slope)])
    normal = np.array([-along[1], along[0]])
    depth = WEIGHT * math.cos(slope) / STIFFNESS + 2.5e-6
    scene, start = ancf.Scene((0.0, -9.81)), (0.005 - depth) * normal
    material = ancf.Material(modulus, MATERIAL.density)
    rod = scene.add_beam("thin", start, start + along, 4, SECTION, material)
    floor = ancf.HalfSpace((0, 0), tuple(normal))
    contact = scene.contact(rod, floor, stiffness=STIFFNESS, **(friction or FRICTION))
    return scene, rod, contact


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_a_block_starts_at_the_static_and_slides_with_the_kinetic_coefficient(integrator):
    """Under a force that grows to its weight within a second."""
    scene, rod, contact = block()
    scene.distributed_force(rod, ancf.Ramp((WEIGHT, 0.0), 1.0))
    run = ancf.simulate(scene, 0.8, 5e-4, integrator=integrator)
    friction = -run.contact_force(contact).force[:, 0] / WEIGHT
    v, late = run.velocity(rod.at(0.5))[:, 0], run.t > STATIC + 0.02
    sticks = run.t < STATIC - 2e-3
    assert np.abs(v[sticks]).max() < 1e-3
    assert friction.max() == pytest.approx(STATIC, rel=1e-2)
    assert np.argmax(friction) == pytest.approx(STATIC / 5e-4, abs=4)
    np.testing.assert_allclose(friction[late], KINETIC, rtol=1e-9)
    exact = 9.81 * 0.5 * ((run.t - KINETIC) ** 2 - (STATIC - KINETIC) ** 2)
    assert np.abs(v - exact)[late].max() < 0.01


@pytest.mark.parametrize(("ratio", "slides"), [(0.99, False), (1.01, True)])
def test_a_block_on_a_slope_holds_up_to_the_angle_of_static_friction(ratio, slides):
    """A force along the slope that holds it at first decreases to zero within 0.2 s."""
    slope = math.atan(STATIC * ratio)
    scene, rod, _ = block(slope)
    pull = WEIGHT * math.sin(slope) * np.array([math.cos(slope), math.sin(slope)])
    away = ancf.Ramp(tuple(-pull), 0.2, smooth=True)
    scene.distributed_force(rod, tuple(pull))
    scene.distributed_force(rod, away)
    run = ancf.simulate(scene, 0.7, 5e-4, integrator=ancf.GeneralizedAlpha(0.5))
    speed = np.linalg.norm(run.velocity(rod.at(0.5)), axis=1)
    gained = 9.81 * (math.sin(slope) - KINETIC * math.cos(slope)) * 0.4
    assert speed[-1] - speed[-801] == pytest.approx(gained if slides else 0.0, rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_stick_and_slip_of_a_block_on_a_spring(integrator):
    """Pulled at V: y = A cos wt + V/w sin wt from the kinetic friction on, until y' is V again.

    Sticking lasts 2 A / V with A = (mu_s - mu) w / c, sliding 2 (pi - atan(A w / V)) / w.
    """
    speed, spring = 0.05, 40.0
    scene, rod, _ = block()
    position = (2.0, rod.end.position[1])
    hook = scene.add_body(mass=1.0, inertia=1.0, position=position, velocity=(speed, 0.0))
    scene.drive(hook.origin, lambda t: (2.0 + speed * t, position[1]))
    scene.spring(rod.end, hook.origin, stiffness=spring)
    dt = 2e-4
    run = ancf.simulate(scene, 6.0, dt, integrator=integrator)
    force = spring * (1.0 + speed * run.t - run.position(rod.end)[:, 0]) / WEIGHT

    amplitude, rate = (STATIC - KINETIC) * WEIGHT / spring, math.sqrt(spring / LINE_MASS)
    slip = 2.0 * (math.pi - math.atan(amplitude * rate / speed)) / rate
    period = 2.0 * amplitude / speed + slip
    largest = math.hypot(amplitude, speed / rate) * spring / WEIGHT
    begin = int(np.argmax(force > 0.9 * STATIC))
    cycles = force[begin:]
    assert cycles.max() == pytest.approx(KINETIC + largest, rel=5e-3)
    assert cycles.min() == pytest.approx(KINETIC - largest, rel=2e-2)
    falls = np.flatnonzero((cycles[:-1] >= KINETIC) & (cycles[1:] < KINETIC)) * dt
    assert len(falls) >= 4
    np.testing.assert_allclose(np.diff(falls), period, rtol=3e-3)
    energy = run.energy
    missing = energy.total - energy.total[0] - energy.work + energy.lost
    assert np.abs(missing).max() < (1e-6 if integrator.keeps_energy else 2e-2) * energy.work[-1]


def wrapped(**drum):
    """A wire around half a drum with a fixed end, pulled at the other one by a force."""
    reach, tension = DRUM_RADIUS + WIRE_RADIUS, 10.0
    scene = ancf.Scene((0.0, 0.0))
    wire = ancf.Rectangle(2 * WIRE_RADIUS, 2 * WIRE_RADIUS), ancf.Material(2.5e10, 2.5e4)
    arc = scene.add_beam(
        "thin", curve=ancf.Arc((0, 0), (-reach, 0), -math.pi), n_elements=50,
        section=wire[0], material=wire[1],
    )  # fmt: skip
    ends = [scene.add_beam("thin", x, (x[0], -0.05), 4, *wire) for x in ((-reach, 0), (reach, 0))]
    scene.connect(arc.start, ends[0].start)
    scene.connect(arc.end, ends[1].start)
    stiffness = 100.0 * tension / (reach * WIRE_RADIUS) * math.exp(0.5 * STATIC * math.pi)
    for part in (arc, *ends):
        scene.contact(
            part, ancf.Drum((0, 0), DRUM_RADIUS, **drum), stiffness=stiffness,
            radius=WIRE_RADIUS, **FRICTION,
        )  # fmt: skip
    return scene, ends, tension


@pytest.mark.parametrize(
    ("held", "slips"),
    [(0.95 * math.exp(KINETIC * math.pi), False), (1.02 * math.exp(STATIC * math.pi), True)],
)
def test_a_wire_holds_between_the_exponentials_of_both_coefficients(held, slips):
    """It stretches, so that one end slides first, from then on with kinetic friction."""
    scene, ends, tension = wrapped()
    for end, force in zip(ends, (tension, held * tension), strict=True):
        scene.point_force(end.end, ancf.Ramp((0.0, -force), 0.4, smooth=True))
    run = ancf.simulate(scene, 1.0, 1e-3, integrator=ancf.GeneralizedAlpha(0.5))
    way = np.linalg.norm(run.displacement(ends[1].end), axis=1)
    if slips:
        assert way[-1] > 1.0
    else:
        assert way.max() < 1e-3
        assert abs(way[-1] - way[700]) < 1e-8


def test_a_wire_on_a_turning_drum_slides_with_the_kinetic_coefficient():
    scene, ends, tension = wrapped(angular_velocity=-2.0)
    scene.pin(ends[0].end)
    scene.point_force(ends[1].end, ancf.Ramp((0.0, -tension), 0.05, smooth=True))
    run = ancf.simulate(scene, 0.3, 1e-3, integrator=ancf.GeneralizedAlpha(0.5))
    held = np.linalg.norm(run.reaction(ends[0].end), axis=1)[-100:].mean()
    assert held == pytest.approx(tension * math.exp(KINETIC * math.pi), rel=1e-3)


@pytest.mark.parametrize("dim", [2, 3])
def test_momenta_are_kept_and_no_step_gains_energy(dim):
    scene, *_ = collision(dim, offset=0.02, friction=0.1, static_friction=0.4)
    run = ancf.simulate(scene, 0.02, 1e-4, integrator=ancf.EnergyMomentum(), tolerance=1e-12)
    linear, _ = momenta(scene, run)
    assert np.abs(linear - linear[0]).max() < 1e-10
    energy = run.energy
    assert energy.drift < 1e-9
    assert energy.friction[-1] > 1e-4 * energy.total[0]
    assert energy.friction.min() > -1e-12 * energy.total[0]


def test_whether_points_slide_is_stored_with_states(tmp_path):
    def scene():
        made, rod, contact = block()
        made.distributed_force(rod, ancf.Ramp((WEIGHT, 0.0), 0.02))
        return made, contact

    options = {"integrator": ancf.GeneralizedAlpha(0.5), "solver": ancf.Newton()}
    made, contact = scene()
    whole = ancf.simulate(made, 0.03, 5e-4, **options, output=tmp_path / "run.h5")
    n = len(contact.points)
    slides = whole.internal[:, 2 * n : -N_LOSSES]
    assert slides.shape == (61, n)
    assert not slides[5].any()
    assert slides[-1].all()
    first = ancf.simulate(made, 0.02, 5e-4, **options)
    second = ancf.simulate(made, 0.03, 5e-4, start=first.last, **options)
    assert np.array_equal(second.q[-1], whole.q[-1])
    stored = ancf.load(tmp_path / "run.h5", made)
    friction = stored.contact_force(contact).friction
    assert np.array_equal(friction, whole.contact_force(contact).friction)
    made.save(tmp_path / "block.json")
    again = ancf.Scene.load(tmp_path / "block.json")
    assert again.digest() == made.digest()
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
        block(**options)


def test_equal_coefficients_are_one():
    one, other = (block(friction=0.3, **more)[0] for more in ({}, {"static_friction": 0.3}))
    for scene in (one, other):
        scene.distributed_force(scene.beams[0], ancf.Ramp((WEIGHT, 0.0), 0.02))
    runs = [ancf.simulate(scene, 0.03, 1e-3) for scene in (one, other)]
    assert np.array_equal(runs[0].q, runs[1].q)
