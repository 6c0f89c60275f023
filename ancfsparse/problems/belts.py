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
from ancfsparse.problems.mechanism import Mechanism
from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam, Material, Scene, Section, SpinUp
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.force_elements.contacts import Contact
from ancfsparse.scene.force_elements.obstacles import Drum
from ancfsparse.scene.geometry.curves import Arc
from ancfsparse.scene.records.signals import Ramp

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
        Stiffness [N/m2] and coefficient of friction [-] of its contacts.
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

    def section_and_material(self) -> tuple[Section, Material]:
        """Return section and material; only products of modulus, area and inertia matter."""
        area = self.thickness**2
        modulus = self.axial_stiffness / area
        inertia = self.bending_stiffness / modulus
        material = Material(modulus, self.mass / area, axial_damping=self.damping)
        return Section(area, inertia, inertia, inertia), material


# The bending stiffness moves the places where the belt lifts off by sqrt(E I / T): 0.6 mm.
BELT = BeltData(2e4, 5e-5, 0.1, 0.01, 2e-3, 2e9, 0.3)
TOOTHED_BELT = BeltData(1e6, 5e-5, 0.1, 4e-4, 2e-3, 2e9, 1.5)
# The published strain |r'| - 0.95 is 0.95 times the one of a belt without stress at |r'| = 0.95.
PUBLISHED_BELT = BeltData(
    0.95 * 8000.0, 0.02 * 1e7 * 0.08 * 0.01**3 / 12.0, 1036.0 * 0.08 * 0.01 / 0.95,
    1.0 / 0.95 - 1.0, 0.01, 40.0 * 1e8 * 0.08, 0.5, damping=1.0 / 8000.0,
)  # fmt: skip
SERPENTINE_BELT = BeltData(5e4, 5e-5, 0.1, 3e-3, 2e-3, 5e8, 0.6)
# Centre [m], radius [m] and sense of the pulleys, in the order in which a serpentine belt passes.
LAYOUT = {
    "crank": ((0.0, 0.0), 0.08, -1.0),
    "tensioner": ((-0.11, 0.15), 0.035, 1.0),
    "alternator": ((-0.15, 0.32), 0.03, -1.0),
    "pump": ((0.17, 0.28), 0.06, -1.0),
    "idler": ((0.13, 0.13), 0.03, 1.0),
}
PULLEY_MASS = 0.5  # of each [kg]
PIVOT = np.array([-0.16, 0.06])  # of the arm of the tensioner [m]
ARM_STIFFNESS = 30.0  # of its spring [N m/rad]
ARM_MOMENT = 7.0  # of its spring at the start, towards the belt [N m]


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
    pulleys : sequence of Pulley
        Its pulleys in the order in which it runs.
    spans : list of tuple
        Ends of the straight span to each pulley at the start [m].
    parts : list of Beam
        The span to each pulley and the arc around it at the start, from where they run on.
    contacts : list of Contact
        Contacts of all parts with all pulleys.
    """

    data: BeltData
    pulleys: Sequence[Pulley]
    spans: list[tuple[Vector, Vector]]
    parts: list[Beam]
    contacts: list[Contact]

    def forces(self, run: Trajectory) -> Vector:
        """Return the axial forces in the middles of all elements (k, n) [N]."""
        return np.concatenate([_forces(run, part) for part in self.parts], axis=1)

    def tension(self, span: int) -> Callable[[Trajectory], Vector]:
        """Return a function for the mean tension over the middle half of a span [N]."""
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
        """Return a function for the arc of a pulley on which the belt slides [degrees]."""
        contacts = [each for each in self.contacts if each.on is pulley.body]

        def arc(run: Trajectory) -> Vector:
            length = np.zeros(len(run.t))
            for contact in contacts:
                force = run.contact_force(contact)
                limit = SLIDING_FRACTION * contact.friction * force.pressure
                slides = np.linalg.norm(force.friction, axis=2) > np.maximum(limit, 1e-9)
                stretch = 1.0 + _forces(run, contact.bodies[0]) / self.data.axial_stiffness
                length += np.sum(slides * contact.weights * stretch[:, contact.elements], axis=1)
            return np.degrees(length / pulley.radius)

        return arc


def _drive(scene: Scene, radius: float, x: float, load: float, w1: float) -> tuple[Pulley, ...]:
    """Return a driver of a radius [m], and a loaded pulley of 0.1 m at the distance x [m]."""
    driver = _disc(scene, "driver", (0.0, 0.0), radius, 2e-3)
    driven = _disc(scene, "driven", (x, 0.0), 0.1, 2e-3)
    scene.drive_joint(scene.pin(driver.body.origin), SpinUp(-w1, 0.1))
    scene.pin(driven.body.origin)
    scene.point_moment(driven.body.origin, Ramp(load, 0.15, 0.1, smooth=True))
    return driver, driven


def belt_drive(
    load: float = 10.0,
    w1: float = 100.0,
    mu: float = 0.3,
    n_elements: int = 160,
) -> Mechanism:
    """Return a belt drive: a driven pulley, a belt, and an equal pulley under load.

    The axis of the belt runs around the pulleys at 0.1 m, at a distance of 0.4 m; it has
    E A = 2e4 N and 0.1 kg/m, and is stretched by 1 % at the start.  The driver reaches the angular
    velocity `w1` [rad/s] after 0.1 s, and a moment of `load` [N m] resists the driven pulley
    from 0.15 s on.

    Quantities: ``tight`` and ``slack`` tension of the spans [N]; angular velocity ``w2`` of the
    driven pulley [rad/s]; ``speed_loss`` [-]; ``slip_arc_driver`` and ``slip_arc_driven``, where
    the belt slides [degrees].
    """
    scene = Scene((0.0, 0.0))
    driver, driven = _drive(scene, 0.1, 0.4, load, w1)
    belt = _wrap(scene, (driven, driver), replace(BELT, friction=mu), n_elements)
    return _two_pulleys(scene, belt, driver, driven)


def belt_drive_pechstein(n_elements: int = 120, stiffness: float = 3.2e8) -> Mechanism:
    """Return the belt drive of Pechstein and Gerstmayr: pulleys of 0.1 m at a distance of 0.1 pi m.

    Data of Multibody System Dynamics 30, 343 (2013), in the variant of Exudyn's example
    beltDriveReevingSystem with a fiftieth of the bending stiffness and 40 times the stiffness of
    contact: E A = 8000 N for the strain ``|r'| - 0.95``, which gives 400 N at the start, 0.829 kg/m
    of the stretched belt, mu = 0.5, pulleys of 0.25 kg m2.  The driver reaches 12 rad/s after
    0.6 s, here with continuous acceleration and without gravity; a damping of 2 N m s/rad resists
    the driven pulley, and 25 N m from 1.5 s on.  The contact has the `stiffness` [N/m2].

    Quantities: as of `belt_drive`, and ``tension`` in the middles of all elements [N].
    """
    scene = Scene((0.0, 0.0))
    driver = _disc(scene, "driver", (0.0, 0.0), 0.1, 0.25)
    driven = _disc(scene, "driven", (0.1 * math.pi, 0.0), 0.1, 0.25)
    scene.drive_joint(scene.pin(driver.body.origin), SpinUp(-12.0, 0.6))
    scene.joint_spring(scene.pin(driven.body.origin), damping=2.0)
    scene.point_moment(driven.body.origin, Ramp(25.0, 1.5, 1.0, smooth=True))
    data = replace(PUBLISHED_BELT, stiffness=stiffness)
    belt = _wrap(scene, (driven, driver), data, n_elements)
    return _two_pulleys(scene, belt, driver, driven, tension=belt.forces)


def timing_belt(load: float = 20.0, w1: float = 100.0, n_elements: int = 160) -> Mechanism:
    """Return a belt that does not slip, as a model of a timing belt: a drive from 50 to 100 mm.

    The radii are of the axis of the belt, whose E A = 1e6 N and friction of mu = 1.5 let it stick
    nearly everywhere; it has 400 N at the start.  The driver reaches `w1` [rad/s] after 0.1 s;
    `load` [N m] resists the driven pulley from 0.15 s on.  By the torque balance ``tight - slack``
    is `load` / 0.1 m, and the speed ratio is 2, as of the radii, but for the creep.

    Quantities: as of `belt_drive`, and the ``ratio`` of angular velocities [-].
    """
    scene = Scene((0.0, 0.0))
    driver, driven = _drive(scene, 0.05, 0.3, load, w1)
    belt = _wrap(scene, (driven, driver), TOOTHED_BELT, n_elements)

    def ratio(run: Trajectory) -> Vector:
        return driver.angular_velocity(run) / np.maximum(driven.angular_velocity(run), 1e-9)

    return _two_pulleys(scene, belt, driver, driven, ratio=ratio)


def serpentine(
    alternator: float = 2.0, pump: float = 3.0, omega: float = 60.0, n_elements: int = 160
) -> Mechanism:
    """Return the serpentine belt of an engine, with a tensioner arm, around five pulleys.

    The belt, of E A = 5e4 N, runs from the crank over the tensioner, the alternator, the pump and
    an idler, its back on tensioner and idler.  The crank reaches `omega` [rad/s] after 0.1 s;
    moments of `alternator` and `pump` [N m] resist these pulleys from 0.2 s on.  The arm has
    30 N m/rad, a damping of 0.5 N m s/rad, and 7 N m at the start.  By the torque balance the
    tension rises by moment over radius at each load; the arm is in equilibrium with two spans.

    Quantities: ``spans``, tensions in the order of the belt from crank to tensioner to idler to
    crank [N]; ``arm``, rotation of the arm since the start [rad]; ``omegas`` of all pulleys
    [rad/s], beginning with the crank.
    """
    scene = Scene((0.0, 0.0))
    pulleys = {
        name: _disc(scene, name, centre, radius, 0.5 * PULLEY_MASS * radius**2, turn)
        for name, (centre, radius, turn) in LAYOUT.items()
    }
    arm = scene.add_body(mass=0.1, inertia=5e-4, position=PIVOT, name="arm")
    pivot = scene.pin(arm.origin)
    rest = -ARM_MOMENT / ARM_STIFFNESS
    scene.joint_spring(pivot, stiffness=ARM_STIFFNESS, damping=0.5, rest=rest)
    hub = np.array(LAYOUT["tensioner"][0]) - PIVOT
    scene.connect(arm.at(hub), pulleys["tensioner"].body.origin)
    for name in ("alternator", "pump", "idler"):
        scene.pin(pulleys[name].body.origin)
    scene.drive_joint(scene.pin(pulleys["crank"].body.origin), SpinUp(-omega, 0.1))
    for name, moment in (("alternator", alternator), ("pump", pump)):
        scene.point_moment(pulleys[name].body.origin, Ramp(moment, 0.2, 0.1, smooth=True))
    belt = _wrap(scene, list(pulleys.values()), SERPENTINE_BELT, n_elements)

    def rotation(run: Trajectory) -> Vector:
        x, y = (run.position(arm.at(hub)) - PIVOT).T
        return np.asarray(np.arctan2(hub[0] * y - hub[1] * x, hub[0] * x + hub[1] * y))

    watched = {
        "spans": lambda run: np.stack([belt.tension(k)(run) for k in (1, 2, 3, 4, 0)], axis=1),
        "arm": rotation,
        "omegas": lambda run: np.stack([p.angular_velocity(run) for p in belt.pulleys], axis=1),
    }
    return Mechanism(scene, watched, separate=True)


def _disc(
    scene: Scene, name: str, centre: tuple[float, float], radius: float, inertia: float,
    turn: float = -1.0,
) -> Pulley:  # fmt: skip
    """Add a uniform disc with a moment of inertia [kg m2] as a pulley."""
    mass = 2.0 * inertia / radius**2
    return Pulley(
        scene.add_body(mass=mass, inertia=inertia, position=centre, name=name), radius, turn
    )


def _two_pulleys(
    scene: Scene, belt: Belt, driver: Pulley, driven: Pulley, **more: Callable[[Trajectory], Vector]
) -> Mechanism:
    def loss(run: Trajectory) -> Vector:
        rims = [p.radius * p.angular_velocity(run) for p in (driver, driven)]
        return 1.0 - rims[1] / np.maximum(rims[0], 1e-9)

    watched = {
        "tight": belt.tension(1),
        "slack": belt.tension(0),
        "w2": driven.angular_velocity,
        "speed_loss": loss,
        "slip_arc_driver": belt.slip_arc(driver),
        "slip_arc_driven": belt.slip_arc(driven),
        **more,
    }
    return Mechanism(scene, watched, separate=True)


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
    section, material = data.section_and_material()
    parts = [
        scene.add_beam(
            "thin",
            **shape,
            strain="biot",
            n_elements=max(1, round(n_elements * length / total)),
            section=section,
            material=material,
            length=length / (1.0 + data.strain),
        )
        for shape, length in shapes
    ]
    for before, after in zip(parts, [*parts[1:], parts[0]], strict=True):
        scene.connect(before.end, after.start)
    half, contacts = 0.5 * data.thickness, []
    law: Any = {"stiffness": data.stiffness, "radius": half, "friction": data.friction}
    for pulley in pulleys:
        drum = Drum(tuple(pulley.centre.tolist()), pulley.radius - half)
        contacts += [scene.contact(part, drum, on=pulley.body, **law) for part in parts]
    return Belt(data, pulleys, spans, parts, contacts)


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
