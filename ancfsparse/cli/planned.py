"""Plans for scenes by name, run and verified."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.integrators import Newmark
from ancfsparse.messages import format_value
from ancfsparse.nonlinear import QuasiNewton
from ancfsparse.plans import Plan, plan, position, static_deflection
from ancfsparse.plans.execution.planned_trajectory import PlannedRun
from ancfsparse.problems import pendulum
from ancfsparse.problems.undecided import UNDECIDED
from ancfsparse.results import Trajectory
from ancfsparse.scene import Point
from ancfsparse.solve import simulate

Array = NDArray[np.float64]

# Elements of the paper with their dimensions, its step and first mesh, and those that refine it.
ELEMENTS = {"l2t2": 2, "thin": 3, "thick": 3}
STEP, MESHES = 5e-4, (10, 14, 20, 28, 40, 56, 80)
# The meshes and the accuracy in time of what both are compared with [m].
FINE, ACCURATE = {"l2t2": 80, "thin": 80, "thick": 160}, 1e-5
# Runs are repeated so often, but not beyond so many seconds.
REPEATS, LONG_ENOUGH = 3, 1.0
# What the pendulum is compared at [m].
ERROR = 1e-3


@dataclass(frozen=True)
class Planned:
    """A plan, and its run if there was one.

    Attributes
    ----------
    plan : Plan
        The plan.
    run : PlannedRun or None
        Its run, verified.
    """

    plan: Plan
    run: PlannedRun | None

    def __str__(self) -> str:
        """Write both."""
        return "\n".join(map(str, (self.plan, self.run) if self.run else (self.plan,)))


def plan_scene(name: str, error: str | None, march: bool) -> Planned:
    """Plan a scene by name.

    Parameters
    ----------
    name : str
        One of `UNDECIDED`.
    error : str or None
        As `ancfsparse.plan` takes it, a number [m] or a share such as ``"1 %"``; None takes the
        one of the scene.
    march : bool
        Whether to run it, and once more with a finer model.
    """
    scene, point, t_end, usual = UNDECIDED[check_choice("scene", name, UNDECIDED)]()
    ask = static_deflection if t_end is None else position
    made = plan(scene, t_end, ask(point), _error(usual if error is None else error))
    return Planned(made, made.run(verify=True) if march else None)


def _error(text: str) -> float | str:
    if text.strip().endswith("%"):
        return text
    try:
        return float(text)
    except ValueError:
        raise InputError(
            f"--error needs a number [m] or a share such as '1 %', got {format_value(text)}"
        ) from None


@dataclass(frozen=True)
class Contest:
    """The paper's pendulum, as planned and as in the paper with finer meshes.

    Attributes
    ----------
    element : str
        The element, of the paper and of the plan.
    error : float
        Tolerance [m].
    planned, paper : tuple of (float, float)
        Seconds of the processor, set-up included, and achieved error [s], [m].
    planning : float
        The same of the plan, with the run that it has made [s].
    elements : int
        Elements that the paper's way needs.
    refining : float
        Seconds of all its meshes up to there [s].
    """

    element: str
    error: float
    planned: tuple[float, float]
    paper: tuple[float, float]
    planning: float
    elements: int
    refining: float

    def __str__(self) -> str:
        """Write both, and the ratios."""
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


def contest(element: str, error: float) -> Contest:
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
        If no mesh of the paper's way reaches the error.
    """
    t_end, dim = 2.0, ELEMENTS[element]

    # Converged elements differ by half a millimetre, so each has a reference of its own.
    fine_scene, fine_rod = pendulum(element, FINE[element], 2)

    @cache
    def reference(steps: int, dt: float) -> Array:
        return simulate(fine_scene, steps * dt, dt, accuracy=ACCURATE).position(fine_rod.end)

    def exact(run: Trajectory, tip: Point) -> float:
        dt = float(run.t[1] - run.t[0])
        steps = int(np.floor(t_end / dt + 1e-9))
        apart: Array = run.position(tip)[: steps + 1, :2] - reference(steps, dt)
        return float(np.linalg.norm(apart, axis=1).max())

    refining = 0.0
    for n in MESHES:
        scene, rod = pendulum(element, n, dim)
        seconds, run = _best(lambda scene=scene: simulate(
            scene, t_end, STEP, integrator=Newmark(0.0), solver=QuasiNewton("davidon", "full"),
            tolerance="paper"))  # fmt: skip
        refining += seconds
        off = exact(run, rod.end)
        if off <= error:
            break
    else:
        raise InputError(
            f"the paper's way does not reach {error:g} m with {MESHES[-1]} elements: ask for more "
            f"than {off:.1e} m"
        )
    scene, rod = pendulum(element, "auto", dim)
    planning, _ = _best(lambda: plan(scene, t_end, position(rod.end), error).run())
    made = replace(plan(scene, t_end, position(rod.end), error), result=None)
    mine, planned = _best(made.run)
    return Contest(
        element, error, (mine, exact(planned, rod.end)), (seconds, off), planning, n, refining
    )


def _best(call: Any) -> tuple[float, Any]:
    """Return the shortest time of a few calls, and the last result."""
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        found = call()
        times.append(time.process_time() - begin)
        if sum(times) > LONG_ENOUGH:
            break
    return min(times), found
