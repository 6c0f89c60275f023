"""Shapes of obstacles: distances, derivatives, and work between states, fixed and on bodies."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from tests.matrices import full
from tests.system.contributions.shapes import ORIENTED, SHAPES, core_points, lowered

RADIUS, STIFFNESS = 0.002, 1e5
SOFT = ancf.Material(1e3, 1e3)  # whose matrix does not hide that of the contact


def pressed(obstacle, is_moving=False, depth=1e-3):
    """The system of a cable that is pressed on an obstacle, its contact, and a body or None."""
    obstacle = lowered(obstacle, RADIUS - depth)
    pad = (0.0,) * (obstacle.dim - 2)
    scene = ancf.Scene((0.0, 0.0, *pad))
    cable = scene.add_beam(
        "thin", (-0.3, 0, *pad), (0.3, 0, *pad), 40, ancf.Circle(2.0 * RADIUS), SOFT
    )
    body = None
    if is_moving:
        inertia = 2e-5 if obstacle.dim == 2 else (2e-5, 3e-5, 4e-5)
        turn = 0.4 if obstacle.dim == 2 else (0.6, 0.8, 0, 0)
        body = scene.add_body(
            mass=0.05, inertia=inertia, position=(0.01, -0.08, *pad), orientation=turn
        )
    contact = scene.contact(cable, obstacle, stiffness=STIFFNESS, on=body)
    system = System(scene)
    part = next(each for each in system.contributions if hasattr(each, "contact"))
    return system, contact, part


def near(system, rng, size=1e-4):
    """Return coordinates near those of the start."""
    return system.q0 + size * rng.normal(size=system.n_all)


def forces(system, q):
    """Return the residual of a state at rest."""
    rest, lam = np.zeros(system.n_all), np.zeros(system.n_multipliers)
    return system.assembly.residual(q, rest, rest, lam, rest, np.zeros(0))[0]


@pytest.mark.parametrize("name", SHAPES)
def test_penetrations_are_distances_from_points_of_the_core(name, rng):
    system, contact, part = pressed(SHAPES[name])
    obstacle, q = contact.obstacle, near(system, rng)
    sums = [system.point(point) for point in contact.points]
    x = np.array([weights @ q[places].T for places, weights in sums])
    core = core_points(obstacle, 41 if isinstance(obstacle, ancf.Block) else 20_001)
    nearest = np.array([np.linalg.norm(core - each, axis=1).min() for each in x])
    found = RADIUS + obstacle.radius - part.motion(q, np.zeros(system.n_all))[1]
    # A point between two of the core, h apart, is nearer by up to h^2 / 8 (1 / D + 1 / R).
    spacing = 0.12 / 40 * np.sqrt(obstacle.dim) if isinstance(obstacle, ancf.Block) else 2e-5
    outside = found > 5e-4
    assert outside.sum() > 100
    error = nearest[outside] - found[outside]
    assert error.min() > -1e-12
    assert np.all(error < spacing**2 / 8.0 * (1.0 / found[outside] + 1.0 / 0.06) + 1e-12)
    np.testing.assert_allclose(obstacle.distances(x), found - obstacle.radius, atol=1e-15)


@pytest.mark.parametrize("is_moving", [False, True])
@pytest.mark.parametrize("name", ORIENTED)
def test_force_and_matrix_are_derivatives_of_the_energy(name, is_moving, rng):
    system, _, part = pressed(ORIENTED[name], is_moving)
    n, q, none = system.n_free, near(system, rng), np.zeros(0)
    assert part.forces(q[None], q[None])[0, 0].any()
    h = 1e-7
    units, energy = h * np.eye(system.n_all)[:n], system.assembly.strain_energy
    differences = np.array([energy(q + e) - energy(q - e) for e in units]) / (2.0 * h)
    assert np.abs(forces(system, q)[:n] - differences).max() < 1e-7 * np.abs(differences).max()
    tangent = np.array([forces(system, q + e) - forces(system, q - e) for e in units]).T
    tangent = tangent[:n] / (2.0 * h)
    lam = np.zeros(system.n_multipliers)
    found = full(system, system.assembly.matrix(0.0, 1.0, q, lam, none))[:n, :n]
    assert np.abs(found - tangent).max() < 1e-7 * np.abs(tangent).max()
    if is_moving:
        own = system.places[1].ravel()
        assert np.abs((found - tangent)[own]).max() < 1e-7 * np.abs(tangent[own]).max() > 0.0


@pytest.mark.parametrize("is_moving", [False, True])
@pytest.mark.parametrize("name", ORIENTED)
def test_work_between_any_two_states_is_the_change_of_energy(name, is_moving, rng):
    system, _, part = pressed(ORIENTED[name], is_moving)
    none, rest = np.zeros(0), np.zeros(system.n_all)
    lam, energy = np.zeros(system.n_multipliers), system.assembly.strain_energy
    for size in (2e-4, 1e-5, 1e-8):
        before = near(system, rng)
        after = before + size * rng.normal(size=system.n_all)
        assert part.forces(after[None], rest[None])[0, 0].any()
        middle = 0.5 * (before + after)
        force = system.assembly.residual_between(before, after, middle, rest, lam, rest, none)[0]
        change = energy(after) - energy(before)
        work = force @ (after - before)
        # Rounding errors are up to 1e-16 over 1e-3 in penetrations.
        assert abs(work - change) < 3e-13 * energy(after)


@pytest.mark.parametrize("name", ORIENTED)
def test_the_forces_on_cable_and_body_balance(name, rng):
    system, _, part = pressed(ORIENTED[name], is_moving=True)
    q, other = near(system, rng), near(system, rng)
    none, rest = np.zeros(0), np.zeros(system.n_all)
    lam, middle = np.zeros(system.n_multipliers), 0.5 * (q + other)
    between = system.assembly.residual_between(q, other, middle, rest, lam, rest, none)[0]
    assert part.forces(q[None], rest[None])[0, 0].any()
    for state, force in ((q, forces(system, q)), (middle, between)):
        size = np.abs(force).max()
        dim = system.dim
        for c in range(dim):
            assert abs(system.uniform(c) @ force) < 1e-12 * size
        # Virtual rotations of all positions and vectors.
        for a, b in [(0, 1), (1, 2), (2, 0)][: 3 if dim == 3 else 1]:
            turn = np.zeros(system.n_all)
            for places in system.places:
                turn[places[:, a::dim]] = -state[places[:, b::dim]]
                turn[places[:, b::dim]] = state[places[:, a::dim]]
            assert abs(turn @ force) < 1e-12 * size
