"""Scenes with contacts in the making: random sizes, materials and axes, and what adds parts."""

import math

import numpy as np

import ancfsparse as ancf
from tests.soak import scenes

GRAVITY = 9.81  # [m/s2]
SINKING = 0.1  # of a given stiffness in an impact, over the radius
REST = 0.01  # and under loads at rest
MAX_STEPS = 4000  # of a run
RESOLVED = 12.0  # steps of an impact times its restitution, which contact needs


class Draft:
    """Numbers that the parts of a scene share, in axes that are turned at random.

    All its friction has a slip speed if it must, or else less than half of it.  The generator
    `laws` draws restitution and static friction, without changing the rest of the scene.
    """

    def __init__(self, rng, layout, slips, laws=None):
        self.rng, self.layout, self.slips, self.laws = rng, layout, slips, laws
        spatial = layout in ("ropes", "net", "bend") or (layout != "pulley" and rng.random() < 0.4)
        self.dim = 3 if spatial else 2
        self.length = float(10 ** rng.uniform(-3, 2))
        self.radius = float(self.length * 10 ** rng.uniform(-2.7, -1.5))
        self.gap = float(self.length * 10 ** rng.uniform(-2.5, -0.5))
        self.density = float(10 ** rng.uniform(2.7, 3.95))
        has_speed = layout in ("fall", "throw", "ropes", "net") and rng.random() < 0.5
        fall = math.sqrt(GRAVITY * self.length)
        self.speed = float(fall * 10 ** rng.uniform(-1, 0.7)) if has_speed else 0.0
        is_weightless = has_speed and rng.random() < 0.3
        gravity = 0.0 if is_weightless else GRAVITY
        self.closing = gravity  # relative acceleration of both sides of the gap
        self.curvature = 0.0  # from which a body springs back [1/m]
        stretch = 10 ** rng.uniform(-5, -1.7)  # of its weight and of an impact
        self.modulus = float(self.density * (fall**2 + self.speed**2) / stretch)
        self.axes = turn(rng, self.dim)
        self.origin = self.length * rng.uniform(-1, 1, self.dim)
        self.scene = ancf.Scene(-gravity * self.axes[:, 1])
        self.section, self.needs_radius = ancf.Circle(2 * self.radius), False
        if rng.random() < 0.15:
            side = 2 * self.radius
            self.section, self.needs_radius = ancf.Rectangle(side, side), True
        self.material = ancf.Material(
            self.modulus, self.density, float(rng.choice([0.0, 0.3])), **self.damping()
        )
        self.element, self.options = draw_element(rng, self.dim, layout)
        self.beams, self.bodies, self.contacts, self.pulls = [], [], [], []
        self.words = {"layout": layout, "dim": self.dim, "length": self.length, "gravity": gravity}

    @property
    def weight(self):
        """Weight per length [N/m]."""
        return self.density * self.section.area * GRAVITY

    @property
    def duration(self):
        """Time until the gap is closed [s]."""
        if self.closing == 0.0:
            return self.gap / self.speed
        v, g = self.speed, self.closing
        return (math.sqrt(v * v + 2 * g * self.gap) - v) / g

    def draw_duration(self, most):
        """Draw the time of a run, some multiple of that in which the gap is closed [s]."""
        return self.duration * float(self.rng.uniform(1.3, most))

    def damping(self):
        """Return damping of the material, or none."""
        if self.rng.random() < 0.7:
            return {}
        period = math.sqrt(self.length / GRAVITY)
        size = float(10 ** self.rng.uniform(-5, -2)) * period
        return {"axial_damping": size, "bending_damping": size}

    def at(self, x, y, z=0.0):
        """Return a point of the axes in which y points up."""
        return self.origin + self.along(x, y, z)

    def along(self, x, y, z=0.0):
        """Return a vector of these axes."""
        return self.axes @ np.array([x, y, z][: self.dim])

    def line(self, start, end, n, **options):
        """Add a straight beam."""
        return self.keep(
            self.scene.add_beam(
                self.element, start, end, n, self.section, self.material,
                **self.options, **options,
            )
        )  # fmt: skip

    def pull(self, node, force, duration):
        """Apply a force that grows to its full size."""
        signal = ancf.Ramp(force, duration, smooth=True)
        self.pulls.append((node, signal))
        self.scene.point_force(node, signal)

    def keep(self, beam):
        """Enter a body, and return it."""
        self.beams.append(beam)
        return beam

    def touch(self, body, obstacle, *, tension=0.0, on=None):
        """Let a body touch an obstacle, by a stiffness that is given or left to the package."""
        rng, options = self.rng, {"on": on} if on is not None else {}
        mass = self.density * self.section.area
        square = self.speed**2 + 2 * GRAVITY * self.gap
        pressure = self.weight + (tension / obstacle.radius if tension else 0.0)
        impact = mass * square + self.modulus * self.section.inertia_z * self.curvature**2
        needed = max(impact / (SINKING * self.radius) ** 2, pressure / (REST * self.radius))
        is_unknown = self.layout == "throw"  # the speed of the body is
        if is_unknown or rng.random() < 0.4:
            options["stiffness"] = float(needed * 10 ** rng.uniform(0.3 if is_unknown else 0.0, 2))
        if self.needs_radius:
            options["radius"] = self.radius
        options |= self.draw_friction(square, slips=self.slips or self.rng.random() < 0.4)
        options = self.draw_law(options, mass / options.get("stiffness", needed))
        self.contacts.append(self.scene.contact(body, obstacle, **options))
        self.words |= {"obstacle": obstacle, **options, "on": on is not None}

    def draw_friction(self, square, slips=True):
        """Draw friction, and a slip speed below the speed whose square is given, or neither."""
        rng = self.rng
        if rng.random() >= 0.4:
            return {}
        options = {"friction": float(rng.uniform(0.05, 0.8))}
        if slips:
            typical = math.sqrt(square + 1e-3 * GRAVITY * self.length)
            options["slip_speed"] = float(typical * 10 ** rng.uniform(-2.5, -0.5))
        return options

    def draw_law(self, options, ratio):
        """Return options with a static friction above that of bristles, a restitution, or neither.

        Ropes can stick to each other then.  The ratio of mass and stiffness [s2] of an impact
        decides whether a run has time for its steps.
        """
        laws, more = self.laws, dict(options)
        if laws is None:
            return options
        if self.layout == "ropes" and not self.slips and laws.random() < 0.6:
            more.pop("slip_speed", None)
            more.setdefault("friction", float(laws.uniform(0.05, 0.8)))
        if "friction" in more and "slip_speed" not in more and laws.random() < 0.5:
            more["static_friction"] = float(more["friction"] * laws.uniform(1.0, 2.5))
        if self.layout in ("fall", "throw", "ropes", "net") and laws.random() < 0.5:
            restitution = float(laws.uniform(0.2, 1.0))
            steps = 3.0 * self.duration * RESOLVED / (restitution * math.pi * math.sqrt(ratio))
            if steps < MAX_STEPS:
                more["restitution"] = restitution
        return more


def turn(rng, dim):
    """Return random axes of the right hand in the columns of a matrix."""
    axes, _ = np.linalg.qr(rng.normal(size=(dim, dim)))
    axes[:, -1] *= np.linalg.det(axes)
    return axes


def draw_element(rng, dim, layout):
    element, options = scenes.draw_element(rng)
    if (dim == 3 and element == "l2t2") or (layout == "net" and element == "thick"):
        return "thin", {}
    return element, options
