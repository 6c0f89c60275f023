"""A pile of 100 cables and a net of 60 x 60 meshes: rest, penetration, convergence and time."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from functools import cache

import numpy as np

from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.problems import net_on_sphere, pile
from ancfsparse.solve import simulate
from benchmarks.contact.references.comparison import (
    Comparison,
    compare_absolute,
    compare_relative,
    limit_above,
    state_value,
)

GRAVITY = 9.81  # [m/s2]
N_CABLES = 100
LENGTH = 1.6  # of a cable, in 40 elements [m]
STIFFNESS = 1e8  # between cables [N/m2]
PILE_RADIUS = 5e-3  # [m]
PILE_DENSITY = 1000.0  # [kg/m3]
PILE_END = 0.4  # [s]
PILE_STEP = 1e-3  # [s]
CONVERGENCE_STEPS = (4e-3, 2e-3, 1e-3, 5e-4)  # the last one is the reference [s]
MAX_PENETRATION = 0.01  # over the radius
REST_SPEED = 1e-3  # of all nodes at the end [m/s]
REST_TIME = 0.35  # from which on the pile rests [s]
HEIGHT_TOLERANCE = 1e-6  # of the nodes at rest, over steps [m]
PENETRATION_TOLERANCE = 1e-4  # at rest, over steps, over the radius
WEIGHT_TOLERANCE = 1e-4  # of the force on the floor or the ball [-]
NET_SIZE = 60  # meshes along a side
NET_MASS = 1000.0 * math.pi * 2e-3**2 * 1.6 * 2 * (NET_SIZE + 1)  # [kg]
NET_END = 2.0  # [s]
NET_STEP = 4e-3  # [s]
NET_SECONDS = 60.0  # processor time of the net
DAMPED = GeneralizedAlpha(0.5)


@dataclass(frozen=True)
class PileRun:
    """The values of a run of the pile."""

    speed: float  # largest of a node, from `REST_TIME` on [m/s]
    force: float  # on the floor at the end [N]
    largest_penetration: float  # in all saved states, over the radius
    height: float  # mean of the nodes at the end [m]
    penetration: float  # at the end, over the radius
    processor_seconds: float
    seconds: float  # wall-clock time


def compare_pile() -> list[Comparison]:
    """Compare a pile at rest with its weight, and its speed and penetrations with limits."""
    run = _run_pile(PILE_STEP)
    weight = PILE_DENSITY * math.pi * PILE_RADIUS**2 * N_CABLES * LENGTH * GRAVITY
    name = f"pile of {N_CABLES} cables, 1 ms"
    return [
        limit_above(f"{name}: largest speed from {REST_TIME:g} s [m/s]", run.speed, REST_SPEED),
        compare_relative(f"{name}: force on the floor [N]", run.force, weight, WEIGHT_TOLERANCE),
        limit_above(
            f"{name}: largest penetration, over the radius",
            run.largest_penetration,
            MAX_PENETRATION,
        ),
    ]


def compare_pile_steps() -> list[Comparison]:
    """Compare the pile at rest after steps of several lengths with the result of the shortest."""
    runs = {dt: _run_pile(dt) for dt in CONVERGENCE_STEPS}
    shortest, best = CONVERGENCE_STEPS[-1], runs[CONVERGENCE_STEPS[-1]]
    rows = []
    for dt in CONVERGENCE_STEPS[:-1]:
        name = f"pile, {1e3 * dt:g} against {1e3 * shortest:g} ms"
        rows += [
            compare_absolute(
                f"{name}: mean height at rest [m]", runs[dt].height, best.height, HEIGHT_TOLERANCE
            ),
            compare_absolute(
                f"{name}: penetration at rest, over the radius",
                runs[dt].penetration,
                best.penetration,
                PENETRATION_TOLERANCE,
            ),
        ]
    return rows


def state_time_factors() -> list[Comparison]:
    """State simulated time over computing time of the pile, on one and two threads."""
    rows = []
    for threads, words in ((1, "one thread"), (2, "two threads")):
        run = _run_pile(PILE_STEP, threads)
        name = f"pile of {N_CABLES} cables, 1 ms, {words}"
        rows += [
            state_value(f"{name}: simulated over processor time", PILE_END / run.processor_seconds),
            state_value(f"{name}: simulated over wall-clock time", PILE_END / run.seconds),
        ]
    return rows


@cache
def _run_pile(dt: float, threads: int = 1) -> PileRun:
    """Run the wide pile of ten layers."""
    case = pile(N_CABLES, LENGTH, 1.0, stiffness=STIFFNESS, cables_in_layer=10, width=1.4)
    every = max(1, round(PILE_STEP / dt))
    begin, processor_begin = time.perf_counter(), time.process_time()
    run = simulate(case.scene, PILE_END, dt, integrator=DAMPED, save_every=every, threads=threads)
    seconds, processor = time.perf_counter() - begin, time.process_time() - processor_begin
    values = case.quantities(run)
    heights = np.asarray(run.q[-1])[run.system.vectors("r")[0][:, 2]]
    return PileRun(
        float(values["speed"][run.t > REST_TIME].max()),
        float(values["force"][-1]),
        float(values["largest_penetration"].max()),
        float(heights.mean()),
        float(values["largest_penetration"][-1]),
        processor,
        seconds,
    )


def compare_net() -> list[Comparison]:
    """Compare a net that falls on a ball with its weight, and its processor time with a limit."""
    case = net_on_sphere(NET_SIZE)
    begin = time.process_time()
    run = simulate(case.scene, NET_END, NET_STEP, integrator=DAMPED)
    seconds = time.process_time() - begin
    values = case.quantities(run)
    kinetic = values["kinetic_energy"]
    name = f"net of {NET_SIZE} x {NET_SIZE} meshes"
    return [
        limit_above(f"{name}: processor time [s]", seconds, NET_SECONDS),
        compare_relative(
            f"{name}: force on the ball [N]", values["force"][-1], NET_MASS * GRAVITY, 1e-3
        ),
        limit_above(
            f"{name}: kinetic energy at the end over the largest", kinetic[-1] / kinetic.max(), 1e-3
        ),
    ]
