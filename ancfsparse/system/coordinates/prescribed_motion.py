"""Prescribed motions: coordinates with their rates, and right-hand sides of equations."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.errors import LoadError
from ancfsparse.scene.kinematics.linear_forms import RheonomicTerm
from ancfsparse.system.loads.amplitudes import FunctionAmplitude

if TYPE_CHECKING:
    from ancfsparse.scene.records.prescribed_motion import PrescribedMotion

Integers = NDArray[np.int_]

STENCIL_POINTS = 6  # points of a difference formula for missing rates
STENCIL_CENTRE = 2  # index of the evaluated time among them
RATE_ROUNDING = 1e-9  # rounding error of a function, over its variation across these points


class PrescribedValues(NamedTuple):
    """Prescribed values at a time.

    Attributes
    ----------
    q, v, a : (n,) float
        Prescribed coordinates [m], velocities, accelerations.
    s, s_rate, s_second : (n_equations,) float
        Right-hand sides of the prescribed equations [m], and their rates.
    """

    q: Vector
    v: Vector
    a: Vector
    s: Vector
    s_rate: Vector
    s_second: Vector


class PrescribedMotions:
    """The motions that a scene prescribes.

    Parameters
    ----------
    courses : sequence of Course
        Motions of the last coordinates.
    led : sequence of Led
        Right-hand sides of the last equations.

    Attributes
    ----------
    n, n_equations : int
        Numbers of prescribed coordinates and equations.
    courses : list of Course
        All motions without repetition.
    """

    def __init__(
        self, courses: Sequence[PrescribedMotion], rheonomic: Sequence[RheonomicTerm]
    ) -> None:
        of_equations = {id(each.motion): each.motion for each in rheonomic}
        self.courses = [*courses, *of_equations.values()]
        self._courses = [_MotionTable(course) for course in courses]
        tables = {key: _MotionTable(course) for key, course in of_equations.items()}
        self._rheonomic = [(tables[id(each.motion)], each) for each in rheonomic]
        self._tables = [*self._courses, *tables.values()]
        self.n = sum(table.width for table in self._courses)
        self.n_equations = len(rheonomic)

    def __bool__(self) -> bool:
        """Return True if anything is prescribed."""
        return self.n + self.n_equations > 0

    @property
    def differences(self) -> str:
        """Name of a motion with rates by differences, empty if there is none."""
        return next((table.name for table in self._tables if not table.has_rates), "")

    @property
    def widths(self) -> list[int]:
        """Widths of the blocks of columns of `tabulate`: motions, their rates, and equations."""
        return [*[table.width for table in self._courses] * 3, *[1] * self.n_equations]

    def resolve(self, step: float, begin: float, end: float) -> None:
        """Set step and interval of the difference formulas [s]."""
        for table in self._tables:
            table.step = min(step, (end - begin) / (STENCIL_POINTS - 1))
            table.begin, table.end = begin, end

    def tabulate(self, times: Vector, rates: bool = False) -> tuple[Vector, LoadError | None]:
        """Return prescribed values up to the first time at which a function fails.

        Parameters
        ----------
        times : (k,) float
            Times [s].
        rates : bool, optional
            Include two rates of the prescribed equations.

        Returns
        -------
        table : (j, 3 n + n_equations) float
            Coordinates, velocities, accelerations; right-hand sides of equations, then their rates.
        failure : LoadError or None
            Failure at time j.
        """
        courses, rheonomic, failure = self._evaluate(times)
        parts = [courses[:, k] for k in range(3)]
        parts += [rheonomic[:, k] for k in range(3 if rates else 1)]
        return np.concatenate(parts, axis=1), failure

    def at(self, time: float) -> PrescribedValues:
        """Return prescribed values at a time [s].

        Raises
        ------
        LoadError
            If a function fails.
        """
        return PrescribedValues(*(each[0] for each in self.history(np.array([time]))))

    def history(self, times: Vector) -> PrescribedValues:
        """Return prescribed values at times (k,) [s], each with k rows.

        Raises
        ------
        LoadError
            If a function fails.
        """
        courses, rheonomic, failure = self._evaluate(times)
        if failure is not None:
            raise failure
        return PrescribedValues(*courses.swapaxes(0, 1), *rheonomic.swapaxes(0, 1))

    def course_of(self, k: int) -> PrescribedMotion:
        """Return the motion of prescribed coordinate k."""
        ends = np.cumsum([table.width for table in self._courses])
        return self.courses[int(np.searchsorted(ends, k, side="right"))]

    def speed_errors(self, time: float) -> Vector:
        """Return error bounds of velocities by differences, (n,) [m/s]."""
        errors = [table.rate_error(time) for table in self._courses]
        return np.concatenate([np.zeros(0), *errors])

    def rate_errors(self, time: float) -> Vector:
        """Return error bounds of rates of equations by differences, (n_equations,) [m/s].

        Parameters
        ----------
        time : float
            Time [s].
        """
        out = np.zeros(self.n_equations)
        for k, (table, each) in enumerate(self._rheonomic):
            course = table.tabulate(np.array([time]))[0][:, :, each.column]
            off = course.copy()
            off[:, 1] += table.rate_error(time)[each.column]
            if each.scale is not None:
                course, off = each.scale(course), each.scale(off)
            out[k] = abs(off[0, 1] - course[0, 1])
        return out

    def fastest(self, times: Vector) -> float:
        """Return the largest velocity of a coordinate at some times (k,) [m/s].

        Times from the first failure of a function on are ignored.
        """
        return float(np.max(np.abs(self._evaluate(times)[0][:, 1]), initial=0.0))

    def _evaluate(self, times: Vector) -> tuple[Vector, Vector, LoadError | None]:
        """Return values and rates of coordinates (j, 3, n) and equations (j, 3, n_equations)."""
        rows, failure = len(times), None
        found: dict[int, Vector] = {}
        for table in self._tables:
            found[id(table)], failed = table.tabulate(times[:rows])
            rows, failure = len(found[id(table)]), failed or failure
        courses = [np.empty((rows, 3, 0)), *(found[id(each)][:rows] for each in self._courses)]
        rheonomic = np.empty((rows, 3, self.n_equations))
        for k, (table, each) in enumerate(self._rheonomic):
            course = found[id(table)][:rows, :, each.column]
            rheonomic[:, :, k] = course if each.scale is None else each.scale(course)
        return np.concatenate(courses, axis=2), rheonomic, failure


class _MotionTable:
    """A prescribed motion and its rates at many times."""

    def __init__(self, course: PrescribedMotion) -> None:
        self._places = FunctionAmplitude(course.value)
        given = (course.rate, course.second_rate)
        self._rates = [FunctionAmplitude(each) for each in given if each is not None]
        self.name, self.has_rates = course.value.what, bool(self._rates)
        self.width = self._places.width
        self.step = self.begin = self.end = 0.0

    def tabulate(self, times: Vector) -> tuple[Vector, LoadError | None]:
        """Return value and rates (j, 3, width), up to the first time at which a function fails."""
        if not self.has_rates:
            return self._by_differences(times)
        rows, failure, columns = len(times), None, []
        for source in (self._places, *self._rates):
            column, failed = source.tabulate(times[:rows])
            rows, failure = len(column), failed or failure
            columns.append(column)
        return np.stack([column[:rows] for column in columns], axis=1), failure

    def rate_error(self, time: float) -> Vector:
        """Return an error bound of the rate at a time, (width,) [m/s]; zero for specified rates.

        It is ten times the change of the rate when one point of the polynomial is omitted, plus a
        small fraction of the mean rate across the points, plus the rounding errors of the values.
        """
        if self.has_rates or self.step == 0.0:
            return np.zeros(self.width)
        values, middle, _ = self._around(np.array([time]))
        centre = int(middle[0])
        far = STENCIL_POINTS - 1 if centre < STENCIL_POINTS // 2 else 0
        fewer = np.delete(values[0], far, axis=0)
        rates = [
            _difference_weights(place, len(points))[0] @ (points - points[place])
            for points, place in ((values[0], centre), (fewer, centre - (far == 0)))
        ]
        size = np.max(np.abs(values), initial=0.0) * np.sum(np.abs(_difference_weights(centre)[0]))
        rounding = 2.0 * np.finfo(float).eps * size
        across = RATE_ROUNDING * np.max(np.abs(values[0] - values[0, centre]), axis=0)
        return np.asarray((10.0 * np.abs(rates[1] - rates[0]) + across + rounding) / self.step)

    def _by_differences(self, times: Vector) -> tuple[Vector, LoadError | None]:
        """Differentiate the polynomial through points around each time, within the run."""
        if self.step == 0.0:  # without a run: values only
            values, failure = self._places.tabulate(times)
            return np.stack([values, 0.0 * values, 0.0 * values], axis=1), failure
        values, middle, failure = self._around(times)
        rows = len(values)
        weights = np.stack([_difference_weights(k) for k in range(STENCIL_POINTS)])[middle]
        centre = values[np.arange(rows), middle]
        apart = values - centre[:, None]  # avoids cancellation
        rates = np.einsum("kop,kpw->kow", weights, apart)
        rates /= np.array([self.step, self.step**2])[None, :, None]
        return np.concatenate([centre[:, None], rates], axis=1), failure

    def _around(self, times: Vector) -> tuple[Vector, Integers, LoadError | None]:
        """Return values (j, STENCIL_POINTS, width) around times, and the indices of these times."""
        before = np.floor((times - self.begin) / self.step + 1e-6)
        after = np.floor((self.end - times) / self.step + 1e-6)
        low = np.clip(STENCIL_POINTS - 1 - after, 0, STENCIL_POINTS - 1)
        middle = np.clip(
            np.minimum(np.maximum(STENCIL_CENTRE, low), before), 0, STENCIL_POINTS - 1
        ).astype(int)
        points = times[:, None] + self.step * (np.arange(STENCIL_POINTS) - middle[:, None])
        points = np.clip(points, self.begin, self.end)
        points[np.arange(len(times)), middle] = times
        values, failure = self._places.tabulate(points.ravel())
        rows = len(values) // STENCIL_POINTS
        return (
            values[: rows * STENCIL_POINTS].reshape(rows, STENCIL_POINTS, self.width),
            middle[:rows],
            failure,
        )


@cache
def _difference_weights(middle: int, n: int = STENCIL_POINTS) -> Vector:
    """Return weights of n equally spaced points for two derivatives at one of them, (2, n)."""
    powers = np.vander(np.arange(n) - float(middle), n, increasing=True)
    inverse = np.linalg.inv(powers)
    return np.stack([inverse[1], 2.0 * inverse[2]])
