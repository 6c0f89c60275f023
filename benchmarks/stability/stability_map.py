"""The stability map: outcome over time step, stiffness, integrator and solver.

The whole product would be large and show little more: every integrator is run with Newton and with
``"auto"``, and every solver with one integrator that keeps energy and one that damps.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import typer

from ancfsparse.checks import check_choice, check_positive
from ancfsparse.errors import InputError
from benchmarks.common.progress import bar as progress_bar
from benchmarks.other_codes.environment import environment
from benchmarks.stability.cells import (
    FAILED,
    GAINED,
    INTEGRATORS,
    MAX_STEPS,
    SOLVERS,
    T_END,
    MapPoint,
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

MAX_GAIN = 0.01  # energy that a finished run may gain, over its largest kinetic energy
CALM_TURN = 0.3  # largest turn of an element in a calm step [rad]
CALM_STRETCH = 1e-3  # largest relative change of its length in a calm step
MAX_NEWTON_FRACTION = 0.05  # calm steps that damped Newton may recover


@dataclass(frozen=True)
class Stability:
    """The map."""

    runs: list[Run]  # one for each point
    settings: dict[str, Any]  # of the study and the machine

    @cached_property
    def at(self) -> dict[MapPoint, Run]:
        """Runs by their place."""
        return {run.map_point: run for run in self.runs}

    @property
    def scenes(self) -> list[str]:
        """Names of the scenes, in order."""
        return list(dict.fromkeys(run.map_point.scene for run in self.runs))

    def of(self, scene: str, integrator: str, solver: str) -> list[Run]:
        """Return a panel of the map."""
        return [
            run for run in self.runs
            if (run.map_point.scene, run.map_point.integrator, run.map_point.solver)
            == (scene, integrator, solver)
        ]  # fmt: skip

    def with_newton(self) -> Iterator[tuple[Run, Run]]:
        """Yield every run with another solver and that of Newton at the same place."""
        for run in self.runs:
            newton = self.at.get(run.map_point._replace(solver="Newton"))
            if newton is not None and run.map_point.solver != "Newton":
                yield run, newton

    def worse_than_newton(self, outcome: str = FAILED) -> list[Run]:
        """Return the runs that end in this way where Newton's comes to its end, not by chance."""
        return [
            run for run, newton in self.with_newton()
            if run.outcome == outcome and newton.is_complete and not run.chaotic
        ]  # fmt: skip

    def by_chance(self) -> list[Run]:
        """Return the runs that do not finish where Newton's does, by chance alone."""
        return [run for run in self.runs if run.chaotic]

    def judged(self) -> Stability:
        """Return the map with those runs marked that end otherwise than Newton's by chance."""
        worse = [*self.worse_than_newton(FAILED), *self.worse_than_newton(GAINED)]
        chaotic = {run.map_point for run in worse if ends_by_chance(run.map_point)}
        runs = [replace(run, chaotic=run.map_point in chaotic) for run in self.runs]
        return Stability(runs, self.settings)

    def hidden_gains(self) -> list[Run]:
        """Return the runs that came to their end with more energy than they may have gained."""
        return [run for run in self.runs if run.is_complete and run.gain > MAX_GAIN]

    def calm(self) -> list[Run]:
        """Return the runs that took steps, all of them calm, and came to their end."""
        return [
            run for run in self.runs
            if run.is_complete and run.turn < CALM_TURN and run.stretch < CALM_STRETCH
        ]  # fmt: skip

    def calm_of_others(self) -> list[Run]:
        """Return the calm runs of all solvers but Newton, which recovers their failed steps."""
        return [run for run in self.calm() if run.map_point.solver != "Newton"]

    def often_recovered(self) -> list[Run]:
        """Return those in which damped Newton recovered too many steps."""
        return [run for run in self.calm_of_others() if run.newton > MAX_NEWTON_FRACTION]


def map_points(
    scenes: Sequence[str], stiffnesses: Sequence[float], steps: Sequence[float]
) -> list[MapPoint]:
    """Return the points of the cut."""
    pairs = [(i, s) for i in INTEGRATORS for s in SOLVERS
             if s in FOR_ALL_INTEGRATORS or i in FOR_ALL_SOLVERS]  # fmt: skip
    return [
        MapPoint(scene, stiffness, dt, integrator, solver)
        for scene in scenes
        for integrator, solver in pairs
        for stiffness in stiffnesses
        for dt in steps
    ]


Scenes = Annotated[list[str] | None, typer.Option("--scene", help="Only this scene; repeatable.")]
Steps = Annotated[list[float] | None, typer.Option("--step", help="Only this time step [s].")]
Stiffnesses = Annotated[
    list[float] | None, typer.Option("--stiffness", help="Only this Young's modulus [Pa].")
]


def stability_map(
    scenes: Scenes = None,
    steps: Steps = None,
    stiffnesses: Stiffnesses = None,
    table: Annotated[
        Path | None,
        typer.Option("--from", help="Run nothing: tables and charts of this stability.csv."),
    ] = None,
    progress: bool = False,
) -> Stability:
    """Map the runs that complete, over step, stiffness, integrator and solver; minutes."""
    if table is not None:
        if scenes or steps or stiffnesses:
            raise InputError(
                f"--from {table} shows a map that is finished: leave out --scene, --step and "
                "--stiffness, or --from"
            )
        return read(table)
    cut = check_cut(scenes, steps, stiffnesses, SCENES)
    runs = [run_at(map_point) for map_point in progress_bar(map_points(*cut), "run", progress)]
    settings = {
        "t_end_s": T_END,
        "max_steps": MAX_STEPS,
        "tolerance": "default",
        "max_energy_gain": MAX_GAIN,
        **environment(),
    }
    return Stability(runs, settings).judged()


def check_cut(
    scenes: Sequence[str] | None,
    steps: Sequence[float] | None,
    stiffnesses: Sequence[float] | None,
    table: Mapping[str, Any],
) -> tuple[Sequence[str], Sequence[float], Sequence[float]]:
    """Return scenes, Young's moduli [Pa] and steps [s] after a check, by default all."""
    for scene in scenes or ():
        check_choice("scene", scene, table)
    for what, values, unit in (("stiffness", stiffnesses, "Pa"), ("step", steps, "s")):
        for value in values or ():
            check_positive(what, value, unit)
    return scenes or tuple(table), stiffnesses or STIFFNESSES, steps or STEPS


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
            f"{path} is not a table of `python -m benchmarks stability map`: a column or number is "
            f"missing ({error})"
        ) from error
    if not runs:
        raise InputError(f"{path} holds no run of `python -m benchmarks stability map`")
    return Stability(runs, {"read_from": path.name})
