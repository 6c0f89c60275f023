"""A block, a cable, a cantilever and a chain on obstacles, compared with formulas."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ancfsparse.integrators import EnergyMomentum, GeneralizedAlpha
from ancfsparse.problems import (
    cable_drop,
    cantilever_on_cylinders,
    chain_over_pulley,
    sliding_block,
)
from ancfsparse.scene.force_elements.contacts import LAYER_RATIO
from ancfsparse.solve import simulate, solve_static
from benchmarks.contact.references.comparison import (
    Comparison,
    compare_absolute,
    compare_relative,
    limit_above,
)

GRAVITY = 9.81  # [m/s2]
BLOCK_SPEED = 3.0  # at the start [m/s]
BLOCK_FRICTION = 0.3
SLIP_SPEED = 1e-2  # of the block [m/s]
COULOMB_DISTANCE = 1.529052  # of the block without a slip speed [m]
DROP_HEIGHT = 0.3970702  # of the dropped cable at 0.5 s, by DOP853 for a point mass [m]
DROP_DEPTH = 6.303547e-3  # of its impact on a floor of 1e5 N/m2 without a layer [m]
DROP_STIFFNESS = 1e5  # [N/m2]
LINE_MASS = 0.4  # of the dropped cable [kg/m]
DROP_ENERGY = 2.0 * LINE_MASS * GRAVITY * 0.5  # of its fall: 2 m of cable fall by 0.5 m [J]
DROP_LAYER = LAYER_RATIO * 5e-3  # penetration within which the pressure begins [m]
SHOOTING_TIP = (1.8905202, -0.4825640)  # of the cantilever: Reissner's rod by shooting [m]
EXUDYN_TIP = -0.4842698  # height of the tip in Exudyn's test, on its coarse mesh [m]
LIFT_OFF_TIME = math.sqrt(1.0 / GRAVITY)  # of the chain, sqrt(2 l0 (g+a)/(a (3a+g))), a = g [s]
LIFT_OFF_SPEED = math.sqrt(GRAVITY)  # of the chain [m/s]
DAMPED = GeneralizedAlpha(0.5)


def compare_block() -> list[Comparison]:
    """Compare the distance of a block that friction stops with Coulomb's and regularized law."""
    case = sliding_block(BLOCK_FRICTION, BLOCK_SPEED, SLIP_SPEED)
    run = simulate(case.scene, 1.5, 5e-3, integrator=EnergyMomentum())
    distance = case.quantities(run)["distance"][-1]
    v, u = BLOCK_SPEED, SLIP_SPEED
    path = v * math.hypot(v, u) + u**2 * math.asinh(v / u)
    regularized = path / (2.0 * BLOCK_FRICTION * GRAVITY)
    return [
        compare_absolute("block, regularized friction: distance [m]", distance, regularized, 3e-6),
        compare_relative("block, Coulomb's law: distance [m]", distance, COULOMB_DISTANCE, 1e-4),
    ]


def compare_drop() -> list[Comparison]:
    """Compare the impact of a level cable with a point mass, and the place where it rests."""
    case = cable_drop()
    run = simulate(case.scene, 0.5, 2.5e-4, integrator=EnergyMomentum(), tolerance=1e-12)
    values = case.quantities(run)
    lost = np.abs(values["energy_lost"]).max() / DROP_ENERGY
    damped = cable_drop()
    rest = damped.quantities(simulate(damped.scene, 1.0, 5e-3, integrator=DAMPED))
    depth = LINE_MASS * GRAVITY / DROP_STIFFNESS
    # Half of the work of the weight on the last way is stored in the contact.
    lost_at_rest = DROP_ENERGY + 2.0 * LINE_MASS * GRAVITY * 0.5 * (depth + DROP_LAYER)
    return [
        compare_absolute(
            "cable drop: height at 0.5 s [m]", values["height"][-1], DROP_HEIGHT, 2e-5
        ),
        compare_relative("cable drop: penetration [m]", -values["height"].min(), DROP_DEPTH, 1e-3),
        limit_above("cable drop: change of energy over the initial one", lost, 1e-6),
        compare_relative(
            "cable drop, damped: depth at rest [m]",
            -rest["height"][-1],
            depth + 0.5 * DROP_LAYER,
            1e-6,
        ),
        compare_relative(
            "cable drop, damped: energy lost [J]", rest["energy_lost"][-1], lost_at_rest, 1e-6
        ),
    ]


def compare_cantilever() -> list[Comparison]:
    """Compare the tip of a cantilever on two cylinders with shooting and with Exudyn's test."""
    case = cantilever_on_cylinders()
    rod: Any = case.bodies["cantilever"]
    x, y = solve_static(case.scene).position(rod.end)
    return [
        compare_absolute("cantilever on cylinders: x of the tip [m]", x, SHOOTING_TIP[0], 2e-4),
        compare_absolute("cantilever on cylinders: y of the tip [m]", y, SHOOTING_TIP[1], 2e-4),
        compare_relative("cantilever on cylinders, Exudyn's test: y [m]", y, EXUDYN_TIP, 1e-3),
    ]


def compare_chain() -> list[Comparison]:
    """Compare time and speed at which a chain lifts off a pulley with Brun et al."""
    rows = []
    for radius in (0.2, 0.1, 0.05):
        case = chain_over_pulley(radius=radius)
        start = solve_static(case.scene)
        run = simulate(case.scene, 0.4, 1e-3, integrator=DAMPED, start=start)
        values, name = case.quantities(run), f"chain over a pulley of {radius:g} m"
        time, speed = values["lift_off_time"][-1], values["speed_at_lift_off"][-1]
        rows += [
            compare_relative(f"{name}: lift-off [s]", time, LIFT_OFF_TIME, 0.01),
            compare_relative(f"{name}: speed then [m/s]", speed, LIFT_OFF_SPEED, 0.01),
        ]
    return rows
