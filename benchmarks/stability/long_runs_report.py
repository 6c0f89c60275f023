"""The long runs as text, CSV, JSON and a chart."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from matplotlib.figure import Figure

from benchmarks.common.charts import new_figure, set_axes, set_legend
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.stability.long_runs import MOST_RISE, NOISE, LongRun, LongRuns, long_runs

REASONS = {
    "EnergyIncreaseError": "gained energy",
    "InstabilityError": "gained energy",
    "ConvergenceError": "no convergence",
}
"""Exceptions of a march in words."""

COLOURS = {
    "GeneralizedAlpha": ("#56b4e9", "#0072b2", "#003f63"),
    "EnergyMomentum": ("#2fbf8f", "#009e73", "#005c43"),
    "RungeKuttaNystrom": ("#000000",),
    "CentralDifference": ("#f2b5a7", "#e07a5f", "#b22222"),
    # With steps at which it fails: from light to dark.
    "Newmark": ("#f0e442", "#f6d28b", "#e69f00", "#c07a00", "#8c5500", "#4d2f00"),
}
"""Of each integrator, from its shortest step to its longest."""


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
    "memory grew": lambda run: "no" if run.growth <= NOISE else f"{run.growth / 1e6:.0f} MB",
}


def table(result: LongRuns) -> Table:
    """Set a line for each run."""
    return Table.of(result.runs, COLUMNS)


def findings(result: LongRuns) -> list[str]:
    """State which runs kept their energy, which failed, and whether memory grew."""
    failed = [run for run in result.runs if run.reason]
    grew = [run.label for run in result.runs if run.growth > NOISE]
    sentences = []
    for steel in (False, True):
        kept = [run for run in result.runs if run.kept and run.steel == steel]
        if kept:
            best = min(kept, key=lambda run: abs(run.energy[-1]))
            sentences.append(
                f"Never above the start by more than {100 * MOST_RISE:g} % of the largest kinetic "
                f"energy: {'; '.join(run.label for run in kept)}. The one that keeps most is "
                f"{best.label}: {100 * best.energy[-1]:+.2g} % in {best.t[-1]:.4g} s."
            )
    sentences += [f"{run.label} was stopped at {run.stopped:.4g} s: {REASONS[run.reason]}."
             for run in failed]  # fmt: skip
    memory = f"Memory grew in {', '.join(grew)}" if grew else "Memory grew in no run"
    return [*sentences, f"{memory} by more than {NOISE / 1e6:g} MB beyond a tenth of it."]


def chart(result: LongRuns) -> Figure:
    """Draw energy against time: all runs of the soft pendulum, the same nearer, those of steel."""
    figure = new_figure(6.2, "Energy of a pendulum that falls without damping")
    axes = figure.subplots(1, 3)
    soft = [run for run in result.runs if not run.steel]
    steel = [run for run in result.runs if run.steel]
    titles = ("All; x: stopped", "The same, nearer; dotted: what it may rise", "Of steel")
    limits = ((-70.0, 10.0), (-3.0, 3.0), (-1.0, 1.0))
    for ax, runs, title, (low, high) in zip(axes, (soft, soft, steel), titles, limits, strict=True):
        for run, colour in _coloured(runs):
            flat = "EnergyMomentum" in run.label  # and under everything else, if not on top
            ax.plot(
                run.t[1:], 100 * run.energy[1:], color=colour, linewidth=2.0 if flat else 1.0,
                label=run.label, zorder=2 + 2 * run.kept + flat,
            )  # fmt: skip
            if run.reason:
                ax.plot(run.t[-1], 100 * run.energy[-1], "x", color=colour, markersize=7)
        set_axes(ax, "time [s]", log="x", title=title)
        ax.set_ylim(low, high)
    for ax in axes[1:]:
        ax.axhline(100 * MOST_RISE, color="grey", linestyle=":", linewidth=1.0)
    axes[0].set_ylabel("energy above the start [% of the largest kinetic]")
    shown: dict[str, Any] = {}
    for ax in axes:
        handles, labels = ax.get_legend_handles_labels()
        shown |= dict(zip(labels, handles, strict=True))
    set_legend(figure, shown, 3)
    return figure


def _coloured(runs: list[LongRun]) -> list[tuple[LongRun, str]]:
    """Give each run a colour of its integrator, darker for longer steps."""
    found: dict[str, list[LongRun]] = {}
    for run in runs:
        names = [name for name in COLOURS if name in run.label]
        found.setdefault(names[0] if names else "RungeKuttaNystrom", []).append(run)
    return [
        (run, COLOURS[name][min(k, len(COLOURS[name]) - 1)])
        for name, members in found.items()
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
