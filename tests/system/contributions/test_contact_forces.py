"""Contact: law, residual, matrix and energy against quadrature and differences."""

import numpy as np
import pytest
from scipy.integrate import quad

import ancfsparse as ancf
from ancfsparse.scene.force_elements.contacts import LAYER_RATIO
from ancfsparse.system import System
from tests.matrices import full

STIFFNESS, RADIUS = 1e6, 0.005
OBSTACLES = {
    "plane": ancf.HalfSpace((0.0, -0.1), (0.1, 1.0)),
    "disc": ancf.Drum((0.45, -0.3), 0.297, angular_velocity=2.0),
    "floor": ancf.HalfSpace((0.0, -0.1, 0.0), (0.1, 1.0, 0.3)),
    "drum": ancf.Drum((0.45, -0.3, 0.0), 0.297, axis=(0.1, 0.0, 1.0), angular_velocity=-2.0),
    "ball": ancf.Ball((0.45, -0.3, 0.05), 0.301),
}


def pressed(name, friction=0.0):
    """A system of a bent cable that is pressed on an obstacle, and a state in which it is."""
    obstacle = OBSTACLES[name]
    pad = (0.0,) * (obstacle.dim - 2)
    scene = ancf.Scene((0.0, -9.81, *pad))
    rod = scene.add_beam(
        "thin", (0, 0, *pad), (1, 0, *pad), 12, ancf.Circle(2.0 * RADIUS), ancf.Material(1e9, 1e3)
    )
    contact = scene.contact(
        rod, obstacle, stiffness=STIFFNESS, friction=friction, slip_speed=0.1 if friction else None
    )
    system = System(scene)
    return system, contact, system.q0


def moved(system, q, size, rng):
    """Move all coordinates at random, by about `size` in every direction."""
    return q + size * rng.normal(size=system.n_all)


def law(e):
    """The pressure of a penetration, written a second time."""
    layer = LAYER_RATIO * RADIUS
    x = np.clip(e / layer, 0.0, 1.0)
    return STIFFNESS * np.where(e < layer, layer * (x**3 - 0.5 * x**4), e - 0.5 * layer)


def contact_part(system):
    """The contribution of the contact."""
    return next(each for each in system.contributions if hasattr(each, "contact"))


@pytest.mark.parametrize("name", OBSTACLES)
def test_pressures_follow_the_law(name, rng):
    system, contact, q = pressed(name)
    if name in ("plane", "floor"):
        q = q - 0.1 * system.uniform(1)
    q = moved(system, q, 2e-3, rng)
    normal, friction = contact_part(system).forces(q[None], np.zeros((1, system.n_all)))[0]
    assert normal.any()
    assert not friction.any()
    obstacle = contact.obstacle
    for k, point in enumerate(contact.points):
        x = np.array(system.point(point)[1] @ q[system.point(point)[0]].T)
        d = x - np.array(obstacle.base)
        if isinstance(obstacle, ancf.HalfSpace):
            n = np.array(obstacle.normal) / np.linalg.norm(obstacle.normal)
            gap = d @ n
        else:
            axis = np.array(getattr(obstacle, "axis", None) or np.zeros(obstacle.dim))
            d -= np.dot(d, axis) * axis / max(axis @ axis, 1e-9)
            n, gap = d / np.linalg.norm(d), np.linalg.norm(d) - obstacle.radius
        expected = contact.weights[k] * law(RADIUS - gap) * n
        assert np.allclose(normal[k], expected, rtol=1e-9, atol=1e-12)


def test_the_energy_is_the_integral_of_the_pressure():
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam(
        "thin", (0, 1), (1, 1), 2, ancf.Circle(2 * RADIUS), ancf.Material(1e9, 1e3)
    )
    scene.contact(rod, ancf.HalfSpace((0, 0), (0, 1)), stiffness=STIFFNESS)
    system = System(scene)
    for depth in (-1e-3, 1e-6, 4e-6, 6e-6, 1e-4):
        q = system.q0 + (RADIUS - depth - 1.0) * system.uniform(1)
        expected = quad(law, 0.0, max(depth, 0.0), points=[5e-6])[0]
        assert system.assembly.strain_energy(q) == pytest.approx(expected, rel=1e-9, abs=1e-18)


@pytest.mark.parametrize("name", OBSTACLES)
def test_force_and_matrix_are_derivatives_of_the_energy(name, rng):
    system, _, q = pressed(name)
    if name in ("plane", "floor"):
        q = q - 0.0999 * system.uniform(1)
    q = moved(system, q, 1e-4, rng)
    n, none, rest = system.n_free, np.zeros(0), np.zeros(system.n_all)
    assert contact_part(system).forces(q[None], rest[None])[0, 0].any()

    def force(q):
        return system.assembly.residual(q, rest, rest, none, rest, none)[0][:n]

    h = 1e-8
    units = np.eye(system.n_all)[:n]
    energy = system.assembly.strain_energy
    differences = np.array([(energy(q + h * e) - energy(q - h * e)) / (2 * h) for e in units])
    assert np.abs(force(q) - differences).max() < 1e-5 * np.abs(differences).max()
    tangent = np.array([(force(q + h * e) - force(q - h * e)) / (2 * h) for e in units]).T
    found = full(system, system.assembly.matrix(0.0, 1.0, q, none, none))
    assert np.abs(found - tangent).max() < 1e-5 * np.abs(tangent).max()


@pytest.mark.parametrize("name", OBSTACLES)
def test_between_two_states_the_pressure_does_the_work_of_its_energy(name, rng):
    system, _, q = pressed(name)
    if name in ("plane", "floor"):
        q = q - 0.1 * system.uniform(1)
    none, rest = np.zeros(0), np.zeros(system.n_all)
    q0 = moved(system, q, 1e-4, rng)
    for size in (1e-2, 1e-4, 1e-7, 1e-10, 0.0):
        q1 = moved(system, q0, size, rng)
        r, _ = system.assembly.residual_between(q0, q1, rest, rest, none, rest, none)
        gained = system.assembly.strain_energy(q1) - system.assembly.strain_energy(q0)
        scale = system.assembly.strain_energy(q1)
        assert r @ (q1 - q0) == pytest.approx(gained, rel=1e-9, abs=1e-13 * scale)


def test_the_matrix_of_a_step_that_enters_has_the_derivative_of_its_mean_force():
    system, _, q = pressed("plane")
    none, rest = np.zeros(0), np.zeros(system.n_all)
    q0 = q - 0.093 * system.uniform(1)  # outside
    n, up = system.n_free, system.uniform(1)[: system.n_free]

    def between(q1):
        return system.assembly.residual_between(q0, q1, rest, rest, none, rest, none)[0]

    q1 = q0 - 0.003 * system.uniform(1)
    assert not contact_part(system).forces(q0[None], rest[None]).any()
    h = 1e-7
    change = (between(q1 + h * system.uniform(1)) - between(q1 - h * system.uniform(1)))[:n] / (
        2 * h
    )
    between(q1)
    matrix = full(system, system.assembly.matrix(0.0, 1.0, 0.5 * (q0 + q1), none, none))
    assert up @ change > 1.0
    assert 0.5 * up @ matrix @ up == pytest.approx(up @ change, rel=1e-6)


@pytest.mark.parametrize("name", ["disc", "floor", "drum", "ball"])
def test_friction_opposes_sliding_on_the_moving_surface(name, rng):
    system, contact, q = pressed(name, friction=0.4)
    if name == "floor":
        q = q - 0.1 * system.uniform(1)
    v = rng.normal(size=system.n_all)
    normal, friction = contact_part(system).forces(q[None], v[None])[0]
    obstacle = contact.obstacle
    touching = np.flatnonzero(np.linalg.norm(normal, axis=1))
    assert len(touching)
    for k in touching:
        place, weight = system.point(contact.points[k])
        x, u = weight @ q[place].T, weight @ v[place].T
        pressure = np.linalg.norm(normal[k])
        n = normal[k] / pressure
        u = u - obstacle.spin @ (x - np.array(obstacle.base))
        u = u - n * (n @ u)
        expected = -0.4 * pressure * u / np.sqrt(u @ u + 0.1**2)
        assert np.allclose(friction[k], expected, rtol=1e-9, atol=1e-12)
        assert abs(friction[k] @ n) < 1e-9 * pressure
        assert np.linalg.norm(friction[k]) < 0.4 * pressure


def test_the_matrix_has_the_derivative_of_friction_by_velocities(rng):
    system, _, q = pressed("drum", friction=0.4)
    none, rest = np.zeros(0), np.zeros(system.n_all)
    n, v = system.n_free, 0.1 * rng.normal(size=system.n_all)

    def force(v):
        return system.assembly.residual(q, v, rest, none, rest, none)[0][:n]

    h = 1e-6
    expected = np.array(
        [(force(v + h * e) - force(v - h * e)) / (2 * h) for e in np.eye(system.n_all)[:n]]
    ).T
    values = system.assembly.matrix(0.0, 0.0, q, none, none, damping_factor=1.0, v=v)
    assert np.abs(full(system, values) - expected).max() < 1e-6 * np.abs(expected).max()
