"""Points of a sweep: grids and Latin hypercube samples of named parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import product
from typing import Any

import numpy as np

from ancfsparse.checks import check_count, check_reals
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.system_memory import check_memory

ParameterPoint = dict[str, Any]
"""A value for every parameter, by name."""

PLAIN_TYPES = (bool, int, float, str)
"""Types that a file of results stores exactly."""


def grid(**values: Iterable[Any]) -> list[ParameterPoint]:
    """Return all combinations of parameter values.

    Parameters
    ----------
    **values : iterable
        The values of each parameter, in its own unit; the last parameter varies fastest.

    Returns
    -------
    list of dict
        Points for `sweep`.

    Examples
    --------
    >>> grid(length=[1.0, 2.0], n_elements=[4, 8])[1]
    {'length': 1.0, 'n_elements': 8}
    """
    columns = {}
    for name, each in values.items():
        if isinstance(each, str) or not _is_list(each):
            got = format_value(each)
            raise InputError(f"the values of {name} must be a list, got {got}: try [{got}]")
        columns[name] = list(each)
        if not columns[name]:
            raise InputError(f"{name} has no values: give at least one")
    if not columns:
        raise InputError("a grid needs parameters: try grid(length=[1.0, 2.0])")
    return [dict(zip(columns, each, strict=True)) for each in product(*columns.values())]


def latin_hypercube(n: int, seed: int = 0, **ranges: tuple[float, float]) -> list[ParameterPoint]:
    """Return a Latin hypercube sample: one point in each of n intervals of every parameter.

    Parameters
    ----------
    n : int
        Number of points.
    seed : int, optional
        Seed of the random numbers; equal seeds give equal points.
    **ranges : (float, float)
        Smallest and largest value of each parameter, in its own unit.

    Returns
    -------
    list of dict
        Points for `sweep`.

    Raises
    ------
    InputError
        If a range is not two finite numbers in ascending order.

    Notes
    -----
    McKay, Beckman and Conover (1979), as in `scipy.stats.qmc.LatinHypercube`.
    """
    from scipy.stats.qmc import LatinHypercube

    count = check_count("n", n)
    check_memory("a sample", 64.0 * count * max(1, len(ranges)), "a smaller n")
    start = check_count("seed", seed, 0)
    if not ranges:
        raise InputError("a sample needs parameters: try latin_hypercube(10, length=(1.0, 2.0))")
    bounds = []
    for name, each in ranges.items():
        pair = check_reals(f"the range of {name}", each, "two numbers")
        if pair.shape != (2,) or not np.isfinite(pair).all() or not pair[0] < pair[1]:
            raise InputError(
                f"the range of {name} must be two finite numbers in ascending order, "
                f"got {format_value(each)}"
            )
        bounds.append(pair)
    unit = LatinHypercube(len(ranges), rng=np.random.default_rng(start)).random(count)
    low, high = np.array(bounds).T
    return [dict(zip(ranges, row, strict=True)) for row in (low + unit * (high - low)).tolist()]


def check_points(points: Any) -> list[ParameterPoint]:
    """Return points as dictionaries of plain values, all with the same names.

    Parameters
    ----------
    points : sequence of mapping, or pandas.DataFrame
        The argument.

    Raises
    ------
    InputError
        If there are no points, if names differ, or if a file cannot store a value.
    """
    rows = points.to_dict("records") if hasattr(points, "to_dict") else points
    if isinstance(rows, Mapping) or not _is_list(rows):
        raise InputError(
            f"points of a sweep must be a list of dictionaries, got {format_value(points)}: try "
            "ancf.grid(length=[1.0, 2.0])"
        )
    out: list[ParameterPoint] = []
    for k, row in enumerate(rows):
        if not isinstance(row, Mapping) or not all(isinstance(name, str) for name in row):
            raise InputError(
                f"point {k} of the sweep must be a dictionary, got {format_value(row)}"
            )
        point = {name: _plain(k, name, value) for name, value in row.items()}
        if out and set(point) != set(out[0]):
            other = sorted(set(point) ^ set(out[0]))
            raise InputError(
                f"point {k} of the sweep has other parameters than the first: {other[0]!r} is in "
                "only one of them"
            )
        out.append(point)
    if not out:
        raise InputError("the sweep has no points")
    return out


def _is_list(values: object) -> bool:
    """Return True for an iterable, but not for an array of shape ()."""
    return isinstance(values, Iterable) and getattr(values, "shape", None) != ()


def _plain(k: int, name: str, value: Any) -> bool | int | float | str:
    plain = value.item() if isinstance(value, np.generic) else value
    if not isinstance(plain, PLAIN_TYPES):
        raise InputError(
            f"{name} of point {k} must be a number or a string, got {format_value(value)}: build "
            "vectors and materials from numbers in the function that builds the scene"
        )
    return plain
