"""Cables at obstacles of every shape: residual and matrix of their contact, and its formulas."""

from functools import lru_cache

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from tests.matrices import full
from tests.system.contributions.contact_tangents.complex_steps import derivative
from tests.system.contributions.contact_tangents.obstacle_forces import ObstacleForces
from tests.system.contributions.shapes import SHAPES, lowered

RADIUS, STIFFNESS, DENSITY = 0.05, 1e5, 1e3
SOFT = ancf.Material(1e-2, DENSITY)  # whose matrix does not hide that of the contact
LINE_MASS = DENSITY * np.pi * RADIUS**2
PLANES = {
    "plane": ancf.HalfSpace((0, 0), (0.1, 1)),
    "floor": ancf.HalfSpace((0, 0, 0), (0.1, 1, 0.1)),
}
ROUND = {
    "disc": ancf.Drum((0, 0), 0.1),
    "drum": ancf.Drum((0, 0, 0), 0.07, (0.1, 0.1, 1)),
    "ball": ancf.Ball((0, 0, 0), 0.1),
}
TURNING = {
    "turning disc": ancf.Drum((0, 0), 0.1, angular_velocity=2.0),
    "turning drum": ancf.Drum((0, 0, 0), 0.07, (0.1, 0.1, 1), -2.0),
}
OBSTACLES = SHAPES | PLANES | ROUND
ALL = OBSTACLES | TURNING
# Largest penetration over the radius: within the layer in which the pressure begins, and deep.
DEPTHS = 6e-4, 0.1
DT = 0.3 * np.pi * np.sqrt(LINE_MASS / STIFFNESS) / 2.0  # [s], at which impacts are damped by 0.09


@lru_cache
def build(name, is_moving, law):
    """A system, its contact with a law, without any for None, and the formulas of its forces."""
    obstacle = lowered(ALL[name], RADIUS)
    pad, is_flat = (0.0,) * (obstacle.dim - 2), obstacle.dim == 2
    scene, body, contact = ancf.Scene((0.0, 0.0, *pad)), None, None
    ends, section = ((-0.15, 0, *pad), (0.15, 0, *pad)), ancf.Circle(2.0 * RADIUS)
    cable = scene.add_beam("thin", *ends, 4, section, SOFT)
    if is_moving:
        turn, inertia = (0.4, 2e-5) if is_flat else ((0.6, 0.8, 0, 0), (2e-5, 3e-5, 4e-5))
        body = scene.add_body(
            mass=0.05, inertia=inertia, position=(0.01, -0.08, *pad), orientation=turn
        )
    if law is not None:
        contact = scene.contact(cable, obstacle, stiffness=STIFFNESS, on=body, **dict(law))
    system = System(scene)
    if law is None:
        return system, None
    restitution = dict(law).get("restitution", 0.0)
    return system, ObstacleForces(system, contact, STIFFNESS, LINE_MASS, restitution)


class Case:
    """A cable at an obstacle, the formulas of their contact, and the system without it."""

    def __init__(self, name, is_moving=False, seed=0, **law):
        self.rng = np.random.default_rng([seed, *name.encode()])
        self.system, self.forces = build(name, is_moving, tuple(law.items()))
        self.without, _ = build(name, is_moving, None)
        self.part = next(each for each in self.system.contributions if hasattr(each, "contact"))
        self.n, self.n_all = self.system.n_free, self.system.n_all
        self.none, self.rest = np.zeros(0), np.zeros(self.n_all)
        self.lam = np.zeros(self.system.n_multipliers)

    def state(self, ratio, size=1e-3):
        """Coordinates near those of the start with a given largest penetration over the radius."""
        q = self.system.q0 + size * self.rng.normal(size=self.n_all)
        heights = self.system.vectors("r")[0][:, 1]
        for _ in range(99):
            excess = self.forces.depth(q).max() - ratio * RADIUS
            if abs(excess) < 1e-10 * RADIUS:
                break
            q[heights] += excess
        assert self.forces.depth(q).max() == pytest.approx(ratio * RADIUS, rel=1e-6)
        return q

    def velocities(self, size=0.1):
        """Velocities at random."""
        return size * self.rng.normal(size=self.n_all)

    def near(self, q, size=1e-4):
        """Coordinates near others."""
        return q + size * self.rng.normal(size=self.n_all)

    def begin_step(self, q0, dt=DT):
        """Begin a step at coordinates, without deflections of bristles."""
        self.system.assembly.begin(q0)
        self.system.assembly.set_step(dt)

    def residual(self, q, v=None):
        """The residual of the contact in a state."""
        v = self.rest if v is None else v
        with_it, without = (
            each.assembly.residual(q, v, self.rest, self.lam, self.rest, self.none)[0]
            for each in (self.system, self.without)
        )
        return with_it - without

    def residual_between(self, q0, q1, v=None):
        """The residual of the contact between two states."""
        v = self.rest if v is None else v
        with_it, without = (
            each.assembly.residual_between(q0, q1, v, self.rest, self.lam, self.rest, self.none)[0]
            for each in (self.system, self.without)
        )
        return with_it - without

    def matrix(self, q, v=None, stiffness=1.0, damping=0.0):
        """The matrix of the contact, (n, n)."""
        with_it, without = (
            full(
                each,
                each.assembly.matrix(
                    0.0, stiffness, q, self.lam, self.none, damping_factor=damping, v=v
                ),
            )[: self.n, : self.n]
            for each in (self.system, self.without)
        )
        return with_it - without

    def damping(self, q, v):
        """The derivative by velocities in the matrix."""
        return self.matrix(q, v, 0.0, 1.0)

    def derivative(self, function, x):
        """The derivative of a function by the free coordinates."""
        return derivative(function, x, self.n)[: self.n]
