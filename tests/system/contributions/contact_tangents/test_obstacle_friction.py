"""Friction on obstacles against formulas in NumPy, and its matrix against complex steps.

These parts are left out of the matrix, and a derivative that is compared holds them constant:

- the change of friction by the pressure, which is not symmetric; equilibria have it in a second
  matrix;
- the change by the rotation of the normal; so with held pressures the stiffness of bristles is
  complete on planes at rest, and on other shapes in steps without motion, with held normals too;
- with a slip speed the stiffness altogether; its damping is complete.
"""

import numpy as np
import pytest

from tests.system.contributions.contact_tangents.complex_steps import assert_same
from tests.system.contributions.contact_tangents.obstacle_cases import (
    ALL,
    DEPTHS,
    DT,
    OBSTACLES,
    PLANES,
    TURNING,
    Case,
)
from tests.system.contributions.contact_tangents.obstacle_forces import GRIP_RATIO
from tests.system.contributions.contact_tangents.vectors import carried, shortened, without_normal

EXACT = 1e-11  # penetrations in the layer, of 3e-5 m, have rounding errors of 1e-16 m
MU, STATIC_MU = 0.3, 0.5
SIDES = [(name, False) for name in ALL] + [(name, True) for name in OBSTACLES]
IDS = [f"{name}-{'moving' if is_moving else 'fixed'}" for name, is_moving in SIDES]
places = pytest.mark.parametrize(("name", "is_moving"), SIDES, ids=IDS)


@places
@pytest.mark.parametrize("ratio", DEPTHS)
def test_with_a_slip_speed(name, is_moving, ratio):
    case = Case(name, is_moving, friction=MU, slip_speed=0.05)
    q, v, forces = case.state(ratio), case.velocities(), case.forces
    place, p = forces.place(q), forces.pressures(q)

    def rub(u):
        return forces.rub(place, forces.sliding_friction(place, u, p))

    def press(z):
        return forces.press(forces.place(z), forces.pressures(z))

    case.begin_step(q, 0.0)
    assert_same(case.residual(q, v), press(q) + rub(v), EXACT)
    assert_same(case.damping(q, v), case.derivative(rub, v), EXACT)
    assert_same(case.matrix(q, v), case.derivative(press, q), EXACT)


@places
@pytest.mark.parametrize("ratio", DEPTHS)
def test_with_a_slip_speed_between_two_states(name, is_moving, ratio):
    case = Case(name, is_moving, friction=MU, slip_speed=0.05)
    q0, v, forces = case.state(ratio), case.velocities(), case.forces
    q1 = case.near(q0)
    place, p = forces.place(0.5 * (q0 + q1)), forces.mean_pressures(q0, q1, DT)

    def rub(u):
        return forces.rub(place, forces.sliding_friction(place, u, p))

    case.begin_step(q0)
    pressed = forces.press(forces.mean_place(q0, q1), p)
    assert_same(case.residual_between(q0, q1, v), pressed + rub(v), EXACT)
    assert_same(case.damping(0.5 * (q0 + q1), v), case.derivative(rub, v), EXACT)


class Bristles:
    """A step of a case from deflections at random, which stick, or slide at its end.

    Their lengths are a half or the double of the one at which they slide.
    """

    def __init__(self, case, slides, is_resting):
        forces = case.forces
        self.case, self.forces = case, forces
        self.q0 = case.state(DEPTHS[1])
        self.q1 = self.q0.copy() if is_resting else case.near(self.q0, 1e-5)
        place, e0 = forces.place(self.q0), forces.depth(self.q0)
        self.pressures = forces.pressures(self.q1, e0, DT)
        mu = forces.contact.static_friction or forces.contact.friction
        z = case.rng.normal(size=place.d.shape)
        z = carried(z, place.n)
        limit = mu * forces.pressures(self.q0) / (GRIP_RATIO * forces.k)
        z *= ((2.0 if slides else 0.5) * limit / np.linalg.norm(z, axis=1))[:, None]
        self.z = z
        case.begin_step(self.q0)
        memory = case.system.assembly.memory
        memory[: z.size] = z.ravel()
        case.system.assembly.memory = memory

    def end(self, q, p):
        """The residual of friction at the end of a step, with given pressures."""
        place, halfway = self.forces.place(q), self.forces.halfway(self.q0, q)
        friction = self.forces.bristle_friction(self.q0, q, self.z, p, DT, halfway, place)
        return self.forces.rub(place, friction)

    def end_with_held_normals(self, q, p):
        """The same, with the places of the state without imaginary parts."""
        place, halfway = self.forces.place(self.q1), self.forces.halfway(self.q0, self.q1)
        friction = self.forces.bristle_friction(self.q0, q, self.z, p, DT, halfway, place)
        return self.forces.rub(place, friction)

    def between(self, q, p, at=None):
        """The residual of friction between two states, with places of another end of the step."""
        halfway = self.forces.halfway(self.q0, q if at is None else at)
        friction = self.forces.bristle_friction(self.q0, q, self.z, p, DT, halfway)
        return self.forces.rub(halfway, friction)

    def press(self, q):
        """The residual of pressures at the end of a step."""
        forces = self.forces
        p = forces.pressures(q, forces.depth(self.q0), DT)
        return forces.press(forces.place(q), p)


LAWS = {"kinetic": {"friction": MU}, "static": {"friction": MU, "static_friction": STATIC_MU}}


@places
@pytest.mark.parametrize("slides", [False, True], ids=["sticks", "slides"])
@pytest.mark.parametrize("law", LAWS)
def test_bristles_at_the_end_of_a_step(name, is_moving, law, slides):
    case = Case(name, is_moving, **LAWS[law])
    is_plane = name in PLANES and not is_moving
    for is_resting in (False, True):
        step = Bristles(case, slides, is_resting)
        q, p = step.q1, step.pressures
        assert_same(case.residual(q), step.press(q) + step.end(q, p), EXACT)
        if is_plane or (is_resting and name not in TURNING):
            rub = step.end if is_plane else step.end_with_held_normals
            expected = case.derivative(lambda z, s=step, r=rub: s.press(z) + r(z, s.pressures), q)
            assert_same(case.matrix(q), expected, EXACT)


@places
@pytest.mark.parametrize("slides", [False, True], ids=["sticks", "slides"])
@pytest.mark.parametrize("law", LAWS)
def test_bristles_between_two_states(name, is_moving, law, slides):
    """A bristle that slides is at its limit at the begin, where the matrix jumps without motion."""
    case = Case(name, is_moving, **LAWS[law])
    forces = case.forces
    for is_resting in (False, True):
        step = Bristles(case, slides, is_resting)
        q0, q1 = step.q0, step.q1
        p = forces.mean_pressures(q0, q1, DT)

        def press(z, q0=q0):
            return forces.press(forces.mean_place(q0, z), forces.mean_pressures(q0, z, DT))

        assert_same(case.residual_between(q0, q1), press(q1) + step.between(q1, p), EXACT)
        is_held = is_resting and not slides and name not in TURNING
        if is_held or (name in PLANES and not is_moving and not is_resting):
            expected = case.derivative(
                lambda z, s=step, p=p, q1=q1, f=press: f(z) + s.between(z, p, q1), q1
            )
            assert_same(0.5 * case.matrix(0.5 * (q0 + q1)), expected, EXACT)


@pytest.mark.parametrize("slides", [False, True], ids=["sticks", "slides"])
@pytest.mark.parametrize("name", PLANES)
def test_equilibria_have_the_change_of_friction_by_the_pressure(name, slides):
    """Both matrices are complete where points touched in the equilibrium before."""
    case = Case(name, friction=MU)
    forces, q0 = case.forces, case.state(DEPTHS[1])
    tangent = case.system.uniform(0) - 0.1 * case.system.uniform(1)
    q = case.near(q0, 1e-6) + (0.05 if slides else 0.001) * tangent
    assert np.array_equal(forces.depth(q) > 0.0, forces.depth(q0) > 0.0)

    def press_and_rub(z):
        place, p = forces.place(z), forces.pressures(z)
        x = without_normal(forces.along(place, None, z - q0), place.n)
        grip = GRIP_RATIO * forces.k
        friction = -grip[:, None] * shortened(x, MU * p / grip)
        return forces.press(place, p) + forces.rub(place, friction)

    case.part.begin_equilibria(q0)
    assert_same(case.residual(q), press_and_rub(q), EXACT)
    found = case.matrix(q) + case.part.unsymmetric_stiffness(q).toarray()[: case.n, : case.n]
    case.part.end_equilibria()
    assert_same(found, case.derivative(press_and_rub, q), EXACT)
