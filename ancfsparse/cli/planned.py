"""The command ``ancfsparse plan``: plans for scenes by name, run and verified."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.integrators import Newmark
from ancfsparse.messages import format_value
from ancfsparse.nonlinear import QuasiNewton
from ancfsparse.plans import Plan, plan, position, static_deflection
from ancfsparse.problems import pendulum
from ancfsparse.problems.auto_scenes import AUTO_SCENES
from ancfsparse.results import Trajectory
from ancfsparse.scene import Point
from ancfsparse.solve import simulate

ELEMENTS = {"l2t2": 2, "thin": 3, "thick": 3}
"""Elements of the paper with their dimensions."""
STEP = 5e-4  # s, time step of the paper
MESHES = (10, 14, 20, 28, 40, 56, 80)  # elements, the first mesh is that of the paper
REFERENCE_MESHES = {"l2t2": 80, "thin": 80, "thick": 160}  # elements of the reference runs
REFERENCE_ACCURACY = 1e-5  # m, in time
MAX_REPEATS = 3  # timed runs
MAX_TOTAL_TIME = 1.0  # s, of timed runs
ERROR = 1e-3  # m, of the comparison


def plan_scene(name: str, error: str | None) -> Plan:
    """Plan one of `AUTO_SCENES` with the options of the command, by default to its own error."""
    scene, point, t_end, usual = AUTO_SCENES[check_choice("scene", name, AUTO_SCENES)]()
    quantity = static_deflection(point) if t_end is None else position(point)
    return plan(scene, t_end, quantity, _parse_error(usual if error is None else error))


def _parse_error(text: str) -> float | str:
    if text.strip().endswith("%"):
        return text
    try:
        return float(text)
    except ValueError:
        raise InputError(
            f"--error needs a number [m] or a fraction such as '1 %', got {format_value(text)}"
        ) from None


@dataclass(frozen=True)
class Comparison:
    """The pendulum by a plan, and as in the paper with refined meshes.

    Attributes
    ----------
    element : str
        The element, of the paper and of the plan.
    error : float
        Tolerance [m].
    planned, paper : tuple of (float, float)
        Processor time with set-up [s], and achieved error [m].
    planning : float
        Processor time of the plan and its run [s].
    elements : int
        Number of elements as in the paper.
    refining : float
        Processor time of all meshes up to this number [s].
    """

    element: str
    error: float
    planned: tuple[float, float]
    paper: tuple[float, float]
    planning: float
    elements: int
    refining: float

    def __str__(self) -> str:
        """Return both results and their ratios as text."""
        run, off = self.planned
        its, its_off = self.paper
        return (
            f"the paper's {self.element}: {self.elements} elements, dt = {STEP:g} s, Davidon with "
            f"full memory: error {its_off:.1e} m in {its:.3g} s; with the coarser meshes before "
            f"{self.refining:.3g} s\n"
            f"planned: error {off:.1e} m in {run:.3g} s, {self.planning:.3g} s with the plan"
            f"\nthe run is {its / run:.1f} times as fast, plan and run together "
            f"{self.refining / self.planning:.1f} times as fast as refining"
        )


def compare_with_paper(element: str, error: float) -> Comparison:
    """Compare the planned pendulum with the paper's element, step and method, refined.

    Parameters
    ----------
    element : str
        One of `ELEMENTS`.
    error : float
        Largest error of the tip over two seconds [m].

    Raises
    ------
    InputError
        If no mesh with the method of the paper reaches the error.
    """
    t_end, dim = 2.0, ELEMENTS[element]

    # Converged elements differ by half a millimetre, so each has a reference of its own.
    fine_scene, fine_rod = pendulum(element, REFERENCE_MESHES[element], 2)

    @cache
    def reference(steps: int, dt: float) -> Vector:
        return simulate(fine_scene, steps * dt, dt, accuracy=REFERENCE_ACCURACY).position(
            fine_rod.end
        )

    def error_of(run: Trajectory, tip: Point) -> float:
        dt = float(run.t[1] - run.t[0])
        steps = int(np.floor(t_end / dt + 1e-9))
        difference: Vector = run.position(tip)[: steps + 1, :2] - reference(steps, dt)
        return float(np.linalg.norm(difference, axis=1).max())

    refining = 0.0
    for n in MESHES:
        scene, rod = pendulum(element, n, dim)
        seconds, run = _best(lambda scene=scene: simulate(
            scene, t_end, STEP, integrator=Newmark(0.0), solver=QuasiNewton("davidon", "full"),
            tolerance="paper"))  # fmt: skip
        refining += seconds
        off = error_of(run, rod.end)
        if off <= error:
            break
    else:
        raise InputError(
            f"the method of the paper does not reach {error:g} m with {MESHES[-1]} elements: "
            f"request more than {off:.1e} m"
        )
    scene, rod = pendulum(element, "auto", dim)
    planning, _ = _best(lambda: plan(scene, t_end, position(rod.end), error).run())
    planned_run = replace(plan(scene, t_end, position(rod.end), error), result=None)
    own, planned = _best(planned_run.run)
    return Comparison(
        element, error, (own, error_of(planned, rod.end)), (seconds, off), planning, n, refining
    )


def _best(call: Any) -> tuple[float, Any]:
    """Return the shortest time of some calls, and the last result."""
    times = []
    for _ in range(MAX_REPEATS):
        begin = time.process_time()
        result = call()
        times.append(time.process_time() - begin)
        if sum(times) > MAX_TOTAL_TIME:
            break
    return min(times), result
