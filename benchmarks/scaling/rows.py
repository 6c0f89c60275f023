"""Measurements of the scaling study: rows, ratios, powers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any

import numpy as np

from benchmarks.common.worker import Answered
from benchmarks.other_codes.exudyn_scene import SETTINGS as OTHERS
from benchmarks.scaling.roofline import Roofline
from benchmarks.scaling.scaling_job import SOLVERS

TITLES = {
    ("chain", "rest"): "chain falling from rest",
    ("chain", "rough"): "chain in rough motion",
    ("net", "rest"): "net falling from rest",
}
"""Cases and motions of the study."""

GROWTH_FROM = (1000, 100_000)  # elements of the compared chains: in the caches, and not
FIT_FROM = 500  # elements; fixed costs show below


@dataclass
class Row(Answered):
    """One solver on one scene."""

    seconds: list[float] = field(default_factory=list)  # time loop of each round [s]

    @property
    def fastest(self) -> float:
        """March of the fastest round [s]."""
        return min(self.seconds)

    @property
    def scene(self) -> tuple[str, str]:
        """Case and motion."""
        return self.job.case, self.job.motion

    @property
    def split(self) -> dict[str, float]:
        """Time of each part per element and step [microseconds]."""
        per = 1e6 / (self.job.steps * self.job.elements)
        return {part: per * seconds for part, seconds in self.record.get("split", {}).items()}

    def flat(self) -> dict[str, Any]:
        """Return the entries of the CSV table; None where there is no result."""
        job, record, done = self.job, self.record, not self.note
        counts = ("set_up_seconds", "iterations_per_step", "factorizations", "recoveries")
        return {
            "scene": TITLES[self.scene],
            "size": job.size,
            "elements": job.elements,
            "solver": job.solver,
            "steps": job.steps,
            "rounds": len(self.seconds),
            "microseconds_per_element_and_step": self.microseconds if done else None,
            **{name: record.get(name) for name in counts},
            "peak_megabytes": record["peak_bytes"] / 1e6 if done else None,
            "bytes_per_element": self.bytes_per_element if done else None,
            "chosen": record.get("chosen"),
            "note": self.note,
            **{f"{part}_microseconds": value for part, value in self.split.items()},
        }


@dataclass(frozen=True)
class Scaling:
    """Measurements of all scenes, sizes and solvers."""

    rows: list[Row]  # scene by scene, size by size, solver by solver
    counts: list[dict[str, Any]]  # for each scene and size, sizes of pattern and factor
    roofline: Roofline  # measured in the same run
    settings: dict[str, Any]  # of the study and the machine

    def done(self, scene: tuple[str, str], solver: str) -> list[Row]:
        """Return the rows with results of one scene and solver, by size."""
        return [r for r in self.rows if r.scene == scene and r.job.solver == solver and not r.note]

    def by_size(self) -> list[list[Row]]:
        """Return the rows of each scene and size."""
        return [list(g) for _, g in groupby(self.rows, key=lambda r: (r.scene, r.job.size))]

    def slopes(self) -> dict[str, float]:
        """Fit powers of the number of elements to counts and memory, from 500 elements on."""
        out: dict[str, float] = {}
        for scene, title in TITLES.items():
            table = [c for c in self.counts if c["scene"] == title]
            for key in ("pattern_entries", "factor_entries", "factor_flops"):
                out[f"{title}: {key}"] = slope([(c["elements"], c[key]) for c in table])
            rows = self.done(scene, "auto")
            peak = [(r.job.elements, r.bytes_per_element * r.job.elements) for r in rows]
            out[f"{title}: memory of auto above idle"] = slope(peak)
            steps = [(r.job.elements, r.record["iterations_per_step"]) for r in rows]
            out[f"{title}: iterations of auto per step"] = slope(steps)
        return {key: value for key, value in out.items() if not np.isnan(value)}

    def growth(self) -> dict[str, float]:
        """Divide the cost per element of the longest chain at rest by that of shorter ones."""
        rows = self.done(("chain", "rest"), "auto")
        return {
            f"{rows[-1].job.elements:,} over {row.job.elements:,} elements": rows[-1].microseconds
            / row.microseconds
            for row in rows[:-1]
            if row.job.elements in GROWTH_FROM
        }


def slope(points: Sequence[tuple[float, float]]) -> float:
    """Return the power of x that fits y best; NaN with fewer than two points that count."""
    used = np.array([p for p in points if p[0] >= FIT_FROM and p[1] > 0], dtype=float)
    if len(used) < 2:
        return float("nan")
    x, y = np.log(used).T
    return float(np.polyfit(x, y, 1)[0])


def ratios(group: Sequence[Row]) -> dict[str, Any]:
    """Compare the solvers of one scene and size, each by the fastest of its rounds.

    Rounds are interleaved, so a busy moment of the machine hits all alike.

    Returns
    -------
    dict
        ``scene``, ``size``, and where both sides have a result ``auto / best fixed``,
        ``best fixed``, its name, ``Newton / auto`` and ``<other code> / auto``, and the gain of
        threads.
    """
    done = {row.job.solver: row for row in group if not row.note}
    out: dict[str, Any] = {"scene": TITLES[group[0].scene], "size": group[0].job.size}
    auto = done.pop("auto", None)
    if auto is None:
        return out
    fixed = [row for name, row in done.items() if name in SOLVERS]
    if fixed:
        best = min(fixed, key=lambda row: row.fastest)
        out["auto / best fixed"] = auto.fastest / best.fastest
        out["best fixed"] = best.job.solver
    for name in ("Newton", *(other.name for other in OTHERS)):
        if name in done:
            out[f"{name} / auto"] = done[name].fastest / auto.fastest
    for row in done.values():
        if row.job.threads > 1:
            out[f"gain of {row.job.threads} threads"] = auto.fastest / row.fastest
    return out
