"""The scenes with contact of the stability map, at any stiffness and with any friction."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from ancfsparse.scene import Circle, Material, Scene
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.force_elements.contacts import Contact
from ancfsparse.scene.force_elements.obstacles import Ball, Drum, HalfSpace, Obstacle
from ancfsparse.scene.geometry.curves import Arc
from ancfsparse.scene.records.signals import Ramp
from ancfsparse.system import System
from ancfsparse.system.contributions.force_elements.contact_stiffness import (
    default_stiffness,
)

GRAVITY = 9.81  # [m/s2]
CABLE = Circle(0.01), Material(1e8, 2e3)
FALL_HEIGHT = 5e-3  # contact begins after 0.03 s [m]
TILT = 0.05  # of the tilted cable [rad]
THROW = 1.0  # its speed along the floor [m/s]
DRUM_RADIUS = 0.1  # also of the pulley [m]
WIRE = Circle(0.002), Material(1e10, 4e3)
TENSION = 10.0  # of the wire at its pulled end [N]
TURNING = 2.0  # of the drum, towards the fixed end of the wire [rad/s]
LOAD_TIME = 0.02  # in which tensions rise [s]
PULLEY_MASS = 0.05  # [kg]
END_MASSES = 0.25, 0.3  # of the rope over the pulley [kg]
BALL_RADIUS = 0.4  # [m]
NET_SIDE = 0.9  # [m]
NET_MESHES = 3  # along a side
NET_OFFSET = 0.05  # of the centre of the net from the centre of the ball [m]
STRING = Circle(4e-3), Material(1e6, 1e3)  # rubber
FLOOR = HalfSpace((0.0, 0.0), (0.0, 1.0))

FRICTIONS: dict[str, dict[str, float]] = {
    "no friction": {},
    "bristles": {"friction": 0.3},
    "slip speed": {"friction": 0.3, "slip_speed": 1e-2},
}
"""Arguments of `Scene.contact` [-, m/s]."""


class ContactCase(NamedTuple):
    """A scene with contact of the map."""

    scene: Scene  # ready to simulate
    contact: Contact


class Parts(NamedTuple):
    """A scene before its contact is added."""

    scene: Scene
    body: ElasticBody
    obstacle: Obstacle
    on: RigidBody | None = None  # body of the obstacle


def level_fall() -> Parts:
    """Set up a level cable above a floor: all of it touches at once."""
    scene = Scene((0.0, -GRAVITY))
    level = 0.5 * CABLE[0].diameter + FALL_HEIGHT
    return Parts(scene, scene.add_beam("thin", (0.0, level), (1.0, level), 10, *CABLE), FLOOR)


def tilted_throw() -> Parts:
    """Set up a tilted cable that is thrown along a floor and whips onto it."""
    scene = Scene((0.0, -GRAVITY))
    level = 0.5 * CABLE[0].diameter + FALL_HEIGHT
    end = math.cos(TILT), level + math.sin(TILT)
    body = scene.add_beam("thin", (0.0, level), end, 20, *CABLE, velocity=(THROW, 0.0))
    return Parts(scene, body, FLOOR)


def wire_on_drum() -> Parts:
    """Set up a wire around half of a turning drum: one end is fixed, the other one pulled."""
    scene = Scene((0.0, 0.0))
    curve = Arc((0.0, 0.0), (-DRUM_RADIUS - 0.5 * WIRE[0].diameter, 0.0), -math.pi)
    wire = scene.add_beam("thin", curve=curve, n_elements=20, section=WIRE[0], material=WIRE[1])
    scene.pin(wire.start)
    scene.point_force(wire.end, Ramp((0.0, -TENSION), LOAD_TIME, smooth=True))
    return Parts(scene, wire, Drum((0.0, 0.0), DRUM_RADIUS, angular_velocity=-TURNING))


def rope_over_pulley() -> Parts:
    """Set up a rope over a pulley that turns freely, with unequal masses at its ends."""
    scene = Scene((0.0, 0.0))
    inertia = 0.5 * PULLEY_MASS * DRUM_RADIUS**2
    pulley = scene.add_body(mass=PULLEY_MASS, inertia=inertia, position=(0.0, 0.0))
    scene.pin(pulley.origin)
    curve = Arc((0.0, 0.0), (-DRUM_RADIUS - 0.5 * WIRE[0].diameter, 0.0), -math.pi)
    rope = scene.add_beam("thin", curve=curve, n_elements=20, section=WIRE[0], material=WIRE[1])
    for end, mass in zip((rope.start, rope.end), END_MASSES, strict=True):
        scene.add_mass(end, mass)
        scene.point_force(end, Ramp((0.0, -GRAVITY * mass), LOAD_TIME, smooth=True))
    return Parts(scene, rope, Drum((0.0, 0.0), DRUM_RADIUS), pulley)


def net_on_ball() -> Parts:
    """Set up a net of strings that falls on a ball off its centre, and slides down."""
    scene = Scene((0.0, 0.0, -GRAVITY))
    number = np.arange((NET_MESHES + 1) ** 2).reshape(NET_MESHES + 1, -1)
    edges = np.concatenate(
        [np.stack([one.ravel(), other.ravel()], axis=1)
         for one, other in ((number[:-1], number[1:]), (number[:, :-1], number[:, 1:]))]
    )  # fmt: skip
    x, y = np.stack(np.divmod(number.ravel(), NET_MESHES + 1)) * (NET_SIDE / NET_MESHES)
    height = BALL_RADIUS + 0.5 * STRING[0].diameter + FALL_HEIGHT
    nodes = np.stack([x - 0.5 * NET_SIDE + NET_OFFSET, y - 0.5 * NET_SIDE, 0.0 * x + height], 1)
    return Parts(
        scene, scene.add_mesh(nodes, edges, "string", *STRING), Ball((0.0, 0.0, 0.0), BALL_RADIUS)
    )


SHAPES: dict[str, Callable[[], Parts]] = {
    "level fall": level_fall,
    "tilted throw": tilted_throw,
    "wire on a drum": wire_on_drum,
    "rope on a pulley": rope_over_pulley,
    "net on a ball": net_on_ball,
}


def add_contact(
    shape: str, friction: str, stiffness: float | None, restitution: float | None = None
) -> ContactCase:
    """Set up a scene with the stiffness of its contact [N/m2], or the default one."""
    parts = SHAPES[shape]()
    options = FRICTIONS[friction]
    contact = parts.scene.contact(
        parts.body,
        parts.obstacle,
        on=parts.on,
        stiffness=stiffness,
        friction=options.get("friction", 0.0),
        slip_speed=options.get("slip_speed"),
        restitution=restitution,
    )
    return ContactCase(parts.scene, contact)


@cache
def compute_reference_stiffness(shape: str) -> float:
    """Return the stiffness for 10 % of the radius in an impact and 1 % at rest [N/m2].

    It is the default one of a contact with a restitution.
    """
    case = add_contact(shape, "no friction", None, restitution=1.0)
    return default_stiffness(System(case.scene), case.contact, 0)


def scale_stiffness(shape: str, friction: str, ratio: float) -> ContactCase:
    """Set up a scene with a multiple of the reference stiffness of its contact [-]."""
    return add_contact(shape, friction, ratio * compute_reference_stiffness(shape))


SCENES: dict[str, Callable[[float], ContactCase]] = {
    f"{shape}, {friction}": partial(scale_stiffness, shape, friction)
    for shape, friction in itertools.product(SHAPES, FRICTIONS)
    if shape != "level fall" or friction == "no friction"  # it does not slide
}
"""Each takes the stiffness of its contact over the reference one [-]."""
