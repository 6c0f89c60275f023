"""Friction in proportion to the force of a joint: an incline, braked wheels, a pendulum."""

import numpy as np
import pytest

import ancfsparse as ancf
from tests.solve.refusals import assert_refused

G, SLIP = 9.81, 1e-4
DAMPED = ancf.GeneralizedAlpha(0.9)


def on_incline(dim, angle=0.5, speed=0.0):
    """A block on a slope; its axis points down."""
    down = np.array([np.cos(angle), -np.sin(angle), 0.0])[:dim]
    scene = ancf.Scene(np.array([0.0, -G, 0.0])[:dim])
    block = scene.add_body(
        ancf.Box(length=0.2, width=0.1, height=0.1),
        mass=3.0,
        position=np.zeros(dim),
        velocity=speed * down,
    )
    return scene, block, scene.prismatic(block.origin, axis=down), down


@pytest.mark.parametrize("solver", ["auto", ancf.Newton(), ancf.QuasiNewton("davidon")], ids=repr)
@pytest.mark.parametrize("integrator", [DAMPED, ancf.EnergyMomentum()], ids=repr)
@pytest.mark.parametrize("dim", [2, 3])
def test_a_block_slides_down_an_incline(dim, integrator, solver):
    """From 1 m/s with g (sin - mu cos), the regularised law on top by (slip / rate)^2 / 2."""
    scene, block, slide, down = on_incline(dim, speed=1.0)
    scene.joint_friction(slide, coefficient=0.3, slip=SLIP)
    run = ancf.simulate(scene, 1.0, 0.01, integrator=integrator, solver=solver, tolerance=1e-10)
    way = run.position(block.origin) @ down
    pull = G * (np.sin(0.5) - 0.3 * np.cos(0.5))
    np.testing.assert_allclose(way, run.t + 0.5 * pull * run.t**2, atol=1e-7)
    taken = 0.3 * 3.0 * G * np.cos(0.5) * way[-1]
    assert run.energy.dissipated[-1] == pytest.approx(taken, rel=1e-4)
    assert run.energy.drift < 1e-4


def test_a_block_stays_on_a_flat_incline():
    """Below the angle of friction, tan 0.2 < 0.3, it creeps by less than the slip."""
    scene, block, slide, down = on_incline(2, angle=0.2)
    scene.joint_friction(slide, coefficient=0.3, slip=SLIP)
    run = ancf.simulate(scene, 1.0, 0.01)
    share = np.tan(0.2) / 0.3
    creep = SLIP * share / np.sqrt(1.0 - share**2)
    rate = np.diff(run.position(block.origin) @ down)[-1] / 0.01
    assert rate == pytest.approx(creep, rel=1e-2)


def test_a_wheel_on_a_rubbing_axle_slows_down_at_the_rate_of_its_weight():
    """mu m g r / J, with J = 0.02 kg m2 and r = 1 cm, until it stops."""
    scene = ancf.Scene((0.0, -G))
    wheel = scene.add_body(mass=2.0, inertia=0.02, position=(0, 0), angular_velocity=3.0)
    pin = scene.pin(wheel.origin, as_constraint=True)
    scene.joint_friction(pin, coefficient=0.2, radius=0.01, slip=1e-3)
    run = ancf.simulate(scene, 2.0, 0.01, tolerance=1e-10)
    slower = 0.2 * 2.0 * G * 0.01 / 0.02
    expected = np.maximum(3.0 - slower * run.t, 0.0)
    np.testing.assert_allclose(run.body(wheel).angular_velocity, expected, atol=2e-3)


def pendulum(dim):
    """A rod on a rubbing bearing, from horizontal rest: its force changes with angle and speed."""
    gravity = (0.0, -G) if dim == 2 else (0.0, -G, 0.0)
    scene = ancf.Scene(gravity)
    rod = scene.add_body(ancf.Rod(1.0), mass=1.0, position=np.zeros(dim)) if dim == 2 else (
        scene.add_body(
            mass=1.0, inertia=(0.1, 0.12, 1 / 12), centre=(0.4, 0, 0), position=(0.1, 0, 0)
        )
    )  # fmt: skip
    if dim == 2:
        joint = scene.pin(rod.origin, as_constraint=True)
    else:
        joint = scene.revolute(rod.at((-0.1, 0.0, 0.0)), axis=(0, 0, 1))
    scene.joint_friction(joint, coefficient=0.3, radius=0.1, slip=0.05)
    return scene, rod


def by_angle(t_end):
    """The pendulum by its angle and DOP853, with the force of its pin from the same instant."""
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    inertia, arm = 1.0 / 3.0, 0.5

    def acceleration(angle, rate):
        def off(a):
            x = -arm * (np.sin(angle) * a + np.cos(angle) * rate**2)
            y = arm * (np.cos(angle) * a - np.sin(angle) * rate**2) + G
            rub = 0.3 * 0.1 * np.hypot(x, y) * rate / np.hypot(rate, 0.05)
            return inertia * a + arm * G * np.cos(angle) + rub

        return brentq(off, -100.0, 100.0, xtol=1e-13)

    return solve_ivp(
        lambda t, y: (y[1], acceleration(*y)), (0.0, t_end), (0.0, 0.0), "DOP853",
        rtol=1e-10, atol=1e-12,
    ).y[0, -1]  # fmt: skip


@pytest.mark.parametrize("integrator", [DAMPED, ancf.EnergyMomentum()], ids=repr)
def test_second_order_with_a_force_that_changes(integrator):
    """Against the equation of the angle; the same multipliers that balance the step."""
    exact, errors = by_angle(1.5), []
    for dt in (0.01, 0.005):
        scene, rod = pendulum(2)
        run = ancf.simulate(scene, 1.5, dt, integrator=integrator, tolerance=1e-11)
        errors.append(abs(np.unwrap(run.body(rod).angles)[-1] - exact))
    assert 3.3 < errors[0] / errors[1] < 4.7
    assert errors[1] < 1e-3


def test_a_hinge_in_space_rubs_as_in_the_plane():
    """The same masses about the axis of the hinge, 0.5 m from the centre."""
    ends = []
    for dim in (2, 3):
        scene, rod = pendulum(dim)
        run = ancf.simulate(scene, 1.0, 0.005, tolerance=1e-11)
        motion = run.body(rod)
        ends.append(motion.centre[-1][:2])
    np.testing.assert_allclose(*ends, atol=1e-7)


def test_bad_friction_is_refused():
    scene, _, slide, _ = on_incline(2)
    for words, given in (
        ("either a size or a coefficient", {}),
        ("either a size or a coefficient", {"size": 1.0, "coefficient": 0.1}),
        (r"radius .* leave it out", {"coefficient": 0.1, "radius": 0.1}),
        (r"coefficient .* must be positive, got 0", {"coefficient": 0.0}),
        (r"slip .* must be a number", {"coefficient": 0.1, "slip": None}),
    ):
        assert_refused(words, scene.joint_friction, slide, **({"slip": 0.1} | given))
    other = ancf.Scene((0.0, -G))
    pin = other.pin(other.add_body(mass=2.0, inertia=0.02, position=(0, 0)).origin)
    rubbing = {"coefficient": 0.1, "slip": 0.1}
    assert_refused("give the radius of the bearing", other.joint_friction, pin, **rubbing)
    other.joint_friction(pin, radius=0.1, **rubbing)
    assert_refused("joints without multipliers do not provide", ancf.simulate, other, 0.1, 0.01)
    scene.joint_friction(slide, **rubbing)
    words, explicit = "cannot follow friction by the forces of joints", ancf.DormandPrince()
    assert_refused(words, ancf.simulate, scene, 0.1, 0.01, integrator=explicit)


def test_it_is_recorded():
    scene, _, slide, _ = on_incline(2)
    scene.joint_friction(slide, coefficient=0.1, slip=0.1)
    other, _, slide, _ = on_incline(2)
    other.joint_friction(slide, 0.1, slip=0.1)
    assert scene != other
    assert "coefficient (0.1)" in " ".join(scene.digest().values())
    assert "coefficient" not in " ".join(other.digest().values())
