"""Level falls, impacts with a restitution, and cables that rub: energies and momenta."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import AncfError
from ancfsparse.integrators import (
    HHT,
    CentralDifference,
    DormandPrince,
    EnergyMomentum,
    Explicit,
    GeneralizedAlpha,
    Implicit,
    Newmark,
    RungeKuttaNystrom,
)
from ancfsparse.results import Trajectory
from ancfsparse.scene import Circle, Material, Scene
from ancfsparse.scene.force_elements.obstacles import HalfSpace
from ancfsparse.solve import simulate
from ancfsparse.system.contributions.force_elements.contact_steps import RESTITUTION_STEPS
from benchmarks.contact.references.comparison import (
    NO_VALUE,
    Comparison,
    compare_absolute,
    limit_above,
)

Method = Implicit | Explicit

GRAVITY = 9.81  # [m/s2]
RADIUS = 5e-3  # of all cables [m]
SECTION = Circle(2.0 * RADIUS)
MATERIAL = Material(1e8, 5e3)
LINE_MASS = MATERIAL.density * SECTION.area  # [kg/m]
FLOOR = HalfSpace((0.0, 0.0), (0.0, 1.0))
STIFFNESSES = (1e5, 1e6, 1e7, 1e8, 1e9)  # of the floor [N/m2]
STEPS = (1e-4, 3e-4, 1e-3, 3e-3, 1e-2)  # [s]
HEIGHTS = (0.48, 0.4937, 0.5, 0.5121)  # of falls, which meet the floor in different phases [m]
FALLING_INTEGRATORS: Sequence[Method] = (
    *(GeneralizedAlpha(rho) for rho in (0.0, 0.5, 0.9, 1.0)),
    *(HHT(0.1), HHT(0.3), Newmark(0.0), Newmark(0.1)),
)
EXPLICIT_INTEGRATORS: Sequence[Method] = (
    *(CentralDifference(), DormandPrince(), RungeKuttaNystrom(4), RungeKuttaNystrom(8)),
)
EXPLICIT_STEPS = {1e6: (0.05, 0.2), 1e7: (0.4,)}
"""Steps by the stiffness k [N/m2], times sqrt(k / m) [-]."""
REBOUND_STEPS = 1.8  # duration of a run over the time of the fall
MAX_REBOUND = 1.0001  # ratio of the energies of rebound and fall
CONSERVED_ENERGY = 5e-5  # deviation from 1 of this ratio with a method that conserves energy
RESTITUTIONS = (0.25, 0.5, 0.64, 0.8, 0.95)
IMPACT_SPEEDS = (0.5, 3.0)  # [m/s]
IMPACT_STIFFNESSES = (1e5, 1e7, 1e9)  # [N/m2]
STEP_RATIOS = (0.9999, 0.37)  # over the longest step that is admitted
RESTITUTION_INTEGRATORS: Sequence[Method] = (
    *(EnergyMomentum(), GeneralizedAlpha(0.9), GeneralizedAlpha(0.5), HHT(0.1), Newmark(0.0)),
)
RESTITUTION_TOLERANCE = 0.01  # of the speed after an impact [-]
RUBBING_LAWS: dict[str, dict[str, float]] = {
    "bristles": {},
    "slip speed": {"slip_speed": 0.05},
    "static friction": {"static_friction": 0.4},
}
RUBBING_STEPS = (2e-5, 2e-4)  # [s]
RUBBING_STIFFNESSES = (1e6, 1e7)  # [N/m2]
RUBBING_TIME = 8e-3  # [s]
MAX_MOMENTUM_CHANGE = 1e-12  # over the momentum
BOOK_ERRORS = {EnergyMomentum(): 1e-8, GeneralizedAlpha(0.9): 1e-3}
"""Largest errors of the energy balance over the kinetic energy."""


def compare_falls() -> list[Comparison]:
    """Compare rebounds of level falls with the energy of the fall."""
    rows = [
        limit_above(
            f"level falls, {integrator!r}: energy of the rebound over the initial one",
            np.max(_rebounds(integrator)),
            MAX_REBOUND,
        )
        for integrator in FALLING_INTEGRATORS
    ]
    ratios = _rebounds(EnergyMomentum())
    name = "level falls, EnergyMomentum(): energy of the rebound over the initial one"
    rows += [
        compare_absolute(f"{name}, {which}", value, 1.0, CONSERVED_ENERGY)
        for which, value in (("largest", np.max(ratios)), ("smallest", np.min(ratios)))
    ]
    return rows


def compare_explicit_falls() -> list[Comparison]:
    """Compare rebounds with explicit integrators, whose steps must resolve the impact."""
    rows = []
    for integrator in EXPLICIT_INTEGRATORS:
        ratios = [
            _fall(integrator, stiffness, step / math.sqrt(stiffness / LINE_MASS), height)
            for stiffness, steps in EXPLICIT_STEPS.items()
            for step, height in itertools.product(steps, HEIGHTS)
        ]
        name = f"level falls, {integrator!r}: energy of the rebound over the initial one"
        rows.append(limit_above(name, np.max(ratios), MAX_REBOUND))
    return rows


def _rebounds(integrator: Method) -> list[float]:
    """Return the ratios of energies over all stiffnesses, steps and heights."""
    return [
        _fall(integrator, stiffness, dt, height)
        for stiffness, dt in itertools.product(STIFFNESSES, STEPS)
        for height in (HEIGHTS if dt > STEPS[0] else HEIGHTS[2:3])
    ]


def _fall(integrator: Method, stiffness: float, dt: float, height: float) -> float:
    """Return the ratio of the energies of a level rebound and of the fall, NaN if the run fails.

    The rod has left the floor; methods that correct the energy of an impact do so at this time.
    """
    scene = Scene((0.0, -GRAVITY))
    ends = (0.0, RADIUS + height), (1.0, RADIUS + height)
    rod = scene.add_beam("thin", *ends, 4, SECTION, MATERIAL)
    scene.contact(rod, FLOOR, stiffness=stiffness)
    fall = math.sqrt(2.0 * height / GRAVITY)
    try:
        run = simulate(scene, round(REBOUND_STEPS * fall / dt) * dt, dt, integrator=integrator)
    except AncfError:
        return NO_VALUE
    y = run.position(rod.at(0.5))[:, 1] - RADIUS
    energy = 0.5 * run.velocity(rod.at(0.5))[:, 1] ** 2 + GRAVITY * y
    has_left = (run.t > fall + 2.0 * dt) & (y > 0.0)
    return float(energy[has_left].max(initial=0.0) / (GRAVITY * height))


def compare_restitutions() -> list[Comparison]:
    """Compare speeds after level impacts with their coefficient of restitution."""
    rows = []
    for integrator in RESTITUTION_INTEGRATORS:
        cases = itertools.product(RESTITUTIONS, IMPACT_STIFFNESSES, IMPACT_SPEEDS, STEP_RATIOS)
        errors = [_restitution_error(integrator, *case) for case in cases]
        name = f"restitution .25 to .95, {integrator!r}: relative error"
        rows.append(limit_above(name, np.max(errors), RESTITUTION_TOLERANCE))
    return rows


def _restitution_error(
    integrator: Method, restitution: float, stiffness: float, speed: float, ratio: float
) -> float:
    """Return the relative error of the speed after an impact, NaN if the run fails."""
    duration = math.pi * math.sqrt(LINE_MASS / stiffness)
    dt = ratio * restitution * duration / RESTITUTION_STEPS
    height = RADIUS + 2.37 * speed * dt
    scene = Scene((0.0, 0.0))
    rod = scene.add_beam(
        "thin", (0.0, height), (1.0, height), 4, SECTION, MATERIAL, velocity=(0.0, -speed)
    )
    scene.contact(rod, FLOOR, stiffness=stiffness, restitution=restitution)
    n_steps = int(3.0 + 3.0 * duration / (dt * restitution)) + 10
    try:
        run = simulate(scene, n_steps * dt, dt, integrator=integrator)
    except AncfError:
        return NO_VALUE
    after = float(run.velocity(rod.at(0.5))[-1, 1])
    return abs(after / (restitution * speed) - 1.0)


def compare_rubbing() -> list[Comparison]:
    """Compare momentum and energy balance of two free cables that rub on each other."""
    rows = []
    for law, (integrator, bound) in itertools.product(RUBBING_LAWS, BOOK_ERRORS.items()):
        cases = itertools.product(RUBBING_STIFFNESSES, RUBBING_STEPS)
        changes, errors = zip(
            *(_rub(integrator, RUBBING_LAWS[law], *case) for case in cases), strict=True
        )
        name = f"cables that rub, {law}, {integrator!r}"
        rows += [
            limit_above(f"{name}: change of momentum", np.max(changes), MAX_MOMENTUM_CHANGE),
            limit_above(f"{name}: error of the energy balance", np.max(errors), bound),
        ]
    return rows


def _rub(
    integrator: Method, law: dict[str, Any], stiffness: float, dt: float
) -> tuple[float, float]:
    """Return the relative change of momentum and the error of the energy balance of a run."""
    scene = Scene((0.0, 0.0, 0.0))
    lower = scene.add_beam("thin", (-0.4, 0.05, 0.0), (0.6, 0.05, 0.0), 6, SECTION, MATERIAL)
    height = 2.1 * RADIUS
    ends, velocity = ((0.0, -0.5, height), (0.0, 0.5, height)), (2.0, 0.7, -1.0)
    upper = scene.add_beam("thin", *ends, 6, SECTION, MATERIAL, velocity=velocity)
    scene.contact(lower, upper, stiffness=stiffness, friction=0.3, **law)
    steps = round(RUBBING_TIME / dt)
    try:
        run = simulate(scene, steps * dt, dt, integrator=integrator, tolerance=1e-12)
    except AncfError:
        return NO_VALUE, NO_VALUE
    before, after = _momentum(run, 0), _momentum(run, -1)
    change = np.abs(after - before).max() / np.abs(before).max()
    return float(change), run.energy.drift


def _momentum(run: Trajectory, state: int) -> Vector:
    """Return the momentum of a saved state, (3,) [kg m/s]."""
    p = run.system.assembly.inertia(np.asarray(run.v[state]))
    return np.array([p @ run.system.uniform(axis) for axis in range(3)])
