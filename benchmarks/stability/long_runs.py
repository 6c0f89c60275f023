"""A million steps: whether memory grows, and what becomes of the energy.

The paper's pendulum falls for 500 s without damping.  Its energy goes little by little into waves
as short as the elements, which no step of that length resolves; each integrator keeps, loses or
invents them in its own way.  The same of steel has waves that no step but an explicit one's can
resolve, and hardly feeds them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_count
from ancfsparse.errors import StepError
from ancfsparse.problems import pendulum
from ancfsparse.results import Trajectory
from ancfsparse.solve import simulate
from benchmarks.common import paper
from benchmarks.common.methods import INTEGRATORS
from benchmarks.common.process import peak_memory
from benchmarks.common.progress import bar as progress_bar
from benchmarks.other_codes.environment import environment

Vector = NDArray[np.float64]

SAVED = 5000
"""States that are saved of a run."""

# The energy may not rise further above its start than this share of the largest kinetic energy.
MOST_RISE = 1e-3

# The first run of a tenth of the steps shows what a run needs at all; what the whole run needs
# beyond it, with as many saved states, is growth [bytes].
NOISE = 4e6


# Young's modulus of the paper's pendulum, and of steel [Pa].
SOFT, STEEL = 1e8, 2.1e11


@dataclass(frozen=True)
class Entrant:
    """An integrator and its step, in terms of the paper's [-].

    Attributes
    ----------
    name : str
        Of the integrator.
    share : float
        Its step over the paper's.
    youngs_modulus : float
        Of the pendulum [Pa].
    max_halvings : int
        How often a step that cannot be solved may be halved.
    """

    name: str
    share: float
    youngs_modulus: float = SOFT
    max_halvings: int = 0

    @property
    def label(self) -> str:
        """For tables and legends."""
        what = "steel, " if self.youngs_modulus == STEEL else ""
        return f"{what}{self.name}, dt = {self.share * paper.DT:g} s"


ENTRANTS = (
    Entrant("GeneralizedAlpha(0.8)", 1.0),
    Entrant("GeneralizedAlpha(0.9)", 1.0),
    Entrant("RungeKuttaNystrom(8)", 0.25),
    Entrant("EnergyMomentum", 1.0),
    *(Entrant("EnergyMomentum", share, max_halvings=6) for share in (2.0, 4.0)),
    Entrant("Newmark(0)", 0.5),
    *(Entrant("CentralDifference", share) for share in (0.125, 0.25, 0.5)),
    *(Entrant("Newmark(0)", share) for share in (1.0, 2.0, 4.0, 8.0, 20.0)),
    *(
        Entrant(name, share, STEEL)
        for name in ("EnergyMomentum", "GeneralizedAlpha(0.8)", "Newmark(0)")
        for share in (1.0, 4.0, 20.0)
    ),
)
"""What falls; the trapezoidal rule also with steps at which it fails."""


@dataclass(frozen=True)
class LongRun:
    """What became of a run.

    Attributes
    ----------
    label : str
        Integrator and step.
    dt : float
        Step [s].
    t : ndarray, shape (k,)
        Times of the saved states [s].
    energy : ndarray, shape (k,)
        Energy above that at the start, over the largest kinetic energy [-].
    stopped : float
        When it was stopped [s]; not a number if it was not.
    reason : str
        Why, empty if it was not.
    seconds : float
        Of the march [s].
    growth : float
        Memory beyond that of a tenth of the run [bytes].
    youngs_modulus : float
        Of the pendulum [Pa].
    iterations : float
        Per step [-].
    halved : int
        Steps that were crossed in shorter ones.
    """

    label: str
    dt: float
    t: Vector = field(repr=False)
    energy: Vector = field(repr=False)
    stopped: float
    reason: str
    seconds: float
    growth: float
    youngs_modulus: float = SOFT
    iterations: float = math.nan
    halved: int = 0

    @property
    def rise(self) -> float:
        """Most energy above the start, over the largest kinetic energy [-]."""
        return float(self.energy.max())

    @property
    def rate(self) -> float:
        """Mean change of the energy over the run, in largest kinetic energies per second [1/s]."""
        return float(self.energy[-1] / self.t[-1])

    @property
    def steel(self) -> bool:
        """Whether the pendulum is of steel."""
        return self.youngs_modulus == STEEL

    @property
    def kept(self) -> bool:
        """Whether it came to its end and never gained more than it may."""
        return not self.reason and self.rise <= MOST_RISE

    def record(self) -> dict[str, Any]:
        """Return a row of the table."""
        return {
            "run": self.label,
            "dt": self.dt,
            "t_end": float(self.t[-1]),
            "reason": self.reason,
            "rise": self.rise,
            "end": float(self.energy[-1]),
            "rate": self.rate,
            "seconds": self.seconds,
            "growth": self.growth,
            "youngs_modulus": self.youngs_modulus,
            "iterations": self.iterations,
            "halved": self.halved,
        }


@dataclass(frozen=True)
class LongRuns:
    """Everything ``python -m benchmarks long-runs`` finds."""

    runs: list[LongRun]
    settings: dict[str, Any]


def long_runs(
    steps: int = 1_000_000, entrants: Sequence[Entrant] = ENTRANTS, progress: bool = False
) -> LongRuns:
    """Let the paper's pendulum fall for so many of the paper's steps."""
    check_count("steps", steps, 200)
    wanted = progress_bar(entrants, "run", progress)
    runs = [_fall(entrant, steps) for entrant in wanted]
    settings = {"scene": "the paper's pendulum, thin", "steps": steps, **environment()}
    return LongRuns(runs, settings)


def _fall(entrant: Entrant, paper_steps: int) -> LongRun:
    dt = entrant.share * paper.DT
    steps = max(1, round(paper_steps / entrant.share))
    _march(entrant, dt, max(1, steps // 10))
    before = peak_memory()
    path, stopped, reason = _march(entrant, dt, steps)
    growth = peak_memory() - before
    energy = path.energy
    above = (energy.total - energy.total[0]) / energy.kinetic.max()
    halved = sum("steps of" in event.rung for event in path.stats.events)
    return LongRun(
        entrant.label, dt, np.asarray(path.t), above, stopped, reason, path.stats.march_seconds,
        float(growth), entrant.youngs_modulus, path.stats.iterations / max(path.stats.steps, 1),
        halved,
    )  # fmt: skip


def _march(entrant: Entrant, dt: float, steps: int) -> tuple[Trajectory, float, str]:
    scene, _ = pendulum("thin", paper.ELEMENTS, youngs_modulus=entrant.youngs_modulus)
    try:
        path = simulate(
            scene, steps * dt, dt, integrator=INTEGRATORS[entrant.name],
            save_every=max(1, steps // SAVED), max_halvings=entrant.max_halvings,
        )  # fmt: skip
    except StepError as stop:
        return stop.trajectory, stop.time, type(stop).__name__
    return path, math.nan, ""
