"""The same scenes in other units and under other accelerations."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

import ancfsparse as ancf
from ancfsparse.nonlinear.methods import UPDATES


class Units(NamedTuple):
    """Units of a system in a metre, a kilogram and a second."""

    length: float
    mass: float
    time: float


UNITS = {
    "kg m s": Units(1.0, 1.0, 1.0),
    "t mm s": Units(1e3, 1e-3, 1.0),
    "g um ms": Units(1e6, 1e3, 1e3),
    "g cm s": Units(1e2, 1e3, 1.0),
    "kg mm ms": Units(1e3, 1.0, 1e3),
    "kg km h": Units(1e-3, 1.0, 1.0 / 3600.0),
    "lb ft s": Units(1.0 / 0.3048, 1.0 / 0.45359237, 1.0),
}
# Accelerations [m/s2]; moduli are scaled with them, so that only the time of a motion changes.
STANDARD = 9.81  # [m/s2]
GRAVITIES = (1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e3, 1e4)
LENGTH = 2.0  # of a beam [m]
STEPS = 200
SAVE_EVERY = 20  # steps
FEW_PAIRS = 5
SOLVERS = (
    "auto",
    ancf.ModifiedNewton(),
    ancf.Newton(),
    *(ancf.QuasiNewton(update, "full") for update in UPDATES),
    *(ancf.QuasiNewton(update, FEW_PAIRS) for update in UPDATES),
)
INTEGRATORS = (
    ancf.GeneralizedAlpha(0.9),
    ancf.Newmark(0.0),
    ancf.HHT(0.05),
    ancf.EnergyMomentum(),
    ancf.RungeKuttaNystrom(4),
)


def pendulum(units, gravity, modulus=1e8):
    _, material = scaled(units, gravity, modulus, 4000.0)
    scene = ancf.Scene((0.0, -gravity * units.length / units.time**2))
    section = ancf.Rectangle(0.01 * units.length, 0.01 * units.length)
    rod = scene.add_beam("thin", (0, 0), (LENGTH * units.length, 0), 8, section, material)
    scene.pin(rod.start)
    return scene, rod


def steel_pendulum(units, gravity):
    return pendulum(units, gravity, 2.1e11)


def pendulum_on_rod(units, gravity):
    scene, rod = pendulum(units, gravity)
    scene.rod(rod.end, (LENGTH * units.length, 0.5 * LENGTH * units.length))
    return scene, rod


def pushed_beam(units, gravity):
    """Bend a thick beam to and fro by a force."""
    second, material = scaled(units, gravity, 1e9, 4000.0)
    scene = ancf.Scene((0.0, -gravity * units.length / units.time**2, 0.0))
    section = ancf.Rectangle(0.02 * units.length, 0.02 * units.length)
    end = (LENGTH * units.length, 0, 0)
    beam = scene.add_beam("thick", (0, 0, 0), end, 4, section, material)
    scene.clamp(beam.start)
    force = 0.2 * gravity / STANDARD * units.mass * units.length / units.time**2
    scene.point_force(beam.end, lambda t: (0.0, 0.0, force * math.sin(5.0 * t / second)))
    return scene, beam


def scaled(units, gravity, modulus, density):
    """Return the scaled second, and a material whose stress is proportional to gravity."""
    second = math.sqrt(STANDARD / gravity) * units.time
    stress = gravity / STANDARD * units.mass / (units.length * units.time**2)
    return second, ancf.Material(modulus * stress, density * units.mass / units.length**3, 0.3)


SCENES = {
    "pendulum": (pendulum, 5e-4),
    "steel pendulum": (steel_pendulum, 1e-3),
    "pendulum on a rod": (pendulum_on_rod, 5e-4),
    "pushed beam": (pushed_beam, 5e-4),
}
"""Functions that build a scene, and its time step under 9.81 m/s2 [s]."""


@dataclass(frozen=True)
class Comparison:
    """A scene in one system of units, compared with SI units under 9.81 m/s2."""

    scene: str
    integrator: str
    solver: str
    units: str
    gravity: float  # [m/s2]
    difference: float  # largest distance of the tips, over the length [-]
    count_difference: float  # larger relative difference of iterations and of residuals [-]


def cases():
    """Yield each scene with each integrator under "auto", and each solver under the first."""
    for scene in SCENES:
        for integrator in INTEGRATORS[:-1]:
            for solver in SOLVERS if integrator == INTEGRATORS[0] else SOLVERS[:1]:
                yield scene, integrator, solver
    yield "pendulum", INTEGRATORS[-1], "auto"  # explicit


def compare(pairs):
    """Run all cases in pairs of a system of units and an acceleration."""
    found = []
    for scene, integrator, solver in cases():
        tip, counts = run(scene, integrator, solver, UNITS["kg m s"], STANDARD)
        for name, gravity in pairs:
            other, others = run(scene, integrator, solver, UNITS[name], gravity)
            apart = float(np.linalg.norm(other - tip, axis=1).max()) / LENGTH
            change = float(np.abs((others - counts) / np.maximum(counts, 1.0)).max())
            names = scene, repr(integrator), repr(solver), name
            found.append(Comparison(*names, gravity, apart, change))
    return found


def run(scene, integrator, solver, system, gravity):
    """Return the tip over time, over the unit of length, and iterations and residuals per step."""
    build, dt = SCENES[scene]
    model, beam = build(system, gravity)
    step = dt * math.sqrt(STANDARD / gravity) * system.time
    if integrator == INTEGRATORS[-1]:
        step /= 4.0
    found = ancf.simulate(
        model, STEPS * step, step, integrator=integrator, solver=solver, save_every=SAVE_EVERY
    )
    counts = np.array([found.stats.iterations, found.stats.residual_evaluations])
    return found.position(beam.end) / system.length, counts / found.stats.steps
