"""Maps of outcomes over stiffness, time step, integrator and solver: all runs, and comparisons."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Annotated, Any

import typer

from ancfsparse.checks import check_choice, check_positive
from ancfsparse.errors import InputError
from benchmarks.common.progress import bar as progress_bar
from benchmarks.other_codes.environment import environment
from benchmarks.stability.cells import FAILED, GAINED, MapPoint, Run
from benchmarks.stability.map_spec import MapSpec

MAX_GAIN = 0.01  # energy that a finished run may gain, relative to the energy of its measure


@dataclass(frozen=True)
class Stability:
    """A map."""

    runs: list[Run]  # one for each point
    settings: dict[str, Any]  # of the study and the machine
    spec: MapSpec = field(repr=False)

    @cached_property
    def at(self) -> dict[MapPoint, Run]:
        """Runs by their place."""
        return {run.map_point: run for run in self.runs}

    @property
    def scenes(self) -> list[str]:
        """Names of the scenes, in order."""
        return list(dict.fromkeys(run.map_point.scene for run in self.runs))

    @property
    def integrators(self) -> list[str]:
        """Names of the integrators, in order."""
        names = {run.map_point.integrator for run in self.runs}
        return [name for name in self.spec.integrators if name in names]

    @property
    def groups(self) -> dict[str, list[str]]:
        """Scenes that differ in what follows the comma of their names, by what precedes it."""
        groups: dict[str, list[str]] = {}
        for scene in self.scenes:
            groups.setdefault(scene.partition(",")[0], []).append(scene)
        return groups

    def of(self, scenes: Sequence[str], integrator: str, solver: str) -> list[Run]:
        """Return a panel of the map."""
        return [
            run for run in self.runs
            if run.map_point.scene in scenes
            and (run.map_point.integrator, run.map_point.solver) == (integrator, solver)
        ]  # fmt: skip

    def newton_at(self, run: Run) -> Run | None:
        """Return the run of Newton at the same place, if it is another one."""
        newton = self.at.get(run.map_point._replace(solver="Newton"))
        return None if newton is run else newton

    def with_newton(self) -> Iterator[tuple[Run, Run]]:
        """Yield every run with another solver and that of Newton at the same place."""
        for run in self.runs:
            if (newton := self.newton_at(run)) is not None:
                yield run, newton

    def worse_than_newton(self, outcome: str = FAILED) -> list[Run]:
        """Return the runs that end in this way where Newton's comes to its end, not by chance."""
        return [
            run for run, newton in self.with_newton()
            if run.outcome == outcome and newton.is_complete and not run.chaotic
        ]  # fmt: skip

    def better_than_newton(self) -> list[Run]:
        """Return the runs that come to their end where Newton's does not."""
        return [
            run for run, newton in self.with_newton()
            if run.is_complete and not newton.is_complete
        ]  # fmt: skip

    def by_chance(self) -> list[Run]:
        """Return the runs that do not finish where Newton's does, by chance alone."""
        return [run for run in self.runs if run.chaotic]

    def judged(self) -> Stability:
        """Return the map with those runs marked that end otherwise than Newton's by chance."""
        worse = [*self.worse_than_newton(FAILED), *self.worse_than_newton(GAINED)]
        finishes = cache(self.spec.finishes)
        chaotic = {
            run.map_point for run in worse if self.spec.ends_by_chance(run.map_point, finishes)
        }
        runs = [replace(run, chaotic=run.map_point in chaotic) for run in self.runs]
        return replace(self, runs=runs)

    def hidden_gains(self) -> list[Run]:
        """Return the runs that came to their end with more energy than they may have gained."""
        return [run for run in self.runs if run.is_complete and run.gain > MAX_GAIN]


Scenes = Annotated[list[str] | None, typer.Option("--scene", help="Only this scene; repeatable.")]
Steps = Annotated[list[float] | None, typer.Option("--step", help="Only this time step [s].")]
Stiffnesses = Annotated[list[float] | None, typer.Option("--stiffness", help="Only this one.")]
Names = Annotated[list[str] | None, typer.Option("--integrator", help="Only this integrator.")]
Solvers = Annotated[list[str] | None, typer.Option("--solver", help="Only this solver.")]
Table = Annotated[
    Path | None, typer.Option("--from", help="Run nothing: tables and charts of this table.")
]


def map_command(spec: MapSpec, purpose: str) -> Callable[..., Stability]:
    """Return the run of a study that makes a map."""

    def run(
        scenes: Scenes = None,
        steps: Steps = None,
        stiffnesses: Stiffnesses = None,
        integrators: Names = None,
        solvers: Solvers = None,
        table: Table = None,
        progress: bool = False,
    ) -> Stability:
        if table is not None:
            if scenes or steps or stiffnesses or integrators or solvers:
                raise InputError(
                    f"--from {table} shows a map that is finished: leave out --scene, --step, "
                    "--stiffness, --integrator and --solver, or --from"
                )
            return read(table, spec)
        cut = check_cut(scenes, steps, stiffnesses, spec.scenes)
        for what, names, choices in (
            ("integrator", integrators, spec.integrators),
            ("solver", solvers, spec.solvers),
        ):
            for name in names or ():
                check_choice(what, name, choices)
        points = spec.map_points(*cut, integrators or (), solvers or ())
        if not points:
            raise InputError(
                f"the map has no run of {', '.join(integrators or ())} with "
                f"{', '.join(solvers or ())}: all solvers are run with "
                f"{' and '.join(spec.for_all_solvers)} only"
            )
        runs = [spec.run_at(point) for point in progress_bar(points, "run", progress)]
        settings = {
            "t_end_s": spec.t_end,
            "max_steps": spec.max_steps,
            "tolerance": "default",
            "max_energy_gain": MAX_GAIN,
            **environment(),
        }
        return Stability(runs, settings, spec).judged()

    run.__doc__ = purpose
    return run


def check_cut(
    scenes: Sequence[str] | None,
    steps: Sequence[float] | None,
    stiffnesses: Sequence[float] | None,
    table: Mapping[str, Any],
) -> tuple[Sequence[str], Sequence[float], Sequence[float]]:
    """Return scenes, stiffnesses and steps [s] after a check, empty for all."""
    for scene in scenes or ():
        check_choice("scene", scene, table)
    for what, values, unit in (("stiffness", stiffnesses, ""), ("step", steps, "s")):
        for value in values or ():
            check_positive(what, value, unit)
    return scenes or (), stiffnesses or (), steps or ()


def read(path: Path, spec: MapSpec) -> Stability:
    """Read a map from the table that its study writes.

    Raises
    ------
    InputError
        If the file is not such a table.
    """
    command = f"`python -m benchmarks {spec.command}`"
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    try:
        runs = [Run.of(row, spec.measures) for row in rows]
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"{path} is not a table of {command}: a column or number is missing ({error})"
        ) from error
    if not runs:
        raise InputError(f"{path} holds no run of {command}")
    return Stability(runs, {"read_from": path.name}, spec)
