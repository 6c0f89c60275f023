"""Mechanisms of cables and rigid bodies, with reference values of an independent program.

The references were computed with Exudyn 1.13.6 on the same meshes; its planar cable is ``"thin"``
with ``strain="biot"``.  Other elements or strains give different values.
`n_elements` is the number of elements of each cable.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_count
from ancfsparse.problems.mechanism import GRAVITY, Mechanism, bar, upper_intersection
from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam, Circle, Material, Ramp, Rectangle, Scene, Sine, SpinUp
from ancfsparse.scene.bodies.rigid_shapes import Box
from ancfsparse.scene.records.signal import Signal
from ancfsparse.scene.sections.cross_section import AnySection

CABLE = Rectangle(0.01, 0.01), Material(1e8, 4000.0)  # of the paper's pendulum


def spin_up(n_elements: int = 16) -> Mechanism:
    """Return a beam of 10 m on a hub accelerated to 6 rad/s in 15 s, after Kane and Simo.

    It has EA = 2.8e7 N, EI = 1.4e4 N m2 and 1.2 kg/m; there is no gravity.

    Quantities: ``u1`` and ``u2``, the displacement of the tip along the rigidly rotating beam and
    across it [m].
    """
    scene = Scene((0.0, 0.0))
    rod = add_cable(scene, "rod", (0, 0), (10, 0), n_elements, cable(2.8e7, 1.4e4, 1.2))
    turn = SpinUp(6.0, 15.0)
    scene.drive_joint(scene.pin(rod.start), turn)

    def in_rotating_frame(run: Trajectory) -> Vector:
        angle = turn(run.t)
        c, s = np.cos(angle), np.sin(angle)
        x, y = run.position(rod.end).T
        return np.stack([c * x + s * y - rod.length, c * y - s * x], axis=1)

    watched = {
        "u1": lambda run: in_rotating_frame(run)[:, 0],
        "u2": lambda run: in_rotating_frame(run)[:, 1],
    }
    return Mechanism(scene, watched)


def elastic_slider_crank(n_elements: int = 16) -> Mechanism:
    """Return a steel rod of 0.3 m between a crank of 0.15 m at 150 rad/s and a slider.

    The rod is round, 6 mm thick; the slider has half its mass.  It starts straight at a crank angle
    of zero, with the velocities of a rigid rod.  There is no gravity.

    Quantities: ``deflection`` of the middle of the rod from its chord over its length [-], positive
    to the left of the line from crank to slider; ``crank_angle`` [degrees].
    """
    crank, length, speed = 0.15, 0.3, 150.0
    scene = Scene((0.0, 0.0))
    section, material = make = Circle(0.006), Material(2e11, 7870.0)
    start, end = np.array([crank, 0.0]), np.array([crank + length, 0.0])

    def velocity(x: Vector) -> Vector:
        return np.stack([0.0 * x[:, 0], speed * crank * (end[0] - x[:, 0]) / length], axis=1)

    rod = add_cable(scene, "rod", start, end, n_elements, make, min_elements=2, velocity=velocity)
    turns = speed / (2.0 * math.pi)
    scene.drive(rod.start, Sine((crank, 0.0), turns, 0.5 * math.pi) + Sine((0.0, crank), turns))
    mass = 0.5 * section.area * material.density * length
    # The shape has no effect, because the slider does not rotate.
    slider = scene.add_body(
        Box(length=0.04, width=0.02, height=0.02), mass=mass, position=end, name="slider"
    )
    scene.connect(rod.end, slider.origin)
    scene.prismatic(slider.origin, axis=(1, 0))
    watched = {
        "deflection": lambda run: _deflection(run, rod) / length,
        "crank_angle": lambda run: np.degrees(speed * run.t),
    }
    return Mechanism(scene, watched)


def double_pendulum_bob(n_elements: int = 16) -> Mechanism:
    """Return two cables of 1 m in series, pinned at the origin, with a disc at their end.

    They start at rest along +x; the cables are those of `pendulum`.  The disc of 0.5 kg and
    6.25e-4 kg m2 has its centre 0.05 m beyond the end, in the direction of the cable there.

    Quantities: ``hinge`` between the cables and centre of the ``bob`` [m]; ``bob_angle`` [rad].
    """
    scene = Scene((0.0, -GRAVITY))
    upper = add_cable(scene, "upper", (0, 0), (1, 0), n_elements)
    lower = add_cable(scene, "lower", (1, 0), (2, 0), n_elements)
    bob = scene.add_body(mass=0.5, inertia=6.25e-4, centre=(0.05, 0), position=(2, 0), name="bob")
    scene.pin(upper.start)
    scene.connect(upper.end, lower.start)
    scene.weld(lower.end, bob.origin)
    watched = {
        "hinge": lambda run: run.position(lower.start),
        "bob": lambda run: run.body(bob).centre,
        "bob_angle": lambda run: run.body(bob).angles,
    }
    return Mechanism(scene, watched)


@dataclass(frozen=True)
class CrankEnd(Signal):
    """The end of a crank of 1 m that starts at 90 degrees.

    Attributes
    ----------
    turn : SpinUp
        Its angle relative to the start.
    """

    turn: SpinUp
    smoothness = SpinUp.smoothness

    def __call__(self, t: ArrayLike) -> Vector:
        """Return the position at a time, or one in each row for an array of times [m]."""
        angle = self.turn(t)
        return np.stack([-np.sin(angle), np.cos(angle)], axis=-1)

    def rate(self, t: ArrayLike, order: int = 1) -> Vector:
        """Return its first or second derivative [m/s, m/s2]."""
        outward = self(t)
        along = np.stack([-outward[..., 1], outward[..., 0]], axis=-1)
        speed = self.turn.rate(t)[..., None]
        if order == 1:
            return np.asarray(speed * along)
        return np.asarray(self.turn.rate(t, 2)[..., None] * along - speed**2 * outward)


def elastic_four_bar(n_elements: int = 16) -> Mechanism:
    """Return `four_bar` with an elastic coupler and a crank accelerated to -2 pi rad/s in 0.5 s.

    The coupler has 1 kg/m, EA = 1e5 N and EI = 200 N m2.

    Quantities: ``middle`` of the coupler and ``B``, its end at the rocker [m].
    """
    scene = Scene((0.0, -GRAVITY))
    a, d = np.array([0.0, 1.0]), np.array([3.0, 0.0])
    b = upper_intersection(a, 2.0, d, 2.5)
    coupler = add_cable(scene, "coupler", a, b, n_elements, cable(1e5, 200.0, 1.0))
    rocker = bar(scene, "rocker", d, b)
    scene.drive(coupler.start, CrankEnd(SpinUp(-2.0 * math.pi, 0.5)))
    scene.pin(rocker.origin)
    scene.connect(coupler.end, rocker.end)
    watched = {
        "middle": lambda run: run.position(coupler.at(0.5 * coupler.length)),
        "B": lambda run: run.position(coupler.end),
    }
    return Mechanism(scene, watched)


def spaghetti(n_elements: int = 32) -> Mechanism:
    """Return a free cable of 10 m thrown by a force of 8 N and a moment of -80 N m.

    It has EA = 1e4 N, EI = 500 N m2, 1 kg/m, and starts at rest from (6, 0) to (0, 8) m without
    gravity.  The loads at its first end rise in 0.5 s and fall between 2.25 and 2.75 s.

    Quantities: ``a``, ``middle`` and ``b`` of the cable [m].
    """
    scene = Scene((0.0, 0.0))
    rod = add_cable(scene, "rod", (6, 0), (0, 8), n_elements, cable(1e4, 500.0, 1.0))
    force, moment = (8.0, 0.0), -80.0
    ends = 2.25, 2.75
    scene.point_force(
        rod.start,
        Ramp(force, 0.5, smooth=True) + Ramp((-8.0, 0.0), ends[1], ends[0], smooth=True),
    )
    scene.point_moment(
        rod.start, Ramp(moment, 0.5, smooth=True) + Ramp(-moment, ends[1], ends[0], smooth=True)
    )
    watched = {
        "a": lambda run: run.position(rod.start),
        "middle": lambda run: run.position(rod.at(0.5 * rod.length)),
        "b": lambda run: run.position(rod.end),
    }
    return Mechanism(scene, watched)


def moving_supports(n_elements: int = 16) -> Mechanism:
    """Return a slack cable of 2.2 m over 2 m, whose right end moves by (0.15, -0.15) m in 0.5 s.

    The cable is that of `pendulum`, free of stress when straight; it starts in equilibrium.

    Quantities: ``middle`` of the cable [m]; ``pull``, the reaction at its right end [N].
    """
    scene = Scene((0.0, -GRAVITY))
    rope = add_cable(scene, "rope", (0, 0), (2.2, 0), n_elements)
    scene.pin(rope.start)
    begin = 2.0, 0.0
    scene.drive(rope.end, Ramp((0.15, -0.15), 0.5, smooth=True) + begin)
    watched = {
        "middle": lambda run: run.position(rope.at(0.5 * rope.length)),
        "pull": lambda run: run.reaction(rope.end),
    }
    return Mechanism(scene, watched, settles=True)


def sliding_bead(n_elements: int = 32) -> Mechanism:
    """Return a bead of 0.1 kg on a cable of 2 m between two pins, free of stress and straight.

    The cable has the section and material of `pendulum`; the bead starts at rest at a quarter of
    its length.

    Quantities: positions of the ``bead`` and of the ``middle`` of the cable [m].
    """
    scene = Scene((0.0, -GRAVITY))
    rope = add_cable(scene, "rope", (0, 0), (2, 0), n_elements)
    scene.pin(rope.start)
    scene.pin(rope.end)
    bead = scene.add_body(mass=0.1, inertia=1e-4, position=(0.5, 0), name="bead")
    scene.slide(bead.origin, rope)
    watched = {
        "bead": lambda run: run.position(bead.origin),
        "middle": lambda run: run.position(rope.at(0.5 * rope.length)),
    }
    return Mechanism(scene, watched)


def add_cable(
    scene: Scene,
    name: str,
    start: ArrayLike,
    end: ArrayLike,
    n_elements: int,
    make: tuple[AnySection, Material] = CABLE,
    *,
    min_elements: int = 1,
    **more: Any,
) -> Beam:
    """Add a planar cable like that of Exudyn; `more` are arguments of `add_beam`."""
    count = check_count("n_elements", n_elements, min_elements)
    return scene.add_beam("thin", start, end, count, *make, strain="biot", name=name, **more)


def cable(
    axial_stiffness: float, bending_stiffness: float, mass_per_length: float
) -> tuple[AnySection, Material]:
    """Return a square section and its material, of a stiffness [N, N m2] and a mass [kg/m]."""
    side = math.sqrt(12.0 * bending_stiffness / axial_stiffness)
    return Rectangle(side, side), Material(axial_stiffness / side**2, mass_per_length / side**2)


def _deflection(run: Trajectory, rod: Beam) -> Vector:
    """Return the distance of the middle of a rod to the left of its chord [m]."""
    points = rod.start, rod.end, rod.at(0.5 * rod.length)
    start, end, middle = (run.position(point) for point in points)
    chord = end - start
    chord /= np.linalg.norm(chord, axis=1)[:, None]
    offset = middle - start
    return np.asarray(chord[:, 0] * offset[:, 1] - chord[:, 1] * offset[:, 0])
