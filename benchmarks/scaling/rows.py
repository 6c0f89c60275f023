"""What the scaling study has measured: rows, ratios, powers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any

import numpy as np

from benchmarks.common.worker import Answered
from benchmarks.other_codes.exudyn_scene import SETTINGS as PEERS
from benchmarks.scaling.roofline import Roofline
from benchmarks.scaling.scaling_job import SOLVERS

TITLES = {
    ("chain", "rest"): "chain falling from rest",
    ("chain", "rough"): "chain in rough motion",
    ("net", "rest"): "net falling from rest",
}
"""What is studied."""

# Chains whose cost per element the longest one is compared with: in the caches, and not.
GROWTH_FROM = (1000, 100_000)
# Fits leave out sizes where fixed costs show.
FIT_FROM = 500


@dataclass
class Row(Answered):
    """One solver on one scene.

    Attributes
    ----------
    seconds : list of float
        March of each round [s].
    """

    seconds: list[float] = field(default_factory=list)

    @property
    def fastest(self) -> float:
        """March of the fastest round [s]."""
        return min(self.seconds)

    @property
    def scene(self) -> tuple[str, str]:
        """Case and motion."""
        return self.job.case, self.job.motion

    def flat(self) -> dict[str, Any]:
        """Return one line of the table; None where there is no result."""
        job, record, done = self.job, self.record, not self.note
        per = 1e6 / (job.steps * job.elements)
        return {
            "scene": TITLES[self.scene],
            "size": job.size,
            "elements": job.elements,
            "solver": job.solver,
            "steps": job.steps,
            "rounds": len(self.seconds),
            "microseconds_per_element_and_step": self.microseconds if done else None,
            "set_up_seconds": record.get("set_up_seconds"),
            "iterations_per_step": record.get("iterations_per_step"),
            "factorizations": record.get("factorizations"),
            "recoveries": record.get("recoveries"),
            "peak_megabytes": record["peak_bytes"] / 1e6 if done else None,
            "bytes_per_element": self.bytes_per_element if done else None,
            "split_microseconds": {k: per * v for k, v in record.get("split", {}).items()},
            "chosen": record.get("chosen"),
            "note": self.note,
        }


@dataclass(frozen=True)
class Scaling:
    """Everything `python -m benchmarks scaling` measures.

    Attributes
    ----------
    rows : list of Row
        Scene by scene, size by size, solver by solver.
    counts : list of dict
        For each scene and size, what grows with it.
    roofline : Roofline
        Measured in the same run.
    settings : dict
        What was run, and on what.
    """

    rows: list[Row]
    counts: list[dict[str, Any]]
    roofline: Roofline
    settings: dict[str, Any]

    def done(self, scene: tuple[str, str], solver: str) -> list[Row]:
        """Return the rows with results of one scene and solver, by size."""
        return [r for r in self.rows if r.scene == scene and r.job.solver == solver and not r.note]

    def by_size(self) -> list[list[Row]]:
        """Return the rows of each scene and size."""
        return [list(g) for _, g in groupby(self.rows, key=lambda r: (r.scene, r.job.size))]

    def slopes(self) -> dict[str, float]:
        """Fit powers of the number of elements to what is counted, from 500 elements on."""
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

    Rounds are run in turn, as many of each, so what else the machine does hits all alike, and a
    single round that it slows down decides nothing.

    Returns
    -------
    dict
        ``scene``, ``size``, and where both sides have a result ``auto / best fixed``,
        ``best fixed``, its name, ``Newton / auto`` and ``<peer> / auto``, and what threads gain.
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
    for name in ("Newton", *(peer.name for peer in PEERS)):
        if name in done:
            out[f"{name} / auto"] = done[name].fastest / auto.fastest
    for row in done.values():
        if row.job.threads > 1:
            out[f"gain of {row.job.threads} threads"] = auto.fastest / row.fastest
    return out
