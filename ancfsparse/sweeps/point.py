"""Computation at one point of a sweep: build a scene, run it, evaluate quantities."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ancfsparse.errors import AncfError, InputError
from ancfsparse.messages import format_value
from ancfsparse.scene import Scene
from ancfsparse.solve import simulate
from ancfsparse.sweeps.samples import ParameterPoint


@dataclass(frozen=True)
class Task:
    """The computation at every point.

    Attributes
    ----------
    build : callable
        Function of the parameters by name; returns a scene, or a scene and handles of it.
    quantities : mapping of str to callable
        Functions of a run and those handles; each returns a number.
    t_end : float
        Final time [s].
    options : mapping
        Other arguments of `simulate`.
    """

    build: Callable[..., Any]
    quantities: Mapping[str, Callable[..., float]]
    t_end: float
    options: Mapping[str, Any]


@dataclass(frozen=True)
class Row:
    """The result at one point.

    Attributes
    ----------
    values : dict of str to float
        The quantities; NaN if the point failed.
    reason : str
        Reason of the failure; empty without one.
    seconds : float
        Computing time [s].
    """

    values: dict[str, float] = field(default_factory=dict)
    reason: str = ""
    seconds: float = math.nan


def evaluate(task: Task, point: ParameterPoint) -> Row:
    """Run one point.

    An exception of a user function becomes the reason for the failure of this point.
    """
    begin = time.perf_counter()
    values = dict.fromkeys(task.quantities, math.nan)
    reason = ""
    try:
        built = task.build(**point)
        scene, *handles = built if isinstance(built, tuple) else (built,)
        if not isinstance(scene, Scene):
            raise InputError(
                "the function that builds the scene must return it, or a tuple that begins with "
                f"it, got {format_value(built)}"
            )
        run = simulate(scene, task.t_end, **task.options)
        values = {
            name: _number(name, quantity(run, *handles))
            for name, quantity in task.quantities.items()
        }
    except AncfError as error:
        reason = str(error)
    except Exception as error:  # user functions may raise anything; the row names it
        reason = f"{type(error).__name__}: {error}"
    return Row(values, reason, time.perf_counter() - begin)


def evaluate_all(task: Task, points: list[ParameterPoint]) -> list[Row]:
    """Run several points in sequence."""
    return [evaluate(task, point) for point in points]


def _number(name: str, value: Any) -> float:
    if np.ndim(value) or not np.isreal(value):
        raise InputError(f"quantity {name} must be one number, got {format_value(value)}")
    return float(value)
