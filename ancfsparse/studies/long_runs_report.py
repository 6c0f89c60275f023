"""The long runs as text, CSV, JSON and a chart."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from ancfsparse.studies.charts import WIDTH, set_head, set_legend, set_title
from ancfsparse.studies.files import save, write_csv, write_json
from ancfsparse.studies.long_runs import MOST_RISE, NOISE, LongRun, LongRuns

REASONS = {
    "EnergyGain": "gained energy",
    "Instability": "gained energy",
    "StepFailure": "no convergence",
}
"""Exceptions of a march in words."""

COLOURS = ("#0072b2", "#000000", "#2f4f4f", "#009e73", "#b22222", "#e07a5f", "#f2b5a7")
# The trapezoidal rule with steps at which it dies: from light to dark.
DYING = ("#f6d28b", "#e69f00", "#c07a00", "#8c5500", "#4d2f00")


def table(result: LongRuns) -> str:
    """Set the table for a page."""
    lines = [
        "| | end | energy at the end | most above the start | drift per second | s | memory grew |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    for run in result.runs:
        end = f"{run.t[-1]:.4g} s"
        if run.reason:
            end = f"{REASONS[run.reason]} at {run.stopped:.3g} s"
        lines.append(
            f"| {run.label} | {end} | {100 * run.energy[-1]:+.2g} % | {100 * run.rise:.1e} % | "
            f"{100 * run.rate:+.1e} % | {run.seconds:.2g} | {_grown(run)} |"
        )
    return "\n".join([*lines, "", *(f"- {each}" for each in findings(result))])


def _grown(run: LongRun) -> str:
    return "no" if run.growth <= NOISE else f"{run.growth / 1e6:.0f} MB"


def findings(result: LongRuns) -> list[str]:
    """Say which runs kept their energy, which died, and whether memory grew."""
    kept = [run for run in result.runs if run.kept]
    died = [run for run in result.runs if run.reason]
    grew = [run.label for run in result.runs if run.growth > NOISE]
    said = []
    if kept:
        best = min(kept, key=lambda run: abs(run.energy[-1]))
        said.append(
            f"Never above the start by more than {100 * MOST_RISE:g} % of the largest kinetic "
            f"energy: {'; '.join(run.label for run in kept)}. The one that keeps most is "
            f"{best.label}: {100 * best.energy[-1]:+.2g} % in {best.t[-1]:.4g} s."
        )
    said += [f"{run.label} was stopped at {run.stopped:.4g} s: {REASONS[run.reason]}."
             for run in died]  # fmt: skip
    memory = f"Memory grew in {', '.join(grew)}" if grew else "Memory grew in no run"
    return [*said, f"{memory} by more than {NOISE / 1e6:g} MB beyond a tenth of it."]


def headline(result: LongRuns) -> str:
    """Sum up the chart."""
    alive = [run for run in result.runs if not run.reason]
    if not alive:
        return "No run came to its end"
    said = f"{len(alive)} of {len(result.runs)} runs come to {alive[0].t[-1]:.4g} s"
    kept = [run for run in alive if run.kept]
    if not kept:
        return f"{said}, none without gaining energy"
    best = min(kept, key=lambda run: abs(run.energy[-1]))
    return f"{said}; {best.label} keeps its energy best: {100 * best.energy[-1]:+.2g} %"


def write(result: LongRuns, folder: Path) -> list[Path]:
    """Write long-runs.csv, .json and .png.

    Parameters
    ----------
    result : LongRuns
        A finished study.
    folder : Path
        Where to; made if missing.

    Returns
    -------
    list of Path
        The files.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"long-runs.{kind}" for kind in ("csv", "json", "png")]
    write_csv([run.record() for run in result.runs], paths[0])
    write_json({**result.record(), "findings": findings(result)}, paths[1])
    save(chart(result), paths[2])
    return paths


def chart(result: LongRuns) -> Figure:
    """Draw energy against time: all runs, and the small changes of those that keep it."""
    figure = Figure(figsize=(WIDTH, 5.2), layout="constrained")
    axes = figure.subplots(1, 2)
    alive = [run for run in result.runs if not run.reason]
    died = [run for run in result.runs if run.reason]
    for ax in axes:
        dying = iter(DYING)
        for k, run in enumerate(result.runs):
            trapezoidal = run.reason and run.label.startswith("Newmark")
            colour = next(dying, DYING[-1]) if trapezoidal else COLOURS[k % len(COLOURS)]
            ax.plot(
                run.t[1:], 100 * run.energy[1:], color=colour, linewidth=1.0, label=run.label,
                zorder=4 if run.kept else 2,
            )  # fmt: skip
            if run.reason:
                ax.plot(run.t[-1], 100 * run.energy[-1], "x", color=colour, markersize=7)
        ax.set_xscale("log")
        ax.set_xlabel("time [s]")
        ax.set_ylabel("energy gained [% of the largest kinetic]")
        ax.grid(alpha=0.3)
    axes[0].set_ylim(-70.0, 10.0)
    set_title(axes[0], f"All; x: stopped, {len(died)} runs")
    axes[1].set_ylim(-3.0, 3.0)
    axes[1].axhline(100 * MOST_RISE, color="grey", linestyle=":", linewidth=1.0)
    set_title(axes[1], f"Nearer: {len(alive)} runs live; dotted: what the energy may rise")
    set_head(figure, headline(result))
    handles, labels = axes[0].get_legend_handles_labels()
    set_legend(figure, dict(zip(labels, handles, strict=True)), 3)
    return figure
