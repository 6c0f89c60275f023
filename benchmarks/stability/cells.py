"""One run of a map of outcomes: its place, its outcome, and measures of its stored states."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from ancfsparse.results import Trajectory

FINISHED, RECOVERED, GAINED, FAILED = "finished", "recovered", "gained energy", "failed"
OUTCOMES = (FINISHED, RECOVERED, GAINED, FAILED)
"""Complete; complete with recovered steps; stopped for its energy; stopped."""


class MapPoint(NamedTuple):
    """A point of a map: keys of its tables, stiffness in its unit, step [s]."""

    scene: str
    stiffness: float
    dt: float
    integrator: str
    solver: str


@dataclass(frozen=True)
class Run:
    """The outcome at a point of a map."""

    map_point: MapPoint
    outcome: str  # one of `OUTCOMES`
    steps: int  # steps that were accepted
    reason: str  # why it was stopped, empty if it was not
    iterations: float  # corrections per step
    # fractions of the steps recovered by a new seed, and by damped Newton or beyond
    new_seed: float
    newton: float
    measures: Mapping[str, float]  # of the stored states by the columns of the map
    # whether it ended otherwise than Newton's run by chance alone, see `MapSpec.ends_by_chance`
    chaotic: bool = False

    @property
    def is_complete(self) -> bool:
        """True if it came to its end."""
        return self.outcome in (FINISHED, RECOVERED)

    @property
    def gain(self) -> float:
        """Largest energy above the supplied one, relative [-]; see the measures of the map."""
        return self.measures["gain"]

    def record(self) -> dict[str, Any]:
        """Return a row of the table, short: three digits."""
        return {
            **self.map_point._asdict(),
            "outcome": self.outcome,
            "steps": self.steps,
            "reason": self.reason,
            "iterations": round(self.iterations, 2),
            **{name: _short(getattr(self, name)) for name in ("new_seed", "newton")},
            **{name: _short(value) for name, value in self.measures.items()},
            "chaotic": int(self.chaotic),
        }

    @classmethod
    def of(cls, row: Mapping[str, str], measures: Iterable[str]) -> Run:
        """Make a run of a row of the table, which has columns of these measures."""
        map_point = MapPoint(
            row["scene"], float(row["stiffness"]), float(row["dt"]), row["integrator"],
            row["solver"],
        )  # fmt: skip
        return cls(
            map_point,
            row["outcome"],
            int(row["steps"]),
            row["reason"],
            float(row["iterations"]),
            float(row["new_seed"]),
            float(row["newton"]),
            {name: float(row[name]) for name in measures},
            row["chaotic"] == "1",
        )


def _short(value: float) -> float:
    return float(f"{value:.2e}")


def recovered_fractions(path: Trajectory) -> tuple[float, float]:
    """Return the fractions of steps recovered by a new seed, and by damped Newton or beyond.

    Of the steps up to the last stored event, if some were not stored.
    """
    stats = path.stats
    if not stats.recoveries:
        return 0.0, 0.0
    newton = {e.step for e in stats.events if e.rung != "new seed" and e.step <= stats.steps}
    seed = {e.step for e in stats.events if e.step <= stats.steps} - newton
    listed = stats.steps if len(newton | seed) == stats.recoveries else stats.events[-1].step
    return len(seed) / listed, len(newton) / listed


def in_words(run: Run) -> str:
    """Name the outcome with its recovery or its reason."""
    if run.outcome == RECOVERED:
        by = "damped Newton" if run.newton > 0.0 else "a new seed"
        return f"recovered by {by} in {100 * (run.newton + run.new_seed):.2g} % of the steps"
    if run.is_complete:
        return run.outcome
    text = f"{run.outcome} at {run.steps * run.map_point.dt:.3g} s"
    return f"{text} ({run.reason})" if run.outcome == FAILED else text
