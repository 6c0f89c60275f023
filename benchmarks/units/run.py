"""The same scenes in other units and under other accelerations: nothing may depend on a scale."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.nonlinear import Method, QuasiNewton
from ancfsparse.nonlinear.methods import UPDATES
from ancfsparse.scene import Beam, Material, Rectangle, Scene
from ancfsparse.solve import simulate
from benchmarks.common import methods
from benchmarks.common.methods import chosen
from benchmarks.common.progress import bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table


class Units(NamedTuple):
    """How many of a system's units make a metre, a kilogram and a second."""

    length: float
    mass: float
    time: float


UNITS = {
    "kg m s": Units(1.0, 1.0, 1.0),
    "t mm s": Units(1e3, 1e-3, 1.0),
    "g um ms": Units(1e6, 1e3, 1e3),
    "g cm s": Units(1e2, 1e3, 1.0),
    "kg mm ms": Units(1e3, 1.0, 1e3),
    "kg km h": Units(1e-3, 1.0, 1.0 / 3600.0),
    "lb ft s": Units(1.0 / 0.3048, 1.0 / 0.45359237, 1.0),
}
# Accelerations [m/s2]; moduli go with them, so that the motions are the same but for their time.
GRAVITIES = (1e-6, 1e-4, 1e-2, 1.0, 9.81, 1e2, 1e3, 1e4)
STANDARD = 9.81

LENGTH, STEPS, SAVED = 2.0, 200, 20
FEW_PAIRS = 5
SOLVERS: tuple[Method | str, ...] = (
    *chosen(methods.SOLVERS, "auto", "modified Newton", "Newton").values(),
    *chosen(methods.SOLVERS, *(f"{update}, full" for update in UPDATES)).values(),
    *(QuasiNewton(update, FEW_PAIRS) for update in UPDATES),
)
INTEGRATORS: tuple[Implicit | Explicit, ...] = tuple(
    chosen(
        methods.INTEGRATORS,
        *("GeneralizedAlpha(0.9)", "Newmark(0)", "HHT(0.05)", "EnergyMomentum"),
        "RungeKuttaNystrom(4)",
    ).values()
)


def _pendulum(units: Units, gravity: float, modulus: float = 1e8) -> tuple[Scene, Beam]:
    _, material = _scaled(units, gravity, modulus, 4000.0)
    scene = Scene((0.0, -gravity * units.length / units.time**2))
    section = Rectangle(0.01 * units.length, 0.01 * units.length)
    rod = scene.add_beam("thin", (0, 0), (LENGTH * units.length, 0), 8, section, material)
    scene.pin(rod.start)
    return scene, rod


def _steel(units: Units, gravity: float) -> tuple[Scene, Beam]:
    return _pendulum(units, gravity, 2.1e11)


def _hung(units: Units, gravity: float) -> tuple[Scene, Beam]:
    scene, rod = _pendulum(units, gravity)
    scene.rod(rod.end, (LENGTH * units.length, 0.5 * LENGTH * units.length))
    return scene, rod


def _pushed(units: Units, gravity: float) -> tuple[Scene, Beam]:
    """Let a force bend a thick beam to and fro."""
    second, material = _scaled(units, gravity, 1e9, 4000.0)
    scene = Scene((0.0, -gravity * units.length / units.time**2, 0.0))
    section = Rectangle(0.02 * units.length, 0.02 * units.length)
    end = (LENGTH * units.length, 0, 0)
    beam = scene.add_beam("thick", (0, 0, 0), end, 4, section, material)
    scene.clamp(beam.start)
    force = 0.2 * gravity / STANDARD * units.mass * units.length / units.time**2
    scene.point_force(beam.end, lambda t: (0.0, 0.0, force * math.sin(5.0 * t / second)))
    return scene, beam


def _scaled(units: Units, gravity: float, modulus: float, density: float) -> tuple[float, Material]:
    """Return what stands for a second, and a material whose stress is in proportion to gravity."""
    second = math.sqrt(STANDARD / gravity) * units.time
    stress = gravity / STANDARD * units.mass / (units.length * units.time**2)
    return second, Material(modulus * stress, density * units.mass / units.length**3, 0.3)


SCENES: dict[str, tuple[Callable[[Units, float], tuple[Scene, Beam]], float]] = {
    "pendulum": (_pendulum, 5e-4),
    "steel pendulum": (_steel, 1e-3),
    "pendulum on a rod": (_hung, 5e-4),
    "pushed beam": (_pushed, 5e-4),
}
"""What makes a scene, and its time step under 9.81 m/s2 [s]."""


@dataclass(frozen=True)
class Run:
    """One scene in one system of units, beside the same in SI units under 9.81 m/s2."""

    # what was run
    scene: str
    integrator: str
    solver: str
    units: str
    gravity: float  # acceleration [m/s2]
    # largest distance of the tips at equal shares of the run, over the length [-]
    difference: float
    # corrections and evaluations per step
    iterations: float
    residuals: float
    count_difference: float  # of these two the larger relative difference [-]


class _Found(NamedTuple):
    tip: NDArray[np.float64]
    iterations: float
    residuals: float


def cases(
    scenes: Sequence[str] = tuple(SCENES),
) -> Iterator[tuple[str, Implicit | Explicit, Method | str]]:
    """Give each scene with each integrator under "auto", and each solver under the first."""
    for scene in scenes:
        for integrator in INTEGRATORS:
            if isinstance(integrator, Explicit):
                if scene == "pendulum":
                    yield scene, integrator, "auto"
                continue
            for solver in SOLVERS if integrator == INTEGRATORS[0] else SOLVERS[:1]:
                yield scene, integrator, solver


def units(
    scenes: Sequence[str] = tuple(SCENES),
    systems: Sequence[str] = tuple(UNITS),
    gravities: Sequence[float] = GRAVITIES,
    progress: bool = False,
) -> list[Run]:
    """Run the same scenes in all systems of units and under all accelerations."""
    runs = []
    for scene, integrator, solver in bar(list(cases(scenes)), "case", progress):
        first = _run(scene, integrator, solver, UNITS["kg m s"], STANDARD)
        for name in systems:
            for gravity in gravities:
                found = _run(scene, integrator, solver, UNITS[name], gravity)
                apart = np.linalg.norm(found.tip - first.tip, axis=1).max() / LENGTH
                counts = max(
                    abs(found.iterations - first.iterations) / max(first.iterations, 1.0),
                    abs(found.residuals / first.residuals - 1.0),
                )
                runs.append(
                    Run(
                        scene,
                        repr(integrator),
                        solver if isinstance(solver, str) else repr(solver),
                        name,
                        gravity,
                        float(apart),
                        found.iterations,
                        found.residuals,
                        counts,
                    )
                )
    return runs


def _run(
    name: str, integrator: Implicit | Explicit, solver: Method | str, system: Units, gravity: float
) -> _Found:
    make, dt = SCENES[name]
    scene, beam = make(system, gravity)
    step = dt * math.sqrt(STANDARD / gravity) * system.time
    if isinstance(integrator, Explicit):
        step /= 4.0
    run = simulate(
        scene, STEPS * step, step, integrator=integrator, solver=solver, save_every=SAVED
    )
    stats = run.stats
    return _Found(
        run.position(beam.end) / system.length,
        stats.iterations / stats.steps,
        stats.residual_evaluations / stats.steps,
    )


def tables(runs: Sequence[Run]) -> list[Table]:
    """Set the worst of each case, and of each system of units and acceleration."""
    cases = []
    for scene, integrator, solver in dict.fromkeys((r.scene, r.integrator, r.solver) for r in runs):
        mine = [r for r in runs if (r.scene, r.integrator, r.solver) == (scene, integrator, solver)]
        short = solver.split(", carry")[0].replace("(max_iterations=25", "(")
        counts = 100.0 * max(r.count_difference for r in mine)
        cases.append([scene, integrator, short, _worst(mine), f"{counts:.1f}%"])
    gravities = list(dict.fromkeys(r.gravity for r in runs))
    systems = [
        [name, *(_worst([r for r in runs if (r.units, r.gravity) == (name, g)]) for g in gravities)]
        for name in dict.fromkeys(r.units for r in runs)
    ]
    title = "Largest differences of positions over the length, by units and m/s2"
    return [
        Table(["scene", "integrator", "solver", "positions", "counts"], cases, (0, 1, 2)),
        Table(["", *(f"{g:g}" for g in gravities)], systems, title=title),
    ]


def _worst(runs: Sequence[Run]) -> str:
    return f"{max(run.difference for run in runs):.1e}"


STUDY = Study("units", run=units, tables=tables, rows=lambda runs: [asdict(run) for run in runs])
