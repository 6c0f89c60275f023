"""Forces of crossing cables against formulas in NumPy, and their matrices against complex steps.

Matrices lack the changes of the places of points, of the lengths they represent and of normals
(docs/theory.md), which the derivatives that are compared hold constant.  Damping is complete.
These parts are left out too:

- between two states the correction of the work;
- with a restitution, of the stiffness, changes of the approach other than in the mean of a pair;
- of friction the change by the normal force, and with a slip speed the stiffness altogether.
"""

import math
from functools import lru_cache

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from tests.matrices import full
from tests.system.contributions.contact_tangents.beam_forces import GRIP_RATIO, BeamForces
from tests.system.contributions.contact_tangents.complex_steps import assert_same, derivative
from tests.system.contributions.contact_tangents.vectors import carried

RADIUS, STIFFNESS, DENSITY = 0.005, 1e6, 1e3
SECTION, SOFT = ancf.Circle(2.0 * RADIUS), ancf.Material(1e-2, DENSITY)
LINE_MASS = DENSITY * np.pi * RADIUS**2
IMPACT_TIME = np.pi * np.sqrt(0.5 * LINE_MASS / STIFFNESS)  # of two lines [s]
DT = 0.15 * IMPACT_TIME  # at which impacts are damped by 0.09 [s]
EXACT = 1e-11  # penetrations of 5e-5 m have rounding errors of 1e-16 m
STATES = [(angle, depth) for angle in (0.4, 1.2) for depth in (0.01, 0.1)]
states = pytest.mark.parametrize(("angle", "depth"), STATES)


@lru_cache
def build(angle, law):
    """A system of two cables that cross between nodes, and their contact, without any for None."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    lower = scene.add_beam("thin", (-0.3, 0, 0), (0.3, 0, 0), 6, SECTION, SOFT)
    along = np.array([math.cos(angle), math.sin(angle), 0.0])
    middle = np.array([0.05, 0.0, 3.0 * RADIUS])
    upper = scene.add_beam("thin", middle - 0.35 * along, middle + 0.25 * along, 6, SECTION, SOFT)
    contact = None
    if law is not None:
        contact = scene.contact(lower, upper, stiffness=STIFFNESS, **dict(law))
    return System(scene), contact


class Crossing:
    """Two cables that cross with a penetration over the radius, bent at random."""

    def __init__(self, angle, depth, **law):
        self.rng = np.random.default_rng(int(1e4 * angle + 1e3 * depth))
        self.system, contact = build(angle, tuple(law.items()))
        self.without, _ = build(angle, None)
        self.part = next(each for each in self.system.contributions if hasattr(each, "contact"))
        self.forces = BeamForces(self.system, contact, STIFFNESS, LINE_MASS)
        self.n, self.n_all, self.none = self.system.n_free, self.system.n_all, np.zeros(0)
        self.rest = np.zeros(self.n_all)
        heights = self.system.vectors("r")[1][:, 2]
        self.q = self.system.q0 + 1e-4 * self.rng.normal(size=self.n_all)
        self.q[heights] -= 1.2 * RADIUS
        for _ in range(40):
            self.q[heights] += self.part.compiled.touches(self.q)[3].max() - depth * RADIUS
        self.system.assembly.use_couplings(True)

    def near(self, size=1e-6):
        """A state near that one."""
        return self.q + size * self.rng.normal(size=self.n_all)

    def begin_step(self, q0, dt=DT):
        """Begin a step at coordinates, without deflections of bristles."""
        self.system.assembly.begin(q0)
        self.system.assembly.set_step(dt)

    def touches(self, q0=None, dt=0.0):
        """The touching points, with the damping of a step from q0."""
        q0 = None if q0 is None else q0[None]
        return self.forces.touches(self.q[None], q0, self.forces.theta(dt))

    def residual(self, v=None, q0=None):
        """The residual of the contact in the state, or between another one and it."""
        v, rest, none = self.rest if v is None else v, self.rest, self.none
        with_it, without = (
            each.assembly.residual(self.q, v, rest, none, rest, none)[0]
            if q0 is None
            else each.assembly.residual_between(q0, self.q, v, rest, none, rest, none)[0]
            for each in (self.system, self.without)
        )
        return with_it - without

    def matrix(self, v=None, stiffness=1.0, damping=0.0, q0=None):
        """The matrix of the contact, with the blocks that couple elements."""
        system, options = self.system, {"damping_factor": damping, "v": v}
        q = self.q if q0 is None else 0.5 * (q0 + self.q)
        values = system.assembly.coupled_matrix(0.0, stiffness, q, self.none, self.none, **options)
        n_values = len(system.pattern.indices)
        out = full(system, values[:n_values])
        other = self.without.assembly.matrix(0.0, stiffness, q, self.none, self.none, **options)
        out -= full(self.without, other)
        pairs = self.part.compiled.coupled_pairs
        blocks = values[n_values + 1 :][: 144 * len(pairs)].reshape(-1, 12, 12)
        for (low, high), block in zip(pairs, blocks, strict=True):
            i, j = (self.forces.places[e].ravel() for e in (low, high))
            out[np.ix_(i, j)] += block
            out[np.ix_(j, i)] += block.T
        return out

    def held(self, touches, q0=None, dt=0.0):
        """A function of states: the residual of pressures with held places, lengths and normals."""
        theta = self.forces.theta(dt)

        def press(z):
            way = np.zeros_like(z) if q0 is None else z - q0
            sizes = [t.stiffness * self.forces.penetration(z, way, theta, t) for t in touches]
            return self.forces.push(
                touches, [f[:, None] * t.n for f, t in zip(sizes, touches, strict=True)], len(z)
            )

        return press

    def derivative(self, function, x):
        """The derivative of a function of rows by the coordinates."""
        return derivative(function, x, self.n)[: self.n]


@states
def test_pressures_in_a_state(angle, depth):
    """All that is left out is less than half of the penetration over the radius."""
    case = Crossing(angle, depth)
    case.begin_step(case.near(), 0.0)
    touches, q, forces = case.touches(), case.q, case.forces
    assert len(touches) == 10
    assert_same(case.residual(), forces.press(touches, 1)[0], EXACT)
    expected = case.derivative(case.held(touches), q)
    assert_same(case.matrix(), expected, EXACT)
    complete = case.derivative(lambda z: forces.press(forces.touches(z), len(z)), q)
    assert_same(complete, complete.T, 1e-6)
    assert_same(case.matrix(), complete, 0.5 * depth)


@states
def test_damped_pressures_at_the_end_of_a_step(angle, depth):
    case = Crossing(angle, depth)
    q0 = case.near()
    case.begin_step(q0)
    assert 0.0 < case.forces.theta(DT) < 1.0
    touches = case.touches(q0, DT)
    assert_same(case.residual(), case.forces.press(touches, 1)[0], EXACT)
    assert_same(case.matrix(), case.derivative(case.held(touches, q0, DT), case.q), EXACT)


@states
def test_mean_pressures_between_two_states(angle, depth):
    """The matrix holds the correction of the work, too."""
    case = Crossing(angle, depth)
    q0, q, forces = case.near(0.02 * depth * RADIUS), case.q, case.forces
    case.begin_step(q0)
    assert_same(case.residual(q0=q0), forces.press_between(q0[None], q[None])[0], EXACT)
    points = forces.mean_touches(q0[None], q[None])

    shares = np.repeat((0.0, 0.5, 1.0), len(points) // 3)  # of the displacement

    def press(z):
        way = np.zeros_like(z)
        sizes = [
            share * t.stiffness * forces.penetration(q + moved * (z - q), way, 0.0, t)
            for moved, (share, t) in zip(shares, points, strict=True)
        ]
        touches = [t for _, t in points]
        return forces.push(
            touches, [f[:, None] * t.n for f, t in zip(sizes, touches, strict=True)], len(z)
        )

    assert_same(0.5 * case.matrix(q0=q0), case.derivative(press, q), EXACT)


@states
def test_pressures_with_a_restitution(angle, depth):
    """The stiffness has the change of penetrations in the mean, by which s is e' / (c e)."""
    case = Crossing(angle, depth, restitution=0.5)
    forces, q = case.forces, case.q
    v = 0.02 * depth * case.rng.normal(size=case.n_all)
    case.begin_step(case.near())
    touches = case.touches()
    rates = forces.rates(touches, v[None])
    assert 0.01 < abs(next(iter(rates.values()))) < 3.0
    assert_same(case.residual(v), forces.press(touches, 1, rates)[0], EXACT)
    expected = case.derivative(lambda u: forces.press(touches, len(u), forces.rates(touches, u)), v)
    assert_same(case.matrix(v, 0.0, 1.0), expected, EXACT)

    def energies(z):
        way = np.zeros_like(z)
        return sum(t.stiffness * forces.penetration(z, way, 0.0, t) ** 2 for t in touches)

    def press(z):
        (s,) = rates.values()
        ratio = 1.0 + forces.gamma * np.tanh(s * np.sqrt(energies(q[None]) / energies(z)))
        return ratio[:, None] * case.held(touches)(z)

    assert_same(case.matrix(v), case.derivative(press, q), EXACT)


@states
def test_friction_with_a_slip_speed(angle, depth):
    case = Crossing(angle, depth, friction=0.3, slip_speed=0.05)
    forces, v = case.forces, 0.1 * case.rng.normal(size=case.n_all)
    case.begin_step(case.near(), 0.0)
    touches = case.touches()
    rubbed = forces.press(touches, 1) + forces.rub(touches, v[None])
    assert_same(case.residual(v), rubbed[0], EXACT)
    expected = case.derivative(lambda u: forces.rub(touches, u), v)
    assert_same(case.matrix(v, 0.0, 1.0), expected, EXACT)
    assert_same(case.matrix(v), case.derivative(case.held(touches), case.q), EXACT)


LAWS = {"kinetic": {"friction": 0.3}, "static": {"friction": 0.3, "static_friction": 0.5}}


@pytest.mark.parametrize(("angle", "depth"), [STATES[0], STATES[3]])
@pytest.mark.parametrize("share", [0.5, 1.5])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("slides", [False, True], ids=["sticks", "slides"])
def test_bristles_at_the_end_of_a_step(angle, depth, law, share, slides):
    """After one with a share of the stiffness, and a force of a half or the double of the limit."""
    case = Crossing(angle, depth, **LAWS[law])
    q0, q, forces = case.near(1e-7), case.q, case.forces
    case.begin_step(q0)
    touches = case.touches(q0, DT)
    n, stiffness = touches[0].n[0], GRIP_RATIO * sum(float(t.stiffness[0]) for t in touches)
    size = 0.3 * sum(float((t.stiffness * t.e)[0]) for t in touches)
    s = carried(case.rng.normal(size=(1, 3)), n[None])[0]
    s *= (2.5 if slides else 0.5) * size / np.linalg.norm(s)
    pair = tuple(sorted((touches[0].a, touches[0].b)))
    memory = case.system.assembly.memory
    memory[:5] = 2.0 * (pair[0] * len(forces.lengths) + pair[1]) + 1.0, share * stiffness, *s
    case.system.assembly.memory = memory
    bristles = forces.bristles(touches, q[None], q0[None], DT, {pair: (share * stiffness, s)})
    (bristle,) = bristles
    assert (np.linalg.norm(bristle.trial(q[None])) > bristle.limit[0]) == slides
    found = case.residual()
    assert_same(found, (forces.press(touches, 1) + bristle.push(q[None]))[0], EXACT)
    held = case.held(touches, q0, DT)
    assert_same(case.matrix(), case.derivative(lambda z: held(z) + bristle.push(z), q), EXACT)
