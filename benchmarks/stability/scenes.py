"""The scenes of the stability map, each at any stiffness."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.problems import pendulum
from ancfsparse.scene import Beam, Material, Rectangle, Scene

# Kuhl and Crisfield (1999).
TRUSS_LENGTH = 3.0443  # [m]
TRUSS_MASS = 6.57  # [kg/m]
TRUSS_SPEED = 7.72  # of its tip, transverse [m/s]
TRUSS_AREA = 0.05  # EA = 1e10 N at 2e11 Pa [m2]

LOAD = 1.1  # force on the compressed beam, over Euler's
RISE_TIME = 0.1  # of that force [s]
PUSH = 0.5  # sudden force on the tip of the pendulum, over its weight
PUSH_TIMES = (0.02005, 0.52005)  # its jumps, inside a step of any length of the map [s]


class Case(NamedTuple):
    """A scene of the map."""

    scene: Scene  # ready to simulate
    rod: Beam  # its beam
    # the force on the end of the beam over time [s], shape (2,) [N]
    force: Callable[[float], tuple[float, float]] | None = None
    jumps: tuple[float, ...] = ()  # when the force jumps [s]


def swinging(youngs_modulus: float) -> Case:
    """Set up the paper's pendulum, thin, ten elements, falling from rest."""
    return Case(*pendulum("thin", 10, youngs_modulus=youngs_modulus))


def truss(youngs_modulus: float) -> Case:
    """Set up a truss pendulum: one stocky cable element, thrown across, without weight."""
    scene = Scene((0.0, 0.0))
    side = math.sqrt(TRUSS_AREA)
    rod = scene.add_beam(
        "l2t2", (0.0, 0.0), (TRUSS_LENGTH, 0.0), 1, Rectangle(side, side),
        Material(youngs_modulus, TRUSS_MASS / TRUSS_AREA), velocity=_turning,
    )  # fmt: skip
    scene.pin(rod.start)
    return Case(scene, rod)


def _turning(points: Vector) -> Vector:
    rate = TRUSS_SPEED / TRUSS_LENGTH
    return np.stack([-rate * points[:, 1], rate * points[:, 0]], axis=1)


def hanging(youngs_modulus: float) -> Case:
    """Set up the pendulum with its tip on a massless rod of 1 m: a constraint that turns."""
    scene, rod = pendulum("thin", 10, youngs_modulus=youngs_modulus)
    scene.rod(rod.end, (2.0, 1.0))
    return Case(scene, rod)


def compressed(youngs_modulus: float) -> Case:
    """Set up a clamped beam of 1 m under a little more than Euler's load, and nudge it."""
    scene = Scene((0.0, 0.0))
    rod = scene.add_beam(
        "thin", (0.0, 0.0), (1.0, 0.0), 10, Rectangle(0.05, 0.05), Material(youngs_modulus, 4000.0),
        velocity=_nudged,
    )  # fmt: skip
    scene.clamp(rod.start)
    euler = 0.25 * math.pi**2 * rod.parameters()["bending_stiffness"]

    def force(t: float) -> tuple[float, float]:
        return -LOAD * euler * 0.5 * (1.0 - math.cos(math.pi * min(t / RISE_TIME, 1.0))), 0.0

    scene.point_force(rod.end, force)
    return Case(scene, rod, force)


def _nudged(points: Vector) -> Vector:
    return np.stack([0.0 * points[:, 0], 0.01 * points[:, 0] ** 2], axis=1)


def pushed(youngs_modulus: float) -> Case:
    """Set up the pendulum with a force on its tip that begins at once and ends at once."""
    scene, rod = pendulum("thin", 10, youngs_modulus=youngs_modulus)
    weight = rod.stiffnesses()["mass_per_length"] * rod.length * -float(scene.gravity[1])

    def force(t: float) -> tuple[float, float]:
        return 0.0, PUSH * weight if PUSH_TIMES[0] < t < PUSH_TIMES[1] else 0.0

    scene.point_force(rod.end, force)
    return Case(scene, rod, force, PUSH_TIMES)


SCENES: dict[str, Callable[[float], Case]] = {
    "pendulum": swinging,
    "truss pendulum": truss,
    "rod at the tip": hanging,
    "compressed beam": compressed,
    "sudden force": pushed,
}
"""Each takes Young's modulus [Pa]."""
