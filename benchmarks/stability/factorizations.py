"""Runs that finish on complete and on incomplete seeds, over time step and stiffness."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from matplotlib.figure import Figure

from ancfsparse.checks import check_choice
from ancfsparse.errors import EnergyIncreaseError, StepError
from ancfsparse.problems import lattice, octet
from ancfsparse.scene import Scene
from ancfsparse.solve import simulate
from benchmarks.common import methods
from benchmarks.common.charts import new_figure, set_axes, set_legend
from benchmarks.common.methods import chosen
from benchmarks.common.progress import bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.stability.scenes import SCENES
from benchmarks.stability.stability_map import STEPS, STIFFNESSES

DENSITY = 4000.0
MOST_STEPS = 100
FACTORIZATIONS = ("complete", "incomplete", "auto")
INTEGRATORS = chosen(methods.IMPLICIT, "Newmark(0)", "GeneralizedAlpha(0.8)")
# Product of step and highest axial frequency of an element up to which incomplete seeds must serve.
CLAIM = 250.0
# That frequency over the time of a wave through an element [-].
OMEGA = 9.55


def _lattice(modulus: float) -> Scene:
    return lattice(5, "smooth", modulus, DENSITY).scene


def _rough(modulus: float) -> Scene:
    return lattice(5, "rough", modulus, DENSITY).scene


def _truss(modulus: float) -> Scene:
    return octet(2, "smooth", modulus, DENSITY).scene


def _plain(name: str) -> Callable[[float], Scene]:
    return lambda modulus: SCENES[name](modulus).scene


CASES: dict[str, Callable[[float], Scene]] = {
    **{name: _plain(name) for name in ("pendulum", "compressed beam", "sudden force")},
    "lattice": _lattice,
    "rough lattice": _rough,
    "octet truss": _truss,
}
"""Each takes Young's modulus [Pa]; beams of the map that are no mesh have nothing to drop."""


@dataclass(frozen=True)
class Row:
    """A point of the map.

    Attributes
    ----------
    scene, integrator, factorization : str
        Keys of `CASES`, `INTEGRATORS`, and the factorization.
    youngs_modulus, dt : float
        Stiffness [Pa] and step [s].
    h_omega : float
        Step times the highest axial frequency of an element [-].
    outcome : str
        ``"finished"``, ``"gained energy"`` or ``"failed"``.
    steps : int
        Steps that were accepted.
    on_exact : bool
        Whether the run went over from an incomplete seed to the complete one.
    """

    scene: str
    integrator: str
    factorization: str
    youngs_modulus: float
    dt: float
    h_omega: float
    outcome: str
    steps: int
    on_exact: bool


def seeds(
    scenes: Sequence[str] = tuple(CASES),
    stiffnesses: Sequence[float] = STIFFNESSES,
    steps: Sequence[float] = STEPS,
    progress: bool = False,
) -> list[Row]:
    """Run the map on each factorization, up to 100 steps a run."""
    for scene in scenes:
        check_choice("scene", scene, CASES)
    points = [
        (scene, integrator, modulus, dt, factorization)
        for scene in scenes
        for integrator in INTEGRATORS
        for modulus in stiffnesses
        for dt in steps
        for factorization in FACTORIZATIONS
    ]
    return [_run(*point) for point in bar(points, "run", progress)]


def _run(name: str, integrator: str, modulus: float, dt: float, factorization: str) -> Row:
    scene = CASES[name](modulus)
    outcome = "finished"
    try:
        stats = simulate(
            scene, MOST_STEPS * dt, dt, integrator=INTEGRATORS[integrator],
            factorization=factorization, save_every=MOST_STEPS,
        ).stats  # fmt: skip
    except EnergyIncreaseError as error:
        stats, outcome = error.trajectory.stats, "gained energy"
    except StepError as error:
        stats, outcome = error.trajectory.stats, "failed"
    over = "a complete seed" in stats.solver
    return Row(
        name,
        integrator,
        factorization,
        modulus,
        dt,
        dt * frequency(scene),
        outcome,
        stats.steps,
        over,
    )


def frequency(scene: Scene) -> float:
    """Return the highest axial frequency of an element of a scene [1/s]."""
    (body,) = scene.beams
    values = body.stiffnesses()
    speed = math.sqrt(values["axial_stiffness"] / values["mass_per_length"])
    return OMEGA * speed / float(body.lengths.min())


def worse(rows: Sequence[Row], factorization: str) -> list[Row]:
    """Return the runs on a factorization that do not finish where those on complete ones do."""
    whole = {
        (row.scene, row.integrator, row.youngs_modulus, row.dt)
        for row in rows if row.factorization == "complete" and row.outcome == "finished"
    }  # fmt: skip
    return [
        row for row in rows
        if row.factorization == factorization and row.outcome != "finished"
        and (row.scene, row.integrator, row.youngs_modulus, row.dt) in whole
    ]  # fmt: skip


def findings(rows: Sequence[Row]) -> list[str]:
    """State which runs need the complete seed, and whether they go over to it by themselves."""
    sentences = []
    for factorization in FACTORIZATIONS[1:]:
        lost = worse(rows, factorization)
        below = [row for row in lost if row.h_omega <= CLAIM]
        total = sum(row.factorization == factorization for row in rows)
        sentences.append(
            f"With factorization={factorization!r} {len(lost)} of {total} runs do not finish where "
            f"complete seeds do, {len(below)} of them at h omega up to {CLAIM:g}"
        )
        sentences += [
            f"{row.scene}, {row.youngs_modulus:.0e} Pa, dt = {row.dt:g} s (h omega = "
            f"{row.h_omega:.3g}), {row.integrator}, factorization={factorization!r}: {row.outcome} "
            f"after {row.steps} steps"
            for row in lost
        ]
    over = sum(row.on_exact for row in rows)
    sentences.append(f"Of the runs with factorization='auto' {over} went over to a complete seed")
    return sentences


def finished(rows: Sequence[Row]) -> Table:
    """Set how many runs finish, by scene and factorization."""
    lines = []
    for scene in dict.fromkeys(row.scene for row in rows):
        cells = []
        for factorization in FACTORIZATIONS:
            own = [row for row in rows if (row.scene, row.factorization) == (scene, factorization)]
            cells.append(f"{sum(row.outcome == 'finished' for row in own)} of {len(own)}")
        lines.append([scene, *cells])
    return Table(["finished of all", *FACTORIZATIONS], lines)


OUTCOMES = {
    (True, True): ("both finish", "#009e73", "."),
    (True, False): ("only complete ones finish", "#d55e00", "x"),
    (False, True): ("only incomplete ones finish", "#0072b2", "+"),
    (False, False): ("neither finishes", "#999999", "."),
}
"""Label, colour and marker by which runs finish: on complete and on incomplete seeds."""


def chart(rows: Sequence[Row]) -> Figure:
    """Draw at each stiffness and step which seeds finish, the two integrators side by side."""
    scenes = list(dict.fromkeys(row.scene for row in rows))
    lines = -(-len(scenes) // 3)
    figure = new_figure(2.6 * lines + 1.2, "Runs that finish on complete and on incomplete seeds")
    axes = figure.subplots(lines, min(3, len(scenes)), squeeze=False)
    shown: dict[str, Any] = {}
    for ax in axes.ravel()[len(scenes) :]:
        ax.set_axis_off()
    for ax, scene in zip(axes.ravel(), scenes, strict=False):
        finished = {
            (row.factorization, row.integrator, row.youngs_modulus, row.dt):
                row.outcome == "finished"
            for row in rows if row.scene == scene
        }  # fmt: skip
        for (factorization, integrator, modulus, dt), whole in finished.items():
            if factorization == "complete":
                other = finished["incomplete", integrator, modulus, dt]
                label, colour, marker = OUTCOMES[whole, other]
                x = dt * (0.9 if integrator == next(iter(INTEGRATORS)) else 1.1)
                (shown[label],) = ax.plot(x, modulus, marker, color=colour, linestyle="none")
        set_axes(ax, "dt [s]", "Young's modulus [Pa]", title=scene)
    set_legend(figure, shown, 4)
    return figure


STUDY = Study(
    "stability-seeds",
    run=seeds,
    tables=lambda rows: [finished(rows)],
    rows=lambda rows: [asdict(row) for row in rows],
    findings=findings,
    charts={"stability-seeds": chart},
    regions={"stability-seeds": finished},
)
