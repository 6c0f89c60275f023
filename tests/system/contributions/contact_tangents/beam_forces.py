"""Forces of two cables on each other where they cross, analytic in the state (docs/theory.md).

Ends of overlaps and feet are zeros found by Newton's method in complex numbers, so a complex step
differentiates the forces with all that moves.  Rows of coordinates have one real part.  Axes are
bent little, and overlaps do not reach the ends of elements.
"""

import math
from itertools import product

import numpy as np

from tests.system.contributions.contact_tangents.vectors import (
    carried,
    dot,
    norm,
    shortened,
    without_normal,
)

STEPS_PER_IMPACT, SLOW_RATIO, GRIP_RATIO, BRISTLE_DAMPING = 2.0, 0.05, 0.1, 1.0
# Of Newton's method for feet; and for ends of overlaps, where it lacks the rotation of normals.
CORRECTIONS, CORRECTIONS_OF_ENDS = 7, 14
# Powers of the place in the weights of position and slope at both ends.
HERMITE = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [-3, -2, 3, -1], [2, 1, -2, 1]])
SAMPLES = np.linspace(0.0, 1.0, 201)  # of an element, for overlaps, and for their feet
COARSE = SAMPLES[::10]
SIMPSON, ALONG = (1 / 6, 4 / 6, 1 / 6), 1e-3  # shares; weight of forces between control points
GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(5)


def weights_at(z, order=0):
    """Weights (..., 4) of a cubic's ends and slopes at the places z, or their derivatives."""
    one, square = np.ones_like(z), z * z
    powers = (
        (one, z, square, square * z),
        (0.0 * one, one, 2.0 * z, 3.0 * square),
        (0.0 * one, 0.0 * one, 2.0 * one, 6.0 * z),
    )
    return np.stack(powers[order], axis=-1) @ HERMITE


class Touch:
    """A point z of the axis a that touches at the foot u on b: normal, penetration, stiffness."""

    def __init__(self, a, b, z, u, n, e, stiffness):
        self.a, self.b, self.z, self.u, self.n, self.e, self.stiffness = a, b, z, u, n, e, stiffness


class BeamForces:
    """The forces between all elements of two bodies.

    Parameters
    ----------
    system : System
        The system.
    contact : BeamContact
        The contact.
    stiffness, line_mass : float
        Stiffness [N/m2] and mass per length of both bodies [kg/m].
    """

    def __init__(self, system, contact, stiffness, line_mass):
        self.contact, self.k, self.n_all = contact, stiffness, system.n_all
        self.places, self.lengths = [], []
        r, r_x = system.vectors("r"), system.vectors("r_x")
        for body, places, slopes in zip(system.bodies, r, r_x, strict=True):
            i, j = body.ends.T
            self.places.append(np.stack([places[i], slopes[i], places[j], slopes[j]], axis=1))
            self.lengths.append(body.lengths)
        n_first = len(self.lengths[0])
        self.places, self.lengths = np.concatenate(self.places), np.concatenate(self.lengths)
        n = len(self.lengths)
        self.pairs = list(product(range(n_first), range(n_first, n)))
        self.reach = sum(contact.radii)
        self.impact_time = math.pi * math.sqrt(0.5 * line_mass / stiffness)
        self.mass = 1.0 / sum(1.0 / body.total_mass for body in system.bodies)
        restitution = contact.restitution
        self.gamma = (1.0 - restitution**2) / (1.0 + restitution**2) if restitution else 0.0
        self.slow = SLOW_RATIO * restitution
        self.settling = 2.0 * BRISTLE_DAMPING if contact.has_static_friction else 0.0

    def nodal_weights(self, e, z, order=0):
        """Weights (..., 4) of the coordinates of an element at a place of its axis."""
        scale = np.array([1.0, self.lengths[e], 1.0, self.lengths[e]])
        return weights_at(z, order) * scale

    def at(self, q, e, z, order=0):
        """Positions (m, dim) at the places z (m,) of an element, or derivatives."""
        return np.einsum("...i,...ic->...c", self.nodal_weights(e, z, order), q[:, self.places[e]])

    def theta(self, dt):
        """The share of the approach in the damped penetration at the end of a step."""
        return 0.0 if self.gamma else min(1.0, (STEPS_PER_IMPACT * dt / self.impact_time) ** 2)

    def foot(self, q, a, b, z, u):
        """The foot on b of a point of a, from a guess."""
        for _ in range(CORRECTIONS):
            d = self.at(q, a, z) - self.at(q, b, u)
            slope, bend = self.at(q, b, u, 1), self.at(q, b, u, 2)
            u = u + dot(d, slope) / (dot(slope, slope) - dot(d, bend))
        return u

    def penetration(self, q, way, theta, touch):
        """The penetration of a point along its normal, at the end of a step with that of the way.

        Places and normals are those of the touch, which can be held.
        """
        here, gone = (self.at(x, touch.a, touch.z) - self.at(x, touch.b, touch.u) for x in (q, way))
        return self.reach - dot(touch.n, here) - theta * dot(touch.n, gone)

    def damped(self, q, way, theta, a, b, z, u):
        """The normal and the penetration of a point and its foot."""
        d = self.at(q, a, z) - self.at(q, b, u)
        n = d / norm(d)[..., None]
        return n, self.penetration(q, way, theta, Touch(a, b, z, u, n, None, None))

    def end_of_overlap(self, q, way, theta, a, b, z, u):
        """Where the penetration is zero, and the foot there."""
        for _ in range(CORRECTIONS_OF_ENDS):
            n, e = self.damped(q, way, theta, a, b, z, u)
            d = self.at(q, a, z) - self.at(q, b, u)
            of_a, of_b, bend = self.at(q, a, z, 1), self.at(q, b, u, 1), self.at(q, b, u, 2)
            e_z = -dot(n, of_a + theta * self.at(way, a, z, 1))
            e_u = dot(n, of_b + theta * self.at(way, b, u, 1))
            h, h_z, h_u = dot(d, of_b), dot(of_a, of_b), dot(d, bend) - dot(of_b, of_b)
            det = e_z * h_u - e_u * h_z
            z, u = z - (e * h_u - e_u * h) / det, u - (e_z * h - e * h_z) / det
        return z, u

    def touches(self, q, q0=None, theta=0.0):
        """The touching points of all pairs, in one state or at the end of a step from q0."""
        out = []
        way = np.zeros_like(q) if q0 is None else q - q0
        for pair in self.pairs:
            for a, b in (pair, pair[::-1]):
                out += self._touches_of(q, way, theta, a, b)
        return out

    def _touches_of(self, q, way, theta, a, b):
        real, gone = (np.repeat(x[:1].real, len(SAMPLES), axis=0) for x in (q, way))
        of_a, of_b = self.at(real, a, SAMPLES), self.at(real[: len(COARSE)], b, COARSE)
        distances = np.linalg.norm(of_a[:, None] - of_b[None], axis=2)
        if distances.min() > 2.0 * self.reach:
            return []
        nearest = distances.argmin(axis=1)
        u = self.foot(real, a, b, SAMPLES, COARSE[nearest])
        inside = (self.damped(real, gone, theta, a, b, SAMPLES, u)[1] > 0.0) & (u > 0.0) & (u < 1.0)
        if not inside.any():
            return []
        first, last = np.flatnonzero(inside)[[0, -1]]
        assert inside[first : last + 1].all()
        assert 0 < first < last < len(SAMPLES) - 1
        rows = np.ones(len(q), dtype=q.dtype)
        (z0, u0), (z1, u1) = (
            self.end_of_overlap(q, way, theta, a, b, SAMPLES[k] * rows, u[k] * rows)
            for k in (first, last)
        )
        assert max(u0.real.max(), u1.real.max()) < 1.0
        out = []
        for x, w in zip(GAUSS_POINTS, GAUSS_WEIGHTS, strict=True):
            z = z0 + 0.5 * (1.0 + x) * (z1 - z0)
            foot = self.foot(q, a, b, z, u0 + 0.5 * (1.0 + x) * (u1 - u0))
            n, e = self.damped(q, way, theta, a, b, z, foot)
            stiffness = 0.25 * self.k * self.lengths[a] * (z1 - z0) * w
            out.append(Touch(a, b, z, foot, n, e, stiffness))
        return out

    def push(self, touches, forces, m):
        """The residual (m, n_all) of forces on points and the opposite ones on their feet."""
        r = np.zeros((m, self.n_all), dtype=np.result_type(*forces))
        for touch, force in zip(touches, forces, strict=True):
            for e, z, sign in ((touch.a, touch.z, -1.0), (touch.b, touch.u, 1.0)):
                r[:, self.places[e]] += sign * self.nodal_weights(e, z)[..., None] * force[:, None]
        return r

    def velocities(self, v, touch):
        """Velocities of points relative to their feet."""
        return self.at(v, touch.a, touch.z) - self.at(v, touch.b, touch.u)

    def of_pairs(self, touches):
        """The touching points of each pair of elements."""
        out = {}
        for touch in touches:
            out.setdefault(tuple(sorted((touch.a, touch.b))), []).append(touch)
        return out.items()

    def rates(self, touches, v):
        """The argument s of the restitution of each pair of elements."""
        total = sum(touch.stiffness for touch in touches)
        rate = self.slow * np.sqrt(total / self.mass)
        out = {}
        for pair, points in self.of_pairs(touches):
            work = -sum(t.stiffness * t.e * dot(t.n, self.velocities(v, t)) for t in points)
            out[pair] = work / (rate * sum(t.stiffness * t.e**2 for t in points))
        return out

    def press(self, touches, m, rates=None):
        """The residual of pressures."""
        sizes = [touch.stiffness * touch.e for touch in touches]
        if rates:
            ratios = {pair: 1.0 + self.gamma * np.tanh(s) for pair, s in rates.items()}
            sizes = [
                size * ratios[tuple(sorted((t.a, t.b)))]
                for size, t in zip(sizes, touches, strict=True)
            ]
        return self.push(
            touches, [f[:, None] * t.n for f, t in zip(sizes, touches, strict=True)], m
        )

    def rub(self, touches, v):
        """The residual of friction with a slip speed."""
        forces = []
        for touch in touches:
            u = self.velocities(v, touch)
            u = u - dot(touch.n, u)[..., None] * touch.n
            size = np.sqrt(dot(u, u) + self.contact.slip_speed**2)
            p = self.contact.friction * touch.stiffness * touch.e
            forces.append(-(p / size)[:, None] * u)
        return self.push(touches, forces, len(v))

    def mean_touches(self, q0, q1):
        """The touching points at begin, middle and end of a step, with Simpson's shares.

        Their normals are those halfway between both states, and `change` is that of a penetration.
        """
        out = []
        for share, q in zip(SIMPSON, (q0, 0.5 * (q0 + q1), q1), strict=True):
            for touch in self.touches(q):
                before, after = self.velocities(q0, touch), self.velocities(q1, touch)
                touch.n = (before + after) / norm(before + after)[:, None]
                touch.change = -dot(touch.n, after - before)
                out.append((share, touch))
        return out

    def press_between(self, q0, q1):
        """The residual of mean pressures between two states."""
        points = self.mean_touches(q0, q1)
        square = sum(share * t.stiffness * t.change**2 for share, t in points)
        work = sum(share * t.stiffness * t.e * t.change for share, t in points)
        stored = [sum(0.5 * t.stiffness * t.e**2 for t in self.touches(q)) for q in (q0, q1)]
        pairs = [(t.a, t.b) for _, t in points[:: len(GAUSS_POINTS)]]
        along = np.zeros((len(q0), self.n_all))
        for pair in pairs:
            size = ALONG / 16.0 * self.k * self.lengths[pair[0]]
            before, after = (self.control_distances(q, *pair) for q in (q0, q1))
            one, two = norm(before), norm(after)
            square = square + size * ((two - one) ** 2).sum(axis=(1, 2))
            f = (size * (two - one) / (one + two))[..., None] * (before + after)
            for e, force in zip(pair, (f.sum(axis=2), -f.sum(axis=1)), strict=True):
                weights = self.control_weights(e)
                along[:, self.places[e]] += np.einsum("ki,mkc->mic", weights, force)
        factor = (stored[1] - stored[0] - work) / square
        forces = [
            (share * t.stiffness * (t.e + factor * t.change))[:, None] * t.n for share, t in points
        ]
        return self.push([t for _, t in points], forces, len(q0)) + factor[:, None] * along

    def control_weights(self, e):
        """Control points by the coordinates of an element, (4, 4)."""
        third = self.lengths[e] / 3.0
        return np.array([[1, 0, 0, 0], [1, third, 0, 0], [0, 0, 1, -third], [0, 0, 1, 0]])

    def control_distances(self, q, a, b):
        """Vectors between the control points of two elements, (m, 4, 4, dim)."""
        of_a, of_b = (
            np.einsum("ki,mic->mkc", self.control_weights(e), q[:, self.places[e]]) for e in (a, b)
        )
        return of_a[:, :, None] - of_b[:, None]

    def bristles(self, touches, q, q0, dt, kept):
        """The bristles of all pairs of elements that touch, see `Bristle`."""
        pairs = self.of_pairs(touches)
        out = [Bristle(self, pair, points, q, q0, *kept[pair]) for pair, points in pairs]
        rate = np.sqrt(sum(each.overlap for each in out) / self.mass)
        for each in out:
            each.delay = self.settling / (rate * dt)
        return out


class Bristle:
    """The bristle of two elements a < b at the end of a step from q0, held at the state q.

    Parameters
    ----------
    forces : BeamForces
        The contact.
    pair : (int, int)
        Both elements.
    points : list of Touch
        Their touching points.
    q, q0 : (m, n_all) array
        States.
    stiffness : float
        That in the last accepted state [N/m].
    force : (dim,) float
        S there [N].
    """

    def __init__(self, forces, pair, points, q, q0, stiffness, force):
        self.forces, self.pair, self.q0, self.delay = forces, pair, q0, 0.0
        self.overlap = GRIP_RATIO * sum(t.stiffness for t in points)
        self.stiffness = np.where(self.overlap.real < stiffness, stiffness, self.overlap)
        sizes = [t.stiffness * t.e for t in points]
        signs = [1.0 if t.a == pair[0] else -1.0 for t in points]
        resultant = sum(
            (f * sign)[:, None] * t.n for f, sign, t in zip(sizes, signs, points, strict=True)
        )
        size = norm(resultant)
        self.n = resultant / size[:, None]
        contact = forces.contact
        mu = contact.static_friction if contact.has_static_friction else contact.friction
        self.limit = mu * size
        self.weights, self.middles = [], []
        for e in pair:
            places = [t.z if t.a == e else t.u for t in points]
            total = sum(sizes)
            mean = sum(f * z for f, z in zip(sizes, places, strict=True)) / total
            weights = sum(
                f[:, None] * forces.nodal_weights(e, z) for f, z in zip(sizes, places, strict=True)
            )
            self.weights.append(weights / total[:, None])
            self.middles.append(mean)
        self.kept = self._turned(carried(np.broadcast_to(force, self.n.shape), self.n), q)

    def _turned(self, s, q):
        """Vectors of the plane, rotated about its normal as both axes are in the step."""
        along = across = 0.0
        for e, z in zip(self.pair, self.middles, strict=True):
            before, after = (self.forces.at(x, e, z, 1) for x in (self.q0, q))
            before, after = (without_normal(t / norm(t)[:, None], self.n) for t in (before, after))
            along = along + dot(before, after)
            across = across + dot(self.n, np.cross(before, after))
        size = np.sqrt(along**2 + across**2)
        return (along / size)[:, None] * s + (across / size)[:, None] * np.cross(self.n, s)

    def trial(self, q):
        """The force as if the bristle did not slide, with displacements up to q."""
        sides = [
            np.einsum("...i,...ic->...c", w, (q - self.q0)[:, self.forces.places[e]])
            for w, e in zip(self.weights, self.pair, strict=True)
        ]
        x = without_normal(sides[0] - sides[1], self.n)
        return self.kept + ((1.0 + self.delay) * self.stiffness)[:, None] * x

    def push(self, q):
        """The residual of its friction."""
        f = -shortened(self.trial(q), self.limit)
        r = np.zeros(q.shape, dtype=f.dtype)
        for w, e, sign in zip(self.weights, self.pair, (-1.0, 1.0), strict=True):
            r[:, self.forces.places[e]] += sign * w[..., None] * f[:, None]
        return r
