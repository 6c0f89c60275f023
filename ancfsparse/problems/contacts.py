"""Cables in contact, with reference values of formulas."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_positive
from ancfsparse.problems.flexible import SpinUp
from ancfsparse.problems.mechanism import Mechanism
from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam, Circle, Material, Rectangle, Scene
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.force_elements.contacts import Contact
from ancfsparse.scene.force_elements.obstacles import Drum
from ancfsparse.scene.geometry.curves import Arc
from ancfsparse.scene.records.signals import Ramp, Table

DRUM_RADIUS = 0.1  # [m]
WIRE_RADIUS = 1e-3  # [m]
TAIL_LENGTH = 0.05  # of the straight ends [m]
LOAD_TIME = 0.05  # until the force has its full value [s]
BELT_RADIUS = 0.1  # of the axis of a belt around a pulley [m]
CENTRE_DISTANCE = 0.4  # of the pulleys [m]
BELT_STIFFNESS = 2e4  # E A [N]
BELT_MASS = 0.1  # [kg/m]
BELT_STRAIN = 0.01  # at the start [1]
ROD_RADIUS = 0.01  # [m]
LOOP_RADIUS = 0.5  # of the knot at the start [m]
ROD_TAIL = 0.5  # straight part at either end [m]
# Rubber; velocities are damped so that the tension at the ends is nearly the one of equilibria.
RUBBER = Material(1e7, 1000.0, axial_damping=1e-2, rayleigh=(1.0, 0.0))
CONTACT_STIFFNESS = 2e5  # [N/m2]
BRAID_RATIO = 0.6  # half of the part where both strands lie side by side, over the loop radius
WINDING_RATIO = 0.75  # of this part, where they wind
GAP_RATIO = 1.08  # of the distance of the axes there, over the one at which surfaces touch
SETTLING_TIME = 2.4  # [s]
TIGHTENING_TIME = 13.6  # [s]
N_TIMES = 60  # of the table of the motion of the ends
SLIDING_FRACTION = 0.9  # of mu times the pressure, above which a point of a belt slides


def capstan(
    mu: float = 0.3,
    angle: float = 180.0,
    tension: float = 10.0,
    turning: float = 2.0,
    n_elements: int = 48,
    slip_speed: float = 0.0,
) -> Mechanism:
    """Return a wire around a turning drum, one end of which is fixed and the other one pulled.

    The wire, of 2 mm x 2 mm and bent without stress, touches the drum of 0.1 m along an arc of
    `angle` [degrees] with `n_elements`; its ends are straight.  The drum turns at `turning`
    [rad/s], towards the fixed end if positive, so that the tension there is
    ``tension * exp(mu * angle)`` (Euler, Eytelwein), else ``tension * exp(-mu * angle)``.
    The wire can stick, or with a `slip_speed` [m/s] its friction depends on the velocity.

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
            part,
            drum,
            stiffness=stiffness,
            radius=WIRE_RADIUS,
            friction=mu,
            slip_speed=slip_speed or None,
        )
    return Mechanism(
        scene, {"held": lambda run: np.linalg.norm(run.reaction(fixed_end.start), axis=1)}
    )


def belt_drive(
    load: float = 10.0,
    omega: float = 100.0,
    mu: float = 0.3,
    n_elements: int = 120,
) -> Mechanism:
    """Return a belt drive: a driven pulley, a belt, and an equal pulley under load.

    The axis of the belt runs around the pulleys at 0.1 m, whose centres are 0.4 m apart; it has
    E A = 2e4 N and 0.1 kg/m, and is stretched by 1 % at the start.  The driver reaches the angular
    velocity `omega` [rad/s] after 0.1 s, and a moment of `load` [N m] resists the driven pulley
    from 0.15 s on.

    Quantities: ``tight`` and ``slack`` tension of the spans [N]; ``omega_driven``
    [rad/s]; ``loss`` of speed [-]; ``slip_driver`` and ``slip_driven``, arcs where the belt slides
    [degrees].
    """
    scene = Scene((0.0, 0.0))
    centres = np.array([0.0, 0.0]), np.array([CENTRE_DISTANCE, 0.0])
    driver, driven = (
        scene.add_body(mass=1.0, inertia=2e-3, position=centre, name=name)
        for centre, name in zip(centres, ("driver", "driven"), strict=True)
    )
    pins = [scene.pin(pulley.origin) for pulley in (driver, driven)]
    scene.drive_joint(pins[0], SpinUp(-omega, 0.1))
    scene.point_moment(driven.origin, Ramp(load, 0.15, 0.1, smooth=True))
    belt, contacts = _belt(scene, centres, (driver, driven), n_elements, mu)

    def tension(side: float) -> Callable[[Trajectory], Vector]:
        """Mean over the middle half of a span, where other parts of the belt pass."""

        def mean(run: Trajectory) -> Vector:
            forces, positions = [], []
            for part in belt:
                middles = 0.5 * (part.arcs[1:] + part.arcs[:-1])
                forces.append(run.section_force(part, middles).N)
                positions.append(np.stack([run.position(part.at(s)) for s in middles], axis=1))
            x, y = np.moveaxis(np.concatenate(positions, axis=1), 2, 0)
            is_there = (np.abs(x / CENTRE_DISTANCE - 0.5) < 0.25) & (side * y > 0.0)
            return np.asarray(
                np.sum(np.concatenate(forces, axis=1) * is_there, axis=1) / is_there.sum(axis=1)
            )

        return mean

    def compute_speed(run: Trajectory, pulley: RigidBody) -> Vector:
        rim = run.velocity(pulley.at((1.0, 0.0))) - run.velocity(pulley.origin)
        return np.asarray(np.linalg.norm(rim, axis=1))

    def slip_arc(pulley: RigidBody) -> Callable[[Trajectory], Vector]:
        def arc(run: Trajectory) -> Vector:
            length = np.zeros(len(run.t))
            for contact in contacts:
                if contact.on is pulley:
                    force = run.contact_force(contact)
                    limit = SLIDING_FRACTION * mu * force.pressure
                    slides = np.linalg.norm(force.friction, axis=2) > np.maximum(limit, 1e-9)
                    length += slides @ contact.weights
            return np.degrees(length * (1.0 + BELT_STRAIN) / BELT_RADIUS)

        return arc

    watched = {
        "tight": tension(-1.0),
        "slack": tension(1.0),
        "omega_driven": lambda run: compute_speed(run, driven),
        "loss": lambda run: (
            1.0 - compute_speed(run, driven) / np.maximum(compute_speed(run, driver), 1e-9)
        ),
        "slip_driver": slip_arc(driver),
        "slip_driven": slip_arc(driven),
    }
    return Mechanism(scene, watched)


def _belt(
    scene: Scene,
    centres: tuple[Vector, Vector],
    pulleys: tuple[RigidBody, RigidBody],
    n_elements: int,
    mu: float,
) -> tuple[list[Beam], list[Contact]]:
    """Return the upper span, the right arc, the lower span and the left arc, and their contacts."""
    section = Circle(2.0 * WIRE_RADIUS)
    material = Material(BELT_STIFFNESS / section.area, BELT_MASS / section.area)
    up, n_arc, n_span = np.array([0.0, BELT_RADIUS]), n_elements // 3, n_elements // 6
    parts = []
    for here, there, side in ((centres[0], centres[1], up), (centres[1], centres[0], -up)):
        curve = Arc(tuple(there.tolist()), tuple((there + side).tolist()), -math.pi)
        for shape, n, length in (
            ({"start": here + side, "end": there + side}, n_span, CENTRE_DISTANCE),
            ({"curve": curve, "rest": "straight"}, n_arc, math.pi * BELT_RADIUS),
        ):
            length /= 1.0 + BELT_STRAIN
            parts.append(
                scene.add_beam(
                    "thin",
                    **shape,
                    strain="biot",
                    n_elements=n,
                    section=section,
                    material=material,
                    length=length,
                )
            )
    for before, after in zip(parts, [*parts[1:], parts[0]], strict=True):
        scene.connect(before.end, after.start)
    # Tensions fall by E A T / (R^2 k), here .9 N of 200 N: the belt sinks into the pulleys.
    stiffness = 1e4 * BELT_STRAIN * BELT_STIFFNESS / BELT_RADIUS**2
    contacts = []
    for centre, pulley in zip(centres, pulleys, strict=True):
        drum = Drum(tuple(centre.tolist()), BELT_RADIUS - WIRE_RADIUS)
        contacts += [
            scene.contact(part, drum, on=pulley, stiffness=stiffness, friction=mu) for part in parts
        ]
    return parts, contacts


def knot(mu: float = 0.1, radius: float = 0.125, n_elements: int = 110) -> Mechanism:
    """Return a rubber rod in an overhand knot (a trefoil), which its ends tighten.

    The rod has a radius h of 10 mm and a loop of 0.5 m; it comes to rest in 2.4 s, and then its
    ends move apart until, at 16 s, they have taken 2 pi (0.5 m - `radius` [m]) of its length.  For
    ``eps = sqrt(h / R)`` towards zero, with the radius R of the loop, its tension T follows
    ``T h^2 / B = eps^4 / 2 + 0.492 mu eps^3`` (Audoly, Clauvelin and Neukirch, 2007), where B is
    the bending stiffness.

    Quantities: ``tension`` T, the mean of both ends [N]; ``loop`` radius, the length that the knot
    takes over 2 pi [m]; ``pressing``, the sum of normal forces [N].
    """
    check_positive("radius", radius, "m")
    scene = Scene((0.0, 0.0, 0.0))
    rod = scene.add_beam(
        "thin",
        curve=_overhand(LOOP_RADIUS, ROD_RADIUS, ROD_TAIL),
        rest="straight",
        n_elements=n_elements,
        section=Circle(2.0 * ROD_RADIUS),
        material=RUBBER,
        name="rod",
    )
    times = np.linspace(0.0, SETTLING_TIME + TIGHTENING_TIME, N_TIMES)
    progress = np.clip((times - SETTLING_TIME) / TIGHTENING_TIME, 0.0, 1.0)
    displacement = math.pi * LOOP_RADIUS * (1.0 - (radius / LOOP_RADIUS) ** progress)
    for end, sign in ((rod.start, -1.0), (rod.end, 1.0)):
        path = np.array(end.position) + np.outer(sign * displacement, (1.0, 0.0, 0.0))
        scene.drive(end, Table(times, path, smooth=True))
    contact = scene.contact(rod, rod, stiffness=CONTACT_STIFFNESS, friction=mu)

    def loop(run: Trajectory) -> Vector:
        chord = np.linalg.norm(run.position(rod.end) - run.position(rod.start), axis=1)
        return np.asarray((rod.length - chord) / (2.0 * math.pi))

    watched = {
        "tension": lambda run: 0.5 * (run.reaction(rod.end) - run.reaction(rod.start))[:, 0],
        "loop": loop,
        "pressing": lambda run: run.contact_force(contact).size,
    }
    return Mechanism(scene, watched)


def _overhand(loop: float, radius: float, tail: float) -> Vector:
    """Return points of the axis of an overhand knot in space, (k, 3) [m].

    Its ends are along x.  Two strands near the origin wind around each other by three half turns
    between a tail and the loop, the circle that touches the x axis.
    """
    half = BRAID_RATIO * loop
    x = np.linspace(-half, half, 161)
    height = loop - np.sqrt(loop**2 - x**2)  # of the circle
    distance = height + 2.0 * GAP_RATIO * radius * (1.0 - _step(np.abs(x) / half))
    w = np.clip(0.5 + 0.5 * x / (WINDING_RATIO * half), 0.0, 1.0)
    angle = math.pi * (1.0 + 3.0 * w * w * (3.0 - 2.0 * w))
    across = 0.5 * distance * np.stack([np.zeros_like(x), np.cos(angle), np.sin(angle)])
    middle = np.stack([x, 0.5 * height, np.zeros_like(x)])
    first = math.asin(BRAID_RATIO)
    turn = np.linspace(first, 2.0 * math.pi - first, 200)[1:-1]
    circle = loop * np.stack([np.sin(turn), 1.0 - np.cos(turn), np.zeros_like(turn)])
    straight = np.zeros((3, 59))
    straight[0] = np.linspace(-half - tail, -half, 60)[:-1]
    other = np.array([[-1.0], [1.0], [1.0]]) * straight[:, ::-1]
    return np.concatenate([straight, middle + across, circle, middle - across, other], axis=1).T


def _step(s: Vector) -> Vector:
    """Rise from 0 to 1 with two continuous derivatives."""
    return np.asarray(s**3 * (10.0 + s * (6.0 * s - 15.0)))
