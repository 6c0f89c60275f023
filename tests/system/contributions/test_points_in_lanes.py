"""Forces on points that are evaluated together, and one by one in the plane, against NumPy."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.scene.force_elements.contacts import LAYER_RATIO
from ancfsparse.system import System
from ancfsparse.system.contributions.force_elements.contact.contacts import GRIP_RATIO

STIFFNESS, RADIUS, DT = 1e6, 0.005, 1e-3
MATERIAL = ancf.Material(1e6, 1e3)
# Ends and numbers of elements: vectors have points of one rod, of both, and of the last elements.
RODS = (0.0, 0.6, 13), (0.6, 1.0, 6)
OBSTACLES = {
    "plane": ancf.HalfSpace((0.0, -0.1), (0.1, 1.0)),
    "disc": ancf.Drum((0.45, -0.3), 0.297, angular_velocity=2.0),
    "floor": ancf.HalfSpace((0.0, -0.1, 0.0), (0.1, 1.0, 0.3)),
    "drum": ancf.Drum((0.45, -0.3, 0.0), 0.297, axis=(0.1, 0.0, 1.0), angular_velocity=-2.0),
    "pipe": ancf.Drum((0.45, -0.3, 0.0), 0.297, axis=(0.1, 0.0, 1.0)),
    "ball": ancf.Ball((0.45, -0.3, 0.05), 0.301),
}


def pressed(name, **friction):
    """A system of cables that are pressed on an obstacle, that without it, and their state."""
    obstacle = OBSTACLES[name]
    pad = (0.0,) * (obstacle.dim - 2)
    both = []
    for has_contact in (True, False):
        scene = ancf.Scene((0.0, -9.81, *pad))
        rods = [
            scene.add_beam(
                "thin", (begin, 0, *pad), (end, 0, *pad), n, ancf.Circle(2.0 * RADIUS), MATERIAL
            )
            for begin, end, n in RODS
        ]
        if has_contact:
            contact = scene.contact(rods, obstacle, stiffness=STIFFNESS, **friction)
        both.append(System(scene))
    q = both[0].q0.copy()
    if name in ("plane", "floor"):
        q -= 0.11 * both[0].uniform(1)
    return *both, contact, q


class ByHand:
    """The forces of a contact at the ends of steps, from positions of the points."""

    def __init__(self, contact, x):
        self.contact, self.obstacle, self.x = contact, contact.obstacle, x
        self.z = np.zeros_like(x)
        self.stiffness = STIFFNESS * np.array(contact.weights)
        line_mass = 1e3 * np.pi * RADIUS**2
        self.theta = min(1.0, (2.0 * DT / (np.pi * np.sqrt(line_mass / STIFFNESS))) ** 2)

    def place(self, x):
        """Vectors from the base, normals and penetrations."""
        obstacle = self.obstacle
        d = x - np.array(obstacle.base)
        if isinstance(obstacle, ancf.HalfSpace):
            n = np.broadcast_to(
                np.array(obstacle.normal) / np.linalg.norm(obstacle.normal), d.shape
            )
            return d, n, RADIUS - (d * n).sum(axis=1)
        if obstacle.dim == 3 and isinstance(obstacle, ancf.Drum):
            axis = np.array(obstacle.axis) / np.linalg.norm(obstacle.axis)
            d = d - np.outer(d @ axis, axis)
        distance = np.linalg.norm(d, axis=1)
        return d, d / distance[:, None], obstacle.radius + RADIUS - distance

    def pressures(self, x):
        """Normal forces, with the damping of impacts."""
        before, e = self.place(self.x)[2], self.place(x)[2]
        e = e + self.theta * (e - before)
        layer = LAYER_RATIO * RADIUS
        s = np.clip(e / layer, 0.0, 1.0)
        return self.stiffness * np.where(e < layer, layer * (s**3 - 0.5 * s**4), e - 0.5 * layer)

    def pressures_between(self, x):
        """Differences of the potential over those of the penetrations."""

        def potential(e):
            s = np.clip(e / layer, 0.0, 1.0)
            above = np.maximum(e - layer, 0.0)
            return layer**2 * (s**4 / 4 - s**5 / 10) + 0.5 * above * (layer + above)

        layer = LAYER_RATIO * RADIUS
        e0, e1 = self.place(self.x)[2], self.place(x)[2]
        return self.stiffness * (potential(e1) - potential(e0)) / (e1 - e0)

    def normals_between(self, x):
        """Vectors along which pressures do the work of the potential."""
        d0, n, e0 = self.place(self.x)
        d1, _, e1 = self.place(x)
        if isinstance(self.obstacle, ancf.HalfSpace):
            return n
        reach = self.obstacle.radius + RADIUS
        return (d0 + d1) / (2.0 * reach - e0 - e1)[:, None]

    def rotated(self, u, n):
        """Vectors in the tangent planes with normals n, with their lengths."""
        out = u - (u * n).sum(axis=1)[:, None] * n
        sizes = np.linalg.norm(u, axis=1), np.linalg.norm(out, axis=1)
        return out * (sizes[0] / np.where(sizes[1] > 0.0, sizes[1], 1.0))[:, None]

    def path(self, x):
        """Displacements along the surface, and the normals halfway."""
        d0, (d1, n1, _) = self.place(self.x)[0], self.place(x)
        middle = 0.5 * (d0 + d1)
        n = n1
        if not isinstance(self.obstacle, ancf.HalfSpace):
            n = middle / np.linalg.norm(middle, axis=1)[:, None]
        rate = getattr(self.obstacle, "angular_velocity", 0.0)
        turn = 2.0 / abs(rate) * np.tan(0.5 * abs(rate) * DT) if rate else DT
        path = x - self.x - turn * middle @ self.obstacle.spin.T
        path = path - (path * n).sum(axis=1)[:, None] * n
        return path, n

    def limited(self, u, p):
        """Deflections of bristles that slide at the pressure p."""
        limit = self.contact.friction * p / (GRIP_RATIO * self.stiffness)
        size = np.linalg.norm(u, axis=1)
        return u * (np.minimum(size, limit) / np.where(size > 0.0, size, 1.0))[:, None]

    def bristles(self, x, p):
        """Deflections at the end of a step."""
        (path, _), n1 = self.path(x), self.place(x)[1]
        return self.limited(self.rotated(self.z, n1) + self.rotated(path, n1), p)

    def bristles_between(self, x, p):
        """Deflections whose forces act in a step, and those at its end."""
        (path, n), n1, z = self.path(x), self.place(x)[1], self.limited(self.z, p)
        inside = self.limited(self.rotated(z, n) + 0.5 * path, p)
        z, path = self.rotated(z, n1), self.rotated(path, n1)
        is_sliding = np.linalg.norm(z + 0.5 * path, axis=1) > self.contact.friction * p / (
            GRIP_RATIO * self.stiffness
        )
        share = np.where(is_sliding, 0.5, 1.0)[:, None]
        return inside, self.limited(z + share * path, p)

    def sliding(self, x, v, p):
        """Friction that depends on the velocities."""
        d, n, _ = self.place(x)
        u = v - d @ self.obstacle.spin.T
        u = u - (u * n).sum(axis=1)[:, None] * n
        size = np.sqrt((u * u).sum(axis=1) + self.contact.slip_speed**2)
        return -self.contact.friction * (p / size)[:, None] * u


@pytest.mark.parametrize(
    "friction",
    [{}, {"friction": 0.3}, {"friction": 0.3, "slip_speed": 0.1}],
    ids=["none", "bristles", "slip speed"],
)
@pytest.mark.parametrize("name", OBSTACLES)
def test_forces_at_the_ends_of_steps(name, friction, rng):
    system, free, contact, q = pressed(name, **friction)
    none, rest = np.zeros(0), np.zeros(system.n_all)
    places, weights = zip(*map(system.point, contact.points), strict=True)

    def of_points(q):
        return np.array([w @ q[place].T for place, w in zip(places, weights, strict=True)])

    system.assembly.begin(q)
    system.assembly.set_step(DT)
    by_hand = ByHand(contact, of_points(q))
    slid = stuck = 0
    for speed in (0.0, 0.1, 5.0, 0.1):  # along the cable
        v = rng.normal(scale=1e-2, size=system.n_all) + speed * system.uniform(0)
        q = q + DT * v
        x = of_points(q)
        p = by_hand.pressures(x)
        forces = p[:, None] * by_hand.place(x)[1]
        if contact.sticks:
            z = by_hand.bristles(x, p)
            forces -= GRIP_RATIO * by_hand.stiffness[:, None] * z
            pressing = p > 0.0
            limit = 0.3 * p[pressing] / (GRIP_RATIO * by_hand.stiffness[pressing])
            size = np.linalg.norm(z[pressing], axis=1)
            slid, stuck = slid + np.sum(size > 0.999 * limit), stuck + np.sum(size < 0.9 * limit)
            by_hand.z = np.where(pressing[:, None], z, 0.0)
        elif friction:
            forces += by_hand.sliding(x, of_points(v), p)
        expected = rest.copy()
        for place, w, force in zip(places, weights, forces, strict=True):
            np.add.at(expected, place, -np.outer(force, w))
        found = system.assembly.residual(q, v, rest, none, rest, none)[0]
        found = found - free.assembly.residual(q, v, rest, none, rest, none)[0]
        assert (p > 0.0).any()
        assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
        system.assembly.accept(q)
        by_hand.x = x
    assert not contact.sticks or (slid and stuck)


@pytest.mark.parametrize("friction", [{}, {"friction": 0.3}], ids=["none", "bristles"])
@pytest.mark.parametrize("name", OBSTACLES)
def test_forces_between_states(name, friction, rng):
    system, free, contact, q = pressed(name, **friction)
    none, rest = np.zeros(0), np.zeros(system.n_all)
    places, weights = zip(*map(system.point, contact.points), strict=True)

    def of_points(q):
        return np.array([w @ q[place].T for place, w in zip(places, weights, strict=True)])

    system.assembly.begin(q)
    system.assembly.set_step(DT)
    by_hand = ByHand(contact, of_points(q))
    for speed in (0.01, 0.1, 5.0, 0.1):
        v = rng.normal(scale=1e-2, size=system.n_all) + speed * system.uniform(0)
        after = q + DT * v
        x = of_points(after)
        p = by_hand.pressures_between(x)
        forces = p[:, None] * by_hand.normals_between(x)
        if contact.sticks:
            inside, z = by_hand.bristles_between(x, p)
            forces -= GRIP_RATIO * by_hand.stiffness[:, None] * inside
            by_hand.z = np.where((p > 0.0)[:, None], z, 0.0)
        expected = rest.copy()
        for place, w, force in zip(places, weights, forces, strict=True):
            np.add.at(expected, place, -np.outer(force, w))
        states = q, after, v, rest, none, rest, none
        found = system.assembly.residual_between(*states)[0]
        found = found - free.assembly.residual_between(*states)[0]
        assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()
        system.assembly.accept(after)
        q, by_hand.x = after, x
