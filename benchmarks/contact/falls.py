"""Cables that fall on a drum, a ball and a cable, with this package and with other codes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.scene import Beam, Circle, Material, Scene
from ancfsparse.scene.force_elements.obstacles import Ball, Drum
from ancfsparse.solve import simulate

LENGTH = 1.0  # [m]
RADIUS = 5e-3  # of the section [m]
ELEMENTS = 20
GRAVITY = 9.81  # [m/s2]
MATERIAL = Material(1e7, 1e3)
GAP = 0.02  # of the fall [m]
OBSTACLE_RADIUS = 0.1  # of drum and ball [m]
MIDDLE = 0.4  # place along the cable that falls on the top of the obstacle [m]
FRICTION = 0.3
STIFFNESS = 1e5  # of the contact per length [N/m2]
END = 0.16  # [s]
WATCHED = (0, ELEMENTS // 2, ELEMENTS)  # nodes whose positions are compared


@dataclass(frozen=True)
class Fall:
    """Time of a run, and positions at its end, (3, dim) [m]."""

    seconds: float
    positions: Vector


def start_height(of_cable: bool) -> float:
    """Return the height of the axis at the start over the centre of the obstacle [m]."""
    return GAP + RADIUS + (RADIUS if of_cable else OBSTACLE_RADIUS)


def fall_scene(on: str) -> Scene:
    """Return a level cable above a drum in the plane, a ball, or a cable held at both ends."""
    pad = () if on == "drum" else (0.0,)
    scene = Scene((0.0, -GRAVITY, *pad))
    height = start_height(on == "cable")
    ends = (-MIDDLE, height, *pad), (LENGTH - MIDDLE, height, *pad)
    section = Circle(2.0 * RADIUS)
    cable = scene.add_beam("thin", *ends, ELEMENTS, section, MATERIAL)
    if on == "cable":
        lower = scene.add_beam(
            "thin", (0, 0, -0.5 * LENGTH), (0, 0, 0.5 * LENGTH), ELEMENTS, section, MATERIAL
        )
        scene.pin(lower.start)
        scene.pin(lower.end)
        scene.contact(cable, lower, stiffness=STIFFNESS)
        return scene
    obstacle = Drum((0, 0), OBSTACLE_RADIUS) if on == "drum" else Ball((0, 0, 0), OBSTACLE_RADIUS)
    scene.contact(cable, obstacle, stiffness=STIFFNESS, friction=FRICTION)
    return scene


def run_fall(on: str, dt: float) -> Fall:
    """Run it with this package."""
    scene = fall_scene(on)
    run = simulate(scene, END, dt, save_every=round(END / dt))
    cable = scene.bodies[0]
    assert isinstance(cable, Beam)
    positions = [run.position(cable.node(k))[-1] for k in WATCHED]
    return Fall(run.stats.march_seconds, np.array(positions))
