"""Contact with obstacles on rigid bodies: momentum, energy, and Atwood's machine."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.system import System
from tests.matrices import derivative_of_step, full

SECTION, MATERIAL = ancf.Circle(0.004), ancf.Material(1e9, 1e3)


def collision(dim, offset=0.0, height=0.0521, **friction):
    """A free cable on which a free ball falls, which turns; its centre is off the origin."""
    pad = (0.0,) * (dim - 2)
    scene = ancf.Scene((0.0, 0.0, *pad))
    cable = scene.add_beam("thin", (-0.3, 0, *pad), (0.3, 0, *pad), 12, SECTION, MATERIAL)
    spin = 20.0 if dim == 2 else (0.0, 5.0, 20.0)
    inertia = 2e-5 if dim == 2 else (2e-5, 2e-5, 2e-5)
    ball = scene.add_body(
        mass=0.05,
        inertia=inertia,
        position=(offset, height, *pad),
        velocity=(0.3, -1.0, *pad),
        angular_velocity=spin,
    )
    contact = scene.contact(
        cable, ancf.Ball((0.02, height, *pad), 0.05), on=ball, stiffness=1e5, **friction
    )
    return scene, cable, ball, contact


def momenta(scene, run):
    """Momentum (k, dim), and angular momentum about the origin and z (k,)."""
    system = System(scene)
    impulses = np.array([system.assembly.inertia(np.array(v)) for v in run.v])
    turned = np.zeros_like(impulses)
    for places in system.places:
        x, y = places[:, 0 :: scene.dim].ravel(), places[:, 1 :: scene.dim].ravel()
        turned[:, x], turned[:, y] = -run.q[:, y], run.q[:, x]
    uniform = np.array([system.uniform(c) for c in range(scene.dim)])
    return impulses @ uniform.T, np.sum(impulses * turned, axis=1)


@pytest.mark.parametrize("friction", [{}, {"friction": 0.4, "slip_speed": 0.05}])
@pytest.mark.parametrize("offset", [0.02, -0.01])
@pytest.mark.parametrize("dim", [2, 3])
def test_momenta_are_kept_and_energy_is_lost_to_friction_alone(dim, offset, friction):
    scene, cable, _, contact = collision(dim, offset, **friction)
    run = ancf.simulate(scene, 0.04, 2e-4, integrator=ancf.EnergyMomentum(), tolerance=1e-11)
    assert run.contact_force(contact).pressure.any()
    assert run.velocity(cable.at(0.3))[:, 1].min() < -0.3
    for momentum in momenta(scene, run):
        assert np.abs(momentum - momentum[0]).max() < 1e-7 * np.abs(momentum).max()
    energy = run.energy
    assert not energy.work.any()
    assert energy.drift < 1e-7
    assert (energy.friction[-1] > 0.01 * energy.kinetic[0]) == bool(friction)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_matrix_of_sliding_on_a_body_is_the_derivative_by_velocities(dim, rng):
    scene, *_ = collision(dim, height=0.0505, friction=0.4, slip_speed=0.5)
    system = System(scene)
    none, rest = np.zeros(0), np.zeros(system.n_all)
    q, n = system.q0 + 1e-5 * rng.normal(size=system.n_all), system.n_free
    lam, v = np.zeros(system.n_multipliers), 0.1 * rng.normal(size=system.n_all)

    def force(v):
        return system.assembly.residual(q, v, rest, lam, rest, none)[0][:n]

    units = 1e-6 * np.eye(system.n_all)[:n]
    expected = np.array([force(v + e) - force(v - e) for e in units]).T / 2e-6
    values = system.assembly.matrix(0.0, 0.0, q, lam, none, damping_factor=1.0, v=v)
    found = full(system, values)[:n, :n]
    assert np.abs(expected).max() > 1e-3
    assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()


def test_the_matrix_of_a_step_is_the_derivative_of_its_residual_without_friction():
    scene, *_ = collision(2)
    system = System(scene)
    march, *_ = prepare_implicit(
        system, 1e-3, ancf.GeneralizedAlpha(0.9), ancf.Newton(), 1e-9, math.inf
    )
    march.prepare(np.zeros((1, 0)))
    derivative = derivative_of_step(march, system.n_free + system.n_multipliers)
    march.residual()
    found, n = full(system, march.matrix()), system.n_free
    # Mass is added to the coordinates of the body along its constraints, which changes no solution.
    own = system.places[1].ravel()
    mask = np.ones_like(found, dtype=bool)
    mask[np.ix_(own, own)] = mask[n:, n:] = False
    assert mask[own].any()
    assert np.abs(found - derivative)[mask].max() < 1e-5 * np.abs(derivative).max()


@pytest.mark.parametrize("integrator", [ancf.EnergyMomentum(), ancf.GeneralizedAlpha(0.5)])
def test_a_rope_that_is_pulled_at_both_ends_turns_its_pulley(integrator):
    """Atwood: (F2 - F1) / (m1 + m2 + rope + I / R^2), where the rope does not slide.

    The arc is curved without stress: bending and straightening take E I / R^2 of the force, 1 %.
    """
    radius, inertia, ends, forces = 0.1, 4e-4, (0.25, 0.3), (2.4, 2.9)
    reach = radius + 2.5e-4
    scene = ancf.Scene((0.0, 0.0))
    pulley = scene.add_body(mass=0.05, inertia=inertia, position=(0, 0))
    pin = scene.pin(pulley.origin)
    options = {"section": ancf.Circle(5e-4), "material": ancf.Material(1.6e10, 4e3)}
    left = scene.add_beam("thin", (-reach, -0.3), (-reach, 0), n_elements=12, **options)
    curve = ancf.Arc((0, 0), (-reach, 0.0), -math.pi)
    arc = scene.add_beam("thin", curve=curve, n_elements=30, **options)
    right = scene.add_beam("thin", (reach, 0), (reach, -0.3), n_elements=12, **options)
    scene.connect(left.end, arc.start)
    scene.connect(arc.end, right.start)
    for end, mass, force in zip((left.start, right.end), ends, forces, strict=True):
        scene.add_mass(end, mass)
        scene.point_force(end, ancf.Ramp((0.0, -force), 0.1, smooth=True))
    for part in (left, arc, right):
        scene.contact(part, ancf.Drum((0, 0), radius), on=pulley, friction=0.8, slip_speed=1e-3)
    run = ancf.simulate(scene, 0.3, 5e-4, integrator=integrator)
    rope = 4e3 * math.pi * 2.5e-4**2 * (0.6 + math.pi * reach)
    bending = 1.6e10 * math.pi / 4.0 * 2.5e-4**4 / reach**2
    rate = (forces[1] - forces[0] - bending) / (sum(ends) + rope + inertia / radius**2)
    late = run.t > 0.12
    rim = np.linalg.norm(run.velocity(pulley.at((radius, 0.0))), axis=1)
    speeds = (run.velocity(left.start)[:, 1], -run.velocity(right.end)[:, 1], rim)
    slopes = [np.polyfit(run.t[late], speed[late], 1)[0] for speed in speeds]
    assert np.allclose(slopes, rate, rtol=3e-3)
    held = np.linalg.norm(run.joint_force(pin).force[late], axis=1).mean()
    assert held == pytest.approx(sum(forces) + (ends[0] - ends[1]) * rate, rel=0.01)


def test_scenes_with_obstacles_on_bodies_are_stored(tmp_path):
    scene, *_ = collision(2, friction=0.4, slip_speed=0.05)
    scene.save(tmp_path / "ball.json")
    again = ancf.Scene.load(tmp_path / "ball.json")
    assert again.digest() == scene.digest()
    first, second = (
        ancf.simulate(each, 0.02, 1e-3, integrator=ancf.EnergyMomentum()) for each in (scene, again)
    )
    assert np.array_equal(first.q, second.q)


@pytest.mark.parametrize(
    ("obstacle", "on", "message"),
    [
        (ancf.Drum((0, -1), 0.5, angular_velocity=1.0), "wheel", "leave its angular_velocity out"),
        (ancf.Ball((0, -1), 0.5), "cable", "needs a rigid body"),
        (ancf.Ball((0, -1), 0.5), "other", "of another scene"),
    ],
)
def test_obstacles_that_cannot_move_with_a_body_are_refused(obstacle, on, message):
    scene, other = ancf.Scene((0.0, 0.0)), ancf.Scene((0.0, 0.0))
    cable = scene.add_beam("thin", (-0.3, 0), (0.3, 0), 12, SECTION, MATERIAL)
    bodies = {
        "cable": cable,
        "wheel": scene.add_body(mass=1.0, inertia=1.0, position=(0, -1)),
        "other": other.add_body(mass=1.0, inertia=1.0, position=(0, -1)),
    }
    with pytest.raises(ancf.InputError, match=message):
        scene.contact(cable, obstacle, on=bodies[on], stiffness=1.0)
