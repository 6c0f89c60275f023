"""Outcome on complete and on incomplete seeds over time step and stiffness."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from ancfsparse.errors import EnergyIncreaseError, StepError
from ancfsparse.problems import lattice, octet
from ancfsparse.scene import Scene
from ancfsparse.solve import simulate
from benchmarks.common import methods
from benchmarks.common.charts import new_figure, panels, set_axes, set_legend
from benchmarks.common.methods import chosen
from benchmarks.common.progress import bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.stability.beam_map import BEAMS
from benchmarks.stability.scenes import SCENES
from benchmarks.stability.stability_map import Scenes, Steps, Stiffnesses, check_cut

DENSITY = 4000.0  # [kg/m3]
MAX_STEPS = 100  # of a run
FACTORIZATIONS = ("complete", "incomplete", "auto")
INTEGRATORS = chosen(methods.IMPLICIT, "Newmark(0)", "GeneralizedAlpha(0.8)")
CLAIMED_H_OMEGA = (
    250.0  # step times highest axial frequency up to which incomplete seeds must serve
)
WAVE_OMEGA = 9.55  # that frequency times the travel time of a wave through an element [-]


CASES: dict[str, Callable[[float], Scene]] = {
    "pendulum": lambda modulus: SCENES["pendulum"](modulus).scene,
    "compressed beam": lambda modulus: SCENES["compressed beam"](modulus).scene,
    "sudden force": lambda modulus: SCENES["sudden force"](modulus).scene,
    "lattice": lambda modulus: lattice(5, "smooth", modulus, DENSITY).scene,
    "rough lattice": lambda modulus: lattice(5, "rough", modulus, DENSITY).scene,
    "octet truss": lambda modulus: octet(2, "smooth", modulus, DENSITY).scene,
}
"""Scenes by Young's modulus [Pa], without multipliers."""


@dataclass(frozen=True)
class Row:
    """A point of the map."""

    # keys of `CASES`, `INTEGRATORS`, and the kind of seed
    scene: str
    integrator: str
    factorization: str
    # stiffness [Pa] and step [s]
    youngs_modulus: float
    dt: float
    h_omega: float  # step times the highest axial frequency of an element [-]
    outcome: str  # ``"finished"``, ``"gained energy"`` or ``"failed"``
    steps: int  # steps that were accepted
    on_complete: bool  # the run changed from an incomplete seed to the complete one

    @property
    def is_complete(self) -> bool:
        """True if it came to its end."""
        return self.outcome == "finished"

    @property
    def point(self) -> tuple[str, str, float, float]:
        """The point without the kind of seed."""
        return self.scene, self.integrator, self.youngs_modulus, self.dt


def factorizations(
    scenes: Scenes = None, steps: Steps = None, stiffnesses: Stiffnesses = None,
    progress: bool = False,
) -> list[Row]:  # fmt: skip
    """Map the runs that complete with exact and with incomplete seeds; minutes."""
    names, moduli, lengths = check_cut(scenes, steps, stiffnesses, CASES)
    axes = names or CASES, INTEGRATORS, moduli or BEAMS.stiffnesses, lengths or BEAMS.steps
    points = list(itertools.product(*axes, FACTORIZATIONS))
    return [_run(*point) for point in bar(points, "run", progress)]


def _run(name: str, integrator: str, modulus: float, dt: float, factorization: str) -> Row:
    scene = CASES[name](modulus)
    outcome = "finished"
    try:
        stats = simulate(
            scene, MAX_STEPS * dt, dt, integrator=INTEGRATORS[integrator],
            factorization=factorization, save_every=MAX_STEPS,
        ).stats  # fmt: skip
    except EnergyIncreaseError as error:
        stats, outcome = error.trajectory.stats, "gained energy"
    except StepError as error:
        stats, outcome = error.trajectory.stats, "failed"
    over = "a complete factorization" in stats.solver
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
    return WAVE_OMEGA * speed / float(body.lengths.min())


def worse(rows: Sequence[Row], factorization: str) -> list[Row]:
    """Return the runs on a kind of seed that do not finish where those on complete ones do."""
    complete = {row.point for row in rows if row.factorization == "complete" and row.is_complete}
    own = [row for row in rows if row.factorization == factorization and not row.is_complete]
    return [row for row in own if row.point in complete]


def findings(rows: Sequence[Row]) -> list[str]:
    """State the runs that need the complete seed, and the changes to it."""
    sentences = []
    for factorization in FACTORIZATIONS[1:]:
        lost = worse(rows, factorization)
        below = [row for row in lost if row.h_omega <= CLAIMED_H_OMEGA]
        total = sum(row.factorization == factorization for row in rows)
        sentences.append(
            f"With factorization={factorization!r} {len(lost)} of {total} runs do not finish where "
            f"complete seeds do, {len(below)} of them at h omega up to {CLAIMED_H_OMEGA:g}"
        )
        sentences += [
            f"{row.scene}, {row.youngs_modulus:.0e} Pa, dt = {row.dt:g} s (h omega = "
            f"{row.h_omega:.3g}), {row.integrator}, factorization={factorization!r}: {row.outcome} "
            f"after {row.steps} steps"
            for row in lost
        ]
    over = sum(row.on_complete for row in rows)
    sentences.append(f"Of the runs with factorization='auto' {over} went over to a complete seed")
    return sentences


def finished(rows: Sequence[Row]) -> Table:
    """Set the number of runs that finish, by scene and kind of seed."""
    lines = []
    for scene in dict.fromkeys(row.scene for row in rows):
        cells = []
        for factorization in FACTORIZATIONS:
            own = [row for row in rows if (row.scene, row.factorization) == (scene, factorization)]
            cells.append(f"{sum(row.is_complete for row in own)} of {len(own)}")
        lines.append([scene, *cells])
    return Table(["finished of all", *FACTORIZATIONS], lines)


OUTCOMES = {
    (True, True): ("both finish", "#009e73", "."),
    (True, False): ("only complete ones finish", "#d55e00", "x"),
    (False, True): ("only incomplete ones finish", "#0072b2", "+"),
    (False, False): ("neither finishes", "#999999", "."),
}
"""Label, colour and marker by completion on complete and on incomplete seeds."""


def chart(rows: Sequence[Row]) -> Figure:
    """Draw the outcome of both seeds over stiffness and step, the integrators side by side."""
    scenes = list(dict.fromkeys(row.scene for row in rows))
    lines = -(-len(scenes) // 3)
    figure = new_figure(2.6 * lines + 1.2, "Runs that finish on complete and on incomplete seeds")
    keys: dict[str, Any] = {}
    for ax, scene in zip(panels(figure, len(scenes), 3), scenes, strict=True):
        here = [row for row in rows if row.scene == scene]
        incomplete = {
            row.point for row in here if row.factorization == "incomplete" and row.is_complete
        }
        for row in here:
            if row.factorization == "complete":
                label, colour, marker = OUTCOMES[row.is_complete, row.point in incomplete]
                x = row.dt * (0.9 if row.integrator == next(iter(INTEGRATORS)) else 1.1)
                (keys[label],) = ax.plot(x, row.youngs_modulus, marker, color=colour)
        set_axes(ax, "dt [s]", "Young's modulus [Pa]", title=scene)
    set_legend(figure, keys, 4)
    return figure


STUDY = Study(
    "stability-seeds",
    run=factorizations,
    tables=lambda rows: [finished(rows)],
    rows=lambda rows: rows,
    findings=findings,
    charts={"stability-seeds": chart},
    regions={"stability-seeds": finished},
)
