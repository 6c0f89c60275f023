"""Table, chart, targets and findings of the economy of plans."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.common.charts import new_figure, set_axes, set_legend
from benchmarks.common.study import Study
from benchmarks.common.tables import Table, bullets
from benchmarks.common.target import Target
from benchmarks.economy.run import Economy, Outcome, economy

MIN_LONG_TIME = 0.2  # of best choices whose worst cost is limited [s]
MAX_PLAN_TIME = 0.2  # of a plan [s], or
MAX_PLAN_RATIO = 0.15  # of its run
COLOURS = ("#0072b2", "#e69f00", "#d55e00")


COLUMNS: dict[str, Callable[[Outcome], str]] = {
    "scene": lambda each: each.scene,
    "tolerance": lambda each: f"{100 * each.tolerance:g} %",
    "error / tolerance": lambda each: _number(each.error_ratio),
    "estimate / tolerance": lambda each: _number(each.predicted / each.tolerance),
    "plan": lambda each: each.reason or each.choice,
    "best of the search": lambda each: each.best or "none",
    "plan ms": lambda each: f"{1e3 * each.trial_seconds:.1f}",
    "run ms": lambda each: f"{1e3 * each.run_seconds:.1f}",
    "best ms": lambda each: _number(1e3 * each.best_seconds),
    "cost / best": lambda each: _number(each.cost),
    "work / best": lambda each: _number(each.work),
}


def table(result: Economy) -> Table:
    """Set a line for each scene and error."""
    return Table.of(result.outcomes, COLUMNS, (0, 4, 5))


def _number(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else "-"


def _judged(result: Economy) -> list[Outcome]:
    """Return outcomes whose reference is certain enough to judge them."""
    return [each for each in result.outcomes if each.uncertain <= 0.2 * each.tolerance]


def targets(result: Economy) -> list[Target]:
    """Compare errors and costs with their targets."""
    judged = _judged(result)
    ratios = [each.error_ratio if math.isfinite(each.error_ratio) else math.inf for each in judged]
    planned = [each for each in result.outcomes if not each.reason]
    limits = [max(MAX_PLAN_TIME, MAX_PLAN_RATIO * each.run_seconds) for each in planned]
    cheap = [each.trial_seconds <= limit for each, limit in zip(planned, limits, strict=True)]
    long = [each.cost for each in result.outcomes if each.best_seconds > MIN_LONG_TIME]
    entries = []
    if judged:
        within = 100.0 * float(np.mean([ratio <= 1.0 for ratio in ratios]))
        entries.append(Target("errors within the tolerance [%]", within, 95.0))
        entries.append(Target("worst error over its tolerance", max(ratios), 3.0, at_most=True))
    for what, name in (
        ("cost with trial runs", "cost"),
        ("counted work with trial runs", "work"),
        ("cost without trial runs", "run_cost"),
    ):
        values = _finite(result, name)
        if len(values):
            median = float(np.median(values))
            entries.append(Target(f"{what} over the best, median", median, 2.0, at_most=True))
    if cheap:
        what = "plans below 15 % of their runs or 0.2 s [%]"
        entries.append(Target(what, 100.0 * float(np.mean(cheap)), 100.0))
    if long:
        what = f"worst cost of best runs above {MIN_LONG_TIME:g} s"
        entries.append(Target(what, max(long), 4.0, at_most=True))
    return entries


def _finite(result: Economy, name: str) -> NDArray[np.float64]:
    """Return the finite values of a property of the outcomes."""
    values = np.array([getattr(each, name) for each in result.outcomes], dtype=np.float64)
    return values[np.isfinite(values)]


def findings(result: Economy) -> list[str]:
    """State the tolerances that are met and missed, and the cost of plans."""
    judged = _judged(result)
    failed = [each for each in result.outcomes if each.reason]
    missed = [each for each in judged if not each.reason and each.error_ratio > 1.0]
    sentences = [
        f"Of {len(judged)} requests with a reference certain to a fifth of them, "
        f"{len(judged) - len(missed) - sum(bool(each.reason) for each in judged)} are met."
    ]
    sentences += [f"{_name(each)}: {each.error_ratio:.3g} times the tolerance." for each in missed]
    sentences += [f"{_name(each)}: no plan, {each.reason}." for each in failed]
    doubtful = [each for each in result.outcomes if each not in judged]
    if doubtful:
        names = "; ".join(_name(each) for each in doubtful)
        sentences.append(f"Not judged, since the reference is not certain enough: {names}.")
    nothing = [each for each in result.outcomes if not each.best]
    if nothing:
        names = "; ".join(_name(each) for each in nothing)
        sentences.append(f"The search reaches no such error: {names}.")
    costs, runs = _finite(result, "cost"), _finite(result, "run_cost")
    if len(costs):
        sentences.append(
            f"Plan and run cost {np.median(costs):.3g} times the best choice in the median and "
            f"{costs.max():.3g} times at worst, the run alone {np.median(runs):.3g} and "
            f"{runs.max():.3g} times: the difference is that of the trial runs, "
            f"{1e3 * np.median([each.trial_seconds for each in result.outcomes]):.3g} ms in the "
            "median."
        )
        longest = max(each.best_seconds for each in result.outcomes if each.best)
        if longest <= MIN_LONG_TIME:
            sentences.append(
                f"No best choice takes longer than {MIN_LONG_TIME:g} s (the longest {longest:.2g} "
                "s), so none is held to the worst cost of long runs."
            )
    worst = max(result.outcomes, key=lambda o: o.run_cost if math.isfinite(o.run_cost) else 0.0)
    if worst.run_cost > 2.0:
        sentences.append(
            f"The most expensive run relative to the best: {_name(worst)}, {worst.choice}, "
            f"{worst.run_cost:.3g} times {worst.best}."
        )
    return sentences


def region(result: Economy) -> str:
    """Set the table, findings and targets for a page."""
    sentences = [*findings(result), *(each.sentence() for each in targets(result))]
    return "\n".join([*table(result).markdown(), "", *bullets(sentences)])


def _name(outcome: Outcome) -> str:
    return f"{outcome.scene} to {100 * outcome.tolerance:g} %"


def chart(result: Economy) -> Figure:
    """Draw errors against tolerances, and costs over the best against its time."""
    figure = new_figure(
        4.6, "Errors of plans, and their cost relative to the best choice of the search"
    )
    left, right = figure.subplots(1, 2)
    judged = _judged(result)
    for colour, tolerance in zip(
        COLOURS, sorted({o.tolerance for o in result.outcomes}), strict=False
    ):
        own = [each for each in result.outcomes if each.tolerance == tolerance]
        reached = [each for each in own if math.isfinite(each.reached)]
        places = tolerance * np.linspace(0.85, 1.15, max(2, len(reached)))
        for x, each in zip(places.tolist(), reached, strict=False):
            left.plot(x, each.reached, "o" if each in judged else "+", color=colour, markersize=4)
        failed = [10.0 * tolerance for each in own if each.reason]
        left.plot([tolerance] * len(failed), failed, "x", color=colour)
        known = [each for each in own if math.isfinite(each.cost)]
        best = [1e3 * each.best_seconds for each in known]
        label = f"{100 * tolerance:g} %, plan and run"
        right.plot(best, [o.cost for o in known], "o", color=colour, markersize=4, label=label)
        right.plot(
            best, [o.run_cost for o in known], "o", color=colour, markersize=4, fillstyle="none",
            label="run alone, likewise",
        )  # fmt: skip
    ends = [min(o.tolerance for o in result.outcomes), max(o.tolerance for o in result.outcomes)]
    left.plot(ends, ends, color="grey", linewidth=1.0, label="the tolerance")
    left.plot(ends, [3.0 * end for end in ends], color="grey", linestyle=":", label="3 times")
    for level, line in ((1.0, "-"), (2.0, ":")):
        right.axhline(level, color="grey", linestyle=line, linewidth=1.0)
    set_axes(
        left, "tolerance over the size of the quantity", "error; x: no plan; +: uncertain reference"
    )
    set_axes(
        right, "time of the best choice of the search [ms]", "cost over that of the best choice"
    )
    keys: dict[str, Any] = {}
    for ax in (left, right):
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            keys.setdefault(label, handle)
    set_legend(figure, keys, 3)
    return figure


STUDY = Study(
    "economy",
    run=economy,
    tables=lambda result: [table(result)],
    rows=lambda result: [
        {**asdict(each), "error_ratio": each.error_ratio, "cost": each.cost, "work": each.work}
        for each in result.outcomes
    ],
    findings=findings,
    charts={"economy": chart},
    targets=targets,
    regions={"economy": region},
)
