"""Cables in contact, with reference values of formulas."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.special import exprel

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_count, check_positive
from ancfsparse.errors import InputError
from ancfsparse.problems.mechanism import GRAVITY, Mechanism
from ancfsparse.results import Trajectory
from ancfsparse.scene import Circle, Material, Rectangle, Scene, Section
from ancfsparse.scene.force_elements.obstacles import Ball, Capsule, Drum
from ancfsparse.scene.geometry.curves import Arc
from ancfsparse.scene.records.signals import Ramp, Table

DRUM_RADIUS = 0.1  # [m]
WIRE_RADIUS = 1e-3  # [m]
TAIL_LENGTH = 0.05  # of the straight ends [m]
TAIL_RATIO = 8.0  # of stiff ends, over the length of decay: the moment falls to 3e-4 of its size
# Damping by mass of a wire with bending stiffness, which springs off the drum until the force acts;
# without it, tensions at 0.3 s still vary by 1 to 7 % [1/s].
WIRE_DAMPING = 200.0
# Bending stiffness in space over the planar one; with 3e-4, tensions of 0.2 N change by 0.5 %.
FLEXIBLE_RATIO = 3e-6
LOAD_TIME = 0.05  # until the force has its full value [s]
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
HEAD_RADIUS = 0.1  # [m]
HAIR_RADIUS = 1.2e-3  # [m]
HAIR_LENGTH = 0.12  # [m]
HAIR_ANGLE = 65.0  # of the outermost roots from the vertical [degrees]
# Rubber; the damping of velocities, as by air, brings the hairs to rest in some tenths of a second.
HAIR_MATERIAL = Material(
    1e6, 1000.0, axial_damping=0.02, bending_damping=0.02, rayleigh=(20.0, 0.0)
)
HEAD_STIFFNESS = 1e5  # of the ball [N/m2]
COMB_STIFFNESS = 4e5  # [N/m2]
HAIR_STIFFNESS = 4e5  # of hairs on each other [N/m2]
COMB_RADIUS = 0.01  # [m]
COMB_HEIGHT = 0.02  # of its axis above the ball [m]
COMB_ANGLE = 100.0  # from the vertical, at the start and at the end [degrees]
FALLING_TIME = 0.4  # until the comb moves [s]
COMBING_TIME = 0.9  # in which it moves [s]


def capstan(
    mu: float = 0.3,
    angle: float = 180.0,
    t1: float = 10.0,
    radius: float = DRUM_RADIUS,
    ei: float = 0.0,
    n_elements: int = 48,
    turning: float = 2.0,
    slip_speed: float = 0.0,
    pitch: float = 0.0,
) -> Mechanism:
    """Return a wire around a turning drum, one end of which is fixed and the other one pulled.

    The wire, 2 mm thick, touches the drum of `radius` [m] along an arc of `angle` [degrees] with
    `n_elements`, and is pulled with `t1` [N]; its ends are straight.  The drum turns at `turning`
    [rad/s], towards the fixed end if positive, so that the tension there is
    ``t1 * exp(mu * angle)`` (Euler, Eytelwein), else ``t1 * exp(-mu * angle)``.
    The wire can stick, or with a `slip_speed` [m/s] its friction depends on the velocity.

    Without `ei` it is bent without stress.  With a bending stiffness `ei` [N m2], in the plane, it
    is straight without stress, and lifts off where ``T (1 - cos(a)) = ei / (2 R^2)``, at the angle
    a before the end of the arc, with the distance R of the axes of wire and drum; there the drum
    presses with the force ``T sin(a)``.

    With a `pitch` [m] of its pulled end, the wire lies in space and has almost no bending
    stiffness.  The surface of the drum moves along circles, so friction has no axial component: the
    axial component of the tension is constant, the one around the drum grows by the factor
    ``exp(mu * angle)``, and the pitch decreases by it.

    Quantities: the tension ``t2`` at the fixed end [N]; its ``ratio`` to `t1` [-];
    ``wrapped_angle`` between the forces at both ends, around the drum [degrees].
    """
    if ei and pitch:
        raise InputError("a capstan has a bending stiffness in the plane only: leave pitch out")
    phi, reach, dim = math.radians(angle), radius + WIRE_RADIUS, 3 if pitch else 2
    growth = math.copysign(mu, turning)
    slope = pitch / (2.0 * math.pi * reach)  # of the pulled end

    def wind(fraction: Vector) -> Vector:
        turned = phi * np.asarray(fraction)
        height = slope * math.exp(-growth * phi) * turned * exprel(growth * turned)
        return reach * np.stack([-np.cos(turned), np.sin(turned), height], axis=-1)[..., :dim]

    start, end = wind(np.array([0.0, 1.0]))
    arriving = _unit((0.0, 1.0, slope * math.exp(-growth * phi))[:dim])
    leaving = _unit((math.sin(phi), math.cos(phi), slope)[:dim])
    scene = Scene((0.0,) * dim)
    square, material = Rectangle(2 * WIRE_RADIUS, 2 * WIRE_RADIUS), Material(2.5e10, 2.5e4)
    section: Rectangle | Section = square
    shape: dict[str, Any] = {"curve": Arc((0.0, 0.0), tuple(start[:2].tolist()), -phi)}
    if ei:
        material = replace(material, rayleigh=(WIRE_DAMPING, 0.0))
    if ei or pitch:
        inertia = ei / material.youngs_modulus if ei else FLEXIBLE_RATIO * square.inertia_z
        section = Section(square.area, inertia, inertia, inertia)
        shape = {"curve": wind, "rest": "straight"}
    # The moment of a wire that lifts off decays along its end over sqrt(ei / t1).
    tail = max(TAIL_LENGTH, TAIL_RATIO * math.sqrt(ei / check_positive("t1", t1, "N")))
    fixed_end = scene.add_beam(
        "thin", start - tail * arriving, start, 8, section, material, name="fixed end"
    )
    arc = scene.add_beam(
        "thin", n_elements=n_elements, section=section, material=material, name="arc", **shape
    )
    pulled_end = scene.add_beam(
        "thin", end, end + tail * leaving, 8, section, material, name="pulled end"
    )
    parts = fixed_end, arc, pulled_end
    for before, after in pairwise(parts):
        if ei:
            scene.weld(before.end, after.start)
        else:
            scene.connect(before.end, after.start)
    scene.pin(fixed_end.start)
    force = Ramp(tuple((t1 * leaving).tolist()), LOAD_TIME, smooth=True)
    scene.point_force(pulled_end.end, force)
    # Penetrations are 1 % of the radius of the wire, at the tighter end up to exp(growth / 2) %.
    stiffness = 100.0 * t1 / (reach * WIRE_RADIUS) * math.exp(0.5 * max(growth * phi, 0.0))
    axis = (0.0, 0.0, 1.0) if pitch else None
    drum = Drum((0.0,) * dim, radius, axis, angular_velocity=-turning)
    for part in parts:
        scene.contact(
            part,
            drum,
            stiffness=stiffness,
            radius=WIRE_RADIUS,
            friction=mu,
            slip_speed=slip_speed or None,
        )

    def tension(run: Trajectory) -> Vector:
        return np.asarray(np.linalg.norm(run.reaction(fixed_end.start), axis=1))

    def wrapped_angle(run: Trajectory) -> Vector:
        x, y = -run.reaction(fixed_end.start)[:, :2].T  # along the wire
        return np.asarray(angle - np.degrees(np.arctan2(x, y)))

    watched = {
        "ratio": lambda run: tension(run) / t1,
        "t2": tension,
        "wrapped_angle": wrapped_angle,
    }
    return Mechanism(scene, watched)


def bristle(mu: float = 0.3, n_elements: int = 100) -> Mechanism:
    """Return a wire around half a drum at rest, one end of which moves to and fro.

    The wire, with E A = 1e5 N and E I = 1e-5 N m2, has `n_elements` on the drum, around which its
    axis has a radius of 0.1 m.  A force of 10 N pulls one end from 0.05 s on.  The other end moves
    outwards by 160 um from 0.1 s to 0.5 s, rests until 0.6 s, and moves back by 280 um until 1.3 s.
    Its tension rises to ``10 N exp(mu pi)`` and keeps this value, and then falls to
    ``10 N exp(-mu pi)``.  Bristles have a stiffness of 1e7 N/m2, a tenth of the contact's.

    Quantities: the tension ``t2`` at the moved end [N].
    """
    scene = Scene((0.0, 0.0))
    area = 4.0 * WIRE_RADIUS**2
    modulus = 1e5 / area
    inertia = 1e-5 / modulus
    wire: Any = {
        "section": Section(area, inertia, inertia, inertia),
        "material": Material(modulus, 0.1 / area, rayleigh=(WIRE_DAMPING, 0.0)),
    }
    left, right = np.array((-DRUM_RADIUS, 0.0)), np.array((DRUM_RADIUS, 0.0))
    down = np.array((0.0, -TAIL_LENGTH))
    curve = Arc((0.0, 0.0), tuple(left.tolist()), -math.pi)
    pulled = scene.add_beam("thin", left + down, left, 8, name="pulled end", **wire)
    arc = scene.add_beam(
        "thin", curve=curve, rest="straight", n_elements=n_elements, name="arc", **wire
    )
    moved = scene.add_beam("thin", right, right + down, 8, name="moved end", **wire)
    for before, after in pairwise((pulled, arc, moved)):
        scene.connect(before.end, after.start)
    scene.point_force(pulled.start, Ramp((0.0, -10.0), LOAD_TIME, smooth=True))
    position = tuple((right + down).tolist())
    out = Ramp((0.0, -160e-6), 0.4, 0.1, smooth=True)
    back = Ramp((0.0, 280e-6), 0.7, 0.6, smooth=True)
    scene.drive(moved.end, out + back + position)
    drum = Drum((0.0, 0.0), DRUM_RADIUS - WIRE_RADIUS)
    for part in (pulled, arc, moved):
        scene.contact(part, drum, stiffness=1e8, radius=WIRE_RADIUS, friction=mu)
    return Mechanism(scene, {"t2": lambda run: -run.reaction(moved.end)[:, 1]}, separate=True)


def _unit(vector: tuple[float, ...]) -> Vector:
    return np.array(vector) / math.hypot(*vector)


def knot(
    mu: float = 0.1,
    slenderness: float = 0.08,
    n_elements: int = 110,
    thickness: float = 2.0 * ROD_RADIUS,
    slowness: float = 1.0,
) -> Mechanism:
    """Return a rubber rod in an overhand knot (a trefoil), which its ends tighten.

    The rod has a radius h of half its `thickness` [m] and a loop of 0.5 m; it comes to rest in
    2.4 s.  Its ends then move apart by 2 pi (0.5 m - h / `slenderness`), up to 16 s.  All times are
    in proportion to 20 mm over the thickness, as bending waves take, and the motion of the ends
    lasts longer by the factor `slowness`.  For
    ``eps = sqrt(h / R)`` towards zero, with the radius R of the loop, its tension T follows
    ``T h^2 / B = eps^4 / 2 + 0.492 mu eps^3`` (Audoly, Clauvelin and Neukirch, 2007), where B is
    the bending stiffness.

    Quantities: ``tension`` T, the mean of both ends [N]; ``radius`` of the loop, the length that
    the knot takes over 2 pi [m]; ``pressing``, the sum of normal forces [N].
    """
    h = 0.5 * check_positive("thickness", thickness, "m")
    radius = h / check_positive("slenderness", slenderness)
    scale = ROD_RADIUS / h  # of times
    settling = scale * SETTLING_TIME
    tightening = scale * TIGHTENING_TIME * check_positive("slowness", slowness)
    scene = Scene((0.0, 0.0, 0.0))
    rod = scene.add_beam(
        "thin",
        curve=_overhand(LOOP_RADIUS, h, ROD_TAIL),
        rest="straight",
        n_elements=n_elements,
        section=Circle(2.0 * h),
        material=replace(RUBBER, rayleigh=(1.0 / scale, 0.0)),
        name="rod",
    )
    times = np.linspace(0.0, settling + tightening, N_TIMES)
    progress = np.clip((times - settling) / tightening, 0.0, 1.0)
    displacement = math.pi * LOOP_RADIUS * (1.0 - (radius / LOOP_RADIUS) ** progress)
    for end, sign in ((rod.start, -1.0), (rod.end, 1.0)):
        path = np.array(end.position) + np.outer(sign * displacement, (1.0, 0.0, 0.0))
        scene.drive(end, Table(times, path, smooth=True))
    contact = scene.contact(rod, rod, stiffness=CONTACT_STIFFNESS / scale**2, friction=mu)

    def loop(run: Trajectory) -> Vector:
        chord = np.linalg.norm(run.position(rod.end) - run.position(rod.start), axis=1)
        return np.asarray((rod.length - chord) / (2.0 * math.pi))

    watched = {
        "tension": lambda run: 0.5 * (run.reaction(rod.end) - run.reaction(rod.start))[:, 0],
        "radius": loop,
        "pressing": lambda run: run.contact_force(contact).size,
    }
    return Mechanism(scene, watched, separate=True)


def hair(n_hairs: int = 48, n_elements: int = 8, mu: float = 0.3) -> Mechanism:
    """Return a ball with hairs that fall over it and are combed to one side.

    The ball has a radius of 0.1 m; the hairs, of soft rubber, 0.12 m long and 2.4 mm thick, are
    clamped in its upper part and stick out radially at the start.  They fall for 0.4 s; then a
    rod of 20 mm, 10 mm above the ball, turns over it and about its centre in 0.9 s.  All contacts
    have friction of bristles with the coefficient `mu`.

    Quantities: ``combed``, the mean displacement of the ends of hairs in the direction of the comb
    [m]; ``moment`` on the comb [N m]; vertical ``force`` of the ball on the hairs [N];
    ``kinetic_energy`` [J]; largest ``penetration`` of hairs into each other over their radius [-].
    """
    scene = Scene((0.0, 0.0, -GRAVITY))
    n = check_count("n_hairs", n_hairs)
    # Points for equal areas, each turned from the one before by the golden angle.
    rank = np.arange(n) + 0.5
    height = 1.0 - (1.0 - math.cos(math.radians(HAIR_ANGLE))) * rank / n
    turn, width = math.pi * (1.0 + math.sqrt(5.0)) * rank, np.sqrt(1.0 - height**2)
    outwards = np.stack([width * np.cos(turn), width * np.sin(turn), height], axis=1)
    nodes = np.concatenate([HEAD_RADIUS * outwards, (HEAD_RADIUS + HAIR_LENGTH) * outwards])
    hairs = scene.add_mesh(
        nodes,
        np.arange(2 * n).reshape(2, n).T,
        "thin",
        Circle(2.0 * HAIR_RADIUS),
        HAIR_MATERIAL,
        n_elements=n_elements,
        name="hairs",
    )
    roots, tips = ([hairs.node(k) for k in each] for each in (range(n), range(n, 2 * n)))
    for root in roots:
        scene.clamp(root)
    comb = scene.add_body(mass=0.01, inertia=1e-5 * np.eye(3), position=np.zeros(3), name="comb")
    hinge = scene.revolute(comb.origin, axis=(0.0, 1.0, 0.0))
    begin, sweep = math.radians(COMB_ANGLE), math.radians(2.0 * COMB_ANGLE)
    times = np.linspace(0.0, FALLING_TIME + COMBING_TIME, N_TIMES)
    progress = _step(np.clip((times - FALLING_TIME) / COMBING_TIME, 0.0, 1.0))
    drive = scene.drive_joint(hinge, Table(times, sweep * progress, smooth=True, outside="hold"))
    middle = (HEAD_RADIUS + COMB_HEIGHT) * np.array([-math.sin(begin), 0.0, math.cos(begin)])
    across = np.array([0.0, HEAD_RADIUS, 0.0])
    rod = Capsule(middle - across, middle + across, COMB_RADIUS)
    ball = Ball((0.0, 0.0, 0.0), HEAD_RADIUS)
    on_ball = scene.contact(hairs, ball, stiffness=HEAD_STIFFNESS, friction=mu)
    scene.contact(hairs, rod, on=comb, stiffness=COMB_STIFFNESS, friction=mu)
    tangle = scene.contact(hairs, hairs, stiffness=HAIR_STIFFNESS, friction=mu)
    start = nodes[n:, 0].mean()

    watched = {
        "combed": lambda run: np.mean([run.position(tip)[:, 0] for tip in tips], axis=0) - start,
        "moment": lambda run: run.joint_force(drive).moment[:, 1],
        "force": lambda run: run.contact_force(on_ball).force[:, 2],
        "kinetic_energy": lambda run: run.energy.kinetic,
        "penetration": lambda run: run.contact_force(tangle).penetration / HAIR_RADIUS,
    }
    return Mechanism(scene, watched, separate=True)


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
