"""Springs, stops and friction in joints: oscillators, impacts, and rubbing by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from tests.matrices import full
from tests.solve.refusals import assert_refused

DAMPED = ancf.GeneralizedAlpha(0.9)


def rotor(spin=2.0):
    """A rod of 3 kg and 1 kg m2 about its pin, without gravity."""
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_body(ancf.Rod(1.0), mass=3.0, position=(0, 0), angular_velocity=spin)
    return scene, rod, scene.pin(rod.origin)


def angle_of(run, body):
    return np.unwrap(run.body(body).angles)


@pytest.mark.parametrize("integrator", [DAMPED, ancf.EnergyMomentum()], ids=repr)
def test_a_damped_torsional_spring_swings_as_its_formula(integrator):
    scene, rod, pin = rotor()
    scene.joint_spring(pin, stiffness=10.0, damping=0.3, rest=0.5)
    omega, errors = math.sqrt(10.0 - 0.15**2), []
    for dt in (0.01, 0.005):
        run = ancf.simulate(scene, 2.0, dt, integrator=integrator)
        swing = -0.5 * np.cos(omega * run.t) + (2.0 - 0.075) / omega * np.sin(omega * run.t)
        exact = 0.5 + np.exp(-0.15 * run.t) * swing
        errors.append(np.abs(angle_of(run, rod) - exact).max())
        assert run.energy.drift < 5.0 * dt**2
    assert errors[1] < 2e-4
    assert 3.5 < errors[0] / errors[1] < 4.5


def test_a_spring_without_damping_keeps_its_energy():
    scene, _, pin = rotor()
    scene.joint_spring(pin, stiffness=40.0, rest=2.5)
    scene.joint_stop(pin, -0.2, 0.3, stiffness=3e3)
    run = ancf.simulate(scene, 5.0, 0.05, integrator=ancf.EnergyMomentum(), tolerance=1e-13)
    total = run.energy.total[1:]  # the start puts velocities on the constraints
    np.testing.assert_allclose(total, total[0], rtol=1e-9)


@pytest.mark.parametrize("solver", [ancf.Newton(), ancf.QuasiNewton("bfgs"), "auto"], ids=repr)
def test_friction_stops_a_rotor_where_its_work_is_used_up(solver):
    scene, rod, pin = rotor()
    scene.joint_friction(pin, 1.5, slip=1e-3)
    run = ancf.simulate(scene, 2.0, 0.005, integrator=DAMPED, solver=solver)
    # 1/2 J w^2 = 2 J over 1.5 N m; it stops after 4/3 s and creeps less than slip.
    assert angle_of(run, rod)[-1] == pytest.approx(2.0 / 1.5, abs=1e-3)
    assert run.energy.dissipated[-1] == pytest.approx(2.0, rel=1e-3)
    assert run.energy.drift < 2e-3
    slow = abs(run.body(rod).angular_velocity[-1])
    assert slow < 1e-3


def test_a_load_below_friction_creeps_as_its_formula():
    # moment / size = s: the rate of the regularised law is slip s / sqrt(1 - s^2).
    scene, rod, pin = rotor(spin=0.0)
    scene.joint_friction(pin, 2.0, slip=0.01)
    scene.point_moment(rod.origin, 1.2)
    run = ancf.simulate(scene, 4.0, 0.01, integrator=ancf.GeneralizedAlpha(0.5))
    assert run.body(rod).angular_velocity[-1] == pytest.approx(0.01 * 0.6 / 0.8, rel=1e-6)


def test_a_stop_reaches_as_far_as_its_energy():
    scene, rod, pin = rotor()
    scene.joint_stop(pin, -0.5, 1.0, stiffness=2e3)
    run = ancf.simulate(scene, 2.0, 5e-4, integrator=DAMPED)
    turned = angle_of(run, rod)
    deep = 2.0 / math.sqrt(2e3)
    assert turned.max() == pytest.approx(1.0 + deep, rel=1e-4)
    assert turned.min() == pytest.approx(-0.5 - deep, rel=1e-3)


def test_a_damped_stop_takes_what_the_body_loses():
    scene, rod, pin = rotor()
    scene.joint_stop(pin, -3.0, 1.0, stiffness=2e3, damping=0.3)
    run = ancf.simulate(scene, 1.0, 2e-4, integrator=DAMPED)
    spin = run.body(rod).angular_velocity
    assert -2.0 < spin[-1] < -0.5
    lost = 0.5 * (4.0 - spin[-1] ** 2)
    assert run.energy.dissipated[-1] == pytest.approx(lost, rel=1e-3)


def test_a_spring_and_a_stop_along_a_slide_in_space():
    scene = ancf.Scene((0.0, 0.0, -9.81))
    body = scene.add_body(ancf.Box(length=0.2, width=0.1, height=0.1), mass=2.0, position=(1, 0, 0))
    slide = scene.prismatic(body.origin, axis=(0, 0, 1))
    spring = scene.joint_spring(slide, stiffness=500.0, damping=100.0)
    rest = ancf.solve_static(scene)
    assert rest.position(body.origin)[2] == pytest.approx(-2.0 * 9.81 / 500.0, rel=1e-9)
    run = ancf.simulate(scene, 4.0, 0.01, integrator=DAMPED)
    assert run.position(body.origin)[-1, 2] == pytest.approx(-2.0 * 9.81 / 500.0, rel=1e-6)
    assert "displacement of the prismatic joint" in spring.what


def test_a_hinge_of_beams_with_a_spring_rests_where_moments_balance():
    # A stiff cantilever on a torsional spring: angle = P L cos(angle) / k.
    scene = ancf.Scene((0.0, 0.0))
    material = ancf.Material(2e14, 1e3)
    rod = scene.add_beam("thin", (0, 0), (2, 0), 2, ancf.Rectangle(0.02, 0.02), material)
    pin = scene.pin(rod.start)
    scene.joint_spring(pin, stiffness=50.0)
    scene.point_force(rod.end, (0.0, 20.0))
    rest = ancf.solve_static(scene, tolerance=1e-10)
    x, y = rest.position(rod.end)
    angle = math.atan2(y, x)
    assert 50.0 * angle == pytest.approx(20.0 * 2.0 * math.cos(angle), rel=1e-4)


def test_forces_of_joints_are_derivatives_and_so_is_their_matrix():
    scene = ancf.Scene((0.0, 0.0, 0.0))
    one, other = (
        scene.add_body(ancf.Box(length=0.3, width=0.1, height=0.2), mass=1.0, position=(x, 0, 0))
        for x in (0, 1)
    )
    joint = scene.cylindrical(one.at((0.5, 0, 0)), other.at((-0.4, 0, 0)), axis=(1, 0, 0))
    plain = System(scene)
    scene.joint_spring(joint, stiffness=7.0, rest=0.4, damping=2.0, of="angle")
    scene.joint_stop(joint, -0.3, -0.2, stiffness=30.0, damping=0.5, of="displacement")
    scene.joint_friction(joint, 3.0, slip=0.5, of="angle")
    system = System(scene)
    rng = np.random.default_rng(2)
    q = system.q_ref + 0.05 * rng.standard_normal(system.n_all)
    v, d = rng.standard_normal((2, system.n_all))
    none, m = np.zeros(1), np.zeros(system.n_multipliers)
    force, step = system.assembly.force, 1e-6
    pair = [system.assembly.strain_energy(q + s * step * d) for s in (1, -1)]
    assert (pair[0] - pair[1]) / (2 * step) == pytest.approx(force(q) @ d, rel=1e-7)
    n = system.n_free

    def of(which, stiffness, damping):
        assembly = which.assembly
        values = assembly.matrix(0.0, stiffness, q, m, none, damping_factor=damping, v=v)
        return full(which, values)[:n, :n]

    near = (force(q + step * d) - force(q - step * d)) / (2 * step)
    stiff = of(system, 1.0, 0.0) - of(plain, 1.0, 0.0)
    np.testing.assert_allclose(stiff @ d[:n], near[:n], rtol=1e-6, atol=1e-6)
    damping = system.assembly.damping
    near = (damping(q, v + step * d) - damping(q, v - step * d)) / (2 * step)
    np.testing.assert_allclose(of(system, 0.0, 1.0) @ d[:n], near[:n], atol=1e-6)


def test_bad_arguments_of_joint_springs():
    scene, rod, pin = rotor()
    assert_refused("does nothing", scene.joint_spring, pin)
    with pytest.raises(ancf.InputError, match=r"stiffness of the spring .* must not be negative"):
        scene.joint_spring(pin, stiffness=-1.0)
    with pytest.raises(ancf.InputError, match="low below high, less than a turn apart"):
        scene.joint_stop(pin, 0.0, 7.0, stiffness=1.0)
    assert_refused("it would stop nothing", scene.joint_stop, pin, 0.0, 1.0, stiffness=0.0)
    with pytest.raises(ancf.InputError, match=r"slip of the friction .* must be positive"):
        scene.joint_friction(pin, 1.0, slip=0.0)
    assert_refused("needs a joint that a method", scene.joint_spring, rod, stiffness=1.0)
