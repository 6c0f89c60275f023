"""The command ``ancfsparse problem``: benchmark mechanisms and their quantities."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError, RedundantConstraintsWarning
from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.integrators.interface.time_grid import divides
from ancfsparse.messages import format_numbers, format_value
from ancfsparse.problems.mechanism import Case
from ancfsparse.problems.named import MECHANISMS
from ancfsparse.results import Trajectory
from ancfsparse.solve import simulate, solve_static

TOLERANCE = 1e-12  # m/s2, of the iterations


def list_problems() -> str:
    """Return all problems with their keys, quantities and reference values."""
    lines = []
    for name, case in MECHANISMS.items():
        keys = ", ".join(_format_key(k, *entry) for k, entry in (case.keys or {}).items())
        lines.append(f"{name}" + f" [{keys}]" * bool(keys))
        lines.append(f"  quantities: {', '.join(case.make().watched)}")
        value = f"{format_numbers(case.value)} to {case.tolerance:g}"
        lines.append(f"  {case.quantity} at {case.time:g} s: {value} ({case.source})")
    return "\n".join(lines)


def run_problem(
    name: str,
    at: str,
    pairs: list[str],
    step: float | None,
    accuracy: float | None,
    threads: int = 1,
) -> dict[str, Any]:
    """Solve a problem with the options of the command; return settings, times and quantities.

    Raises
    ------
    InputError
        If a name, a key or a time is invalid, or both step and accuracy are given.
    """
    case = MECHANISMS[check_choice("name of a problem", name, MECHANISMS)]
    times, keys = _parse_numbers("--at", at), _parse_keys(name, case, pairs)
    if step is not None and accuracy is not None:
        raise InputError("give --step or --accuracy, not both")
    # Angles count turns from one saved time to the next, so runs to an accuracy save as many.
    runs = _fitted_steps(times, case.dt) if step is None else [(times, step)]
    parts = [_quantities(case, keys, *each, threads, accuracy) for each in runs]
    dts = [dt for _, dt in runs]
    settings: dict[str, Any]
    if accuracy is not None:
        settings = {"accuracy": accuracy, "integrator": repr(GeneralizedAlpha(0.9))}
    else:
        settings = {"dt": dts[0] if len(dts) == 1 else dts, "integrator": repr(case.integrator)}
        settings["tolerance"] = TOLERANCE
        if step is None:
            fine = [_quantities(case, keys, some, 0.5 * dt, threads) for some, dt in runs]
            measured = case.make(**keys).measured
            parts = [
                {
                    each: found[each] + (each not in measured) * (found[each] - part[each]) / 3.0
                    for each in part
                }
                for part, found in zip(parts, fine, strict=True)
            ]
            names = [f"{dt:.9g} s and {0.5 * dt:.9g} s" for dt in dts]
            settings["extrapolated"] = f"from dt = {', '.join(names)}"
    found = {each: np.concatenate([part[each] for part in parts]) for each in parts[0]}
    return {
        "settings": {"problem": name, **keys, **settings},
        "time": times,
        "quantities": {each: values.tolist() for each, values in found.items()},
    }


def _fitted_steps(times: list[float], dt: float) -> list[tuple[list[float], float]]:
    """Return the times of each run and its step: one run, or one for each time that needs another.

    Steps that do not divide a time become shorter, so that they do.
    """
    if all(time == 0.0 or divides(time, dt) for time in times):
        return [(times, dt)]
    return [([time], time / max(1, math.ceil(time / dt)) if time else dt) for time in times]


def _quantities(
    case: Case,
    keys: dict[str, Any],
    times: list[float],
    dt: float,
    threads: int,
    accuracy: float | None = None,
) -> dict[str, Vector]:
    mechanism = case.make(**keys)
    scene, end = mechanism.scene, max(*times, dt)  # one step for the initial values
    start = solve_static(scene) if mechanism.settles else None
    steps = round(end / dt)
    if abs(steps * dt - end) > 1e-9 * end:
        raise InputError(f"the last time {end:g} s is not an integral number of steps of {dt:g} s")
    how: dict[str, Any] = {"integrator": case.integrator, "tolerance": TOLERANCE}
    if accuracy is not None:
        how = {"integrator": GeneralizedAlpha(0.9), "accuracy": accuracy}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RedundantConstraintsWarning)  # known for these problems
        run: Trajectory = simulate(scene, end, dt, start=start, threads=threads, **how)
    rows = [int(np.argmin(np.abs(run.t - time))) for time in times]
    distance = max(abs(float(run.t[row]) - time) for row, time in zip(rows, times, strict=True))
    if distance > 1e-9 * end:
        raise InputError(
            f"a time of --at is {distance:.3g} s away from the nearest step of {dt:g} s"
        )
    return mechanism.quantities(run, rows)


def _convert_like(default: object, value: float) -> float | int:
    """Return an integer if the default is one."""
    return int(value) if isinstance(default, int) and value.is_integer() else value


def _parse_numbers(what: str, text: str) -> list[float]:
    try:
        values = [float(each) for each in text.split(",")]
    except ValueError:
        raise InputError(
            f"{what} needs numbers separated by commas, got {format_value(text)}"
        ) from None
    if not all(0.0 <= each < np.inf for each in values) and what == "--at":
        raise InputError(f"{what} needs times from 0 on [s], got {format_value(text)}")
    return values


def _format_key(name: str, default: Any, unit: str) -> str:
    """Return a key with its default and its unit."""
    value = format_numbers(default) if isinstance(default, tuple) else f"{default:.9g}"
    return f"{name}={value} {unit}".rstrip()


def _parse_keys(name: str, case: Case, pairs: list[str]) -> dict[str, Any]:
    """Return the arguments of a problem from ``key=value``."""
    keys: dict[str, Any] = {}
    for each in pairs:
        key, equals, value = each.partition("=")
        if not equals:
            raise InputError(f"--set needs key=value, got {format_value(each)}")
        if not case.keys:
            raise InputError(f"{name} takes no keys, got {key!r}")
        check_choice(f"key of {name}", key, case.keys)
        found = _parse_numbers(f"--set {key}", value)
        default = case.keys[key][0]
        keys[key] = found if isinstance(default, tuple) else _convert_like(default, found[0])
    return keys
