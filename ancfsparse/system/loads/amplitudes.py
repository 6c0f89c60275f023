"""Loads that change, tabulated for many times: at once where a function can, else call by call."""

from __future__ import annotations

import warnings
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import LoadError
from ancfsparse.scene.records.signal import is_vectorized
from ancfsparse.scene.records.time_dependent import TimeDependentValue

Vector = NDArray[np.float64]

# Fewer times are not worth an array of what is not a signal, and so many calls check one: the first
# time, the last, and others spread between them.
MIN_ARRAY_TIMES, N_CHECKS = 32, 8
# By how much of the largest value an array and a call may differ: both round, not always alike.
ROUNDING = 1e-12


class Amplitudes(Protocol):
    """Functions of time.

    Attributes
    ----------
    width : int
        How many.
    """

    width: int

    def tabulate(self, times: Vector) -> tuple[Vector, LoadError | None]:
        """Return them up to the first time at which one fails, (j, width), and how it fails."""


class TimeAmplitude:
    """The time itself, as the amplitude of what depends on it."""

    width = 1

    def tabulate(self, times: Vector) -> tuple[Vector, None]:
        """Return the times [s] as a column, (k, 1), and that nothing fails."""
        return times[:, None], None


class ConstantAmplitude:
    """One, at all times: the amplitude of a constant load, by which statics lets it grow."""

    width = 1

    def tabulate(self, times: Vector) -> tuple[Vector, None]:
        """Return ones as a column, (k, 1), and that nothing fails."""
        return np.ones((len(times), 1)), None


class FunctionAmplitude:
    """A load and the amplitudes it gives.

    A function is given arrays of times as long as what it returns for them is what it returns for
    single ones.  That is checked at some times of each array, and what does not depend on the time
    is not believed.  Signals are given arrays of any length, so that their values do not depend on
    how a run is divided: an array and a call are not always rounded alike.

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
        """Return the amplitudes up to the first time at which the load fails, and how it fails.

        Parameters
        ----------
        times : (k,) float
            Times [s].

        Returns
        -------
        table : (j, width) float
            j is k if nothing fails [N, N m or N/m].
        failure : LoadError or None
            What happened at time j.
        """
        if not callable(self.load.value):
            return np.broadcast_to(self.load.at(0.0), (len(times), self.width)), None
        if self._takes_arrays and len(times) >= (1 if self._always else MIN_ARRAY_TIMES):
            table = self._at_once(times)
            if table is not None:
                return table, None
            self._takes_arrays = self._always
        return self._call_by_call(times)

    def _at_once(self, times: Vector) -> Vector | None:
        """Return the amplitudes by one call with all times, or None if they are not right."""
        function: Any = self.load.value
        given = np.array(times)
        given.flags.writeable = False
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                table = _columns(function(given), len(times), self.width)
        except Exception:  # it may raise anything for an array; single calls show what is wrong
            return None
        if table is None or self._always:
            return table
        spread = np.arange(1, N_CHECKS - 1) * 0.6180339887498949 % 1.0  # the golden ratio
        at = np.array([0, *(len(times) * spread).astype(int), len(times) - 1])
        single, failure = self._call_by_call(times[at])
        if failure is not None:
            return None
        far = np.abs(table[at] - single) > ROUNDING * np.max(np.abs(table), axis=0)
        return None if far.any() else table

    def _call_by_call(self, times: Vector) -> tuple[Vector, LoadError | None]:
        function: Any = self.load.value
        values: list[Any] = []
        failure = None
        try:
            for t in times.tolist():
                values.append(function(t))
        except Exception as error:  # a function of the caller's may raise anything
            failure = self.load.failure(t, error)
            failure.__cause__ = error
        table = _rows(values, self.load.shape)
        if table is None:  # one of them is no load: find it
            table = np.empty((len(values), self.width))
            for k, value in enumerate(values):
                try:
                    table[k] = self.load.checked(float(times[k]), value)
                except LoadError as wrong:
                    return table[:k], wrong
        return table, failure


def _columns(found: Any, k: int, width: int) -> Vector | None:
    """Return what a function has returned for k times as a table (k, width), or None.

    It may be an array (k, width), or what single calls return with arrays (k,) for numbers; those
    that stay numbers are constant.
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
    """Return what single calls have returned as a table, or None if one of them is no load."""
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
