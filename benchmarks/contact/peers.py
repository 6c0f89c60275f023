"""Cables that fall on a drum, a ball and a cable: time against error, next to other codes.

The codes have different laws of contact and different elements, so each is compared with itself:
the error of a run is the largest distance of both ends and the middle from their positions with
much shorter steps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from ancfsparse.errors import InputError
from benchmarks.common.progress import bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.common.timing import in_turn
from benchmarks.contact import elastica_falls, exudyn_falls, mujoco_falls
from benchmarks.contact.falls import Fall, run_fall
from benchmarks.other_codes.environment import environment
from benchmarks.other_codes.exudyn import ExudynError

OWN = "ancfsparse"
FALLS = ("drum", "ball", "cable")
STEPS = (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4, 6.25e-5, 3.125e-5)  # [s]
EXPLICIT_STEPS = (8e-5, 5e-5, 2.5e-5, 1.25e-5)  # [s], longer ones are unstable
REFINEMENT = 4  # ratio of the shortest step to the step of the run for comparison
ROUNDS = 3  # the shortest time counts
LIMITS = (1e-3, 1e-4, 1e-5)  # errors for which times are compared [m]
LARGEST_ERROR = 0.1  # of a run that counts [m]


@dataclass(frozen=True)
class Candidate:
    """A code and the fall that it runs."""

    on: str
    code: str
    run: Callable[[float], Fall]
    steps: Sequence[float]


@dataclass(frozen=True)
class FallCost:
    """Error and time of a run."""

    on: str
    code: str
    dt: float  # [s]
    error: float  # [m]
    seconds: float  # processor time [s]


@dataclass(frozen=True)
class ContactPeers:
    """All runs, and the codes that are not installed."""

    runs: list[FallCost]
    differences: list[
        tuple[str, str, float]
    ]  # falls, codes, distances of their references from ours [m]
    missing: list[str]
    environment: dict[str, str]


def candidates() -> list[Candidate]:
    """Return all codes with the falls that they can run."""
    out = [Candidate(on, OWN, partial(run_fall, on), STEPS) for on in ("drum", "ball", "cable")]
    for setting in exudyn_falls.SETTINGS:
        run = partial(exudyn_falls.run_exudyn_fall, setting)
        out.append(Candidate("drum", setting.name, run, STEPS))
    for on in ("ball", "cable"):
        run = partial(elastica_falls.run_elastica_fall, on)
        out.append(Candidate(on, "PyElastica", run, EXPLICIT_STEPS))
    out.append(Candidate("ball", "MuJoCo", mujoco_falls.run_mujoco, STEPS))
    return sorted(out, key=lambda each: FALLS.index(each.on))


def contact_peers(progress: bool = False) -> ContactPeers:
    """Time falls on a drum, a ball and a cable, next to Exudyn, PyElastica and MuJoCo."""
    exact: dict[int, Fall] = {}
    chosen = candidates()
    missing: list[str] = []
    for k, each in enumerate(bar(chosen, "reference", progress)):
        try:
            exact[k] = each.run(min(each.steps) / REFINEMENT)
        except InputError as error:
            missing.append(str(error))
    tasks = [(k, dt) for k in exact for dt in chosen[k].steps]

    def run(task: tuple[int, float]) -> tuple[float, float]:
        k, dt = task
        try:
            fall = chosen[k].run(dt)
        except ExudynError:
            return np.inf, np.inf
        error = _distance(fall, exact[k])
        return error if error < LARGEST_ERROR else np.inf, fall.seconds

    costs = [min(rounds) for rounds in in_turn(tasks, run, ROUNDS)]
    runs = [
        FallCost(chosen[k].on, chosen[k].code, dt, *cost)
        for (k, dt), cost in zip(tasks, costs, strict=True)
    ]
    return ContactPeers(runs, _differences(chosen, exact), missing, environment())


def _differences(chosen: list[Candidate], exact: dict[int, Fall]) -> list[tuple[str, str, float]]:
    own = {chosen[k].on: fall for k, fall in exact.items() if chosen[k].code == OWN}
    return [
        (chosen[k].on, chosen[k].code, _distance(fall, own[chosen[k].on]))
        for k, fall in exact.items()
        if chosen[k].code != OWN
    ]


def _distance(fall: Fall, other: Fall) -> float:
    return float(np.linalg.norm(fall.positions - other.positions, axis=1).max())


def _pairs(result: ContactPeers) -> Iterator[tuple[str, str]]:
    return iter(dict.fromkeys((each.on, each.code) for each in result.runs))


def seconds_for(result: ContactPeers, on: str, code: str, limit: float) -> float:
    """Return the shortest time of a run with at most this error [s], infinite if there is none."""
    return min(
        (
            each.seconds
            for each in result.runs
            if (each.on, each.code) == (on, code) and each.error <= limit
        ),
        default=np.inf,
    )


def _milliseconds(result: ContactPeers, limit: float, pair: tuple[str, str]) -> str:
    seconds = seconds_for(result, *pair, limit)
    return f"{1e3 * seconds:.3g}" if np.isfinite(seconds) else "none"


def peer_table(result: ContactPeers) -> Table:
    """Set the times for each error."""
    columns: dict[str, Callable[[Any], str]] = {
        "fall on": lambda pair: pair[0],
        "code": lambda pair: pair[1],
    }
    for limit in LIMITS:
        columns[f"error of {1e3 * limit:g} mm [ms]"] = partial(_milliseconds, result, limit)
    return Table.of(list(_pairs(result)), columns, left=(0, 1), title="Falls of 0.16 s")


def run_table(result: ContactPeers) -> Table:
    """Set all runs."""
    columns: dict[str, Callable[[Any], str]] = {
        "fall on": lambda each: each.on,
        "code": lambda each: each.code,
        "step [ms]": lambda each: f"{1e3 * each.dt:g}",
        "error [mm]": lambda each: (
            f"{1e3 * each.error:.3g}" if np.isfinite(each.error) else "fails"
        ),
        "time [ms]": lambda each: f"{1e3 * each.seconds:.3g}",
    }
    return Table.of(result.runs, columns, left=(0, 1), title="Runs")


def findings(result: ContactPeers) -> list[str]:
    """State the fastest code of each fall."""
    out = []
    for on in dict.fromkeys(each.on for each in result.runs):
        for limit in LIMITS:
            times = {
                code: seconds_for(result, on, code, limit)
                for other, code in _pairs(result)
                if other == on
            }
            best = min(times, key=lambda code: times[code])
            rest = ", ".join(
                f"{code} {time / times[best]:.3g} times as long"
                if np.isfinite(time)
                else f"{code} never"
                for code, time in times.items()
                if code != best
            )
            if not np.isfinite(times[best]):
                out.append(f"Fall on a {on}, error of {1e3 * limit:g} mm: no run reaches it.")
                continue
            out.append(
                f"Fall on a {on}, error of {1e3 * limit:g} mm: {best} is the fastest with "
                f"{1e3 * times[best]:.3g} ms; {rest or 'alone'}."
            )
    out += [
        f"With a quarter of its shortest step {code} ends {1e3 * size:.2g} mm from {OWN} on a {on}."
        for on, code, size in result.differences
    ]
    return [*out, *result.missing]


def rows(result: ContactPeers) -> list[dict[str, Any]]:
    """Return the lines of the CSV table."""
    return [asdict(each) for each in result.runs]


STUDY = Study(
    "contact-peers",
    run=contact_peers,
    tables=lambda result: [run_table(result), peer_table(result)],
    rows=rows,
    findings=findings,
    regions={"contact-peers": peer_table},
)
