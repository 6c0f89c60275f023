"""Cables that fall, slide, lie and run on fixed obstacles, with reference values of formulas."""

from __future__ import annotations

import math

import numpy as np

from ancfsparse.checks import check_count, check_positive
from ancfsparse.problems.flexible import add_cable
from ancfsparse.problems.mechanism import GRAVITY, Mechanism
from ancfsparse.scene import Circle, Material, Rectangle, Scene
from ancfsparse.scene.force_elements.contacts import LAYER_RATIO
from ancfsparse.scene.force_elements.obstacles import Drum, HalfSpace

FLOOR = HalfSpace((0.0, 0.0), (0.0, 1.0))
CABLE_RADIUS = 5e-3  # half the side of the section of `CABLE` [m]
BLOCK_SECTION = Circle(0.02)
BLOCK_MATERIAL = Material(2e11, 7800.0)
# Cylinders below the cantilever of Exudyn's test: centres and radii [m].
CYLINDERS = ((0.5, -0.15), 0.1), ((1.5, -0.5), 0.2)
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
    scene.contact(bar, FLOOR, stiffness=stiffness, friction=mu, slip_speed=slip_speed)
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
