"""Pressures on obstacles against formulas in NumPy, and their matrices against complex steps.

They are complete in a state and at the end of a step, also on bodies.  These parts are left out:

- with a restitution, of the stiffness, the change of the rate of a penetration by the rotation of
  the normal; so it is complete on planes at rest, and the damping on all shapes;
- between two states, the change of the mean normal beyond the one at the midpoint; so the matrix is
  complete on planes at rest, and in steps without motion on all shapes.

A derivative that is compared holds them constant.
"""

import numpy as np
import pytest

from tests.matrices import full
from tests.system.contributions.contact_tangents.complex_steps import assert_same, derivative
from tests.system.contributions.contact_tangents.obstacle_cases import (
    DEPTHS,
    DT,
    OBSTACLES,
    PLANES,
    RADIUS,
    Case,
)

SEEDS = range(3)
EXACT = 1e-11  # penetrations in the layer, of 3e-5 m, have rounding errors of 1e-16 m
pytestmark = pytest.mark.parametrize("is_moving", [False, True], ids=["fixed", "moving"])


@pytest.mark.parametrize("ratio", DEPTHS)
@pytest.mark.parametrize("name", OBSTACLES)
def test_in_a_state(name, ratio, is_moving):
    for seed in SEEDS:
        check_state(Case(name, is_moving, seed), ratio)


def check_state(case, ratio):
    q, forces = case.state(ratio), case.forces

    def press(z):
        return forces.press(forces.place(z), forces.pressures(z))

    case.begin_step(q, 0.0)
    assert_same(case.residual(q), press(q), EXACT)
    assert_same(case.matrix(q), case.derivative(press, q), EXACT)


@pytest.mark.parametrize("name", ["sharp rectangle", "sharp block"])
def test_within_a_block(name, is_moving):
    for seed in SEEDS:
        case = Case(name, is_moving, seed)
        check_state(case, 1.2)


@pytest.mark.parametrize("name", OBSTACLES)
def test_the_material_part_has_the_slopes_of_the_law(name, is_moving):
    case = Case(name, is_moving)
    q, forces = case.state(0.5e-3), case.forces
    case.begin_step(q, 0.0)
    gradients = derivative(forces.depth, q, case.n)
    s = np.clip(forces.depth(q) / forces.layer, 0.0, 1.0)
    expected = gradients.T @ ((forces.k * (3.0 * s**2 - 2.0 * s**3))[:, None] * gradients)
    found, other = (
        full(each, each.assembly.material(0.0, 1.0, q))[: case.n, : case.n]
        for each in (case.system, case.without)
    )
    assert_same(found - other, expected, EXACT)


@pytest.mark.parametrize("ratio", DEPTHS)
@pytest.mark.parametrize("name", OBSTACLES)
def test_damped_at_the_end_of_a_step(name, ratio, is_moving):
    case = Case(name, is_moving)
    q, forces = case.state(ratio), case.forces
    q0 = case.near(q, 1e-5)
    case.begin_step(q0)
    assert 0.0 < forces.theta(DT) < 1.0

    def press(z):
        return forces.press(forces.place(z), forces.pressures(z, forces.depth(q0), DT))

    assert_same(case.residual(q), press(q), EXACT)
    assert_same(case.matrix(q), case.derivative(press, q), EXACT)


@pytest.mark.parametrize("ratio", DEPTHS)
@pytest.mark.parametrize("name", OBSTACLES)
def test_with_a_restitution(name, ratio, is_moving):
    case = Case(name, is_moving, restitution=0.5)
    q, forces = case.state(ratio), case.forces
    v = case.velocities(forces.slow * ratio * RADIUS)
    place = forces.place(q)
    rates = forces.rates(place, v)

    def press(z):
        here = forces.place(z)
        return forces.press(here, forces.pressures(z, rates=forces.rates(here, v)))

    def press_with(z):
        return forces.press(forces.place(z), forces.pressures(z, rates=rates))

    def brake(u):
        return forces.press(place, forces.pressures(q, rates=forces.rates(place, u)))

    case.begin_step(case.near(q))
    assert_same(case.residual(q, v), press(q), EXACT)
    is_complete = name in PLANES and not is_moving
    expected = case.derivative(press if is_complete else press_with, q)
    assert_same(case.matrix(q, v), expected, EXACT)
    assert_same(case.damping(q, v), case.derivative(brake, v), EXACT)


def press_between(forces, q0, q1):
    """The residual of pressures between two states."""
    return forces.press(forces.mean_place(q0, q1), forces.mean_pressures(q0, q1, DT))


@pytest.mark.parametrize("law", [{}, {"restitution": 0.5}], ids=["conserves", "brakes"])
@pytest.mark.parametrize("ratio", DEPTHS)
@pytest.mark.parametrize("name", OBSTACLES)
def test_between_two_states(name, ratio, law, is_moving):
    """Of a step that enters, of one that leaves, and of one without motion."""
    case = Case(name, is_moving, **law)
    forces = case.forces
    near, far, deep = case.state(ratio), case.state(-ratio), case.state(2.0 * ratio)
    for q0, q1 in ((far, near), (near, far), (deep, near), (near, near)):
        case.begin_step(q0)
        assert_same(case.residual_between(q0, q1), press_between(forces, q0, q1), EXACT)
        if q0 is q1 or (name in PLANES and not is_moving and q1 is near):
            expected = case.derivative(lambda z, q0=q0: press_between(forces, q0, z), q1)
            assert_same(0.5 * case.matrix(0.5 * (q0 + q1)), expected, EXACT)
