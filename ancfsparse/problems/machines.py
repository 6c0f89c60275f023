"""Machine parts in space and in the plane: a bend, a spring, an arm, a crane.

`n_elements` is the number of elements of the flexible part.
"""

from __future__ import annotations

import math

import numpy as np

from ancfsparse.checks import check_count
from ancfsparse.problems.flexible import add_cable, cable
from ancfsparse.problems.mechanism import GRAVITY, Mechanism
from ancfsparse.scene import Circle, Material, Ramp, Scene, Section
from ancfsparse.scene.bodies.rigid_shapes import Box, Cylinder, Rod
from ancfsparse.scene.geometry.curves import Arc, Helix


def bend(n_elements: int = 64, load: float = 600.0) -> Mechanism:
    """Return the bend of 45 degrees of Bathe and Bolourchi (1979), under a force out of its plane.

    Its radius is 100 m, its section a square of 1 m, with 1e7 Pa, Poisson's ratio 0 and the torsion
    constant 1/6 m4 of the literature.  It is clamped along +x at the origin and curves to +y; the
    force at its tip is in +z.

    Parameters
    ----------
    n_elements : int, optional
        Number of elements.
    load : float, optional
        The force [N].

    Notes
    -----
    Quantities: ``tip``, its displacement [m].
    """
    scene = Scene((0.0, 0.0, 0.0))
    n = check_count("n_elements", n_elements, 1)
    section = Section(1.0, 1.0 / 12.0, 1.0 / 12.0, 1.0 / 6.0)
    arc = Arc((0, 100, 0), (0, 0, 0), 0.25 * math.pi, axis=(0, 0, 1))
    rod = scene.add_beam(
        "thick", curve=arc, n_elements=n, section=section, material=Material(1e7, 1e3, 0.0),
        curvature="section", name="bend",
    )  # fmt: skip
    scene.clamp(rod.start)
    scene.point_force(rod.end, (0.0, 0.0, load))
    tip = {"tip": lambda run: run.position(rod.end) - rod.positions[-1]}
    return Mechanism(scene, tip, settles=True)


def spring_antenna(n_elements: int = 192) -> Mechanism:
    """Return a helical wire antenna that is released from compression.

    A helix of six turns, 50 mm in radius and 180 mm high, of 3 mm wire of copper beryllium (1.2e11
    Pa, 8300 kg/m3), carries a plate of 50 g, guided along its axis.  A compressive force of 6 N
    vanishes within 5 ms.

    Quantities: ``height`` of the plate [m].
    """
    radius, turns, pitch, force = 0.05, 6.0, 0.03, (0.0, 0.0, -6.0)
    scene = Scene((0.0, 0.0, 0.0))
    n = check_count("n_elements", n_elements, 1)
    wire = scene.add_beam(
        "thick", curve=Helix(radius, pitch, turns), n_elements=n, section=Circle(0.003),
        material=Material(1.2e11, 8300.0, 0.33), curvature="section", name="wire",
    )  # fmt: skip
    scene.clamp(wire.start)
    top = (0.0, 0.0, turns * pitch)
    plate = scene.add_body(Cylinder(0.01, 0.06), mass=0.05, position=top, name="plate")
    scene.weld(wire.end, plate.at((radius, 0, 0)))
    scene.prismatic(plate.origin, axis=(0, 0, 1))
    scene.point_force(plate.origin, Ramp((0.0, 0.0, 6.0), 5e-3, smooth=True) + force)
    height = {"height": lambda run: run.position(plate.origin)[:, 2]}
    return Mechanism(scene, height, settles=True)


def robot_arm(n_elements: int = 96) -> Mechanism:
    """Return an arm of 1 m and 0.8 m with prescribed joints, and a hose from its base to its hand.

    Its links weigh 8 and 5 kg.  The hose is 2.6 m long, with EA = 2e4 N, EI = 0.05 N m2 and 0.3
    kg/m, and hinged at both ends.  The arm starts at rest, its links at 60 and -30 degrees; from
    0.2 to 1.5 s the shoulder rotates by 45 degrees and the elbow opens by 75.

    Quantities: ``hand`` and ``middle`` of the hose [m]; ``pull``, the reaction of the hose at its
    base [N]; ``shoulder``, the driving moment of the upper arm [N m].
    """
    scene = Scene((0.0, -GRAVITY))
    angles = np.radians((60.0, -30.0))
    elbow = np.array([math.cos(angles[0]), math.sin(angles[0])])
    hand = elbow + 0.8 * np.array([math.cos(angles[1]), math.sin(angles[1])])
    upper = scene.add_body(Rod(1.0), mass=8.0, position=(0, 0), orientation=angles[0], name="upper")
    fore = scene.add_body(Rod(0.8), mass=5.0, position=elbow, orientation=angles[1], name="fore")
    hinges = scene.pin(upper.origin), scene.connect(upper.end, fore.origin)
    make = cable(2e4, 0.05, 0.3)
    hose = add_cable(scene, "hose", (-0.3, 0), hand, n_elements, make, min_elements=2, length=2.6)
    scene.pin(hose.start)
    scene.connect(hose.end, fore.end)
    shoulder, _ = (
        scene.drive_joint(hinge, Ramp(math.radians(angle), 1.5, 0.2, smooth=True))
        for hinge, angle in zip(hinges, (45.0, -75.0), strict=True)
    )
    watched = {
        "hand": lambda run: run.position(fore.end),
        "middle": lambda run: run.position(hose.at(1.3)),
        "pull": lambda run: run.reaction(hose.start),
        "shoulder": lambda run: run.joint_force(shoulder).moment,
    }
    return Mechanism(scene, watched, settles=True)


def crane() -> Mechanism:
    """Return a trolley 10 m above the ground that moves a load of 500 kg and winds its rope up.

    The trolley moves by 5 m in 4 s; from 1 to 5 s the winch shortens the rope from 6 to 4 m.

    Notes
    -----
    Quantities: centre of the ``load`` [m]; ``tension`` of the rope [N].
    """
    scene = Scene((0.0, -GRAVITY))
    trolley = scene.add_body(
        Box(length=0.6, width=0.5, height=0.3), mass=100.0, position=(0, 10), name="trolley"
    )
    load = scene.add_body(
        Box(length=0.8, width=0.8, height=0.8), mass=500.0, position=(0, 4), name="load"
    )
    rail = scene.prismatic(trolley.origin, axis=(1, 0))
    scene.drive_joint(rail, Ramp(5.0, 4.0, smooth=True))
    rope = scene.winch(
        [trolley.origin, load.centre], length=Ramp(-2.0, 5.0, 1.0, smooth=True) + 6.0
    )
    watched = {
        "load": lambda run: run.position(load.centre),
        "tension": lambda run: run.tension(rope),
    }
    return Mechanism(scene, watched)
