"""Friction of beams among each other: forces, momentum, work and matrix."""

import numpy as np
import pytest

import ancfsparse as ancf
from tests.matrices import full
from tests.system.contributions.test_beam_contacts import (
    MATERIAL,
    SECTION,
    STIFFNESS,
    rotations,
    system_of,
)

FRICTION, SLIP_SPEED = 0.3, 0.01


def rubbing(rng, size=1e-3):
    """Two cables that cross, with friction, in a bent state and with velocities at random."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    lower = scene.add_beam("thin", (-0.3, 0, 0), (0.3, 0, 0), 6, SECTION, MATERIAL)
    upper = scene.add_beam("thin", (0.01, -0.3, 0.015), (0.05, 0.3, 0.015), 6, SECTION, MATERIAL)
    options = {"stiffness": STIFFNESS, "friction": FRICTION, "slip_speed": SLIP_SPEED}
    made = scene, scene.contact(lower, upper, **options)
    system, part, q = system_of(made, above=0.0055)
    q = q + size * rng.normal(size=system.n_all)
    return system, part, q, 0.1 * rng.normal(size=system.n_all)


def friction_in(system, q, v):
    """Friction in the residual: what velocities change."""
    none, rest = np.zeros(0), np.zeros(system.n_all)
    with_it, without = (
        system.assembly.residual(q, each, rest, none, rest, none)[0] for each in (v, rest)
    )
    return with_it - without


def test_friction_opposes_sliding_with_at_most_mu_times_the_normal_force(rng):
    system, part, q, v = rubbing(rng)
    elements, positions, normal, _ = part.compiled.touches(q)
    friction = part.friction(q, v, None)
    assert len(elements)
    directions = normal / np.linalg.norm(normal, axis=1)[:, None]
    for k, (pair, places) in enumerate(zip(elements, positions, strict=True)):
        one, other = (
            part.contact.point(int(e), float(xi)) for e, xi in zip(pair, places, strict=True)
        )
        (i, a), (j, b) = system.point(one), system.point(other)
        sliding = v[i] @ a - v[j] @ b
        sliding = sliding - (sliding @ directions[k]) * directions[k]
        size = FRICTION * np.linalg.norm(normal[k]) / np.sqrt(sliding @ sliding + SLIP_SPEED**2)
        assert np.allclose(friction[k], -size * sliding, rtol=1e-10, atol=1e-12 * size)
        assert np.linalg.norm(friction[k]) <= FRICTION * np.linalg.norm(normal[k])
    assert np.abs((friction * directions).sum(axis=1)).max() < 1e-12 * np.abs(friction).max()
    _, size, total, _ = (each[0] for each in part.forces(q[None], v[None]))
    assert total == pytest.approx(np.linalg.norm(friction, axis=1).sum())
    assert 0.0 < total <= FRICTION * size


def test_friction_keeps_momentum_and_has_the_moment_of_its_pairs(rng):
    system, part, q, v = rubbing(rng)
    r = friction_in(system, q, v)
    for direction in range(3):
        assert abs(r @ system.uniform(direction)) < 1e-12 * np.abs(r).sum()
    elements, positions, _, _ = part.compiled.touches(q)
    moment = np.zeros(3)
    for force, pair, places in zip(part.friction(q, v, None), elements, positions, strict=True):
        one, other = (
            part.contact.point(int(e), float(xi)) for e, xi in zip(pair, places, strict=True)
        )
        (i, a), (j, b) = system.point(one), system.point(other)
        moment += np.cross(q[i] @ a - q[j] @ b, force)
    found = -rotations(system, q) @ r
    assert np.abs(found - moment).max() < 1e-12 * np.abs(r).sum()
    assert np.abs(moment).max() > 1e-4 * np.abs(r).sum()


def test_the_matrix_has_the_derivative_of_friction_by_velocities_of_each_body(rng):
    system, _, q, v = rubbing(rng)
    n, none = system.n_free, np.zeros(0)
    friction_in(system, q, v)
    with_it, without = (
        full(system, system.assembly.matrix(0.0, 0.0, q, none, none, damping_factor=factor, v=v))[
            :n, :n
        ]
        for factor in (1.0, 0.0)
    )
    found = with_it - without
    scale = np.abs(found).max()
    assert np.abs(found - found.T).max() < 1e-12 * scale
    own = np.concatenate([system.vectors(name)[0] for name in ("r", "r_x")]).ravel()
    h = 1e-7
    for i in own[::5]:
        unit = np.eye(system.n_all)[i]
        change = friction_in(system, q, v + h * unit) - friction_in(system, q, v - h * unit)
        assert np.abs(change[own] / (2 * h) - found[own, i]).max() < 1e-5 * scale


def test_between_two_states_friction_takes_energy_and_keeps_momentum(rng):
    """Of a step that enters, with the velocity of its path."""
    system, part, q0, v = rubbing(rng, 1e-4)
    assert len(part.compiled.touches(q0)[0])
    rest, none, dt = np.zeros(system.n_all), np.zeros(0), 1e-3
    q1 = q0 + dt * v
    with_it, without = (
        system.assembly.residual_between(q0, q1, each, rest, none, rest, none)[0]
        for each in (v, rest)
    )
    r = with_it - without
    assert r @ v > 0.0
    for direction in range(3):
        assert abs(r @ system.uniform(direction)) < 1e-12 * np.abs(r).sum()
    n = system.n_free
    system.assembly.residual_between(q0, q1, v, rest, none, rest, none)
    matrix = [
        full(
            system,
            system.assembly.matrix(0.0, 0.0, 0.5 * (q0 + q1), none, none, damping_factor=f, v=v),
        )[:n, :n]
        for f in (1.0, 0.0)
    ]
    found = matrix[0] - matrix[1]
    own = np.concatenate([system.vectors(name)[0] for name in ("r", "r_x")]).ravel()
    h = 1e-7
    for i in own[::5]:
        unit = np.eye(system.n_all)[i]
        change = [
            system.assembly.residual_between(q0, q1, v + s * h * unit, rest, none, rest, none)[0]
            for s in (1.0, -1.0)
        ]
        expected = (change[0] - change[1])[own] / (2 * h)
        assert np.abs(expected - found[own, i]).max() < 1e-5 * np.abs(found).max()
