"""Cost per step and element, and memory, against the size of chains and nets."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from itertools import groupby
from statistics import median
from typing import Any

import numpy as np
from tqdm import tqdm

from ancfsparse.studies.exudyn_peer import load
from ancfsparse.studies.exudyn_scene import SETTINGS as PEERS
from ancfsparse.studies.roofline import Roofline, roofline
from ancfsparse.studies.scaling_job import SOLVERS, Job, Worker, counts

DT = 5e-4
CHAINS = (10, 100, 1000, 10_000, 100_000, 1_000_000)
NETS = (10, 30, 60, 100, 200)
TITLES = {
    ("chain", "rest"): "chain falling from rest",
    ("chain", "rough"): "chain in rough motion",
    ("net", "rest"): "net falling from rest",
}
"""What is studied."""

# A scene this much larger takes as much longer with the solver that grows fastest.
GROWTH = {"chain": 1.0, "net": 1.5}
# Chains whose cost per element the longest one is compared with: in the caches, and not.
GROWTH_FROM = (1000, 100_000)
# Fits leave out sizes where fixed costs show.
FIT_FROM = 500


@dataclass
class Row:
    """One solver on one scene.

    Attributes
    ----------
    job : Job
        What was run.
    seconds : list of float
        March of each round [s].
    record : dict
        The last round, as `scaling_job.run` returns it.
    """

    job: Job
    seconds: list[float] = field(default_factory=list)
    record: dict[str, Any] = field(default_factory=dict)

    @property
    def note(self) -> str:
        """Why there is no result, or nothing."""
        return str(self.record.get("note", ""))

    @property
    def microseconds(self) -> float:
        """Median time per element and step [microseconds]."""
        return 1e6 * median(self.seconds) / (self.job.steps * self.job.elements)

    @property
    def scene(self) -> tuple[str, str]:
        """Case and motion."""
        return self.job.case, self.job.motion

    @property
    def bytes_per_element(self) -> float:
        """Peak memory above that of an idle process [bytes]."""
        taken: int = self.record["peak_bytes"] - self.record["base_bytes"]
        return taken / self.job.elements

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
    """Everything `ancfsparse study scaling` measures.

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

    def record(self) -> dict[str, Any]:
        """Return one JSON object."""
        return {
            "settings": self.settings,
            "rows": [r.flat() | {"seconds": r.seconds} for r in self.rows],
            "counts": self.counts,
            "ratios": [ratios(group) for group in self.by_size()],
            "slopes": self.slopes(),
            "growth": self.growth(),
            "roofline": self.roofline.record(),
        }


def slope(points: Sequence[tuple[float, float]]) -> float:
    """Return the power of x that fits y best; NaN with fewer than two points that count."""
    used = np.array([p for p in points if p[0] >= FIT_FROM and p[1] > 0], dtype=float)
    if len(used) < 2:
        return float("nan")
    x, y = np.log(used).T
    return float(np.polyfit(x, y, 1)[0])


def ratios(group: Sequence[Row]) -> dict[str, Any]:
    """Compare the solvers of one scene and size.

    Parameters
    ----------
    group : sequence of Row
        As `Scaling.by_size` returns them.

    Returns
    -------
    dict
        ``scene``, ``size``, and where both sides have a result ``auto / best fixed``,
        ``Newton / auto`` and ``<peer> / auto``, and what threads gain: times of the rounds in turn,
        the median of ratios.
    """
    done = {row.job.solver: row for row in group if not row.note}
    out: dict[str, Any] = {"scene": TITLES[group[0].scene], "size": group[0].job.size}
    auto = done.pop("auto", None)
    if auto is None:
        return out

    def over(row: Row) -> float:
        return median(a / b for a, b in zip(row.seconds, auto.seconds, strict=True))

    fixed = [row for name, row in done.items() if name in SOLVERS]
    if fixed:
        best = max(1.0 / over(row) for row in fixed)
        out |= {"auto / best fixed": best}
    for name in ("Newton", *(peer.name for peer in PEERS)):
        if name in done:
            out[f"{name} / auto"] = over(done[name])
    for row in done.values():
        if row.job.threads > 1:
            out[f"gain of {row.job.threads} threads"] = 1.0 / over(row)
    return out


def scaling(
    largest: int = 100_000,
    steps: int = 100,
    largest_net: int = 60,
    peers: bool = False,
    rounds: int = 3,
    cap: float = 60.0,
    progress: bool = False,
    threads: int = 1,
) -> Scaling:
    """Run all solvers on chains and nets of growing size.

    Each solver has a process of its own for each size; on one size the solvers run in turn, round
    by round, so that a busy moment of the machine hits them alike.

    Parameters
    ----------
    largest : int, optional
        Elements of the longest chain; chains of 10, 100, ... elements up to there are run.
    steps : int, optional
        Time steps of 5e-4 s.
    largest_net : int, optional
        Nodes along a side of the largest net, of 10, 30, 60, 100, 200; 0 runs none.
    peers : bool, optional
        Whether to run Exudyn too.
    rounds : int, optional
        Runs of each solver on each scene.
    cap : float, optional
        A run that is expected to take longer than this [s], from the size before, is left out.
    progress : bool, optional
        Whether to draw a progress bar.
    threads : int, optional
        If more than one, auto is also run on so many threads.
    """
    settings: dict[str, Any] = {"dt_s": DT, "steps": steps, "rounds": rounds, "cap_s": cap}
    if peers:
        settings["exudyn"] = load().__version__
    names = [*SOLVERS, *(peer.name for peer in PEERS if peers)]
    plan = [
        Job(*scene[:1], size, scene[1], "", steps, DT)
        for scene in TITLES
        for size in (_chains(largest) if scene[0] == "chain" else _nets(largest_net))
    ]
    before: dict[tuple[tuple[str, str], str], Row] = {}
    rows: list[Row] = []
    with tqdm(plan, unit="scene", disable=None if progress else True, leave=False) as bar:
        for job in bar:
            bar.set_description(f"{job.case} {job.size}, {job.motion}")
            group = [Row(replace(job, solver=name)) for name in names]
            if threads > 1:
                group.append(Row(replace(job, solver=on_threads(threads), threads=threads)))
            for row in group:
                row.record = _leave_out(row, before.get((row.scene, row.job.solver)), cap)
            _race([row for row in group if not row.note], rounds)
            before |= {(row.scene, row.job.solver): row for row in group}
            rows += group
    table = [
        {"scene": TITLES[job.case, job.motion], "size": job.size, "elements": job.elements}
        | counts(job.scene())
        for job in plan
    ]
    return Scaling(rows, table, roofline(max(_chains(largest))), settings)


def on_threads(threads: int) -> str:
    """Name auto on several threads."""
    return f"auto, {threads} threads"


def _chains(largest: int) -> list[int]:
    return sorted({each for each in CHAINS if each < largest} | {largest})


def _nets(largest: int) -> list[int]:
    return sorted({each for each in NETS if each < largest} | {largest} - {0})


def _leave_out(row: Row, before: Row | None, cap: float) -> dict[str, Any]:
    """Return a note if the size before says that a run cannot be, or nothing."""
    if before is None:
        return {}
    if before.note:
        told = before.note.startswith("from ")
        return {"note": before.note if told else f"from {before.job.size} on: {before.note}"}
    larger = row.job.elements / before.job.elements
    expected = median(before.seconds) * larger ** GROWTH[row.job.case]
    return {"note": f"left out: {expected:.0f} s expected"} if expected > cap else {}


def _race(rows: list[Row], rounds: int) -> None:
    """Run all rows in turn, each in its own process."""
    with ExitStack() as stack:
        workers = [stack.enter_context(Worker()) for _ in rows]
        for _ in range(rounds):
            for row, worker in zip(rows, workers, strict=True):
                if row.note:
                    continue
                row.record = worker.run(row.job)
                if not row.note:
                    row.seconds.append(row.record["seconds"])
