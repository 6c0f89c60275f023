"""The stability map: which run completes, over time step, stiffness, integrator and solver.

The whole product would be large and show little more: every integrator is run with Newton and with
``"auto"``, and every solver with one integrator that keeps energy and one that damps.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from ancfsparse.checks import check_choice, check_positive
from ancfsparse.errors import InputError
from benchmarks.common.progress import bar as progress_bar
from benchmarks.other_codes.environment import environment
from benchmarks.stability.cells import (
    FAILED,
    GAINED,
    INTEGRATORS,
    MOST_STEPS,
    SOLVERS,
    T_END,
    Place,
    Run,
    ends_by_chance,
    run_at,
)
from benchmarks.stability.scenes import SCENES

STIFFNESSES = (1e6, 1e7, 1e8, 1e9, 1e10, 2e11)
"""Young's moduli [Pa]."""

STEPS = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2)
"""Time steps [s]."""

FOR_ALL_INTEGRATORS = ("Newton", "auto")
FOR_ALL_SOLVERS = ("Newmark(0)", "GeneralizedAlpha(0.8)")
"""The cut through the product."""

# A finished run may not have gained more than this over its largest kinetic energy.
MOST_GAIN = 0.01

# Steps are calm where elements turn less [rad] and change their length by less than these; there
# damped Newton may save at most this share of the steps.
CALM_TURN, CALM_STRETCH, CALM_SHARE = 0.3, 1e-3, 0.05


@dataclass(frozen=True)
class Stability:
    """The map.

    Attributes
    ----------
    runs : list of Run
        One for each point.
    settings : dict
        What was run, and on what.
    """

    runs: list[Run]
    settings: dict[str, Any]

    @cached_property
    def at(self) -> dict[Place, Run]:
        """Runs by their place."""
        return {run.place: run for run in self.runs}

    @property
    def scenes(self) -> list[str]:
        """Names of the scenes, in order."""
        return list(dict.fromkeys(run.place.scene for run in self.runs))

    def of(self, scene: str, integrator: str, solver: str) -> list[Run]:
        """Return a panel of the map."""
        return [
            run for run in self.runs
            if (run.place.scene, run.place.integrator, run.place.solver)
            == (scene, integrator, solver)
        ]  # fmt: skip

    def beside_newton(self) -> Iterator[tuple[Run, Run]]:
        """Yield every run with another solver and that of Newton at the same place."""
        for run in self.runs:
            newton = self.at.get(run.place._replace(solver="Newton"))
            if newton is not None and run.place.solver != "Newton":
                yield run, newton

    def worse_than_newton(self, outcome: str = FAILED) -> list[Run]:
        """Return the runs that end in this way where Newton's comes to its end, not by chance."""
        return [
            run for run, newton in self.beside_newton()
            if run.outcome == outcome and newton.whole and not run.chaotic
        ]  # fmt: skip

    def by_chance(self) -> list[Run]:
        """Return the runs that do not finish where Newton's does, by chance alone."""
        return [run for run in self.runs if run.chaotic]

    def judged(self) -> Stability:
        """Return the map with those runs marked that end otherwise than Newton's by chance."""
        worse = [*self.worse_than_newton(FAILED), *self.worse_than_newton(GAINED)]
        chaotic = {run.place for run in worse if ends_by_chance(run.place)}
        runs = [replace(run, chaotic=run.place in chaotic) for run in self.runs]
        return Stability(runs, self.settings)

    def hidden_gains(self) -> list[Run]:
        """Return the runs that came to their end with more energy than they may have gained."""
        return [run for run in self.runs if run.whole and run.gain > MOST_GAIN]

    def calm(self) -> list[Run]:
        """Return the runs that took steps, all of them calm, and came to their end."""
        return [
            run for run in self.runs
            if run.whole and run.turn < CALM_TURN and run.stretch < CALM_STRETCH
        ]  # fmt: skip

    def calm_beside_newton(self) -> list[Run]:
        """Return the calm runs of all solvers but Newton, whose steps it saves where they fail."""
        return [run for run in self.calm() if run.place.solver != "Newton"]

    def often_rescued(self) -> list[Run]:
        """Return the calm runs of these solvers in which Newton saved more steps than it may."""
        return [run for run in self.calm_beside_newton() if run.newton > CALM_SHARE]


def places(
    scenes: Sequence[str], stiffnesses: Sequence[float], steps: Sequence[float]
) -> list[Place]:
    """Return the points of the cut."""
    pairs = [(i, s) for i in INTEGRATORS for s in SOLVERS
             if s in FOR_ALL_INTEGRATORS or i in FOR_ALL_SOLVERS]  # fmt: skip
    return [
        Place(scene, stiffness, dt, integrator, solver)
        for scene in scenes
        for integrator, solver in pairs
        for stiffness in stiffnesses
        for dt in steps
    ]


def stability(
    scenes: Sequence[str] = tuple(SCENES),
    stiffnesses: Sequence[float] = STIFFNESSES,
    steps: Sequence[float] = STEPS,
    progress: bool = False,
) -> Stability:
    """Run all integrators and solvers over scenes, Young's moduli [Pa] and time steps [s]."""
    for scene in scenes:
        check_choice("scene", scene, SCENES)
    for what, values, unit in (("stiffness", stiffnesses, "Pa"), ("step", steps, "s")):
        for value in values:
            check_positive(what, value, unit)
    wanted = progress_bar(places(scenes, stiffnesses, steps), "run", progress)
    runs = [run_at(place) for place in wanted]
    settings = {
        "t_end_s": T_END,
        "most_steps": MOST_STEPS,
        "tolerance": "default",
        "max_energy_gain": MOST_GAIN,
        **environment(),
    }
    return Stability(runs, settings).judged()


def read(path: Path) -> Stability:
    """Read a map from the table that the study writes.

    Raises
    ------
    InputError
        If the file is not such a table.
    """
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    try:
        runs = [Run.of(row) for row in rows]
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"{path} is not a table of `python -m benchmarks stability`: a column or number is "
            f"missing ({error})"
        ) from error
    if not runs:
        raise InputError(f"{path} holds no run of `python -m benchmarks stability`")
    return Stability(runs, {"read_from": path.name})
