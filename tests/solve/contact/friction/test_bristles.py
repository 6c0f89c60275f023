"""Friction of bristles: what sticks stays, against formulas."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems.contacts import DRUM_RADIUS, WIRE_RADIUS, bristle
from ancfsparse.scene.force_elements.contacts import GRIP_RATIO
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.system import System
from tests.matrices import derivative_of_step, full
from tests.solve.contact.test_contact_motion import LINE_MASS, level
from tests.solve.contact.test_moving_obstacles import collision, momenta

STIFFNESS = 1e5
DEPTH = LINE_MASS * 9.81 / STIFFNESS + 2.5e-6  # at rest, with half of the layer [m]
BOTH = [ancf.GeneralizedAlpha(0.5), ancf.EnergyMomentum()]


@pytest.mark.parametrize("integrator", BOTH, ids=repr)
def test_what_sticks_moves_by_the_force_over_the_stiffness_and_back(integrator):
    mu, weight = 0.5, LINE_MASS * 9.81
    scene, rod, contact = level(-DEPTH, STIFFNESS, friction=mu)
    pull = ancf.Ramp((0.8 * mu * weight, 0.0), 0.1, smooth=True)
    back = ancf.Ramp((-0.8 * mu * weight, 0.0), 0.4, 0.3, smooth=True)
    scene.distributed_force(rod, pull + back)
    run = ancf.simulate(scene, 0.6, 1e-3, integrator=integrator)
    x, slack = run.position(rod.at(0.5))[:, 0] - 0.5, 0.8 * mu * weight / (GRIP_RATIO * STIFFNESS)
    assert x[200:300].mean() == pytest.approx(slack, rel=1e-2)
    assert abs(x[500:].mean()) < 0.01 * slack
    friction = run.contact_force(contact).force[:, 0]
    assert friction[200:300].mean() == pytest.approx(-0.8 * mu * weight, rel=1e-2)


def driven_loop():
    """A cable at rest whose ends are led forth and back on a floor, and its contact."""
    reach = 1e-3
    scene, rod, contact = level(-DEPTH, STIFFNESS, friction=0.5)
    for end in (rod.start, rod.end):
        x, y = end.position
        motion = ancf.Table([0.0, 0.5, 1.5], [(x, y), (x + reach, y), (x - reach, y)], smooth=True)
        scene.drive(end, motion)
    return scene, rod, contact


def test_friction_follows_the_loop_of_a_reversed_motion():
    """A parallelogram at each point: the slope of the bristles, and the limit of the pressure."""
    mu, weight = 0.5, LINE_MASS * 9.81
    scene, _, contact = driven_loop()
    run = ancf.simulate(scene, 1.5, 1e-3, integrator=ancf.GeneralizedAlpha(0.5))
    forces, slope = run.contact_force(contact), GRIP_RATIO * STIFFNESS
    places = np.stack([run.position(point)[:, 0] for point in contact.points], axis=1)
    limits, z = mu * forces.pressure / slope, np.zeros_like(places)
    for k, dx in enumerate(np.diff(places, axis=0), 1):
        z[k] = np.clip(z[k - 1] + dx, -limits[k], limits[k])
    assert np.abs(forces.friction[..., 0] + slope * z).max() < 1e-3 * mu * weight
    assert forces.friction[400:480, :, 0].mean() == pytest.approx(-mu * weight, rel=0.02)
    assert forces.friction[1300:1480, :, 0].mean() == pytest.approx(mu * weight, rel=0.02)


@pytest.mark.parametrize("integrator", BOTH, ids=repr)
def test_drives_carry_friction_and_supply_what_it_takes(integrator):
    scene, rod, contact = driven_loop()
    run = ancf.simulate(scene, 1.5, 1e-3, integrator=integrator)
    friction = run.contact_force(contact).force[:, 0]
    drives = run.reaction(rod.start)[:, 0] + run.reaction(rod.end)[:, 0]
    slides = slice(400, 480), slice(1300, 1480)
    assert [drives[k].mean() for k in slides] == pytest.approx(
        [-friction[k].mean() for k in slides], rel=0.02
    )
    energy = run.energy
    missing = energy.total - energy.total[0] - energy.work + energy.lost
    assert np.abs(missing).max() < 0.01 * energy.friction.max()


@pytest.mark.parametrize("integrator", BOTH, ids=repr)
def test_the_bearing_of_a_pulley_carries_friction_too(integrator):
    scene = ancf.Scene((0.0, 0.0))
    pulley = scene.add_body(mass=0.05, inertia=4e-4, position=(0.0, 0.0))
    pin = scene.pin(pulley.origin)
    rope = scene.add_beam(
        "thin",
        curve=ancf.Arc((0, 0), (-0.101, 0), -math.pi),
        n_elements=30,
        section=ancf.Circle(0.002),
        material=ancf.Material(1e9, 4e3),
    )
    contact = scene.contact(rope, ancf.Drum((0, 0), 0.1), on=pulley, friction=0.8)
    for end, force in ((rope.start, 2.4), (rope.end, 2.9)):
        scene.add_mass(end, 0.3)
        scene.point_force(end, ancf.Ramp((0.0, -force), 0.05, smooth=True))
    run = ancf.simulate(scene, 0.1, 1e-3, integrator=integrator)
    forces = run.contact_force(contact)
    assert np.abs(forces.friction).max() > 1.0
    np.testing.assert_allclose(run.joint_force(pin).force, forces.force, atol=1e-9)


def loaded_wire(ratio, **friction):
    """A wire over half a drum with 10 N and `ratio` times as much, and the end with the latter."""
    phi, tension, mu = math.pi, 10.0, friction["friction"]
    reach = DRUM_RADIUS + WIRE_RADIUS
    scene = ancf.Scene((0.0, 0.0))
    wire = ancf.Rectangle(2 * WIRE_RADIUS, 2 * WIRE_RADIUS), ancf.Material(2.5e10, 2.5e4)
    arc = scene.add_beam(
        "thin",
        curve=ancf.Arc((0, 0), (-reach, 0), -phi),
        n_elements=50,
        section=wire[0],
        material=wire[1],
    )
    ends = [scene.add_beam("thin", x, (x[0], -0.05), 4, *wire) for x in ((-reach, 0), (reach, 0))]
    scene.connect(arc.start, ends[0].start)
    scene.connect(arc.end, ends[1].start)
    for end, force in zip(ends, (tension, ratio * tension), strict=True):
        scene.point_force(end.end, ancf.Ramp((0.0, -force), 0.2, smooth=True))
    stiffness = 100.0 * tension / (reach * WIRE_RADIUS) * math.exp(0.5 * mu * phi)
    for part in (arc, *ends):
        scene.contact(
            part,
            ancf.Drum((0, 0), DRUM_RADIUS),
            stiffness=stiffness,
            radius=WIRE_RADIUS,
            **friction,
        )
    return scene, ends[1].end


@pytest.mark.parametrize(("ratio", "slips"), [(0.9, False), (0.98, False), (1.05, True)])
def test_a_wire_around_a_drum_holds_up_to_the_load_of_euler_and_eytelwein(ratio, slips):
    """Tensions at the ends of up to exp(mu phi), and none that moves in ten seconds."""
    scene, end = loaded_wire(ratio * math.exp(0.3 * math.pi), friction=0.3)
    run = ancf.simulate(
        scene, 1.5 if slips else 11.0, 1e-3, integrator=ancf.GeneralizedAlpha(0.5), save_every=500
    )
    way = np.linalg.norm(run.displacement(end), axis=1)
    if slips:
        assert way[-1] > 0.01
    else:
        assert way.max() < 1e-3
        assert abs(way[3] - way[1]) < 1e-9  # from 0.5 to 1.5 s
        assert np.abs(way[2:] - way[-1]).max() < 1e-8


def test_a_wire_on_a_drum_creeps_by_the_law_of_its_slip_speed():
    """At v_s s / sqrt(1 - s^2) with s = ln(T2 / T1) / (mu phi), all of it."""
    scene, end = loaded_wire(1.5, friction=0.3, slip_speed=1e-3)
    run = ancf.simulate(scene, 1.0, 1e-3, integrator=ancf.GeneralizedAlpha(0.5))
    s = math.log(1.5) / (0.3 * math.pi)
    creep = 1e-3 * s / math.sqrt(1.0 - s**2)
    assert -run.velocity(end)[-200:, 1].mean() == pytest.approx(creep, rel=1e-3)


def test_the_tension_of_a_wire_that_is_pulled_to_and_fro_has_both_exponentials():
    """Reached before the motion ends, kept while the end rests, and after it, in 20 steps."""
    made = bristle()
    run = ancf.simulate(made.scene, 1.4, 1e-3, integrator=ancf.GeneralizedAlpha(0.5))
    tension, growth = made.quantities(run)["t2"], math.exp(0.3 * math.pi)
    assert np.abs(tension[350:600] - 10.0 * growth).max() < 0.01 * growth
    assert np.abs(tension[520:600] - 10.0 * growth).max() < 2e-3 * growth
    assert np.abs(np.diff(tension[520:600])).max() < 1e-6
    assert np.abs(tension[1000:] - 10.0 / growth).max() < 1e-2 / growth
    assert run.stats.iterations < 5 * run.stats.steps


@pytest.mark.parametrize("integrator", BOTH, ids=repr)
def test_a_ring_that_sticks_turns_with_its_drum(integrator):
    """It is stretched onto the drum, at rest at first, and has the angle of the drum later."""
    scene, omega = ancf.Scene((0.0, 0.0)), 10.0
    radius = 0.1 + 0.002 - 1e-5
    halves = [
        scene.add_beam(
            "thin",
            curve=ancf.Arc((0, 0), (side * radius, 0), math.pi),
            n_elements=16,
            section=ancf.Circle(0.004),
            material=ancf.Material(1e8, 1e3),
        )
        for side in (1.0, -1.0)
    ]
    for one, other in (halves, halves[::-1]):
        scene.connect(one.end, other.start)
    drum = ancf.Drum((0, 0), 0.1, angular_velocity=omega)
    for half in halves:
        scene.contact(half, drum, stiffness=1e6, friction=0.5)
    run = ancf.simulate(scene, 0.3, 1e-3, integrator=integrator)
    x, y = run.position(halves[0].start).T
    angle = np.unwrap(np.arctan2(y, x)) - omega * run.t
    assert angle[200:].std() < 1e-4
    assert -0.2 < angle[-1] < 0.0  # while it slid
    energy = run.energy
    assert energy.work[-1] > 1.5 * energy.kinetic[-1]  # half of it was lost to sliding
    assert energy.friction[-1] == pytest.approx(energy.work[-1] - energy.kinetic[-1], rel=0.05)
    assert energy.drift < (1e-7 if integrator == ancf.EnergyMomentum() else 2e-2)


@pytest.mark.parametrize("dim", [2, 3])
def test_bristles_keep_momenta_and_lose_energy_to_sliding_alone(dim):
    scene, *_ = collision(dim, offset=0.02, friction=0.4)
    run = ancf.simulate(scene, 0.02, 1e-4, integrator=ancf.EnergyMomentum(), tolerance=1e-12)
    linear, angular = momenta(scene, run)
    assert np.abs(linear - linear[0]).max() < 1e-10
    total = run.energy.total
    assert np.abs(angular - angular[0]).max() < 1e-3 * np.abs(angular).max()
    assert total[-1] < total[0] * (1.0 - 1e-3)


@pytest.mark.parametrize("speed", [0.01, 1.0], ids=["sticks", "slides"])
@pytest.mark.parametrize("integrator", BOTH, ids=repr)
def test_the_matrix_of_a_step_with_bristles_is_the_derivative(integrator, speed):
    """But for the change of the limit with the pressure, which is not symmetric."""
    scene, _, _ = level(-2e-4, STIFFNESS, velocity=(speed, 0.0), friction=0.5)
    system = System(scene)
    march, *_ = prepare_implicit(system, 1e-3, integrator, ancf.Newton(), 1e-9, math.inf)
    march.prepare(np.zeros((1, 0)))
    derivative = derivative_of_step(march, system.n_free)
    march.residual()
    matrix = full(system, march.matrix())
    other = 0.5 * (derivative + derivative.T)
    assert np.abs(matrix - other).max() < (1e-5 if speed < 0.1 else 2e-2) * np.abs(matrix).max()


@pytest.mark.parametrize("integrator", BOTH, ids=repr)
def test_deflections_are_stored_with_states(tmp_path, integrator):
    def scene():
        return level(2e-3, STIFFNESS, friction=0.2, velocity=(0.5, 0.0))

    options = {"integrator": integrator, "solver": ancf.Newton()}
    made, _, contact = scene()
    whole = ancf.simulate(made, 0.04, 1e-3, **options)
    forces = whole.contact_force(contact)
    sizes = np.linalg.norm(forces.friction, axis=2)
    assert sizes.any()
    assert np.all(sizes <= 0.2 * forces.pressure * (1 + 1e-12))
    k = int(np.argmax(sizes.sum(axis=1)))
    assert whole.contacts(whole.t[k])[0].friction == pytest.approx(sizes[k] @ contact.weights)

    rare = ancf.simulate(made, 0.04, 1e-3, save_every=7, **options)
    assert np.array_equal(rare.internal, whole.internal[[0, 7, 14, 21, 28, 35, 40]])

    first = ancf.simulate(made, 0.022, 1e-3, **options)
    assert first.internal[-1].any()
    second = ancf.simulate(made, 0.04, 1e-3, start=first.last, **options)
    assert np.array_equal(second.q[-1], whole.q[-1])
    assert np.array_equal(second.internal[0], first.internal[-1])

    ancf.simulate(made, 0.04, 1e-3, output=tmp_path / "run.h5", **options)
    stored = ancf.load(tmp_path / "run.h5", made)
    assert np.array_equal(stored.internal, whole.internal)
    assert np.array_equal(stored.contact_force(contact).friction, forces.friction)


@pytest.mark.parametrize("integrator", [None, ancf.GeneralizedAlpha(0.5)], ids=repr)
def test_runs_to_an_accuracy_save_deflections(tmp_path, integrator):
    """Of a cable that slides to rest; without deflections its friction would be zero."""
    mu, speed, options = 0.2, 0.5, {"accuracy": 1e-6, "output": tmp_path / "run.h5"}
    scene, rod, contact = level(-DEPTH, STIFFNESS, friction=mu, velocity=(speed, 0.0))
    if integrator is not None:
        options["integrator"] = integrator
    run = ancf.simulate(scene, 0.3, 1e-3, **options)
    end = speed / (mu * 9.81)
    sliding = (run.t > 0.01) & (run.t < end - 0.01)
    friction = run.contact_force(contact).force[:, 0]
    np.testing.assert_allclose(friction[sliding], -mu * LINE_MASS * 9.81, rtol=1e-2)
    impulse = np.sum(0.5 * (friction[11:] + friction[10:-1]) * np.diff(run.t[10:]))
    change = np.ptp(run.velocity(rod.at(0.5))[[10, -1], 0])
    assert impulse == pytest.approx(-LINE_MASS * change, rel=1e-3)
    assert abs(run.position(rod.at(0.5))[-1, 0] - 0.5 - 0.5 * speed * end) < 1e-4


@pytest.mark.parametrize("integrator", BOTH, ids=repr)
def test_a_time_loop_takes_steps_without_a_table_of_deflections(integrator):
    scene, _, _ = level(-DEPTH, STIFFNESS, friction=0.2, velocity=(0.5, 0.0))
    system = System(scene)
    ready = prepare_implicit(system, 1e-3, integrator, ancf.Newton(), "default", math.inf)
    n, m = system.n_all, system.n_multipliers
    rows = [np.empty((3, width)) for width in (n, n, n, m)]
    taken = ready.time_loop.advance(ready.iteration, 2, np.zeros((2, 0)), 1, 0, *rows)
    assert taken == (2, 0)
    assert system.assembly.history.any()


def test_explicit_integrators_need_a_slip_speed():
    scene, _, _ = level(2e-3, STIFFNESS, friction=0.2)
    with pytest.raises(ancf.InputError, match="contacts that stick: give them a slip_speed"):
        ancf.simulate(scene, 0.01, 1e-5, integrator=ancf.DormandPrince())
