"""A million steps: growth of memory, and change of energy.

The paper's pendulum falls for 500 s without damping.  Its energy is gradually transferred to waves
as short as the elements, which no step of that length resolves; each integrator conserves,
dissipates or generates it in its own way.  A pendulum of steel has waves that only explicit steps
resolve, and hardly excites them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
import typer
from matplotlib.figure import Figure

from ancfsparse.array_types import Vector
from ancfsparse.errors import StepError
from ancfsparse.problems import pendulum
from ancfsparse.results import Trajectory
from ancfsparse.solve import simulate
from benchmarks.common import paper
from benchmarks.common.charts import new_figure, panels, set_axes, set_legend
from benchmarks.common.methods import INTEGRATORS
from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table, group_by
from benchmarks.common.worker import peak_memory
from benchmarks.other_codes.environment import environment

SAVED = 5000  # states of a run
MAX_RISE = 1e-3  # energy above its start, over the largest kinetic energy
MIN_GROWTH = 4e6  # memory beyond that of a tenth of the steps that counts as growth [bytes]
SOFT_MODULUS = 1e8  # Young's modulus of the paper's pendulum [Pa]
STEEL = 2.1e11  # Young's modulus [Pa]


@dataclass(frozen=True)
class Candidate:
    """An integrator and its step, in terms of the paper's [-]."""

    name: str  # of the integrator
    step_ratio: float  # its step over the paper's
    youngs_modulus: float = SOFT_MODULUS  # of the pendulum [Pa]
    max_halvings: int = 0  # of a step that cannot be solved

    @property
    def label(self) -> str:
        """For tables and legends."""
        what = "steel, " if self.youngs_modulus == STEEL else ""
        return f"{what}{self.name}, dt = {self.step_ratio * paper.DT:g} s"


CANDIDATES = (
    Candidate("GeneralizedAlpha(0.8)", 1.0),
    Candidate("GeneralizedAlpha(0.9)", 1.0),
    Candidate("RungeKuttaNystrom(8)", 0.25),
    Candidate("EnergyMomentum", 1.0),
    *(Candidate("EnergyMomentum", fraction, max_halvings=6) for fraction in (2.0, 4.0)),
    Candidate("Newmark(0)", 0.5),
    *(Candidate("CentralDifference", fraction) for fraction in (0.125, 0.25, 0.5)),
    *(Candidate("Newmark(0)", fraction) for fraction in (1.0, 2.0, 4.0, 8.0, 20.0)),
    *(
        Candidate(name, fraction, STEEL)
        for name in ("EnergyMomentum", "GeneralizedAlpha(0.8)", "Newmark(0)")
        for fraction in (1.0, 4.0, 20.0)
    ),
)
"""Runs of the study; the trapezoidal rule also with steps at which it fails."""


@dataclass(frozen=True)
class LongRun:
    """The outcome of a run."""

    label: str  # integrator and step
    dt: float  # step [s]
    t: Vector = field(repr=False)  # (k,), times of the saved states [s]
    # (k,), energy above that at the start, over the largest kinetic energy [-]
    energy: Vector = field(repr=False)
    stopped: float  # when it was stopped [s]; not a number if it was not
    reason: str  # why, empty if it was not
    seconds: float  # of the time loop [s]
    growth: float  # memory beyond that of a tenth of the run [bytes]
    youngs_modulus: float = SOFT_MODULUS  # of the pendulum [Pa]
    iterations: float = math.nan  # per step [-]
    halved: int = 0  # steps that were crossed in shorter ones

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
        """True if the pendulum is of steel."""
        return self.youngs_modulus == STEEL

    @property
    def is_conservative(self) -> bool:
        """True if it came to its end and never gained too much energy."""
        return not self.reason and self.rise <= MAX_RISE

    def record(self) -> dict[str, Any]:
        """Return the entries of the CSV table."""
        names = ("dt", "reason", "rise", "rate", "seconds", "growth", "youngs_modulus")
        numbers = {name: getattr(self, name) for name in (*names, "iterations", "halved")}
        return {"run": self.label, "t_end": self.t[-1], "end": self.energy[-1], **numbers}


@dataclass(frozen=True)
class LongRuns:
    """All runs."""

    runs: list[LongRun]
    settings: dict[str, Any]


def long_runs(
    steps: Annotated[int, typer.Option(min=200, help=f"Time steps of {paper.DT:g} s.")] = 1_000_000,
    candidates: Sequence[Candidate] = CANDIDATES,
    progress: bool = False,
) -> LongRuns:
    """Let the paper's pendulum fall for a million steps: memory, energy, and failures."""
    bar_items = progress_bar(candidates, "run", progress)
    runs = [_fall(candidate, steps) for candidate in bar_items]
    settings = {"scene": "the paper's pendulum, thin", "steps": steps, **environment()}
    return LongRuns(runs, settings)


def _fall(candidate: Candidate, paper_steps: int) -> LongRun:
    dt = candidate.step_ratio * paper.DT
    steps = max(1, round(paper_steps / candidate.step_ratio))
    _march(candidate, dt, max(1, steps // 10))
    before = peak_memory()
    path, stopped, reason = _march(candidate, dt, steps)
    growth = peak_memory() - before
    energy = path.energy
    above = (energy.total - energy.total[0]) / energy.kinetic.max()
    halved = sum("steps of" in event.rung for event in path.stats.events)
    return LongRun(
        candidate.label, dt, np.asarray(path.t), above, stopped, reason, path.stats.march_seconds,
        float(growth), candidate.youngs_modulus, path.stats.iterations / max(path.stats.steps, 1),
        halved,
    )  # fmt: skip


def _march(candidate: Candidate, dt: float, steps: int) -> tuple[Trajectory, float, str]:
    scene, _ = pendulum("thin", paper.ELEMENTS, youngs_modulus=candidate.youngs_modulus)
    try:
        path = simulate(
            scene, steps * dt, dt, integrator=INTEGRATORS[candidate.name],
            save_every=max(1, steps // SAVED), max_halvings=candidate.max_halvings,
        )  # fmt: skip
    except StepError as stop:
        return stop.trajectory, stop.time, type(stop).__name__
    return path, math.nan, ""


REASONS = {
    "EnergyIncreaseError": "gained energy",
    "InstabilityError": "gained energy",
    "ConvergenceError": "no convergence",
}
"""Errors of a run in words."""

COLOURS = {
    "GeneralizedAlpha": ("#56b4e9", "#0072b2", "#003f63"),
    "EnergyMomentum": ("#2fbf8f", "#009e73", "#005c43"),
    "RungeKuttaNystrom": ("#000000",),
    "CentralDifference": ("#f2b5a7", "#e07a5f", "#b22222"),
    # With steps at which it fails: from light to dark.
    "Newmark": ("#f0e442", "#f6d28b", "#e69f00", "#c07a00", "#8c5500", "#4d2f00"),
}
"""Colours of each integrator, from its shortest step to its longest."""


def _end(run: LongRun) -> str:
    if run.reason:
        return f"{REASONS[run.reason]} at {run.stopped:.3g} s"
    return f"{run.t[-1]:.4g} s"


COLUMNS: dict[str, Callable[[LongRun], str]] = {
    "": lambda run: run.label,
    "end": _end,
    "energy at the end": lambda run: f"{100 * run.energy[-1]:+.2g} %",
    "most above the start": lambda run: f"{100 * run.rise:.1e} %",
    "drift per second": lambda run: f"{100 * run.rate:+.1e} %",
    "iterations per step": lambda run: f"{run.iterations:.2g}" if run.iterations else "-",
    "steps halved": lambda run: str(run.halved),
    "s": lambda run: f"{run.seconds:.2g}",
    "memory grew": lambda run: "no" if run.growth <= MIN_GROWTH else f"{run.growth / 1e6:.0f} MB",
}


def table(result: LongRuns) -> Table:
    """Set a line for each run."""
    return Table.of(result.runs, COLUMNS)


def findings(result: LongRuns) -> list[str]:
    """State the runs that keep their energy, those that failed, and the growth of memory."""
    failed = [run for run in result.runs if run.reason]
    grew = [run.label for run in result.runs if run.growth > MIN_GROWTH]
    sentences = []
    for steel in (False, True):
        conservative = [run for run in result.runs if run.is_conservative and run.steel == steel]
        if conservative:
            best = min(conservative, key=lambda run: abs(run.energy[-1]))
            sentences.append(
                f"Never above the start by more than {100 * MAX_RISE:g} % of the largest kinetic "
                f"energy: {'; '.join(run.label for run in conservative)}. The one that keeps most "
                f"is {best.label}: {100 * best.energy[-1]:+.2g} % in {best.t[-1]:.4g} s."
            )
    sentences += [f"{run.label} was stopped at {run.stopped:.4g} s: {REASONS[run.reason]}."
             for run in failed]  # fmt: skip
    memory = f"Memory grew in {', '.join(grew)}" if grew else "Memory grew in no run"
    return [*sentences, f"{memory} by more than {MIN_GROWTH / 1e6:g} MB beyond a tenth of it."]


def chart(result: LongRuns) -> Figure:
    """Draw energy against time: all runs of the soft pendulum, the same nearer, those of steel."""
    figure = new_figure(6.2, "Energy of a pendulum that falls without damping")
    axes = panels(figure, 3, 3)
    soft = [run for run in result.runs if not run.steel]
    steel = [run for run in result.runs if run.steel]
    titles = ("All; x: stopped", "The same, nearer; dotted: allowed rise", "Of steel")
    limits = ((-70.0, 10.0), (-3.0, 3.0), (-1.0, 1.0))
    for ax, runs, title, (low, high) in zip(axes, (soft, soft, steel), titles, limits, strict=True):
        for run, colour in _coloured(runs):
            flat = "EnergyMomentum" in run.label  # and under everything else, if not on top
            ax.plot(
                run.t[1:], 100 * run.energy[1:], color=colour, linewidth=2.0 if flat else 1.0,
                label=run.label, zorder=2 + 2 * run.is_conservative + flat,
            )  # fmt: skip
            if run.reason:
                ax.plot(run.t[-1], 100 * run.energy[-1], "x", color=colour, markersize=7)
        set_axes(ax, "time [s]", log="x", title=title)
        ax.set_ylim(low, high)
    for ax in axes[1:]:
        ax.axhline(100 * MAX_RISE, color="grey", linestyle=":", linewidth=1.0)
    axes[0].set_ylabel("energy above the start [% of the largest kinetic]")
    keys: dict[str, Any] = {}
    for ax in axes:
        handles, labels = ax.get_legend_handles_labels()
        keys |= dict(zip(labels, handles, strict=True))
    set_legend(figure, keys, 3)
    return figure


def _coloured(runs: list[LongRun]) -> list[tuple[LongRun, str]]:
    """Give each run a colour of its integrator, darker for longer steps."""

    def integrator(run: LongRun) -> str:
        return next((name for name in COLOURS if name in run.label), "RungeKuttaNystrom")

    return [
        (run, COLOURS[name][min(k, len(COLOURS[name]) - 1)])
        for name, members in group_by(runs, integrator).items()
        for k, run in enumerate(sorted(members, key=lambda each: each.dt))
    ]


STUDY = Study(
    "long-runs",
    run=long_runs,
    tables=lambda result: [table(result)],
    rows=lambda result: [run.record() for run in result.runs],
    findings=findings,
    charts={"long-runs": chart},
    regions={"long-runs": table},
)
