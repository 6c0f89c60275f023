"""Rods of PyElastica that fall on a ball or on another rod."""

from __future__ import annotations

import contextlib
import io
import time
import warnings
from typing import Any

import numpy as np

from benchmarks.contact import falls
from benchmarks.other_codes.elastica import load

SLIDING = 1e2  # friction over the velocity below its limit [N s/m]
BALL_DENSITY = 1e9  # which keeps it in place [kg/m3]


def run_elastica_fall(on: str, dt: float) -> falls.Fall:
    """Run the fall on a ball or a cable with position Verlet, after a step that compiles."""
    elastica = load()
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")  # of its own code
        _run(elastica, on, dt, 1)
        return _run(elastica, on, dt, round(falls.END / dt))


def _run(elastica: Any, on: str, dt: float, steps: int) -> falls.Fall:
    simulator, rod = _build(elastica, on)
    begin = time.process_time()
    elastica.integrate(elastica.PositionVerlet(), simulator, steps * dt, steps, progress_bar=False)
    seconds = time.process_time() - begin
    return falls.Fall(seconds, rod.position_collection[:, list(falls.WATCHED)].T.copy())


def _rod(elastica: Any, start: tuple[float, ...], direction: tuple[float, ...]) -> Any:
    material = falls.MATERIAL
    return elastica.CosseratRod.straight_rod(
        falls.ELEMENTS,
        np.array(start),
        np.array(direction),
        np.array([0.0, 1.0, 0.0]),
        falls.LENGTH,
        falls.RADIUS,
        material.density,
        youngs_modulus=material.youngs_modulus,
        shear_modulus=0.5 * material.youngs_modulus / (1.0 + material.poisson_ratio),
    )


def _build(elastica: Any, on: str) -> tuple[Any, Any]:
    parts = (
        elastica.BaseSystemCollection,
        elastica.Constraints,
        elastica.Forcing,
        elastica.Contact,
    )
    simulator: Any = type("Simulator", parts, {})()
    height = falls.start_height(on == "cable")
    rod = _rod(elastica, (-falls.MIDDLE, height, 0.0), (1.0, 0.0, 0.0))
    stiffness = falls.STIFFNESS * falls.LENGTH / falls.ELEMENTS
    weight = np.array([0.0, -falls.GRAVITY, 0.0])
    simulator.append(rod)
    simulator.add_forcing_to(rod).using(elastica.GravityForces, acc_gravity=weight)
    if on == "ball":
        ball = elastica.Sphere(np.zeros(3), falls.OBSTACLE_RADIUS, BALL_DENSITY)
        simulator.append(ball)
        simulator.detect_contact_between(rod, ball).using(
            elastica.RodSphereContact,
            k=stiffness,
            nu=0.0,
            velocity_damping_coefficient=SLIDING,
            friction_coefficient=falls.FRICTION,
        )
    else:
        lower = _rod(elastica, (0.0, 0.0, -0.5 * falls.LENGTH), (0.0, 0.0, 1.0))
        simulator.append(lower)
        simulator.add_forcing_to(lower).using(elastica.GravityForces, acc_gravity=weight)
        simulator.constrain(lower).using(
            elastica.GeneralConstraint, constrained_position_idx=(0, -1)
        )
        simulator.detect_contact_between(rod, lower).using(
            elastica.RodRodContact, k=stiffness, nu=0.0
        )
    simulator.finalize()
    return simulator, rod
