"""Amplitudes of time-dependent loads, by one call for many times if possible."""

from __future__ import annotations

import warnings
from copy import copy
from typing import Any, Protocol

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import LoadError
from ancfsparse.scene.records.signal import is_vectorized
from ancfsparse.scene.records.time_dependent import TimeDependentValue

MIN_ARRAY_TIMES = 32  # times for a call with an array, except for signals
N_CHECKS = 8  # single calls that check an array: first time, last time, and others between
ROUNDING = 1e-12  # difference of an array and a single call, over the largest value


class Amplitudes(Protocol):
    """Functions of time.

    Attributes
    ----------
    width : int
        Number of functions.
    """

    width: int

    def tabulate(self, times: Vector) -> tuple[Vector, LoadError | None]:
        """Return values up to the first time at which a function fails, (j, width)."""


class TimeAmplitude:
    """The time, as the amplitude of contributions that depend on it."""

    width = 1

    def tabulate(self, times: Vector) -> tuple[Vector, None]:
        """Return the times [s] as a column, (k, 1)."""
        return times[:, None], None


class ConstantAmplitude:
    """The constant one: the amplitude of a constant load, which statics scales."""

    width = 1

    def tabulate(self, times: Vector) -> tuple[Vector, None]:
        """Return ones as a column, (k, 1)."""
        return np.ones((len(times), 1)), None


class FunctionAmplitude:
    """The amplitudes of a load.

    A function is called with arrays of times as long as the results agree with those of single
    calls, which is checked at some times of each array; constant results are not accepted.  Signals
    are always called with arrays, so that their values do not depend on the division of a run:
    rounding errors of array and single calls can differ.

    Parameters
    ----------
    load : Load
        The load.
    """

    def __init__(self, load: TimeDependentValue) -> None:
        self.load = load
        self.width = load.shape[0] if load.shape else 1
        self._always = is_vectorized(load.value)
        self._takes_arrays = True

    def tabulate(self, times: Vector) -> tuple[Vector, LoadError | None]:
        """Return the amplitudes up to the first time at which the load fails.

        Parameters
        ----------
        times : (k,) float
            Times [s].

        Returns
        -------
        table : (j, width) float
            j is k if nothing fails [N, N m or N/m].
        failure : LoadError or None
            Failure at time j.
        """
        if not callable(self.load.value):
            return np.broadcast_to(self.load.at(0.0), (len(times), self.width)), None
        if self._takes_arrays and (self._always or len(times) >= MIN_ARRAY_TIMES):
            table = self._at_once(times)
            if table is not None:
                return table, None
            self._takes_arrays = self._always
        return self._call_by_call(times)

    def _at_once(self, times: Vector) -> Vector | None:
        """Return the amplitudes by one call with all times, or None if they are wrong."""
        function: Any = self.load.value
        array = np.array(times)
        array.flags.writeable = False
        try:
            if self._always:
                with np.errstate(all="ignore"):
                    rows = np.reshape(function(array), (len(times), self.width))
                return rows if np.isfinite(rows).all() else None
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                table = _columns(function(array), len(times), self.width)
        except Exception:  # it may raise anything for an array; single calls decide
            return None
        if table is None:
            return None
        spread = np.arange(1, N_CHECKS - 1) * 0.6180339887498949 % 1.0  # the golden ratio
        at = np.array([0, *(len(times) * spread).astype(int), len(times) - 1])
        single, failure = self._call_by_call(times[at])
        if failure is not None:
            return None
        differs = np.abs(table[at] - single) > ROUNDING * np.max(np.abs(table), axis=0)
        return None if differs.any() else table

    def _call_by_call(self, times: Vector) -> tuple[Vector, LoadError | None]:
        function: Any = self.load.value
        values: list[Any] = []
        failure = None
        try:
            for t in times.tolist():
                values.append(copy(function(t)))  # it may return one array again and again
        except Exception as error:  # user functions may raise anything
            failure = self.load.failure(t, error)
            failure.__cause__ = error
        table = _rows(values, self.load.shape)
        if table is None:  # a value is invalid: find it
            table = np.empty((len(values), self.width))
            for k, value in enumerate(values):
                try:
                    table[k] = self.load.checked(float(times[k]), value)
                except LoadError as wrong:
                    return table[:k], wrong
        return table, failure


def _columns(found: Any, k: int, width: int) -> Vector | None:
    """Return the result of a function for k times as a table (k, width), or None.

    Valid are an array (k, width), or the result of a single call with arrays (k,) in place of
    numbers; remaining numbers are constant.
    """
    if isinstance(found, np.ndarray) and found.shape == (k, width):
        parts = list(found.T)
    else:
        parts = [np.asarray(part) for part in ([found] if width == 1 else found)]
    shapes = {part.shape for part in parts}
    if len(parts) != width or not {(k,)} <= shapes <= {(k,), ()}:
        return None
    if any(part.dtype.kind not in "iuf" for part in parts):
        return None
    table = np.empty((k, width))
    for column, part in zip(table.T, parts, strict=True):
        column[:] = part
    return table if np.isfinite(table).all() else None


def _rows(values: list[Any], shape: tuple[int, ...]) -> Vector | None:
    """Return the results of single calls as a table, or None if one is invalid."""
    try:
        table = np.array(values)
    except ValueError:  # of different lengths
        return None
    if not values:
        return np.empty((0, *(shape or (1,))))
    if table.dtype.kind not in "iuf" or table.shape != (len(values), *shape):
        return None
    table = table.astype(float).reshape(len(values), -1)
    return table if np.isfinite(table).all() else None
