"""Forces of a contact with an obstacle, analytic in the state (docs/theory.md)."""

import math

import numpy as np

import ancfsparse as ancf
from tests.system.contributions.contact_tangents.gaps import from_core
from tests.system.contributions.contact_tangents.vectors import (
    carried,
    dot,
    norm,
    shortened,
    without_normal,
)

LAYER_RATIO, GRIP_RATIO = 1e-3, 0.1  # over the radius; over the stiffness
STEPS_PER_IMPACT, SLOW_RATIO, BRISTLE_DAMPING = 2.0, 0.05, 1.0
SAME_PLACE = 1e-6  # relative change of a place below which the discrete gradient is the gradient


def pressure_law(e, layer):
    """The pressure of a penetration, for unit stiffness."""
    s = e / layer
    within = np.where(s.real < 1.0, layer * (s**3 - 0.5 * s**4), e - 0.5 * layer)
    return np.where(e.real <= 0.0, 0.0, within)


def potential(e, layer):
    """The integral of the pressure."""
    s = e / layer
    within = layer**2 * np.where(s.real < 1.0, s**4 / 4.0 - s**5 / 10.0, 0.15 + 0.5 * (s - 1.0) * s)
    return np.where(e.real <= 0.0, 0.0, within)


def mean_pressure(e0, e1, layer):
    """The difference of the potential over that of the penetration, exact in any case.

    Between the places where the law changes it is the mean of a polynomial, by Gauss points.
    """
    points, weights = np.polynomial.legendre.leggauss(4)
    change, total = e1 - e0, 0.0
    is_same = np.abs(change.real) < 1e-9 * layer
    for low, high in ((0.0, layer), (layer, np.inf)):
        a, b = (np.where(e.real < low, low, np.where(e.real > high, high, e)) for e in (e0, e1))
        for x, w in zip(points, weights, strict=True):
            total = total + 0.5 * w * (b - a) * pressure_law(
                0.5 * (a + b) + 0.5 * x * (b - a), layer
            )
    at = 0.5 * (e0 + e1)
    return np.where(is_same, pressure_law(at, layer), total / np.where(is_same, 1.0, change))


class Place:
    """Points relative to the obstacle: arms d, distances, gradients g, normals n.

    On a body also its vectors u, the components b of the arms, and the derivatives m by them.
    """

    def __init__(self, d, distance, g, u=None, b=None, m=None):
        self.d, self.distance, self.g, self.u, self.b, self.m = d, distance, g, u, b, m
        self.n = g / norm(g)[..., None]


class ObstacleForces:
    """The forces of a contact on all points.

    Parameters
    ----------
    system : System
        The system.
    contact : Contact
        The contact.
    stiffness, line_mass : float
        Stiffness [N/m2] and mass per length of the body [kg/m].
    restitution : float
        Coefficient of restitution, 0 without [-].
    """

    def __init__(self, system, contact, stiffness, line_mass, restitution=0.0):
        self.contact, self.obstacle, self.body = contact, contact.obstacle, contact.on
        self.dim, self.radius = system.dim, contact.radii[0]
        self.layer, self.k = LAYER_RATIO * self.radius, stiffness * np.array(contact.weights)
        self.reach = self.obstacle.radius + self.radius
        self.sums = np.stack([self._sum_of(system, point) for point in contact.points])
        self.impact_time = math.pi * math.sqrt(line_mass / stiffness)
        self.gamma = (1.0 - restitution**2) / (1.0 + restitution**2) if restitution else 0.0
        self.slow = SLOW_RATIO * restitution * math.pi / self.impact_time
        self.settling = 0.0
        if contact.has_static_friction:
            self.settling = (
                2.0 * BRISTLE_DAMPING * self.impact_time / math.pi / math.sqrt(GRIP_RATIO)
            )
        if self.body is not None:
            origin = self._sum_of(system, self.body.origin)
            self.vectors = np.stack(
                [self._sum_of(system, self.body.at(e)) - origin for e in np.eye(self.dim)]
            )
            self.start = self.vectors @ system.q0  # rows are the vectors in the reference state
            arm = np.array(self.obstacle.base) - origin @ system.q0
            self.base = origin + np.einsum("i,ica->ca", self.start @ arm, self.vectors)
        is_ball = isinstance(self.obstacle, ancf.Ball) or (
            isinstance(self.obstacle, ancf.Drum) and self.dim == 2
        )
        self.turns = self.body is not None and not is_ball

    def _sum_of(self, system, point):
        """The matrix (dim, n_all) of a point."""
        places, weights = system.point(point)
        out = np.zeros((self.dim, system.n_all))
        for c in range(self.dim):
            np.add.at(out[c], places[c], weights)
        return out

    def relative(self, q):
        """Sums over states or velocities: points without the base, (..., n, dim), and vectors."""
        n, dim, n_all = self.sums.shape
        x = (q @ self.sums.reshape(-1, n_all).T).reshape(*q.shape[:-1], n, dim)
        if self.body is None:
            return x, None
        turning = np.einsum("ica,...a->...ic", self.vectors, q)
        return x - (q @ self.base.T)[..., None, :], turning

    def arms(self, q):
        """Vectors from the base to the points, and those of the body."""
        x, u = self.relative(q)
        return (x - np.array(self.obstacle.base) if self.body is None else x), u

    def place(self, q):
        """The place of the points in a state."""
        return self._place_at(*self.arms(q))

    def _place_at(self, d, u):
        if not self.turns:
            return Place(d, *from_core(self.obstacle, d), u)
        b = np.einsum("...ic,...kc->...ki", u, d)
        distance, in_start = from_core(self.obstacle, b @ self.start)
        m = in_start @ self.start.T
        return Place(d, distance, np.einsum("...ki,...ic->...kc", m, u), u, b, m)

    def depth(self, q):
        """Penetrations of the points."""
        return self.reach - self.place(q).distance

    def mean_place(self, q0, q1):
        """The place halfway whose gradient makes the work of pressures that of their energy."""
        begin, end = self.place(q0), self.place(q1)
        if self.turns or not isinstance(self.obstacle, (ancf.HalfSpace, ancf.Drum, ancf.Ball)):
            half = self._place_at(
                0.5 * (begin.d + end.d), None if begin.u is None else 0.5 * (begin.u + end.u)
            )
            one, two, m = (begin.b, end.b, half.m) if self.turns else (begin.d, end.d, half.g)
            change = two - one
            moved = dot(change, change)
            moves = moved.real > SAME_PLACE**2 * dot(one, one).real
            rest = end.distance - begin.distance - dot(m, change)
            m = m + np.where(moves, rest / np.where(moves, moved, 1.0), 0.0)[..., None] * change
            g = np.einsum("...ki,...ic->...kc", m, half.u) if self.turns else m
            return Place(half.d, half.distance, g, half.u, half.b, m)
        if isinstance(self.obstacle, ancf.HalfSpace):
            return end
        both = begin.distance + end.distance
        away = begin.g * begin.distance[..., None] + end.g * end.distance[..., None]
        return Place(0.5 * (begin.d + end.d), 0.5 * both, away / both[..., None])

    def rates(self, place, v):
        """Rates of change of the penetrations at the velocities v."""
        u, turning = self.relative(v)
        out = -dot(place.g, u)
        if self.turns:
            out = out - dot(place.m, np.einsum("...kc,...ic->...ki", place.d, turning))
        return out

    def along(self, place, u, v):
        """Velocities (or displacements) v relative to the body, whose vectors are u."""
        out, turning = self.relative(v)
        if self.body is None:
            return out
        share = np.einsum("...ic,...kc->...ki", u, place.d) / dot(u, u)[..., None, :]
        return out - np.einsum("...ki,...ic->...kc", share, turning)

    def theta(self, dt):
        """The share of the approach in the damped penetration at the end of a step."""
        return 0.0 if self.gamma else min(1.0, (STEPS_PER_IMPACT * dt / self.impact_time) ** 2)

    def pressures(self, q, e0=0.0, dt=0.0, rates=0.0):
        """Forces of the pressures, in a state or at the end of a step from penetrations e0.

        A restitution needs the rates of the penetrations.
        """
        place = self.place(q)
        e, theta = self.reach - place.distance, self.theta(dt)
        p = self.k * pressure_law(e + theta * (e - e0), self.layer)
        depth = np.where(e.real > 0.0, e, 0.0) + self.layer
        if self.gamma:
            p = p * (1.0 + self.gamma * np.tanh(rates / (self.slow * depth)))
        return p

    def mean_pressures(self, q0, q1, dt):
        """Forces of the pressures between two states."""
        e0, e1 = self.depth(q0), self.depth(q1)
        p = self.k * mean_pressure(e0, e1, self.layer)
        if self.gamma:
            both = (np.where(e.real > 0.0, e, 0.0) for e in (e0, e1))
            depth = 0.5 * sum(both) + self.layer
            p = p * (1.0 + self.gamma * np.tanh((e1 - e0) / (dt * self.slow * depth)))
        return p

    def _push(self, f):
        """The residual of forces f on the points and the opposite ones on the base."""
        r = -f.reshape(*f.shape[:-2], -1) @ self.sums.reshape(-1, self.sums.shape[2])
        return r if self.body is None else r + f.sum(axis=-2) @ self.base

    def press(self, place, p):
        """The residual of pressures, (..., n_all)."""
        r = self._push(p[..., None] * place.g)
        if self.turns:
            of_vectors = np.einsum("...k,...ki,...kc->...ic", p, place.m, place.d, optimize=True)
            r = r - np.einsum("...ic,ica->...a", of_vectors, self.vectors)
        return r

    def rub(self, place, f):
        """The residual of friction f on the points."""
        r = self._push(f)
        if self.body is None:
            return r
        share = (
            np.einsum("...ic,...kc->...ki", place.u, place.d) / dot(place.u, place.u)[..., None, :]
        )
        return r + np.einsum("...ki,...kc,ica->...a", share, f, self.vectors, optimize=True)

    def sliding_friction(self, place, v, p):
        """Friction that depends on the sliding velocity."""
        u = self.along(place, place.u, v) - place.d @ self.obstacle.spin.T
        u = without_normal(u, place.n)
        size = np.sqrt(dot(u, u) + self.contact.slip_speed**2)
        return -self.contact.friction * (p / size)[..., None] * u

    def halfway(self, q0, q1):
        """Places of the points halfway between two states."""
        (d0, u0), (d1, u1) = self.arms(q0), self.arms(q1)
        return self._place_at(0.5 * (d0 + d1), None if u0 is None else 0.5 * (u0 + u1))

    def bristle_friction(self, q0, q1, z, p, dt, halfway, place=None):
        """Friction of bristles in a step from q0 to q1, with the deflections z at its start.

        At its end with the place there, or else between both states.
        """
        x = self.along(halfway, halfway.u, q1 - q0)
        rate = np.linalg.norm(self.obstacle.spin) / math.sqrt(2.0)
        if rate:
            turn = 2.0 / rate * math.tan(0.5 * rate * dt)
            x = x - turn * halfway.d @ self.obstacle.spin.T
        x = without_normal(x, halfway.n)
        grip, delay = GRIP_RATIO * self.k, self.settling / dt
        mu = self.contact.static_friction if self.settling else self.contact.friction
        limit = mu * p / grip
        if place is None:
            trial = carried(shortened(z, limit), halfway.n) + (0.5 + delay) * x
        else:
            trial = carried(z, place.n) + (1.0 + delay) * carried(x, place.n)
        return -grip[:, None] * shortened(trial, limit)
