"""Tensions of loose knots: equilibria without friction, and the part of friction."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.problems import knot
from ancfsparse.problems.contacts import ROD_RADIUS, RUBBER, SETTLING_TIME, TIGHTENING_TIME
from ancfsparse.solve import simulate, solve_static
from benchmarks.contact.references.comparison import Comparison, compare_relative

# Radius of the rod [m], and the part of the motion of its ends after which it is at rest.
EQUILIBRIA = ((1.25e-3, 0.0), (1.25e-3, 0.5), (2.5e-3, 0.3))
FINAL_LOOP_RADIUS = 0.15  # [m]
N_ELEMENTS = 220
STEP = 2e-3  # for a rod of 20 mm, for others in proportion to the periods of bending waves [s]
REST_SLOWNESS = 2.0  # of the motion before an equilibrium
LAW_TOLERANCE = 0.1  # of tensions at finite eps
LIMIT_TOLERANCE = 0.02  # of the tension over the one by the law, for eps = 0
FRICTION = 0.1
FRICTION_RADIUS = 2.5e-3  # [m]
SLOWNESS = 8.0  # the speed of the ends then hardly adds to the tension
PARTS = (0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)  # of the motion
FRICTION_FACTOR = 0.492  # of mu eps^3 in the law of Audoly, Clauvelin and Neukirch (2007)
FRICTION_TOLERANCE = 0.05


def compare_loose_knots() -> list[Comparison]:
    """Compare tensions of loose knots, and their limits, with the law of thin rods."""
    rows, points = [], []
    for h, part in EQUILIBRIA:
        eps, tension = _find_equilibrium(h, part)
        law = 0.5 * eps**4
        name = f"knot of {2e3 * h:g} mm at rest, mu 0, sqrt(h/R) {eps:.3f}: T h^2 / B"
        rows.append(compare_relative(name, tension, law, LAW_TOLERANCE))
        points.append((eps, tension / law))
    parameters, ratios = np.transpose(points)
    limit = float(np.polyfit(parameters, ratios, 1)[-1])
    name = "knots at rest, mu 0: tension over the law, extrapolated linearly to eps = 0"
    rows.append(compare_relative(name, limit, 1.0, LIMIT_TOLERANCE))
    name = "slow knot of 5 mm: part of friction over mu eps^3, extrapolated linearly to eps = 0"
    return [*rows, compare_relative(name, _friction_limit(), FRICTION_FACTOR, FRICTION_TOLERANCE)]


def _find_equilibrium(h: float, part: float) -> tuple[float, float]:
    """Return eps and T h^2 / B of a knot without friction at rest."""
    case = _make_knot(0.0, h, REST_SLOWNESS, N_ELEMENTS)
    time = (ROD_RADIUS / h) * (SETTLING_TIME + part * REST_SLOWNESS * TIGHTENING_TIME)
    run = _tighten(case, h, time, save_every=1000)
    rest, rod = solve_static(case.scene, start=run.last), case.bodies["rod"]
    chord = float(np.linalg.norm(rest.position(rod.end) - rest.position(rod.start)))
    loop = (rod.length - chord) / (2.0 * math.pi)
    tension = 0.5 * float(rest.reaction(rod.end)[0] - rest.reaction(rod.start)[0])
    return math.sqrt(h / loop), tension * h**2 / _bending_stiffness(h)


def _friction_limit() -> float:
    """Return the difference of tensions with and without friction over mu eps^3 at eps = 0."""
    h = FRICTION_RADIUS
    times = (ROD_RADIUS / h) * (SETTLING_TIME + SLOWNESS * TIGHTENING_TIME * np.array(PARTS))
    tensions: list[Vector] = []
    for mu in (0.0, FRICTION):
        case = _make_knot(mu, h, SLOWNESS)
        run = _tighten(case, h, float(times[-1]), save_every=100)
        rows = np.abs(np.array(run.t)[:, None] - times).argmin(axis=0)
        values = case.quantities(run)
        tensions.append(values["tension"][rows])
    eps = np.sqrt(h / values["radius"][rows])
    parts = (tensions[1] - tensions[0]) * h**2 / (_bending_stiffness(h) * FRICTION * eps**3)
    return float(np.polyfit(eps, parts, 1)[-1])


def _make_knot(mu: float, h: float, slowness: float, n_elements: int = 110) -> Any:
    return knot(mu, h / FINAL_LOOP_RADIUS, n_elements, thickness=2.0 * h, slowness=slowness)


def _tighten(case: Any, h: float, t_end: float, save_every: int) -> Any:
    dt = STEP * ROD_RADIUS / h
    t_end = dt * round(t_end / dt)
    return simulate(case.scene, t_end, dt, integrator=GeneralizedAlpha(0.5), save_every=save_every)


def _bending_stiffness(h: float) -> float:
    return RUBBER.youngs_modulus * math.pi * h**4 / 4.0
