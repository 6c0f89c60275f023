"""Reports of trials, and their summary."""

import re
from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from hypothesis import HealthCheck, given, seed, settings

QUANTILES = {"median": 0.5, "90 %": 0.9, "99 %": 0.99, "largest": 1.0}
SHOWN = 3  # printed finds that differ in numbers only; the file has all


@dataclass
class Report:
    """One trial: its outcome in a word, its errors in sentences, its input, and measured ratios."""

    outcome: str
    finds: list[str] = field(default_factory=list)
    tried: str = ""
    ratios: dict[str, float] = field(default_factory=dict)


@dataclass
class Tally:
    """All trials of one kind."""

    trials: int = 0
    seconds: float = 0.0
    outcomes: Counter = field(default_factory=Counter)
    ratios: dict[str, list[float]] = field(default_factory=dict)

    def add(self, report, seconds):
        """Count a trial and the time that it took."""
        self.trials += 1
        self.seconds += seconds
        self.outcomes[report.outcome] += 1
        for name, ratio in report.ratios.items():
            self.ratios.setdefault(name, []).append(ratio)


def search(number, index, strategy, check, most):
    """Search for an example that breaks a check, and reduce it; return the error, or None."""

    @seed(number * 1_000_003 + index)
    @settings(
        max_examples=most, deadline=None, database=None, report_multiple_bugs=False,
        suppress_health_check=list(HealthCheck), print_blob=False,
    )  # fmt: skip
    @given(strategy)
    def checked(example):
        check(*example)

    try:
        checked()
    except Exception as raw:
        return raw
    return None


def table(tallies, finds):
    """Write one line for each kind, and after them each find with what reproduces it."""
    lines = [f"{'kind':<14}{'trials':>8}{'seconds':>9}{'finds':>7}  outcomes"]
    for kind, tally in tallies.items():
        counts = ", ".join(f"{name} {count}" for name, count in tally.outcomes.most_common())
        found = sum(find["kind"] == kind for find in finds)
        lines.append(f"{kind:<14}{tally.trials:>8}{tally.seconds:>9.1f}{found:>7}  {counts}")
        for name, ratios in tally.ratios.items():
            shares = np.quantile(ratios, list(QUANTILES.values()))
            named = zip(QUANTILES, shares, strict=True)
            shown = ", ".join(f"{part} {share:.3g}" for part, share in named)
            lines.append(f"  {name} ({len(ratios)}): {shown}")
    alike = Counter()
    for find in finds:
        what = re.sub(r"[\d.]+(e[+-]?\d+)?", "#", find["what"])
        alike[find["kind"], what] += 1
        if alike[find["kind"], what] <= SHOWN:
            lines.append(
                "\n{kind} {index}: {what}\n  tried: {tried}\n  again: {again}".format(**find)
            )
    return "\n".join(lines)
