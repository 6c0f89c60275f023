"""Cost of contact with a floor: per point relative to elements, and per step next to MuJoCo."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any

import numpy as np
from tqdm import tqdm

from ancfsparse.scene import Circle, Material, Scene
from ancfsparse.scene.force_elements.contact_points import POINTS_PER_PART
from ancfsparse.scene.force_elements.obstacles import HalfSpace
from ancfsparse.solve import simulate
from ancfsparse.system import System
from benchmarks.common.progress import bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.common.target import Target
from benchmarks.common.timing import in_turn

SIZES = (33, 333, 3333, 33333)  # elements, of three points each
CASES: dict[str, tuple[float, dict[str, float]]] = {
    "air": (1.0, {}),
    "no friction": (-0.01, {}),
    "bristles": (-0.01, {"friction": 0.3}),
    "slip speed": (-0.01, {"friction": 0.3, "slip_speed": 1e-2}),
}
"""Gaps over the radius, and arguments of `Scene.contact`."""
ROUNDS = 60  # of all in turn; the shortest time counts, since other programs can slow some rounds
SHORTEST = 10_000  # elements evaluated in one timing, about 0.5 ms
N_ELEMENTS = (10, 20, 40, 100)  # of the cables whose steps are timed
STATES: dict[str, float | None] = {"air": None, "equilibrium": 0.0, "falling": 10.0}
"""Height of the fall over the radius; None without a floor."""
RUNS = 40  # of all cables in turn; the shortest time counts
N_STEPS = 400
DT = 1e-3  # [s]
LENGTH = 0.05  # of an element [m]
RADIUS = 5e-3  # of its section [m]
STIFFNESS = 1e6  # where points are timed [N/m2]
# Measured before this study, with MuJoCo 4.0 on one core of another machine: a chain of as many
# capsules with ball joints in steps of 1 ms, in the air and lying on a floor [us per step].
MUJOCO = {10: (7.5, 21.0), 20: (24.0, 102.0), 40: (112.0, 500.0), 100: (1350.0, 10_400.0)}
MAX_RATIO = 2.0  # time of the contact of 1e5 points in a residual, over the elements' time
MAX_STEP = 1.0  # time of a step on the floor, per element [us]


@dataclass(frozen=True)
class PointCost:
    """Time of the contact in a residual, also relative to the time of the elements."""

    case: str
    n_points: int
    residual: float  # [ns per point]
    between: float  # between two states [ns per point]
    ratio: float  # [-]
    ratio_between: float


@dataclass(frozen=True)
class StepCost:
    """Time of a step."""

    state: str
    n_elements: int
    step: float  # [us]
    iterations: float  # per step [-]
    mujoco: float  # step of MuJoCo, measured before [us]


@dataclass(frozen=True)
class ContactSpeed:
    """Costs of contact."""

    points: list[PointCost]
    steps: list[StepCost]


def contact_speed(progress: bool = False) -> ContactSpeed:
    """Time contact with a floor per point and per step."""
    n_points, n_steps = ROUNDS * len(SIZES) * (len(CASES) + 2), RUNS * len(N_ELEMENTS) * len(STATES)
    with bar(n_points + n_steps, "run", progress) as runs:
        return ContactSpeed(_time_points(runs), _time_steps(runs))


def _cable(n: int, gap: float, contact: dict[str, Any] | None) -> Scene:
    """Return a level cable with a gap between its lower surface and the floor [m]."""
    scene = Scene((0, 0, -9.81))
    height = RADIUS + gap
    ends = (0, 0, height), (n * LENGTH, 0, height)
    cable = scene.add_beam("thin", *ends, n, Circle(2 * RADIUS), Material(1e8, 2e3))
    if contact is not None:
        scene.contact(cable, HalfSpace((0, 0, 0), (0, 0, 1)), **contact)
    return scene


def _time_points(runs: tqdm[Any]) -> list[PointCost]:
    gap = CASES["no friction"][0] * RADIUS
    calls: dict[tuple[int, str], tuple[Callable[[], Any], Callable[[], Any]]] = {}
    for n in SIZES:
        # Less the time of one element, which is little more than the call, for the elements' time.
        calls[n, "call"] = _residuals(_cable(1, gap, None))
        calls[n, "elements"] = _residuals(_cable(n, gap, None))
        for case, (ratio, options) in CASES.items():
            scene = _cable(n, ratio * RADIUS, {"stiffness": STIFFNESS, **options})
            calls[n, case] = _residuals(scene)

    def run(which: tuple[int, str]) -> list[float]:
        return [_time(call, max(1, SHORTEST // which[0])) for call in calls[which]]

    samples = in_turn(list(calls), run, ROUNDS, runs)
    best = {which: np.min(times, axis=0) for which, times in zip(calls, samples, strict=True)}
    costs = []
    for n, case in product(SIZES, CASES):
        contact = best[n, case] - best[n, "elements"]
        ratios = contact / (best[n, "elements"] - best[n, "call"])
        factor = 1e9 / (POINTS_PER_PART * n)
        costs.append(
            PointCost(case, POINTS_PER_PART * n, *(factor * contact).tolist(), *ratios.tolist())
        )
    return costs


def _residuals(scene: Scene) -> tuple[Callable[[], Any], Callable[[], Any]]:
    """Return calls of the residuals at the end of a step along the cable and between states."""
    system = System(scene)
    none, rest = np.zeros(0), np.zeros(system.n_all)
    q0, v = system.q0, 1e-3 * system.uniform(0)
    q1 = q0 + DT * v
    system.assembly.accept(q0)
    system.assembly.set_step(DT)
    end = q1, v, rest, none, rest, none
    return (
        lambda: system.assembly.residual(*end),
        lambda: system.assembly.residual_between(q0, *end),
    )


def _time(call: Callable[[], Any], repeat: int) -> float:
    begin = time.process_time()
    for _ in range(repeat):
        call()
    return (time.process_time() - begin) / repeat


def _time_steps(runs: tqdm[Any]) -> list[StepCost]:
    cases = list(product(N_ELEMENTS, STATES))

    def run(case: tuple[int, str]) -> tuple[float, float]:
        n, height = case[0], STATES[case[1]]
        contact = None if height is None else {"friction": 0.3}
        scene = _cable(n, (height or 0.0) * RADIUS, contact)
        stats = simulate(scene, N_STEPS * DT, DT).stats
        return 1e6 * stats.march_seconds / stats.steps, stats.iterations / stats.steps

    costs = [min(samples) for samples in in_turn(cases, run, RUNS, runs)]
    return [
        StepCost(state, n, *cost, MUJOCO[n][STATES[state] is not None])
        for (n, state), cost in zip(cases, costs, strict=True)
    ]


def point_table(result: ContactSpeed) -> Table:
    """Set the cost of points."""
    columns: dict[str, Callable[[Any], str]] = {
        "points": lambda each: f"{each.n_points}",
        "contact": lambda each: each.case,
        "residual [ns per point]": lambda each: f"{each.residual:.1f}",
        "over elements": lambda each: f"{each.ratio:.2f}",
        "between two states [ns per point]": lambda each: f"{each.between:.1f}",
        "between, over elements": lambda each: f"{each.ratio_between:.2f}",
    }
    return Table.of(result.points, columns, left=(1,), title="Contact in a residual")


def step_table(result: ContactSpeed) -> Table:
    """Set the cost of steps."""
    columns: dict[str, Callable[[Any], str]] = {
        "elements": lambda each: f"{each.n_elements}",
        "state": lambda each: each.state,
        "step [us]": lambda each: f"{each.step:.1f}",
        "iterations": lambda each: f"{each.iterations:.2f}",
        "MuJoCo [us]": lambda each: f"{each.mujoco:g}",
    }
    return Table.of(result.steps, columns, left=(1,), title="Steps of 1 ms")


def rows(result: ContactSpeed) -> list[dict[str, Any]]:
    """Return the lines of the CSV table: points, then steps."""
    return [*map(asdict, result.points), *map(asdict, result.steps)]


def targets(result: ContactSpeed) -> list[Target]:
    """Compare the largest scene and the slowest step with their targets."""
    largest = max(each.n_points for each in result.points)
    what = f"time over elements at the end of a step, {largest} points"
    of_points = [
        Target(f"{what}, {each.case}", each.ratio, MAX_RATIO, at_most=True)
        for each in result.points
        if each.n_points == largest
    ]
    on_floor = [each.step / each.n_elements for each in result.steps if each.state != "air"]
    what = "longest step on the floor [us per element]"
    return [*of_points, Target(what, max(on_floor), MAX_STEP, at_most=True)]


def findings(result: ContactSpeed) -> list[str]:
    """State whether the targets are met."""
    return [each.sentence() for each in targets(result)]


def _pages(table: Callable[[ContactSpeed], Table]) -> Callable[[ContactSpeed], str]:
    return lambda result: "\n".join(table(result).markdown())


def tables(result: ContactSpeed) -> Sequence[Table]:
    """Set both tables."""
    return [point_table(result), step_table(result)]


STUDY = Study(
    "contact-speed",
    run=contact_speed,
    tables=tables,
    rows=rows,
    targets=targets,
    findings=findings,
    regions={"contact-points": _pages(point_table), "contact-steps": step_table},
)
