"""Newmark's coefficients, and motions it must follow exactly."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import pendulum
from tests.integrators.points import assert_saved_seldom

SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)


@pytest.mark.parametrize("alpha", [0.0, 0.05, 0.3, 1.0])
def test_coefficients(alpha):
    newmark = ancf.Newmark(alpha)
    assert newmark.gamma == pytest.approx(0.5 + alpha, rel=1e-15)
    assert newmark.beta == pytest.approx((1 + alpha) ** 2 / 4, rel=1e-15)
    # Multiplying a linear constraint, a step has the double eigenvalue -(1 - alpha) / (1 + alpha):
    # damped for alpha > 0, kept for ever for alpha = 0.
    g, b = newmark.gamma, newmark.beta
    step = np.array([[1 - g / b, 1 - g / (2 * b)], [-1 / b, 1 - 1 / (2 * b)]])
    expected = -(1 - alpha) / (1 + alpha)
    assert np.trace(step) == pytest.approx(2 * expected, abs=1e-14)
    assert np.linalg.det(step) == pytest.approx(expected**2, abs=1e-14)


@pytest.mark.parametrize("alpha", [-0.01, 1.01, math.nan, math.inf, "0.1"])
def test_a_damping_out_of_range_is_refused(alpha):
    with pytest.raises(ancf.InputError, match="alpha"):
        ancf.Newmark(alpha)


def falling(dim=2, element="thin", velocity=None, gravity=(0.5, -9.81, 0.25)):
    scene = ancf.Scene(gravity[:dim])
    start, end = (0.0,) * dim, (2.0, 0.5, -0.5)[:dim]
    rod = scene.add_beam(element, start, end, 10, SECTION, MATERIAL, velocity=velocity)
    return scene, rod


@pytest.mark.parametrize("alpha", [0.0, 0.3])
@pytest.mark.parametrize(("dim", "element"), [(2, "l2t2"), (2, "thin"), (3, "thin"), (3, "thick")])
def test_free_fall_is_exact(dim, element, alpha):
    velocity = np.array([1.0, 2.0, -3.0])[:dim]
    scene, rod = falling(dim, element, velocity)
    run = ancf.simulate(scene, 1.0, 1e-3, integrator=ancf.Newmark(alpha), save_every=100)
    for s in (0.0, 0.55, rod.length):
        node = rod.at(s)
        path = node.position + np.outer(run.t, velocity) + np.outer(run.t**2 / 2, scene.gravity)
        np.testing.assert_allclose(run.position(node), path, rtol=0, atol=1e-11)
        fall = velocity + np.outer(run.t, scene.gravity)
        np.testing.assert_allclose(run.velocity(node), fall, rtol=0, atol=1e-10)
        weight = np.tile(scene.gravity, (len(run.t), 1))
        np.testing.assert_allclose(run.acceleration(node), weight, rtol=0, atol=1e-6)
    assert np.abs(run.energy.elastic).max() < 1e-15
    assert run.energy.drift < 1e-11


def momentum_weights(run, rod):
    """Shape functions integrated over the beam: the mean of a field is their product with it."""
    places, length = run.system.places[0], rod.length / rod.n_elements
    weights = np.zeros((rod.n_nodes, 2))
    for e in range(rod.n_elements):
        weights[e] += length * np.array([1 / 2, length / 12])
        weights[e + 1] += length * np.array([1 / 2, -length / 12])
    return places, weights / rod.length


@pytest.mark.parametrize("alpha", [0.0, 0.2])
def test_the_centre_of_mass_falls_freely_however_the_beam_moves(alpha):
    scene, rod = falling(
        velocity=lambda x: np.stack([-3 * x[:, 1], 5 * np.sin(3 * x[:, 0])], axis=1)
    )
    run = ancf.simulate(
        scene, 0.5, 5e-4, integrator=ancf.Newmark(alpha), tolerance=1e-9,
        solver=ancf.Newton(), save_every=50,
    )  # fmt: skip
    places, weights = momentum_weights(run, rod)
    for d in range(2):
        where = places[:, [d, 2 + d]]
        centre = np.sum(run.q[:, where] * weights, axis=(1, 2))
        speed = np.sum(run.v[:, where] * weights, axis=(1, 2))
        g = scene.gravity[d]
        path = centre[0] + speed[0] * run.t + g * run.t**2 / 2
        np.testing.assert_allclose(centre, path, rtol=0, atol=1e-10)
        np.testing.assert_allclose(speed, speed[0] + g * run.t, rtol=0, atol=1e-9)
    assert run.energy.elastic[1:].min() > 1e-3  # it does bend


@pytest.mark.parametrize("alpha", [0.0, 0.1])
def test_loads_are_taken_at_the_end_of_the_step(alpha):
    # A rigid beam under a force that grows in time: the recursion by hand.
    scene, rod = falling(gravity=(0.0, 0.0))
    force, dt, steps = np.array([0.7, -0.2]), 1e-2, 60
    scene.distributed_force(rod, lambda t: force * np.sin(3 * t) / rod.length)
    newmark = ancf.Newmark(alpha)
    run = ancf.simulate(scene, steps * dt, dt, integrator=newmark, tolerance=1e-9)
    mass = SECTION.area * MATERIAL.density * rod.length
    x, v, a = np.zeros(2), np.zeros(2), np.zeros(2)
    for k in range(1, steps + 1):
        new = force * np.sin(3 * k * dt) / mass
        x = x + dt * v + dt**2 * ((0.5 - newmark.beta) * a + newmark.beta * new)
        v = v + dt * ((1 - newmark.gamma) * a + newmark.gamma * new)
        a = new
        np.testing.assert_allclose(run.position(rod.end)[k] - rod.end.position, x, atol=1e-12)
        np.testing.assert_allclose(run.velocity(rod.end)[k], v, atol=1e-11)


def test_the_start_is_in_balance():
    # Released from rest, a pinned uniform rod: its tip starts with 3 g / 2, rigid or not, and the
    # pin carries a quarter of the weight.
    scene, rod = pendulum("thin", 10, youngs_modulus=2e11)
    run = ancf.simulate(scene, 1e-4, 1e-4)
    weight = SECTION.area * MATERIAL.density * 2.0 * 9.81
    assert run.t[0] == 0.0
    np.testing.assert_array_equal(run.q[0], run.system.q0)
    # A beam without stress has no stiffness to spread the load: each point falls as the mass matrix
    # says, and only the pinned element feels the pin.
    assert run.acceleration(rod.end)[0, 1] == pytest.approx(-9.81, rel=1e-3)
    mass = run.system.assembly.inertia(run.a[0])
    upward = run.system.places[0][:, 1]
    total = mass[upward].sum()
    assert run.reaction(rod.start)[0, 1] == pytest.approx(total + weight, rel=1e-12)


def test_a_start_that_swings_has_its_centripetal_force():
    # A rod held by a massless one of length 1 m swings about the anchor: at t = 0 its first node
    # has the acceleration of the circle, and the multiplier alone moves the mass.
    scene = ancf.Scene((0.0, 0.0))
    spin = 3.0
    rod = scene.add_beam(
        "thin", (1, 0), (3, 0), 10, SECTION, MATERIAL,
        velocity=lambda x: spin * np.stack([-x[:, 1], x[:, 0]], axis=1),
    )  # fmt: skip
    scene.rod(rod.start, (0.0, 0.0))
    run = ancf.simulate(scene, 1e-3, 1e-3)
    np.testing.assert_allclose(run.acceleration(rod.start)[0], [-(spin**2), 0.0], atol=1e-9)
    pull = run.multipliers[0, 0]
    assert pull > 0.0
    push = np.zeros(run.q.shape[1])
    push[run.system.places[0][0, 0]] = pull  # phi_q is the unit vector from the anchor
    np.testing.assert_allclose(run.system.assembly.inertia(run.a[0]), -push, atol=1e-8 * pull)


def test_a_start_that_breaks_a_rod_is_refused():
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam(
        "thin", (0, 0), (2, 0), 10, SECTION, MATERIAL,
        velocity=lambda x: 3.0 * np.stack([-x[:, 1], x[:, 0]], axis=1),
    )  # fmt: skip
    scene.rod(rod.node(5), (1.0, -1.0))
    # The rod to the middle would be stretched by the spin.
    with pytest.raises(ancf.InputError, match=r"initial velocities violate the rod"):
        ancf.simulate(scene, 1e-3, 1e-3)


def test_saving_seldom_saves_the_same_states():
    scene, _ = pendulum("l2t2", 2)
    assert_saved_seldom(scene, (7, 2100, 4000))


def test_loads_are_evaluated_at_the_times_that_are_saved():
    # A load that sets in at a step's end must be seen alike by the march and by the reactions.
    onset = 1e-3 * 55
    found = []
    for stride in (1, 11):
        scene, rod = pendulum("l2t2", 2)
        scene.point_force(rod.start, lambda t: (0.0, -100.0 * (t >= onset)))
        run = ancf.simulate(scene, 55 * 1e-3, 1e-3, save_every=stride)
        found.append(run.reaction(rod.start)[-1])
    np.testing.assert_array_equal(*found)
    assert found[0][1] > 99.0


def test_changing_loads_cross_chunks_of_steps():
    # Loads are tabulated two thousand steps at a time: a jump in the table would be a jump in a.
    scene, rod = falling(gravity=(0.0, 0.0))
    scene.distributed_force(rod, lambda t: (np.sin(t), 0.0))
    run = ancf.simulate(scene, 2.5, 1e-3, solver=ancf.Newton(), tolerance=1e-6)
    expected = np.sin(run.t) * rod.length / (SECTION.area * MATERIAL.density * rod.length)
    np.testing.assert_allclose(run.acceleration(rod.end)[:, 0], expected, rtol=0, atol=1e-5)
