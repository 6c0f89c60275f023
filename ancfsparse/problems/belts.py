"""Closed belts around pulleys, with reference values of formulas.

`n_elements` is the number of elements of the belt, nearly equal in length, as all of them pass the
pulleys.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.problems.flexible import SpinUp
from ancfsparse.problems.mechanism import Mechanism
from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam, Material, Scene, Section
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.force_elements.contacts import Contact
from ancfsparse.scene.force_elements.obstacles import Drum
from ancfsparse.scene.geometry.curves import Arc
from ancfsparse.scene.records.signals import Ramp

BELT_RADIUS = 0.1  # of the axis of a belt around a pulley [m]
CENTRE_DISTANCE = 0.4  # of the pulleys [m]
SLIDING_FRACTION = 0.9  # of mu times the pressure, above which a point of a belt slides


@dataclass(frozen=True)
class BeltData:
    """The data of a belt.

    Attributes
    ----------
    axial_stiffness, bending_stiffness : float
        E A [N] and E I [N m2].
    mass : float
        Mass per length without stress [kg/m].
    strain : float
        Uniform strain at the start [-].
    thickness : float
        Twice the distance of the axis from a surface that it touches [m].
    stiffness, friction : float
        Of its contacts [N/m2, -].
    damping : float
        Retardation time of stretching [s].
    """

    axial_stiffness: float
    bending_stiffness: float
    mass: float
    strain: float
    thickness: float
    stiffness: float
    friction: float
    damping: float = 0.0

    @property
    def section(self) -> Section:
        """A section whose area only divides stiffness into modulus and area."""
        area = self.thickness**2
        inertia = self.bending_stiffness / self.axial_stiffness * area
        return Section(area, inertia, inertia, inertia)

    @property
    def material(self) -> Material:
        """The material for this section."""
        area = self.section.area
        return Material(self.axial_stiffness / area, self.mass / area, axial_damping=self.damping)


# The bending stiffness moves the places where the belt lifts off by sqrt(E I / T): 0.6 mm.
BELT = BeltData(2e4, 5e-5, 0.1, 0.01, 2e-3, 2e9, 0.3)
# The published strain |r'| - 0.95 is 0.95 times the one of a belt without stress at |r'| = 0.95.
PUBLISHED_BELT = BeltData(
    0.95 * 8000.0, 0.02 * 1e7 * 0.08 * 0.01**3 / 12.0, 1036.0 * 0.08 * 0.01 / 0.95,
    1.0 / 0.95 - 1.0, 0.01, 40.0 * 1e8 * 0.08, 0.5, damping=1.0 / 8000.0,
)  # fmt: skip


@dataclass(frozen=True)
class Pulley:
    """A pulley of a belt.

    Attributes
    ----------
    body : RigidBody
        The pulley, whose origin is its centre.
    radius : float
        Radius of the axis of the belt around it [m].
    turn : float
        Sense in which the belt runs around it: 1 counterclockwise, -1 clockwise.
    """

    body: RigidBody
    radius: float
    turn: float = -1.0

    @property
    def centre(self) -> Vector:
        """Its centre at the start [m]."""
        return np.asarray(self.body.positions[0])

    def angular_velocity(self, run: Trajectory) -> Vector:
        """Return its angular velocity without sign [rad/s]."""
        rim = run.velocity(self.body.at((1.0, 0.0))) - run.velocity(self.body.origin)
        return np.asarray(np.linalg.norm(rim, axis=1))


@dataclass(frozen=True)
class Belt:
    """A belt in a scene.

    Attributes
    ----------
    data : BeltData
        Its data.
    spans : list of tuple
        Ends of the straight span to each pulley at the start [m].
    parts : list of Beam
        The span to each pulley and the arc around it at the start, from where they run on.
    contacts : list of Contact
        Contacts of all parts with all pulleys.
    """

    data: BeltData
    spans: list[tuple[Vector, Vector]]
    parts: list[Beam]
    contacts: list[Contact]

    def forces(self, run: Trajectory) -> Vector:
        """Return the axial forces in the middles of all elements (k, n) [N]."""
        return np.concatenate([_forces(run, part) for part in self.parts], axis=1)

    def tension(self, span: int) -> Callable[[Trajectory], Vector]:
        """Return the mean over the middle half of a span, where other parts of the belt pass."""
        start, end = self.spans[span]
        length = float(np.linalg.norm(end - start))
        along = (end - start) / length

        def mean(run: Trajectory) -> Vector:
            points = [part.at(s) for part in self.parts for s in _middles(part).tolist()]
            offset = np.stack([run.position(point) for point in points], axis=1) - start
            x = offset @ along
            distance = np.linalg.norm(offset - x[..., None] * along, axis=2)
            is_there = (np.abs(x - 0.5 * length) < 0.25 * length) & (distance < 0.1 * length)
            return np.asarray(np.sum(self.forces(run) * is_there, axis=1) / is_there.sum(axis=1))

        return mean

    def slip_arc(self, pulley: Pulley) -> Callable[[Trajectory], Vector]:
        """Return the arc of a pulley on which the belt slides [degrees]."""
        contacts = [each for each in self.contacts if each.on is pulley.body]

        def arc(run: Trajectory) -> Vector:
            length = np.zeros(len(run.t))
            for contact in contacts:
                force = run.contact_force(contact)
                limit = SLIDING_FRACTION * contact.friction * force.pressure
                slides = np.linalg.norm(force.friction, axis=2) > np.maximum(limit, 1e-9)
                stretch = 1.0 + _forces(run, contact.body) / self.data.axial_stiffness
                lengths = (slides * contact.weights).reshape(*stretch.shape, -1).sum(axis=2)
                length += np.sum(lengths * stretch, axis=1)
            return np.degrees(length / pulley.radius)

        return arc


def belt_drive(
    load: float = 10.0,
    omega: float = 100.0,
    mu: float = 0.3,
    n_elements: int = 160,
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
    driver, driven = _pulleys(scene, (BELT_RADIUS, BELT_RADIUS), CENTRE_DISTANCE, 2e-3)
    scene.drive_joint(scene.pin(driver.body.origin), SpinUp(-omega, 0.1))
    scene.pin(driven.body.origin)
    scene.point_moment(driven.body.origin, Ramp(load, 0.15, 0.1, smooth=True))
    belt = _wrap(scene, (driven, driver), replace(BELT, friction=mu), n_elements)
    return Mechanism(scene, _two_pulleys(belt, driver, driven))


def belt_drive_pechstein(n_elements: int = 120, stiffness: float = 3.2e8) -> Mechanism:
    """Return the belt drive of Pechstein and Gerstmayr: pulleys of 0.1 m at a distance of 0.1 pi m.

    Data of Multibody System Dynamics 30, 343 (2013), in the variant of Exudyn's example
    beltDriveReevingSystem with a fiftieth of the bending stiffness and 40 times the stiffness of
    contact: E A = 8000 N for the strain ``|r'| - 0.95``, so 400 N at the start, 0.829 kg/m,
    mu = 0.5, pulleys of 0.25 kg m2.  The driver reaches 12 rad/s after 0.6 s, here with continuous
    acceleration and without gravity; 2 N m s of damping resists the driven pulley, and 25 N m from
    1.5 s on.  The contact has the `stiffness` [N/m2].

    Quantities: as of `belt_drive`, and ``tension`` in the middles of all elements [N].
    """
    scene = Scene((0.0, 0.0))
    driver, driven = _pulleys(scene, (0.1, 0.1), 0.1 * math.pi, 0.25)
    scene.drive_joint(scene.pin(driver.body.origin), SpinUp(-12.0, 0.6))
    scene.joint_spring(scene.pin(driven.body.origin), damping=2.0)
    scene.point_moment(driven.body.origin, Ramp(25.0, 1.5, 1.0, smooth=True))
    data = replace(PUBLISHED_BELT, stiffness=stiffness)
    belt = _wrap(scene, (driven, driver), data, n_elements)
    return Mechanism(scene, {**_two_pulleys(belt, driver, driven), "tension": belt.forces})


def _pulleys(
    scene: Scene, radii: tuple[float, float], distance: float, inertia: float
) -> tuple[Pulley, Pulley]:
    """Add a driver and a driven pulley, uniform discs, at a distance [m]; inertia in kg m2."""
    driver, driven = (
        Pulley(
            scene.add_body(
                mass=2.0 * inertia / radius**2, inertia=inertia, position=(x, 0.0), name=name
            ),
            radius,
        )
        for x, name, radius in zip((0.0, distance), ("driver", "driven"), radii, strict=True)
    )
    return driver, driven


def _two_pulleys(
    belt: Belt, driver: Pulley, driven: Pulley
) -> dict[str, Callable[[Trajectory], Vector]]:
    ratio = driven.radius / driver.radius
    return {
        "tight": belt.tension(1),
        "slack": belt.tension(0),
        "omega_driven": driven.angular_velocity,
        "loss": lambda run: (
            1.0
            - ratio * driven.angular_velocity(run) / np.maximum(driver.angular_velocity(run), 1e-9)
        ),
        "slip_driver": belt.slip_arc(driver),
        "slip_driven": belt.slip_arc(driven),
    }


def _wrap(scene: Scene, pulleys: Sequence[Pulley], data: BeltData, n_elements: int) -> Belt:
    """Add a closed belt around pulleys, in the order in which it runs.

    It is strained uniformly and does not press yet, and sinks into the pulleys in the first steps.
    """
    spans = _tangents(pulleys)
    shapes: list[tuple[dict[str, Any], float]] = []
    for pulley, (start, end), (leave, _) in zip(
        pulleys, spans, [*spans[1:], spans[0]], strict=True
    ):
        first, last = (
            math.atan2(*(point - pulley.centre)[::-1].tolist()) for point in (end, leave)
        )
        angle = (pulley.turn * (last - first)) % (2.0 * math.pi)
        curve = Arc(tuple(pulley.centre.tolist()), tuple(end.tolist()), pulley.turn * angle)
        shapes += [
            ({"start": start, "end": end}, float(np.linalg.norm(end - start))),
            ({"curve": curve, "rest": "straight"}, pulley.radius * angle),
        ]
    total = sum(length for _, length in shapes)
    parts = [
        scene.add_beam(
            "thin",
            **shape,
            strain="biot",
            n_elements=max(1, round(n_elements * length / total)),
            section=data.section,
            material=data.material,
            length=length / (1.0 + data.strain),
        )
        for shape, length in shapes
    ]
    for before, after in zip(parts, [*parts[1:], parts[0]], strict=True):
        scene.connect(before.end, after.start)
    half = 0.5 * data.thickness
    contacts = [
        scene.contact(
            part,
            Drum(tuple(pulley.centre.tolist()), pulley.radius - half),
            on=pulley.body,
            stiffness=data.stiffness,
            radius=half,
            friction=data.friction,
        )
        for pulley in pulleys
        for part in parts
    ]
    return Belt(data, spans, parts, contacts)


def _tangents(pulleys: Sequence[Pulley]) -> list[tuple[Vector, Vector]]:
    """Return the ends of the straight span to each pulley [m].

    The belt leaves the centre c for ``c - turn * radius * m``, with the normal m to its left.
    """
    spans = []
    for one, two in zip([pulleys[-1], *pulleys[:-1]], pulleys, strict=True):
        offset = two.centre - one.centre
        distance = float(np.linalg.norm(offset))
        sine = (two.turn * two.radius - one.turn * one.radius) / distance
        across = np.array([-offset[1], offset[0]])
        m = (math.sqrt(1.0 - sine**2) * across + sine * offset) / distance
        spans.append(
            (one.centre - one.turn * one.radius * m, two.centre - two.turn * two.radius * m)
        )
    return spans


def _middles(part: Beam) -> Vector:
    return np.asarray(0.5 * (part.arcs[1:] + part.arcs[:-1]))


def _forces(run: Trajectory, part: Any) -> Vector:
    """Return the axial forces in the middles of elements (k, n) [N]."""
    return np.asarray(run.section_force(part, _middles(part)).N)
