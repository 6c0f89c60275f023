"""What the work-precision study shows, in sentences that are worked out from it."""

from __future__ import annotations

import math

from ancfsparse.studies.common.race import OURS, Point, fastest
from ancfsparse.studies.work_precision.run import LEVELS, WorkPrecision


def findings(result: WorkPrecision) -> list[str]:
    """State what the numbers show, one sentence for each peer and one for each target."""
    sentences = []
    for model in result.references:
        for program in result.programs(model):
            sentences.append(_finding(result, model, program))
        sentences += _alike(result, model)
        sentences += _about_counts(result, model)
    return sentences + [
        f"Aim, {each.what}: {each.value:.1f}, wanted {each.wanted:g} or more, "
        + ("met." if each.met else "missed.")
        for each in result.targets()
    ]


def _finding(result: WorkPrecision, model: str, program: str) -> str:
    ratios = {level: result.ratio(model, program, level) for level in LEVELS}
    both = {level: r for level, r in ratios.items() if 0.0 < r < math.inf}
    alone = [level for level, r in ratios.items() if r == 0.0]
    lost = [level for level, r in both.items() if r < 1.0]
    if not both:
        return f"{program} and we have no error in common."
    low, high = min(both.values()), max(both.values())
    first = f"{model}: {program} takes {low:.1f} to {high:.1f} times as long as our fastest"
    if lost:
        first += "; it is faster at " + ", ".join(f"{level:.0e}" for level in lost) + " m"
    if alone:
        first += f"; from {max(alone):.0e} m down only it has a result"
    return first + "."


def _alike(result: WorkPrecision, model: str) -> list[str]:
    """Compare implicit methods with implicit methods, where Exudyn ran."""
    found = [result.ratio(model, "Exudyn", v, implicit=True, alike=True) for v in LEVELS]
    both = [each for each in found if 0.0 < each < math.inf]
    if not both:
        return []
    return [
        f"{model}: implicit against implicit, Exudyn takes {min(both):.1f} to {max(both):.1f} "
        "times as long."
    ]


def _about_counts(result: WorkPrecision, model: str) -> list[str]:
    """State at which errors a peer evaluates its equations less often than any run of ours."""
    fewer: dict[str, list[float]] = {}
    for level in LEVELS:
        good = [p for p in result.of(model) if p.finished and p.error <= level]
        counted = [p for p in good if evaluations(p) > 0]
        best = min(counted, key=evaluations, default=None)
        if best is not None and best.task.program != OURS:
            name = f"{best.task.program}'s {best.task.method}"
            fewer.setdefault(name, []).append(level)
    return [
        f"{model}: {name} needs the fewest evaluations of the equations at "
        + ", ".join(f"{level:.0e}" for level in levels)
        + " m, Jacobians and factorizations not counted."
        for name, levels in fewer.items()
    ]


def headline(result: WorkPrecision) -> str:
    """State in a line who is fastest at equal error."""
    model = next(iter(result.references))
    reach = [v for v in LEVELS if fastest(result.of(model, OURS), v) is not None]
    found = [
        (ratio, level, program)
        for program in result.programs(model)
        for level in reach
        if math.isfinite(ratio := result.ratio(model, program, level))
    ]
    if not found:
        best = fastest(result.of(model, OURS), min(reach, default=0.0))
        if best is None:
            return "Seconds against error in time: no run of ours has a result"
        return f"{model}: {best.task.name} reaches {best.error:.0e} m in {best.seconds:.2g} s"
    ratio, level, program = min(found)
    if ratio < 1.0:
        text = f"{program} needs {ratio:.2f} of the time of our fastest at {level:.0e} m"
    else:
        text = (
            f"Down to {min(reach):.0e} m no peer is faster than our fastest; the nearest, "
            f"{program}, takes {ratio:.1f} times as long at {level:.0e} m"
        )
    below = [v for v in LEVELS if v < min(reach) and fastest(result.of(model), v) is not None]
    return text + ("; below, only peers have results" if below else "")


def title(result: WorkPrecision, model: str) -> str:
    """Name the nearest peer at 1e-5 m, or the cost of that error where there is none."""
    best = fastest(result.of(model, OURS), 1e-5)
    name = f"{model}, {result.settings['elements']} elements"
    if best is None:
        return name
    text = f"{name}: 1e-5 m takes {1e3 * best.seconds:.0f} ms ({best.task.name})"
    if "Exudyn" in result.programs(model):
        best_of_all = result.ratio(model, "Exudyn", 1e-5)
        alike = result.ratio(model, "Exudyn", 1e-5, implicit=True, alike=True)
        if all(0.0 < each < math.inf for each in (best_of_all, alike)):
            text += (
                f", Exudyn {best_of_all:.0f} times as long; implicit against implicit {alike:.0f}"
            )
    return text


def count_title(result: WorkPrecision, model: str) -> str:
    """Compare evaluations at 1e-5 m between ours and the peer with the fewest."""
    counted = [p for p in result.of(model) if p.finished and p.error <= 1e-5 and evaluations(p) > 0]
    ours = min((evaluations(p) for p in counted if p.task.program == OURS), default=math.nan)
    rivals = [p for p in counted if p.task.program != OURS]
    if math.isnan(ours):
        return "Evaluations of the equations"
    text = f"Evaluations for 1e-5 m: ours {ours:,.0f}"
    if rivals:
        best = min(rivals, key=evaluations)
        text += f", {best.task.program} {evaluations(best):,.0f} ({best.task.method})"
    return text


def evaluations(point: Point) -> float:
    """Return how many residuals or right-hand sides a run evaluated; NaN where unknown."""
    return float(point.counts.get("residuals", math.nan))
