"""Wires around drums: tensions that grow exponentially, sticking, sliding and creep."""

from __future__ import annotations

import itertools
import math

import numpy as np

from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.nonlinear import QuasiNewton
from ancfsparse.problems.contacts import DRUM_RADIUS, WIRE_RADIUS, bristle, capstan
from ancfsparse.scene import Beam, Material, Point, Ramp, Rectangle, Scene
from ancfsparse.scene.force_elements.obstacles import Drum
from ancfsparse.scene.geometry.curves import Arc
from ancfsparse.solve import simulate
from benchmarks.contact.references.comparison import (
    Comparison,
    compare_relative,
    limit_above,
    limit_below,
)

FRICTIONS = (0.1, 0.3, 0.5)  # coefficients [-]
ANGLES = (90.0, 180.0, 540.0)  # of the arcs [degrees]
BENDING_STIFFNESSES = (1e-3, 4e-3)  # [N m2]
TENSION = 10.0  # at the pulled end [N]
ARC_ELEMENTS = 96  # on half a turn: the moment where a wire lifts off decays within 5 degrees
T_END = 0.3  # [s]
DT = 1e-3  # [s]
MEAN_STEPS = 100  # at the end of a run, since waves run along the wire
EULER_TOLERANCE = 1e-3  # of a ratio of tensions [-]
REACH = DRUM_RADIUS + WIRE_RADIUS  # of the axis of the wire [m]
STICKING_LOADS = (0.9, 0.98)  # over exp(mu phi)
SLIDING_LOADS = (1.02, 1.05)  # over exp(mu phi)
LOAD_TIME = 0.2  # [s]
REST_TIME = 1.0  # until a wire that sticks rests [s]
STICKING_TIME = 10.0  # after this [s]
SLIDING_TIME = 1.5  # the free end of 5 cm has then slid onto the drum, or a part of it [s]
MAX_STICKING = 1e-8  # displacement of an end that sticks [m]
MIN_SLIDING = 0.01  # displacement of an end that slides [m]
SLIP_SPEED = 1e-3  # [m/s]
CREEP_LOAD = 15.0 / 9.81  # ratio of tensions [-]
CREEP = 0.504698e-3  # by the law with this ratio, mu = 0.3 and half a turn [m/s]
PULLED_TENSION = 25.6633  # 10 exp(0.3 pi) [N]
RELEASED_TENSION = 3.8966  # 10 exp(-0.3 pi) [N]
DAMPED = GeneralizedAlpha(0.5)


def compare_capstans() -> list[Comparison]:
    """Compare wires without bending stiffness with Euler and Eytelwein."""
    return [
        compare_relative(
            f"capstan, mu {mu:g}, {angle:g} degrees: T2/T1",
            _run_capstan(mu, angle)[0],
            math.exp(mu * math.radians(angle)),
            EULER_TOLERANCE,
        )
        for mu, angle in itertools.product(FRICTIONS, ANGLES)
    ]


def compare_stiff_capstans() -> list[Comparison]:
    """Compare wires with bending stiffness, which lift off before the ends of the arc."""
    rows = []
    for ei, mu, angle in itertools.product(BENDING_STIFFNESSES, FRICTIONS, ANGLES):
        ratio, wrapped = _run_capstan(mu, angle, ei)
        rows.append(
            compare_relative(
                f"capstan, EI {ei:g} N m2, mu {mu:g}, {angle:g} degrees: T2/T1",
                ratio,
                lift_off_ratio(mu, math.radians(wrapped), ei),
                EULER_TOLERANCE,
            )
        )
    return rows


def _run_capstan(mu: float, angle: float, ei: float = 0.0) -> tuple[float, float]:
    """Return the ratio of tensions [-] and the angle between the forces at both ends [degrees]."""
    n_elements = round(angle / 180.0 * ARC_ELEMENTS)
    case = capstan(mu, angle, TENSION, ei=ei, n_elements=n_elements)
    solver = QuasiNewton("broyden", memory=20, max_iterations=60)
    values = case.quantities(simulate(case.scene, T_END, DT, integrator=DAMPED, solver=solver))
    return float(values["ratio"][-MEAN_STEPS:].mean()), float(values["wrapped_angle"][-1])


def lift_off_ratio(mu: float, angle: float, ei: float, radius: float = REACH) -> float:
    """Return T2/T1 of a stiff wire, for the angle between the forces at both ends [rad].

    It lifts off where T (1 - cos a) = EI / (2 R^2), and presses there with the force T sin a.
    """
    ratio = math.exp(mu * angle)
    first = math.acos(1.0 - ei / (2.0 * TENSION * radius**2))
    for _ in range(100):
        last = math.acos(1.0 - ei / (2.0 * TENSION * ratio * radius**2))
        grown = (math.cos(first) + mu * math.sin(first)) * math.exp(mu * (angle - first - last))
        ratio = grown / (math.cos(last) - mu * math.sin(last))
    return ratio


def compare_loads() -> list[Comparison]:
    """Compare loads below and above exp(mu phi) on a drum at rest: a wire sticks or slides."""
    rows = []
    for mu, load in itertools.product(FRICTIONS, STICKING_LOADS):
        moved = _displacements(mu, load, REST_TIME + STICKING_TIME, REST_TIME)
        name = f"wire with {load:g} exp(mu phi), mu {mu:g}: motion of its end in 10 s [m]"
        rows.append(limit_above(name, moved, MAX_STICKING))
    for mu, load in itertools.product(FRICTIONS, SLIDING_LOADS):
        moved = _displacements(mu, load, SLIDING_TIME, 0.0)
        name = f"wire with {load:g} exp(mu phi), mu {mu:g}: motion of its end in 1.5 s [m]"
        rows.append(limit_below(name, moved, MIN_SLIDING))
    return rows


def _displacements(mu: float, load: float, t_end: float, begin: float) -> float:
    """Return the largest distance of the loaded end from its last position since a time [m]."""
    scene, end = _load_wire(load * math.exp(mu * math.pi), mu)
    run = simulate(scene, t_end, DT, integrator=DAMPED, save_every=100)
    sizes = np.linalg.norm(run.displacement(end)[run.t >= begin - 0.5 * DT], axis=1)
    return float(np.abs(sizes - sizes[-1]).max())


def _load_wire(ratio: float, mu: float, slip_speed: float | None = None) -> tuple[Scene, Point]:
    """Return a wire over half a drum, pulled with 10 N and `ratio` times this, and that end."""
    scene = Scene((0.0, 0.0))
    section, material = Rectangle(2 * WIRE_RADIUS, 2 * WIRE_RADIUS), Material(2.5e10, 2.5e4)
    curve = Arc((0.0, 0.0), (-REACH, 0.0), -math.pi)
    arc = scene.add_beam("thin", curve=curve, n_elements=50, section=section, material=material)
    ends: list[Beam] = []
    for x, joint, force in ((-REACH, arc.start, TENSION), (REACH, arc.end, ratio * TENSION)):
        end = scene.add_beam("thin", (x, 0.0), (x, -0.05), 4, section, material)
        scene.connect(joint, end.start)
        scene.point_force(end.end, Ramp((0.0, -force), LOAD_TIME, smooth=True))
        ends.append(end)
    stiffness = 100.0 * TENSION / (REACH * WIRE_RADIUS) * math.exp(0.5 * mu * math.pi)
    for part in (arc, *ends):
        scene.contact(
            part,
            Drum((0.0, 0.0), DRUM_RADIUS),
            stiffness=stiffness,
            radius=WIRE_RADIUS,
            friction=mu,
            slip_speed=slip_speed,
        )
    return scene, ends[1].end


def compare_creep() -> list[Comparison]:
    """Compare the creep of regularized friction, v_s s / sqrt(1 - s^2), s = ln(T2/T1)/(mu phi)."""
    scene, end = _load_wire(CREEP_LOAD, 0.3, SLIP_SPEED)
    run = simulate(scene, 1.0, DT, integrator=DAMPED)
    creep = -run.velocity(end)[-2 * MEAN_STEPS :, 1].mean()
    return [compare_relative("creep with a slip speed of 1 mm/s [m/s]", creep, CREEP, 1e-3)]


def compare_reversal() -> list[Comparison]:
    """Compare a wire on bristles whose end moves to and fro."""
    case = bristle()
    tension = case.quantities(simulate(case.scene, 1.4, DT, integrator=DAMPED))["t2"]
    rest = tension[520:600]
    change = np.abs(np.diff(rest)).max()
    return [
        compare_relative("reversed wire, pulled: tension [N]", rest[-1], PULLED_TENSION, 1e-3),
        limit_above("reversed wire, end at rest: change per step [N]", change, 1e-6),
        compare_relative(
            "reversed wire, let back: tension [N]", tension[-1], RELEASED_TENSION, 1e-3
        ),
    ]
