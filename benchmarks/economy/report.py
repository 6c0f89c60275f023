"""The economy of plans as text, CSV, JSON and a chart."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from benchmarks.common.charts import new_figure, set_axes, set_legend
from benchmarks.common.study import Study
from benchmarks.common.tables import Table, bullets
from benchmarks.common.target import Target
from benchmarks.economy.run import Economy, Outcome, economy

# Best choices whose run takes longer than this are held to the worst cost [s].
LONG = 0.2
# What plans may take: this time [s], or this share of their run.
FREE, SHARE = 0.2, 0.15
COLOURS = ("#0072b2", "#e69f00", "#d55e00")


COLUMNS: dict[str, Callable[[Outcome], str]] = {
    "scene": lambda each: each.scene,
    "asked": lambda each: f"{100 * each.asked:g} %",
    "reached / asked": lambda each: _number(each.share),
    "predicted / asked": lambda each: _number(each.predicted / each.asked),
    "plan": lambda each: each.reason or each.choice,
    "best by hand": lambda each: each.best or "none",
    "plan ms": lambda each: f"{1e3 * each.pilot_seconds:.1f}",
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
    return [each for each in result.outcomes if each.uncertain <= 0.2 * each.asked]


def targets(result: Economy) -> list[Target]:
    """Compare errors and costs with what they should be."""
    judged = _judged(result)
    shares = [each.share if math.isfinite(each.share) else math.inf for each in judged]
    costs = [each.cost for each in result.outcomes if math.isfinite(each.cost)]
    runs = [each.run_cost for each in result.outcomes if math.isfinite(each.run_cost)]
    works = [each.work for each in result.outcomes if math.isfinite(each.work)]
    cheap = [
        each.pilot_seconds <= max(FREE, SHARE * each.run_seconds)
        for each in result.outcomes
        if not each.reason
    ]
    long = [each.cost for each in result.outcomes if each.best_seconds > LONG]
    found = []
    if judged:
        within = 100.0 * float(np.mean([share <= 1.0 for share in shares]))
        found += [
            Target("errors within those asked for [%]", within, 95.0),
            Target("worst error over the one asked for", max(shares), 3.0, at_most=True),
        ]
    if costs:
        found += [
            Target("cost with pilots over the best, median", float(np.median(costs)), 2.0, True),
            Target(
                "counted work with pilots over the best, median", float(np.median(works)), 2.0, True
            ),
            Target("cost without pilots over the best, median", float(np.median(runs)), 2.0, True),
        ]
    if cheap:
        share = 100.0 * float(np.mean(cheap))
        found.append(Target("plans beside their runs below 15 % or 0.2 s [%]", share, 100.0))
    if long:
        found.append(Target(f"worst cost of best runs above {LONG:g} s", max(long), 4.0, True))
    return found


def findings(result: Economy) -> list[str]:
    """State how many errors are reached, which are not, and what plans cost."""
    judged = _judged(result)
    failed = [each for each in result.outcomes if each.reason]
    missed = [each for each in judged if not each.reason and each.share > 1.0]
    sentences = [
        f"Of {len(judged)} requests with a reference certain to a fifth of them, "
        f"{len(judged) - len(missed) - sum(bool(each.reason) for each in judged)} are met."
    ]
    sentences += [f"{_name(each)}: {each.share:.3g} times the error asked for." for each in missed]
    sentences += [f"{_name(each)}: no plan, {each.reason}." for each in failed]
    doubtful = [each for each in result.outcomes if each not in judged]
    if doubtful:
        names = "; ".join(_name(each) for each in doubtful)
        sentences.append(f"Not judged, since the reference is not certain enough: {names}.")
    nothing = [each for each in result.outcomes if not each.best]
    if nothing:
        names = "; ".join(_name(each) for each in nothing)
        sentences.append(f"The search by hand reaches no such error: {names}.")
    costs = np.array([each.cost for each in result.outcomes if math.isfinite(each.cost)])
    runs = np.array([each.run_cost for each in result.outcomes if math.isfinite(each.run_cost)])
    if len(costs):
        sentences.append(
            f"Plan and run cost {np.median(costs):.3g} times the best choice in the median and "
            f"{costs.max():.3g} times at worst, the run alone {np.median(runs):.3g} and "
            f"{runs.max():.3g} times: what is left is the pilots, "
            f"{1e3 * np.median([each.pilot_seconds for each in result.outcomes]):.3g} ms in the "
            "median."
        )
        longest = max(each.best_seconds for each in result.outcomes if each.best)
        if longest <= LONG:
            sentences.append(
                f"No best choice takes longer than {LONG:g} s (the longest {longest:.2g} s), so "
                "none is held to the worst cost of long runs."
            )
    worst = max(result.outcomes, key=lambda o: o.run_cost if math.isfinite(o.run_cost) else 0.0)
    if worst.run_cost > 2.0:
        sentences.append(
            f"The dearest run beside the best: {_name(worst)}, {worst.choice}, "
            f"{worst.run_cost:.3g} times {worst.best}."
        )
    return sentences


def region(result: Economy) -> str:
    """Set the table, findings and targets for a page."""
    sentences = [*findings(result), *(" ".join(str(each).split()) for each in targets(result))]
    return "\n".join([*table(result).markdown(), "", *bullets(sentences)])


def _name(outcome: Outcome) -> str:
    return f"{outcome.scene} to {100 * outcome.asked:g} %"


def chart(result: Economy) -> Figure:
    """Draw reached against requested errors, and costs over the best against its time."""
    figure = new_figure(4.6, "Errors of plans, and their cost beside the best choice by hand")
    left, right = figure.subplots(1, 2)
    judged = _judged(result)
    for colour, asked in zip(COLOURS, sorted({o.asked for o in result.outcomes}), strict=False):
        own = [each for each in result.outcomes if each.asked == asked]
        reached = [each for each in own if math.isfinite(each.reached)]
        beside = asked * np.linspace(0.85, 1.15, max(2, len(reached)))
        for x, each in zip(beside.tolist(), reached, strict=False):
            left.plot(x, each.reached, "o" if each in judged else "+", color=colour, markersize=4)
        failed = [10.0 * asked for each in own if each.reason]
        left.plot([asked] * len(failed), failed, "x", color=colour)
        known = [each for each in own if math.isfinite(each.cost)]
        best = [1e3 * each.best_seconds for each in known]
        label = f"{100 * asked:g} %, plan and run"
        right.plot(best, [o.cost for o in known], "o", color=colour, markersize=4, label=label)
        alone = {
            "color": colour,
            "markersize": 4,
            "fillstyle": "none",
            "label": "run alone, likewise",
        }
        right.plot(best, [o.run_cost for o in known], "o", **alone)
    ends = [min(o.asked for o in result.outcomes), max(o.asked for o in result.outcomes)]
    left.plot(ends, ends, color="grey", linewidth=1.0, label="as asked for")
    left.plot(ends, [3.0 * end for end in ends], color="grey", linestyle=":", label="3 times")
    for level, line in ((1.0, "-"), (2.0, ":")):
        right.axhline(level, color="grey", linestyle=line, linewidth=1.0)
    set_axes(
        left,
        "error asked for, over the size of the quantity",
        "error reached; x: no plan; +: beside an uncertain reference",
    )
    set_axes(right, "time of the best choice by hand [ms]", "cost over that of the best choice")
    shown: dict[str, Any] = {}
    for ax in (left, right):
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            shown.setdefault(label, handle)
    set_legend(figure, shown, 3)
    return figure


STUDY = Study(
    "economy",
    run=economy,
    tables=lambda result: [table(result)],
    rows=lambda result: [
        {**asdict(each), "share": each.share, "cost": each.cost, "work": each.work}
        for each in result.outcomes
    ],
    findings=findings,
    charts={"economy": chart},
    targets=targets,
    regions={"economy": region},
)
