"""Random scenes with the default stiffness: penetrations of at most 1 % of the radius."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ancfsparse.errors import AncfError
from ancfsparse.integrators import EnergyMomentum, GeneralizedAlpha
from ancfsparse.scene import Beam, Circle, Material, Scene
from ancfsparse.scene.force_elements.beam_contacts import BeamContact
from ancfsparse.scene.force_elements.obstacles import Ball, Drum, HalfSpace
from ancfsparse.solve import simulate
from benchmarks.contact.references.comparison import NO_VALUE, Comparison, limit_above

SEED = 5
N_SCENES = 20  # of each kind
T_END = 0.4  # [s]
STEPS = (1e-3, 2.5e-4)  # [s]
MAX_PENETRATION = 0.01  # over the radius
OBSTACLE_RADIUS = 0.1  # of drums and balls [m]
INTEGRATORS = (GeneralizedAlpha(0.9), GeneralizedAlpha(0.5), EnergyMomentum())
Random = np.random.Generator


def compare_penetrations() -> list[Comparison]:
    """Compare the largest penetration in random scenes of each kind with 1 % of the radius."""
    rng, rows = np.random.default_rng(SEED), []
    for name, build in KINDS.items():
        depths = [_run(build, rng) for _ in range(N_SCENES)]
        quantity = f"{N_SCENES} random scenes, {name}: largest penetration, over the radius"
        rows.append(limit_above(quantity, float(np.max(depths)), MAX_PENETRATION))
    return rows


def _run(build: Callable[..., Scene], rng: Random) -> float:
    """Return the largest penetration of a run over the radius."""
    radius, modulus = (float(10.0 ** rng.uniform(*exponents)) for exponents in ((-3, -2), (6, 10)))
    line = {"section": Circle(2.0 * radius), "material": Material(modulus, 2e3)}
    gap, friction = float(rng.uniform(0.01, 0.4)), float(rng.choice([0.0, 0.3]))
    integrator, dt = INTEGRATORS[rng.integers(len(INTEGRATORS))], float(rng.choice(STEPS))
    scene = build(rng, radius, gap, friction, line)
    try:
        run = simulate(scene, T_END, dt, integrator=integrator)
    except AncfError:
        return NO_VALUE
    contact: Any = scene.attachments[0]
    if isinstance(contact, BeamContact):
        return float(run.contact_force(contact).penetration.max()) / radius
    distances = [contact.obstacle.distances(run.position(p)).min() for p in contact.points]
    return 1.0 - float(min(distances)) / radius


def _fall(rng: Random, radius: float, gap: float, friction: float, line: Any) -> Scene:
    return _fall_on_floor(0.0, radius, gap, friction, line)


def _tilt(rng: Random, radius: float, gap: float, friction: float, line: Any) -> Scene:
    return _fall_on_floor(float(rng.uniform(0.1, 1.2)), radius, gap, friction, line)


def _fall_on_floor(angle: float, radius: float, gap: float, friction: float, line: Any) -> Scene:
    scene, height = Scene((0.0, -9.81)), radius + gap
    ends = (0.0, height), (math.cos(angle), height + math.sin(angle))
    cable = scene.add_beam("thin", *ends, 40, **line)
    scene.contact(cable, HalfSpace((0.0, 0.0), (0.0, 1.0)), friction=friction)
    return scene


def _add_level(scene: Scene, height: float, line: Any) -> Beam:
    return scene.add_beam("thin", (-0.5, height), (0.5, height), 40, **line)


def _drape(rng: Random, radius: float, gap: float, friction: float, line: Any) -> Scene:
    scene = Scene((0.0, -9.81))
    cable = _add_level(scene, OBSTACLE_RADIUS + radius + gap, line)
    obstacle = (Drum, Ball)[rng.integers(2)]
    base = float(rng.uniform(-0.3, 0.3)), 0.0
    scene.contact(cable, obstacle(base, OBSTACLE_RADIUS), friction=friction)
    return scene


def _turn(rng: Random, radius: float, gap: float, friction: float, line: Any) -> Scene:
    scene = Scene((0.0, -9.81))
    cable = _add_level(scene, OBSTACLE_RADIUS + radius + 0.01, line)
    speed = float(rng.uniform(-20.0, 20.0))  # rad/s
    drum = Drum((0.0, 0.0), OBSTACLE_RADIUS, angular_velocity=speed)
    scene.contact(cable, drum, friction=0.3)
    return scene


def _cross(rng: Random, radius: float, gap: float, friction: float, line: Any) -> Scene:
    scene, height = Scene((0.0, 0.0, -9.81)), 2.0 * radius + gap
    lower = scene.add_beam("thin", (-0.5, 0.0, 0.0), (0.5, 0.0, 0.0), 20, **line)
    scene.clamp(lower.start)
    scene.clamp(lower.end)
    upper = scene.add_beam("thin", (0.05, -0.4, height), (0.1, 0.4, height), 20, **line)
    scene.contact(lower, upper, friction=friction)
    return scene


KINDS: dict[str, Callable[..., Scene]] = {
    "level falls on a floor": _fall,
    "tilted falls on a floor": _tilt,
    "falls on a drum or a ball": _drape,
    "falls on a turning drum": _turn,
    "falls on another cable": _cross,
}
"""Functions that build a random scene."""
