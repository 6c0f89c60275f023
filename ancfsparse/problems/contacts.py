"""Cables in contact, with reference values of formulas."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from ancfsparse.problems.mechanism import Mechanism
from ancfsparse.scene import Material, Rectangle, Scene
from ancfsparse.scene.force_elements.obstacles import Drum
from ancfsparse.scene.geometry.curves import Arc
from ancfsparse.scene.records.signals import Ramp

DRUM_RADIUS = 0.1  # [m]
WIRE_RADIUS = 1e-3  # [m]
TAIL_LENGTH = 0.05  # of the straight ends [m]
SLIP_SPEED = 1e-3  # a two hundredth of the default speed of the surface [m/s]
LOAD_TIME = 0.05  # until the force has its full value [s]


def capstan(
    mu: float = 0.3,
    angle: float = 180.0,
    tension: float = 10.0,
    turning: float = 2.0,
    n_elements: int = 48,
) -> Mechanism:
    """Return a wire around a turning drum, one end of which is fixed and the other one pulled.

    The wire, of 2 mm x 2 mm and bent without stress, touches the drum of 0.1 m along an arc of
    `angle` [degrees] with `n_elements`; its ends are straight.  The drum turns at `turning`
    [rad/s], towards the fixed end if positive, so that the tension there is
    ``tension * exp(mu * angle)`` (Euler, Eytelwein), else ``tension * exp(-mu * angle)``.

    Quantities: the ``held`` tension at the fixed end [N].
    """
    phi, reach = math.radians(angle), DRUM_RADIUS + WIRE_RADIUS
    growth = mu * phi if turning > 0.0 else 0.0
    start, end = np.array([-reach, 0.0]), reach * np.array([-math.cos(phi), math.sin(phi)])
    leaving = np.array([math.sin(phi), math.cos(phi)])
    scene = Scene((0.0, 0.0))
    section, material = Rectangle(2 * WIRE_RADIUS, 2 * WIRE_RADIUS), Material(2.5e10, 2.5e4)
    fixed_end = scene.add_beam(
        "thin", start - (0.0, TAIL_LENGTH), start, 8, section, material, name="fixed end"
    )
    curve = Arc((0.0, 0.0), tuple(start.tolist()), -phi)
    arc = scene.add_beam(
        "thin", curve=curve, n_elements=n_elements, section=section, material=material, name="arc"
    )
    pulled_end = scene.add_beam(
        "thin", end, end + TAIL_LENGTH * leaving, 8, section, material, name="pulled end"
    )
    parts = fixed_end, arc, pulled_end
    for before, after in pairwise(parts):
        scene.connect(before.end, after.start)
    scene.pin(fixed_end.start)
    force = Ramp(tuple((tension * leaving).tolist()), LOAD_TIME, smooth=True)
    scene.point_force(pulled_end.end, force)
    # Penetrations are 1 % of the radius of the wire, at the tighter end up to exp(growth / 2) %.
    stiffness = 100.0 * tension / (reach * WIRE_RADIUS) * math.exp(0.5 * growth)
    drum = Drum((0.0, 0.0), DRUM_RADIUS, angular_velocity=-turning)
    for part in parts:
        scene.contact(
            part, drum, stiffness=stiffness, radius=WIRE_RADIUS, friction=mu, slip_speed=SLIP_SPEED
        )
    return Mechanism(
        scene, {"held": lambda run: np.linalg.norm(run.reaction(fixed_end.start), axis=1)}
    )
