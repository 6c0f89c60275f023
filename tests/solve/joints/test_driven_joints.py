"""Joints whose angle or displacement is prescribed, and functions of time that are not smooth."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import ancfsparse as ancf
from ancfsparse.errors import SingularSceneError
from tests.solve.refusals import assert_refused

DAMPED = ancf.GeneralizedAlpha(0.9)
TURNS = ancf.Ramp(8.0 * math.pi, 2.0, smooth=True)
INTEGRATORS = [DAMPED, ancf.Newmark(0.0), ancf.HHT(0.1), ancf.EnergyMomentum()]


def turn(t):
    """One and a half turns and more, with a speed that comes and goes [rad]."""
    return 10.0 * (t - np.sin(2.0 * np.pi * t) / (2.0 * np.pi))


def crank(angle=TURNS, gravity=(0.0, -9.81), **options):
    """A rod of 1 m and 1 kg on a pin at its end, its joint and its drive."""
    scene = ancf.Scene(gravity)
    rod = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0))
    pin = scene.pin(rod.origin)
    return scene, rod, pin, scene.drive_joint(pin, angle, **options)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_a_crank_turns_as_prescribed_four_times_round(integrator):
    scene, rod, *_ = crank()
    run = ancf.simulate(scene, 2.4, 0.02, integrator=integrator)
    angle = TURNS(run.t)
    expected = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    np.testing.assert_allclose(run.position(rod.end), expected, atol=1e-6)


def test_the_moment_of_a_crank_balances_weight_and_inertia():
    errors = []
    for dt in (0.01, 0.005):
        scene, *_ = crank(turn)
        run = ancf.simulate(scene, 2.4, dt, integrator=DAMPED, tolerance=1e-12)
        # The multiplier counts angles at the arm of the rod, which is 1/sqrt(3) m.
        moment = -run.lam[:, -1] / math.sqrt(3.0)
        inertia = 20.0 * np.pi * np.sin(2.0 * np.pi * run.t) / 3.0
        expected = inertia + 0.5 * 9.81 * np.cos(turn(run.t))
        errors.append(np.max(np.abs(moment - expected)))
    assert errors[1] < 5e-3 * np.max(np.abs(expected))
    assert 3.5 < errors[0] / errors[1] < 4.5


def test_energy_is_what_the_drive_gave():
    scene, *_ = crank()
    drifts = [ancf.simulate(scene, 2.0, dt, integrator=DAMPED).energy.drift for dt in (0.01, 0.005)]
    assert 3.5 < drifts[0] / drifts[1] < 4.5


def test_two_bodies_in_space_turn_against_each_other_by_their_inertias():
    scene = ancf.Scene((0.0, 0.0, 0.0))
    one = scene.add_body(inertia=(1.0, 1.2, 2.0), mass=1.0, position=(0, 0, 0))
    other = scene.add_body(inertia=(1.5, 1.0, 1.0), mass=3.0, position=(0, 0, 0))
    hinge = scene.revolute(one.origin, other.origin, axis=(0, 0, 1))
    scene.drive_joint(hinge, TURNS)
    run = ancf.simulate(scene, 2.4, 0.005, integrator=ancf.EnergyMomentum(), tolerance=1e-12)
    for body, share in ((one, 1.0 / 3.0), (other, -2.0 / 3.0)):
        angle = share * TURNS(run.t)
        u = run.body(body).rotation[:, :, 0]
        np.testing.assert_allclose(u[:, 0], np.cos(angle), atol=2e-3)
        np.testing.assert_allclose(u[:, 1], np.sin(angle), atol=2e-3)
    total = run.body(one).angular_momentum + run.body(other).angular_momentum
    np.testing.assert_allclose(total, 0.0, atol=1e-9)


@pytest.mark.parametrize("solver", [ancf.Newton(), ancf.QuasiNewton("bfgs"), "auto"], ids=repr)
def test_a_spinning_beam_lags_as_far_as_in_exudyn(solver):
    # multibody reference: 10 m, EA = 2.8e7 N, EI = 1.4e4 N m2, 1.2 kg/m, spun up in 15 s.
    def angle(t):
        wave = 15.0 / (2.0 * np.pi)
        return 0.4 * (t * t / 2.0 + wave**2 * (np.cos(t / wave) - 1.0))

    side = math.sqrt(12.0 * 1.4e4 / 2.8e7)
    material = ancf.Material(2.8e7 / side**2, 1.2 / side**2)
    scene = ancf.Scene((0.0, 0.0))
    section = ancf.Rectangle(side, side)
    rod = scene.add_beam("thin", (0, 0), (10, 0), 6, section, material, strain="biot")
    scene.drive_joint(scene.pin(rod.start), angle)
    run = ancf.simulate(scene, 8.0, 0.01, integrator=DAMPED, solver=solver)
    tip, turned = run.position(rod.end), angle(run.t)
    lag = np.cos(turned) * tip[:, 1] - np.sin(turned) * tip[:, 0]
    assert lag.min() == pytest.approx(-0.57378, abs=6e-4)
    assert run.t[lag.argmin()] == pytest.approx(6.76, abs=0.02)
    np.testing.assert_allclose(lag[[500, 750]], [-0.46844, -0.55903], atol=6e-4)


def test_a_slide_follows_its_table_and_gives_the_force():
    scene = ancf.Scene((0.0, 0.0, -9.81))
    body = scene.add_body(ancf.Box(length=0.2, width=0.1, height=0.1), mass=2.0, position=(1, 0, 0))
    slide = scene.prismatic(body.origin, axis=(0.6, 0.0, 0.8))
    table = ancf.Table([0.0, 0.2, 0.5, 1.0], [0.0, 0.1, 0.3, 0.25], outside="hold", smooth=True)
    scene.drive_joint(slide, table)
    run = ancf.simulate(scene, 1.2, 0.001, integrator=DAMPED, tolerance=1e-12)
    way = np.outer(table(run.t), [0.6, 0.0, 0.8])
    np.testing.assert_allclose(run.position(body.origin) - [1, 0, 0], way, atol=1e-6)
    expected = 2.0 * (table.rate(run.t, 2) + 9.81 * 0.8)
    np.testing.assert_allclose(-run.lam[:, -1], expected, atol=5e-3 * np.abs(expected).max())


def test_a_screw_is_driven_along_and_about_its_axis():
    scene = ancf.Scene((0.0, 0.0, 0.0))
    nut = scene.add_body(
        ancf.Box(length=0.2, width=0.1, height=0.1), mass=2.0, position=(0, 0, 0.5)
    )
    joint = scene.cylindrical(nut.origin, axis=(0, 0, 1))
    for of, value in (("angle", 6.0), ("displacement", 0.2)):
        scene.drive_joint(joint, ancf.Ramp(value, 1.0, smooth=True), of=of)
    run = ancf.simulate(scene, 1.0, 0.01, integrator=DAMPED)
    np.testing.assert_allclose(run.position(nut.origin)[-1], [0.0, 0.0, 0.7], atol=1e-8)
    u = run.body(nut).rotation[-1, :, 0]
    np.testing.assert_allclose(u, [math.cos(6.0), math.sin(6.0), 0.0], atol=1e-6)


def test_a_distance_follows_its_length():
    scene = ancf.Scene((0.0, 0.0))
    one = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0))
    other = scene.add_body(ancf.Rod(1.0), mass=3.0, position=(2, 0))
    ramp = ancf.Ramp(1.0, 0.5, smooth=True) + 2.0
    scene.distance(one.origin, other.origin, length=ramp)
    run = ancf.simulate(scene, 0.6, 0.01, integrator=DAMPED)
    apart = run.position(other.origin) - run.position(one.origin)
    np.testing.assert_allclose(np.linalg.norm(apart, axis=1), ramp(run.t), atol=1e-7)


def test_a_run_goes_on_after_several_turns_as_if_there_were_no_end_between():
    scene, _rod, *_ = crank()
    options = {"integrator": DAMPED, "tolerance": 1e-12}
    whole = ancf.simulate(scene, 2.4, 0.02, **options)
    half = ancf.simulate(scene, 1.4, 0.02, **options)
    rest = ancf.simulate(scene, 2.4, 0.02, start=half.last, **options)
    np.testing.assert_allclose(rest.q[-1], whole.q[-1], rtol=0, atol=1e-13)


def test_a_run_starts_from_a_state_several_turns_on_in_another_scene():
    scene, _rod, *_ = crank()
    half = ancf.simulate(scene, 1.4, 0.005, integrator=DAMPED)
    after, other, *_ = crank(gravity=(0.0, 0.0))
    run = ancf.simulate(after, 2.4, 0.005, integrator=DAMPED, start=half.last)
    np.testing.assert_allclose(run.position(other.end)[-1], [1.0, 0.0], atol=1e-5)


def test_statics_turn_a_crank_to_where_its_drive_begins():
    scene, rod, _pin, _drive = crank(2.0)
    rest = ancf.solve_static(scene)
    np.testing.assert_allclose(rest.position(rod.end), [math.cos(2.0), math.sin(2.0)], atol=1e-9)


RATES = {"rate": lambda t: 0.0, "second_rate": lambda t: float(t > 0.6)}


@pytest.mark.parametrize(
    ("function", "options", "words"),
    [
        (lambda t: 0.5 * max(0.0, t - 0.3123), {}, "velocity jumps .* 0.5 rad/s near t = 0.3123"),
        (lambda t: max(0.0, t - 0.3123) ** 2, {}, "acceleration jumps .* 2 rad/s2 near t = 0.31"),
        (lambda t: 0.0, RATES, "acceleration jumps by about 1 rad/s2 near t = 0.6"),
        (lambda t: 0.5 * (t > 0.777), {}, "position jumps by about 0.5 rad near t = 0.777"),
        (lambda t: np.interp(t, [0.0, 0.5, 1.0], [0.0, 0.0, 0.1]), {}, "near t = 0.5 s"),
    ],
)
def test_a_drive_that_is_not_smooth_is_refused_and_the_message_says_where(function, options, words):
    scene, *_ = crank(function, **options)
    assert_refused(words, ancf.simulate, scene, 1.0, 0.01, integrator=DAMPED)


@pytest.mark.parametrize(
    "function",
    [
        lambda t: max(0.0, t - 0.3123) ** 3,
        lambda t: 1e-3 * t * t * (1.0 + math.sin(1500.0 * t)),
        lambda t: float(TURNS(t)),
        lambda t: 0.0,
        CubicSpline(np.linspace(0, 1, 9), np.sin(np.linspace(0, 9, 9)) ** 2, bc_type="clamped"),
    ],
)
def test_a_drive_that_is_smooth_is_taken(function):
    scene, *_ = crank(function, gravity=(0.0, 0.0))
    assert ancf.simulate(scene, 1.0, 0.01, integrator=DAMPED).finished


def test_a_support_that_jumps_is_refused_too():
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0))
    scene.drive(rod.origin, lambda t: (0.0, abs(t - 0.25) - 0.25), rate=None)
    with pytest.raises(ancf.InputError, match=r"velocity jumps by about 2 m/s near t = 0\.25 s"):
        ancf.simulate(scene, 1.0, 0.01, integrator=DAMPED)


def test_bad_arguments_of_driven_joints():
    scene, rod, pin, _drive = crank()
    assert_refused("prescribed already", scene.drive_joint, pin, TURNS, error=SingularSceneError)
    with pytest.raises(ancf.InputError, match="needs a joint that a method of this scene returned"):
        scene.drive_joint(rod.origin, TURNS)
    assert_refused("of another scene", crank()[0].drive_joint, pin, TURNS)
    assert_refused("has none: take a revolute", scene.drive_joint, pin, TURNS, of="displacement")
    assert_refused("must be one number, got", crank, (0.0, 1.0))
    assert_refused("acceleration is not continuous", crank, ancf.Ramp(1.0, 1.0))
    space = ancf.Scene((0.0, 0.0, -9.81))
    ball = space.add_body(ancf.Sphere(0.1), mass=1.0, position=(0, 0, 0))
    with pytest.raises(ancf.InputError, match="angle or a displacement, and the pin"):
        space.drive_joint(space.pin(ball.origin), TURNS)
    assert_refused(r"by 0\.1 rad: move the start", ancf.simulate, crank(0.1)[0], 1.0, 0.01)
    with pytest.raises(ancf.InputError, match="by 3 rad/s: give the body a velocity"):
        ancf.simulate(crank(lambda t: 3.0 * t)[0], 1.0, 0.01)


def test_a_double_pendulum_with_a_driven_crank_moves_as_in_exudyn():
    # Exudyn 1.13.6: two RigidBody2D, RevoluteJoint2D, CoordinateConstraint with offsetUserFunction
    # on the rotation, generalised-alpha with 0.95 and steps of 1e-4 s, whose error is below 1e-5 m.
    found = []
    for dt in (1e-3, 5e-4):
        scene = ancf.Scene((0.0, -9.81))
        rod = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0))
        arm = scene.add_body(ancf.Rod(1.5), mass=2.0, position=(1, 0))
        drive = scene.drive_joint(scene.pin(rod.origin), turn)
        hinge = scene.connect(rod.end, arm.origin)
        run = ancf.simulate(scene, 0.5, dt, integrator=ancf.GeneralizedAlpha(0.95), tolerance=1e-12)
        k = [len(run.t) // 2, -1]
        values = run.position(arm.end), run.joint_force(hinge).force, run.joint_force(drive).moment
        found.append([each[k] for each in values])
    place, force, moment = ((4.0 * b - a) / 3.0 for a, b in zip(*found, strict=True))
    known = [[1.55515921, -0.38022575], [-0.35608483, 0.39780847]]
    np.testing.assert_allclose(place, known, atol=1.5e-5)
    # Of the arm on the crank.
    known = [[111.083169, -53.8674718], [3.28008816, -83.3314451]]
    np.testing.assert_allclose(force, known, atol=0.01)
    np.testing.assert_allclose(moment, [144.682023, 21.8839791], atol=5e-3)


def test_runs_to_an_accuracy_begin_each_with_the_turns_of_the_start():
    scene, rod, *_ = crank(ancf.Ramp(8.0 * math.pi, 1.0, smooth=True))
    run = ancf.simulate(scene, 1.0, accuracy=1e-4)
    assert run.finished
    assert run.stats.runs > 1
    np.testing.assert_allclose(run.position(rod.end)[-1], [1.0, 0.0], atol=1e-4)


def arm(as_constraint=False, angle=TURNS, **body):
    """A driven crank with a rod that swings at its end."""
    scene = ancf.Scene((0.0, -9.81))
    crank = scene.add_body(ancf.Rod(0.5), mass=1.0, position=(0, 0), **body)
    rod = scene.add_body(ancf.Rod(1.0), mass=2.0, position=(0.5, 0))
    pin = scene.pin(crank.origin)
    scene.connect(crank.end, rod.origin)
    return scene, crank, rod, pin, scene.drive_joint(pin, angle, as_constraint=as_constraint)


SLOW = ancf.Ramp(2.0 * math.pi, 2.0, smooth=True)


def test_an_angle_by_numbering_is_the_same_motion_as_by_an_equation():
    runs = []
    for as_constraint in (False, True):
        scene, crank, rod, pin, drive = arm(as_constraint, SLOW)
        run = ancf.simulate(scene, 2.0, 2e-3, integrator=ancf.DormandPrince())
        forces = run.joint_force(drive).moment, run.joint_force(pin).force
        runs.append((run.position(rod.end), run.velocity(rod.end), *forces))
        spins = run.body(crank).angular_velocity
        np.testing.assert_allclose(spins, SLOW.rate(run.t), atol=1e-12)
        assert run.system.n_free + run.system.n_multipliers == (11 if as_constraint else 7)
    for found, expected in zip(*runs, strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-10 * np.abs(expected).max())


def test_angle_angular_velocity_and_acceleration_are_exact_by_numbering():
    spins = []
    for as_constraint in (False, True):
        scene, crank, *_ = arm(as_constraint, SLOW)
        run = ancf.simulate(scene, 2.4, 4e-3, integrator=DAMPED)
        turn = run.body(crank)
        np.testing.assert_allclose(np.unwrap(turn.angles), SLOW(run.t), atol=1e-7)
        spins.append(np.abs(turn.angular_velocity - SLOW.rate(run.t)).max())
    assert spins[0] < 1e-13
    assert spins[1] > 1e-4


def test_a_function_without_rates_turns_a_body_by_numbering_too():
    scene, crank, _, _, drive = arm(angle=lambda t: t**3)
    run = ancf.simulate(scene, 1.0, 5e-3)
    np.testing.assert_allclose(np.unwrap(run.body(crank).angles), run.t**3, atol=1e-12)
    np.testing.assert_allclose(run.body(crank).angular_velocity, 3.0 * run.t**2, atol=1e-6)
    assert np.isfinite(run.joint_force(drive).moment).all()


def test_the_axes_of_a_body_that_is_turned_at_the_start_count():
    quarter = math.pi / 2
    scene = ancf.Scene((0.0, 0.0))
    crank = scene.add_body(ancf.Rod(0.5), mass=1.0, position=(1, 0), orientation=quarter)
    load = scene.add_body(mass=1.0, inertia=0.1, position=(1, 0.5))
    pin = scene.pin(crank.origin)
    scene.connect(crank.end, load.origin)
    scene.drive_joint(pin, SLOW)
    run = ancf.simulate(scene, 1.0, 0.01)
    angle = quarter + SLOW(run.t)
    end = np.stack([1.0 + 0.5 * np.cos(angle), 0.5 * np.sin(angle)], axis=1)
    np.testing.assert_allclose(run.position(crank.end), end, atol=1e-12)


def test_equations_stay_where_numbering_would_leave_nothing_or_clash():
    scene = ancf.Scene((0.0, -9.81))
    body = scene.add_body(mass=1.0, inertia=1.0, position=(0, 0))
    scene.drive_joint(scene.pin(body.origin), SLOW)
    run = ancf.simulate(scene, 2.0, 0.01)
    np.testing.assert_allclose(np.unwrap(run.body(body).angles), SLOW(run.t), atol=1e-9)
    slide = ancf.Scene((0.0, -9.81))
    box = slide.add_body(mass=1.0, inertia=1.0, position=(0, 0))
    slide.drive_joint(slide.pin(box.at((0.2, 0.0))), 0.0)
    slide.prismatic(box.at((0.4, 0.0)), axis=(1, 0))
    with pytest.raises(SingularSceneError, match=r"drive of the angle .* constrains no free coord"):
        ancf.simulate(slide, 0.1, 0.01)


def test_a_run_with_a_driven_angle_goes_on_over_many_turns():
    scene, crank, rod, *_ = arm()
    solver = {"solver": ancf.Newton()}
    whole = ancf.simulate(scene, 2.0, 0.002, **solver)
    first = ancf.simulate(scene, 1.2, 0.002, **solver)
    rest = ancf.simulate(scene, 2.0, 0.002, start=first.last, **solver)
    np.testing.assert_array_equal(rest.position(rod.end)[-1], whole.position(rod.end)[-1])
    np.testing.assert_allclose(rest.position(crank.end)[-1], (0.5, 0.0), atol=1e-12)


def test_an_angle_that_begins_elsewhere_or_with_another_speed_is_refused():
    with pytest.raises(ancf.InputError, match=r"begins 0.296 rad and more from where"):
        ancf.simulate(arm(angle=lambda t: 0.3 + t**3)[0], 0.1, 0.01)
    with pytest.raises(ancf.InputError, match=r"with another angular velocity .* 3 rad/s"):
        ancf.simulate(arm(angle=lambda t: 3.0 * t)[0], 0.1, 0.01)
