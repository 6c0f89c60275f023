"""Cables that fall, slide, lie and run on obstacles and on each other, with values of formulas."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_count, check_positive
from ancfsparse.problems.flexible import add_cable, cable
from ancfsparse.problems.mechanism import GRAVITY, Mechanism
from ancfsparse.results import Trajectory
from ancfsparse.scene import Circle, Material, Rectangle, Scene
from ancfsparse.scene.force_elements.contacts import LAYER_RATIO
from ancfsparse.scene.force_elements.obstacles import Ball, Drum, HalfSpace
from ancfsparse.scene.geometry.curves import Arc

FLOOR = HalfSpace((0.0, 0.0), (0.0, 1.0))
CABLE_RADIUS = 5e-3  # half the side of the section of `CABLE` [m]
BLOCK_SECTION = Circle(0.02)
BLOCK_MATERIAL = Material(2e11, 7800.0)
# Cylinders below the cantilever of Exudyn's test: centres and radii [m].
CYLINDERS = ((0.5, -0.15), 0.1), ((1.5, -0.5), 0.2)
CHAIN_MASS = 0.1  # of the chain over a pulley [kg/m]
START_TIME = 0.06  # in which the acceleration of the chain rises [s]
NET_SECTION = Circle(4e-3)
# Rubber, whose rates of strain and velocities are damped so that the net comes to rest in seconds.
NET_MATERIAL = Material(1e6, 1000.0, axial_damping=0.02, rayleigh=(5.0, 0.0))
LAYER_GAP = 2e-3  # between the layers of a pile at the start [m]
SCATTER = 4e-3  # of the ends of cables along that width [m]
PILE_ELEMENT = 8.0 * CABLE_RADIUS  # length [m]
# Rubber, with damping that brings the pile to rest in some tenths of a second.
PILE_MATERIAL = Material(1e7, 1000.0, axial_damping=0.02, bending_damping=0.02, rayleigh=(5.0, 0.0))
N_LOADS = 8  # forces along the cantilever in Exudyn's test, one at the end of each of its cables


def cable_drop(stiffness: float = 1e5, height: float = 0.5, n_elements: int = 4) -> Mechanism:
    """Return a level cable of 2 m that falls flat onto a floor from `height` [m].

    It has the section and material of `pendulum`, and the floor the `stiffness` [N/m2].

    Quantities: ``height`` of the lower surface above the floor [m]; ``energy_lost`` since the start
    [J].
    """
    scene = Scene((0.0, -GRAVITY))
    level = check_positive("height", height) + CABLE_RADIUS
    rod = add_cable(scene, "cable", (0.0, level), (2.0, level), n_elements)
    scene.contact(rod, FLOOR, stiffness=stiffness, radius=CABLE_RADIUS)
    watched = {
        "height": lambda run: run.position(rod.at(1.0))[:, 1] - CABLE_RADIUS,
        "energy_lost": lambda run: run.energy.total[0] - run.energy.total,
    }
    return Mechanism(scene, watched)


def sliding_block(
    mu: float = 0.3, speed: float = 3.0, slip_speed: float = 1e-2, n_elements: int = 2
) -> Mechanism:
    """Return a steel bar of 0.2 m that slides along a floor with an initial `speed` [m/s].

    Coulomb's law stops it after ``speed^2 / (2 mu g)``.  The friction
    ``mu p u / sqrt(u^2 + slip_speed^2)`` takes the distance
    ``(speed sqrt(speed^2 + slip_speed^2) + slip_speed^2 asinh(speed / slip_speed)) / (2 mu g)``,
    with the default `slip_speed` [m/s] 8e-5 of it more, and the bar creeps at the end.

    Quantities: ``distance`` since the start [m]; ``speed`` [m/s].
    """
    scene = Scene((0.0, -GRAVITY))
    radius = 0.5 * BLOCK_SECTION.diameter
    # It sinks in by half a percent of its radius, and by half of the layer where pressure begins.
    weight = BLOCK_SECTION.area * BLOCK_MATERIAL.density * GRAVITY
    stiffness = 200.0 * weight / radius
    level = radius - weight / stiffness - 0.5 * LAYER_RATIO * radius
    bar = scene.add_beam(
        "thin", (0.0, level), (0.2, level), n_elements, BLOCK_SECTION, BLOCK_MATERIAL,
        velocity=(speed, 0.0), name="bar",
    )  # fmt: skip
    slip = slip_speed if mu else None
    scene.contact(bar, FLOOR, stiffness=stiffness, friction=mu, slip_speed=slip)
    watched = {
        "distance": lambda run: run.position(bar.start)[:, 0],
        "speed": lambda run: run.velocity(bar.start)[:, 0],
    }
    return Mechanism(scene, watched)


def cantilever_on_cylinders(n_elements: int = 256) -> Mechanism:
    """Return a cantilever of 2 m that is bent over two cylinders by forces along it.

    After Exudyn's test ANCFcontactCircleTest: 1 mm x 1 mm, 2.07e11 Pa and 7800 kg/m3; each eighth
    of the length has the load of 80 m/s2, half of it at either end.  The cylinders have no
    friction.  It starts in equilibrium.

    Quantities: ``tip`` [m]; ``forces`` of the cylinders of 0.1 m and 0.2 m on it [N].
    """
    scene = Scene((0.0, 0.0))
    section, material = Rectangle(1e-3, 1e-3), Material(2.07e11, 7800.0)
    n = N_LOADS * math.ceil(check_count("n_elements", n_elements) / N_LOADS)
    rod = add_cable(scene, "cantilever", (0, 0), (2, 0), n, (section, material))
    scene.clamp(rod.start)
    load = 80.0 * material.density * section.area * rod.length / N_LOADS
    for i in range(1, N_LOADS + 1):
        size = 0.5 * load if i == N_LOADS else load
        scene.point_force(rod.at(i * rod.length / N_LOADS), (0.0, -size))
    # In the test the axis touches the cylinders: they are thinner here by the radius of the cable.
    radius = 0.5e-3
    contacts = [
        scene.contact(rod, Drum(centre, outer - radius), stiffness=1e6, radius=radius)
        for centre, outer in CYLINDERS
    ]
    watched = {
        "tip": lambda run: run.position(rod.end),
        "forces": lambda run: np.stack(
            [np.linalg.norm(run.contact_force(each).force, axis=-1) for each in contacts], axis=-1
        ),
    }
    return Mechanism(scene, watched, settles=True)


def chain_over_pulley(
    acceleration: float = GRAVITY,
    free_length: float = 1.0,
    radius: float = 0.1,
    n_elements: int = 20,
) -> Mechanism:
    """Return a chain that is pulled over a pulley without friction until it lifts off.

    After Brun, Audoly, Goriely and Vella (arXiv 1605.03714).  It has 0.1 kg/m, E A = 1e4 N and
    hardly any bending stiffness, and `n_elements` on the half of the pulley of `radius` [m] that it
    touches; the free side hangs with the `free_length` l0 [m].  The acceleration a of the pulled
    end rises within 0.06 s, with the same velocities from then on as if it had its full value from
    0.03 s on.  Counted from there, the pulley bears
    ``2 rho ((l0 - a t^2 / 2) (g + a) - (a t)^2) + pi rho radius (g + a)`` until the pressure where
    the chain arrives vanishes, at ``sqrt(2 l0 (g + a) / (a (3 a + g)))``.

    Quantities: vertical ``force`` on the pulley [N]; ``speed`` of the free end [m/s];
    ``lift_off_time``, since 0.03 s, when the force has fallen to its last term [s], and the
    ``speed_at_lift_off`` [m/s], both zero until then.
    """
    scene = Scene((0.0, -GRAVITY))
    section, material = cable(1e4, 1e-8, CHAIN_MASS)
    damped = replace(material, axial_damping=1e-3)
    spacing = math.pi * check_positive("radius", radius) / check_count("n_elements", n_elements, 8)
    # The rise of the acceleration takes a 40th of a START_TIME^2 more than the parabola.
    side_length = check_positive("free_length", free_length, "m") + (
        acceleration * START_TIME**2 / 40.0
    )
    shapes: tuple[dict[str, Any], ...] = (
        {"start": (-radius, -side_length), "end": (-radius, 0.0)},
        {"curve": Arc((0.0, 0.0), (-radius, 0.0), -math.pi), "rest": "straight"},
        {"start": (radius, 0.0), "end": (radius, -radius)},
    )
    counts = math.ceil(side_length / spacing), n_elements, math.ceil(radius / spacing)
    parts = [
        scene.add_beam("thin", **shape, n_elements=n, section=section, material=damped)
        for shape, n in zip(shapes, counts, strict=True)
    ]
    for before, after in pairwise(parts):
        scene.connect(before.end, after.start)

    def displace(t: float) -> tuple[float, float]:
        """Integrate the acceleration a (3 x^2 - 2 x^3) of the rise twice."""
        x, late = min(t / START_TIME, 1.0), max(t - START_TIME, 0.0)
        begun = START_TIME**2 * (x**4 / 4.0 - x**5 / 10.0)
        return radius, -radius - acceleration * (begun + 0.5 * late * (START_TIME + late))

    scene.drive(parts[-1].end, displace)
    # The chain sinks in by up to 1e-4 of the radius, at the tension when it has started.
    stiffness = 1e4 * CHAIN_MASS * (GRAVITY + acceleration) / radius**2
    thickness = 0.01 * radius
    pulley = Drum((0.0, 0.0), radius - thickness)
    contacts = [
        scene.contact(part, pulley, stiffness=stiffness, radius=thickness) for part in parts
    ]

    def force(run: Trajectory) -> Vector:
        return np.asarray(sum(run.contact_force(each).force[..., 1] for each in contacts))

    def speed(run: Trajectory) -> Vector:
        return np.asarray(np.linalg.norm(run.velocity(parts[0].start), axis=-1))

    def at_lift_off(run: Trajectory, values: Vector) -> Vector:
        """Return a value at the lift-off for all states after it, and zero for those before."""
        rest = force(run) - math.pi * CHAIN_MASS * radius * (GRAVITY + acceleration)
        k = int(np.argmax(rest <= 0.0))
        if rest[k] > 0.0 or k == 0:
            return np.zeros(len(values))
        fraction = rest[k - 1] / (rest[k - 1] - rest[k])
        value = values[k - 1] + fraction * (values[k] - values[k - 1])
        return np.where(np.arange(len(values)) < k, 0.0, value)

    watched = {
        "force": force,
        "speed": speed,
        "lift_off_time": lambda run: at_lift_off(run, run.t - 0.5 * START_TIME),
        "speed_at_lift_off": lambda run: at_lift_off(run, speed(run)),
    }
    return Mechanism(scene, watched, settles=True)


def net_on_sphere(n: int = 12, mu: float = 0.4, slip_speed: float = 1e-2) -> Mechanism:
    """Return a square net of rubber strings, 1.6 m wide, that falls by 1 cm on a ball of 0.4 m.

    The net has `n` meshes along a side, strings of 4 mm, 1e6 Pa and 1000 kg/m3, and friction with
    the ball; in the end the ball bears its weight.

    Quantities: vertical ``force`` on the ball [N]; ``kinetic_energy`` [J];
    ``largest_penetration`` of strings into the ball over their radius, by their pressure [-];
    ``real_time_factor``, the simulated time over the wall-clock time of the run [-].
    """
    scene = Scene((0.0, 0.0, -GRAVITY))
    side = 1.6
    number = np.arange((check_count("n", n, 2) + 1) ** 2).reshape(n + 1, n + 1)
    edges = np.concatenate(
        [np.stack([one.ravel(), other.ravel()], axis=1) for one, other in (
            (number[:-1], number[1:]), (number[:, :-1], number[:, 1:]))]
    )  # fmt: skip
    x, y = np.stack(np.divmod(number.ravel(), n + 1)) * (side / n) - 0.5 * side
    nodes = np.stack([x, y, 0.0 * x + 0.4 + 2e-3 + 0.01], axis=1)
    net = scene.add_mesh(nodes, edges, "string", NET_SECTION, NET_MATERIAL, name="net")
    # The net sinks in by some percent of its radius where it hangs over the ball.
    stiffness = 2e6 * NET_SECTION.area * NET_MATERIAL.density
    slip, ball = slip_speed if mu else None, Ball((0.0, 0.0, 0.0), 0.4)
    contact = scene.contact(net, ball, stiffness=stiffness, friction=mu, slip_speed=slip)
    radius = 0.5 * NET_SECTION.diameter

    def largest_penetration(run: Trajectory) -> Vector:
        depth = run.contact_force(contact).pressure.max(axis=-1) / stiffness
        return np.where(depth > 0.0, depth / radius + 0.5 * LAYER_RATIO, 0.0)

    watched = {
        "force": lambda run: run.contact_force(contact).force[..., 2],
        "kinetic_energy": lambda run: run.energy.kinetic,
        "largest_penetration": largest_penetration,
        "real_time_factor": _real_time_factor,
    }
    return Mechanism(scene, watched, measured=("real_time_factor",))


def pile(
    n_cables: int = 20,
    length: float = 0.4,
    mu: float = 0.3,
    slip_speed: float = 0.0,
    stiffness: float = 1e7,
    cables_in_layer: int = 5,
    width: float = 0.3,
) -> Mechanism:
    """Return crossed layers of rubber cables that fall onto a floor and form a pile.

    The cables have a `length` [m], a diameter of 10 mm and elements of 40 mm.  A layer has
    `cables_in_layer` of them, at equal distances across its `width` [m], each end displaced by up
    to 4 mm.  Their
    contacts have the `stiffness` [N/m2], and a tenth of it on the floor.  Friction is by bristles
    unless a `slip_speed` [m/s] is given.

    Quantities: vertical ``force`` on the floor [N]; ``kinetic_energy`` [J]; largest ``speed`` of a
    node [m/s]; ``largest_penetration`` of cables over their radius [-]; ``real_time_factor``, the
    simulated time over the wall-clock time of the run [-].
    """
    scene = Scene((0.0, 0.0, -GRAVITY))
    n = check_count("n_cables", n_cables)
    layer, rank = np.divmod(np.arange(n), check_count("cables_in_layer", cables_in_layer, 2))
    scatter = SCATTER * np.random.default_rng(1).uniform(-1.0, 1.0, (n, 2))
    n_elements = max(1, round(check_positive("length", length, "m") / PILE_ELEMENT))
    along = 0.5 * length
    across = (rank / (cables_in_layer - 1) - 0.5)[:, None] * width + scatter
    height = CABLE_RADIUS + LAYER_GAP + layer * (2.0 * CABLE_RADIUS + LAYER_GAP)
    nodes = np.empty((n, 2, 3))
    nodes[:, :, 0], nodes[:, :, 1], nodes[:, :, 2] = (-along, along), across, height[:, None]
    nodes[layer % 2 == 1] = nodes[layer % 2 == 1][:, :, [1, 0, 2]]
    edges = np.arange(2 * n).reshape(n, 2)
    cables = scene.add_mesh(
        nodes.reshape(-1, 3),
        edges,
        "thin",
        Circle(2.0 * CABLE_RADIUS),
        PILE_MATERIAL,
        n_elements=n_elements,
        name="cables",
    )
    floor = scene.contact(
        cables,
        HalfSpace((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        stiffness=0.1 * stiffness,
        friction=mu,
        slip_speed=slip_speed or None,
    )
    contact = scene.contact(
        cables, cables, stiffness=stiffness, friction=mu, slip_speed=slip_speed or None
    )
    watched = {
        "force": lambda run: run.contact_force(floor).force[:, 2],
        "kinetic_energy": lambda run: run.energy.kinetic,
        "speed": lambda run: np.linalg.norm(run.v[:, run.system.vectors("r")[0]], axis=-1).max(
            axis=-1
        ),
        "largest_penetration": lambda run: run.contact_force(contact).penetration / CABLE_RADIUS,
        "real_time_factor": _real_time_factor,
    }
    return Mechanism(scene, watched, measured=("real_time_factor",))


def _real_time_factor(run: Trajectory) -> Vector:
    """Return the simulated time over the wall-clock time of its steps, for all states."""
    duration = float(run.t[-1] - run.t[0])
    return np.full(len(run.t), duration / run.stats.march_seconds)
