"""Joints that are coupled: gears, racks, screws, and ropes over points."""

from __future__ import annotations

import math

import numpy as np
import pytest

import ancfsparse as ancf
from tests.solve.refusals import assert_refused

G = 9.81
DAMPED = ancf.GeneralizedAlpha(0.9)
FINE = {"integrator": DAMPED, "tolerance": 1e-12}


def wheels(spin=3.0):
    """Two discs in the plane on pins, with polar inertias 2 and 0.5 kg m2, that mesh."""
    scene = ancf.Scene((0.0, 0.0))
    one = scene.add_body(mass=1.0, inertia=2.0, position=(0, 0), angular_velocity=-2.0 * spin)
    other = scene.add_body(mass=1.0, inertia=0.5, position=(1, 0), angular_velocity=spin)
    pins = scene.pin(one.origin), scene.pin(other.origin)
    return scene, (one, other), pins, scene.gear(*pins, -2.0)


@pytest.mark.parametrize("integrator", [DAMPED, ancf.EnergyMomentum()], ids=repr)
def test_two_wheels_turn_at_their_ratio_many_times_round(integrator):
    scene, bodies, _, _ = wheels()
    run = ancf.simulate(scene, 4.0, 0.005, integrator=integrator)
    one, other = (np.unwrap(run.body(body).angles) for body in bodies)
    np.testing.assert_allclose(one, -2.0 * other, atol=1e-6)
    assert other[-1] == pytest.approx(12.0, rel=1e-3)
    total = run.energy.total[1:]  # the start puts velocities on the constraints
    np.testing.assert_allclose(total, total[0], rtol=1e-5)


def test_a_moment_on_one_wheel_moves_the_inertia_of_both():
    # The moment 3 N m on the second wheel accelerates J_2 + ratio^2 J_1 = 8.5 kg m2.
    scene, (_one, other), (_pin, _), gear = wheels(spin=0.0)
    scene.point_moment(other.origin, 3.0)
    run = ancf.simulate(scene, 2.0, 0.01, **FINE)
    angle = np.unwrap(run.body(other).angles)
    np.testing.assert_allclose(angle, 0.5 * 3.0 / 8.5 * run.t**2, atol=5e-5)
    # What the teeth do to the first wheel: J_1 times its acceleration.
    np.testing.assert_allclose(run.joint_force(gear).moment[1:], -2.0 * 2.0 * 3 / 8.5, rtol=1e-4)


@pytest.mark.parametrize("solver", [ancf.Newton(), ancf.QuasiNewton("davidon"), "auto"], ids=repr)
def test_a_rack_is_pushed_by_its_pinion(solver):
    scene = ancf.Scene((0.0, 0.0, -G))
    rack = scene.add_body(ancf.Box(length=0.5, width=0.1, height=0.1), mass=4.0, position=(0, 0, 0))
    wheel = scene.add_body(inertia=(0.1, 0.2, 0.1), mass=1.0, position=(0, 0.5, 0))
    slide = scene.prismatic(rack.origin, axis=(0.6, 0, 0.8))
    hinge = scene.revolute(wheel.origin, axis=(0, 1, 0))
    scene.gear(slide, hinge, 0.3)  # m/rad
    run = ancf.simulate(scene, 1.0, 0.002, solver=solver, **FINE)
    # Reduced: (m + J / r^2) s'' = -m g 0.8.
    pull = -4.0 * G * 0.8 / (4.0 + 0.2 / 0.09)
    way = run.position(rack.origin) @ [0.6, 0.0, 0.8]
    np.testing.assert_allclose(way, 0.5 * pull * run.t**2, atol=2e-4)


def test_a_screw_goes_down_as_it_turns():
    scene = ancf.Scene((0.0, 0.0, -G))
    nut = scene.add_body(inertia=(0.1, 0.1, 0.05), mass=2.0, position=(0, 0, 0))
    joint = scene.cylindrical(nut.origin, axis=(0, 0, 1))
    scene.gear(joint, joint, 0.02, of_one="displacement", of_other="angle")
    run = ancf.simulate(scene, 1.0, 0.002, **FINE)
    pull = -2.0 * G / (2.0 + 0.05 / 0.02**2)
    np.testing.assert_allclose(run.position(nut.origin)[:, 2], 0.5 * pull * run.t**2, atol=1e-4)
    assert run.energy.drift < 1e-3


def test_atwoods_machine():
    # Two weights on a rope over two fixed points, each guided along a line.
    scene = ancf.Scene((0.0, -G))
    heavy = scene.add_body(ancf.Rod(0.1), mass=3.0, position=(0, 0))
    light = scene.add_body(ancf.Rod(0.1), mass=2.0, position=(1, 0))
    rope = scene.winch([heavy.centre, (0.05, 2), (1.05, 2), light.centre])
    run = ancf.simulate(scene, 0.4, 0.002, **FINE)
    y = run.position(heavy.centre)[:, 1]
    np.testing.assert_allclose(y, -0.5 * G / 5.0 * run.t**2, atol=1e-5)
    np.testing.assert_allclose(run.tension(rope), 2.0 * 6.0 / 5.0 * G, rtol=1e-5)


def test_a_winch_hoists_as_prescribed_and_its_rope_carries_the_load():
    scene = ancf.Scene((0.0, -G))
    load = scene.add_body(ancf.Rod(0.1), mass=5.0, position=(-0.05, 0))
    ramp = ancf.Ramp(-1.0, 2.0, smooth=True) + 3.0
    rope = scene.winch([(0.0, 3.0), load.centre], length=ramp)
    run = ancf.simulate(scene, 1.0, 0.002, **FINE)
    np.testing.assert_allclose(run.position(load.centre)[:, 1], 3.0 - ramp(run.t), atol=1e-8)
    expected = 5.0 * (G - ramp.rate(run.t, 2))
    np.testing.assert_allclose(run.tension(rope), expected, rtol=2e-3)
    assert run.energy.work[-1] == pytest.approx(
        run.energy.total[-1] - run.energy.total[0], rel=1e-4
    )


def test_a_pendulum_on_a_pulley_keeps_its_rope():
    # A weight swings on a rope over a point, another hangs at its other end: in polar coordinates
    # (M + m) r'' = m r th'^2 - M g + m g cos th, r th'' = -2 r' th' - g sin th.
    from scipy.integrate import solve_ivp

    scene = ancf.Scene((0.0, -G))
    start = 0.6
    swinging = scene.add_body(mass=1.0, inertia=1e-2, position=(math.sin(start), -math.cos(start)))
    other = scene.add_body(mass=1.5, inertia=1e-2, position=(-1.0, -1.0))
    scene.winch([swinging.origin, (0, 0), (-1.0, 0), other.origin])

    def rate(t, y):
        r, angle, dr, spin = y
        pull = (r * spin**2 - 1.5 * G + G * math.cos(angle)) / 2.5
        return [dr, spin, pull, -(2.0 * dr * spin + G * math.sin(angle)) / r]

    exact = solve_ivp(rate, (0.0, 0.5), [1.0, start, 0.0, 0.0], rtol=1e-11, atol=1e-12).y[:, -1]
    expected = exact[0] * np.array([math.sin(exact[1]), -math.cos(exact[1])])
    errors = []
    for dt in (0.005, 0.0025):
        run = ancf.simulate(scene, 0.5, dt, **FINE)
        errors.append(np.linalg.norm(run.position(swinging.origin)[-1] - expected))
    assert errors[1] < 1e-5
    assert 3.5 < errors[0] / errors[1] < 4.5


def test_a_drum_winds_a_rope_up():
    # A drum of 0.2 m and 0.5 kg m2 lets a load of 3 kg down: (J / R^2 + m) a = m g.
    scene = ancf.Scene((0.0, -G))
    drum = scene.add_body(mass=1.0, inertia=0.5, position=(0, 3))
    load = scene.add_body(mass=3.0, inertia=0.1, position=(0.2, 0))
    pin = scene.pin(drum.origin)
    rope = scene.winch([(0.2, 3.0), load.origin], drum=pin, radius=0.2)
    run = ancf.simulate(scene, 1.0, 0.0025, **FINE)
    fall = 3.0 * G / (0.5 / 0.04 + 3.0)
    np.testing.assert_allclose(run.position(load.origin)[:, 1], -0.5 * fall * run.t**2, atol=1e-4)
    np.testing.assert_allclose(run.tension(rope), 3.0 * (G - fall), rtol=3e-4)
    np.testing.assert_allclose(
        run.joint_force(pin).force[5:, 1], 1.0 * G, rtol=1e-6
    )  # of the weight of the drum alone: the rope leaves from a fixed point


def test_a_rope_keeps_its_energy_at_long_steps():
    scene, *_ = wheels()
    weight = scene.add_body(mass=1.0, inertia=1e-2, position=(0.5, -1.0))
    scene.winch([(0.0, 0.0), weight.origin, (1.0, 0.0)])
    run = ancf.simulate(scene, 4.0, 0.05, integrator=ancf.EnergyMomentum(), tolerance=1e-13)
    total = run.energy.total[1:]  # the start puts velocities on the constraints
    np.testing.assert_allclose(total, total[0], rtol=1e-9)


def test_bad_arguments_of_gears_and_winches():
    scene, (one, other), (pin, _), _ = wheels()
    assert_refused("must not be zero", scene.gear, pin, scene.joints[1], 0.0)
    assert_refused("needs two coordinates, got the angle", scene.gear, pin, pin, 2.0)
    assert_refused("list of two points or more", scene.winch, [one.origin])
    assert_refused("needs a point of a beam or a body", scene.winch, [(0, 0), (1, 1)])
    with pytest.raises(ancf.InputError, match="points 0 and 1 of a winch coincide"):
        scene.winch([one.origin, (0, 0), other.origin])
    assert_refused("drum and radius together", scene.winch, [one.origin, (0, 3)], drum=pin)
    with pytest.raises(ancf.InputError, match="not both"):
        scene.winch([one.origin, (0, 3)], drum=pin, radius=0.1, length=lambda t: 3.0)
    with pytest.raises(ancf.InputError, match="has a rate and is constant"):
        scene.winch([one.origin, (0, 3)], rate=lambda t: 3.0)
    assert_refused("tension needs what", ancf.simulate(scene, 0.01, 0.01).tension, pin)


def driven_wheels():
    """A moment on the faster of two wheels, which turns 9 rad in 0.8 s, the other one 3."""
    scene = ancf.Scene((0.0, 0.0))
    one = scene.add_body(position=(0, 0), mass=1.0, inertia=0.02)
    other = scene.add_body(position=(1, 0), mass=1.0, inertia=0.3)
    scene.gear(scene.pin(one.origin), scene.pin(other.origin), 3.0)
    scene.point_moment(one.origin, 1.5)
    return scene, one, 1.5 / (0.02 + 0.3 / 9.0)


def angle_of(run, body):
    return np.unwrap(np.ravel(run.body(body).angles))


def test_a_run_to_an_accuracy_counts_turns_anew_in_each_of_its_motions():
    """Each explicit motion went on from the turns of the last, and the gear seemed broken."""
    scene, one, rate = driven_wheels()
    run = ancf.simulate(scene, 0.8, accuracy=1e-6, integrator=ancf.DormandPrince())
    assert angle_of(run, one) == pytest.approx(0.5 * rate * run.t**2, abs=2e-6)


@pytest.mark.parametrize(
    "options",
    [
        {"dt": 1e-3},
        {"dt": 1e-3, "integrator": ancf.DormandPrince()},
        {"accuracy": 1e-5, "integrator": ancf.GeneralizedAlpha(0.9)},
        {"accuracy": 1e-5, "integrator": ancf.DormandPrince()},
    ],
    ids=str,
)
def test_gears_that_have_turned_go_on_from_a_last_state(options):
    """They were refused as broken by a whole turn."""
    scene, one, rate = driven_wheels()
    first = ancf.simulate(scene, 0.8, 1e-3, integrator=ancf.DormandPrince())
    run = ancf.simulate(scene, 1.0, start=first.last, **options)
    turned = 0.5 * rate * (run.t**2 - 0.8**2)
    assert angle_of(run, one) - angle_of(run, one)[0] == pytest.approx(turned, abs=5e-4)
