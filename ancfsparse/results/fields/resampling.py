"""States at any times, interpolated between saved ones."""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_reals
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.results.data.interpolation import interpolate_cubic
from ancfsparse.results.data.selected_columns import Readable, SelectedColumns
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system_memory import check_memory

TIME_ROUNDING = 1e-9  # of a time beyond the first or last one, over the larger of both


def resample(states: StateHistory, times: ArrayLike, *, mean_accelerations: bool) -> StateHistory:
    """Interpolate states; see `Trajectory.resample`.

    Parameters
    ----------
    states : StateHistory
        Saved states; their tables can be in a file.
    times : array_like, shape (j,)
        Increasing times between the first and the last saved one [s].
    mean_accelerations : bool
        True if accelerations are means over the step before: velocities are then linear in time.

    Returns
    -------
    StateHistory
        States at these times.
    """
    when = _check_times(times, states.t)
    check_memory("resampled states", 3 * 8.0 * len(when) * _table(states.q).shape[1], "fewer times")
    k = np.clip(np.searchsorted(states.t, when, side="right") - 1, 0, max(len(states.t) - 2, 0))
    after = np.minimum(k + 1, len(states.t) - 1)
    h = (states.t[after] - states.t[k])[:, None]
    s = np.divide(when[:, None] - states.t[k][:, None], h, out=np.zeros_like(h), where=h > 0.0)
    (q0, q1), (v0, v1), (a0, a1) = (
        (np.asarray(_table(table)[k]), np.asarray(_table(table)[after])) for table in states[:3]
    )

    def linear(start: Vector, end: Vector) -> Vector:
        return (1.0 - s) * start + s * end

    is_static = not (v0.any() or v1.any())  # equilibria, whose velocities are zero
    q = linear(q0, q1) if is_static else interpolate_cubic(s, h, q0, q1, v0, v1)
    v = linear(v0, v1) if mean_accelerations else interpolate_cubic(s, h, v0, v1, a0, a1)
    full = [_like(table, x) for table, x in zip(states[:3], (q, v, linear(a0, a1)), strict=True)]
    lam, internal = (linear(each[k], each[after]) for each in (states.lam, states.internal))
    return StateHistory(full[0], full[1], full[2], lam, when, internal)


def _check_times(times: ArrayLike, t: Vector) -> Vector:
    """Return times as an array, those beyond the ends by rounding moved to them."""
    when = np.atleast_1d(check_reals("times", times, "a list of times in s"))
    if when.ndim != 1 or not len(when):
        raise InputError(f"times must be a list such as [0.0, 0.5], got {format_value(times)}")
    slack = TIME_ROUNDING * max(abs(float(t[0])), abs(float(t[-1])))
    outside = ~((when >= t[0] - slack) & (when <= t[-1] + slack))
    if outside.any():
        raise InputError(
            f"there is no state at t = {when[outside][0]:.6g} s: the run goes from {t[0]:.6g} s to "
            f"{t[-1]:.6g} s"
        )
    if not (np.diff(when) > 0.0).all():
        row = int(np.flatnonzero(~(np.diff(when) > 0.0))[0])
        raise InputError(
            f"times must increase: {when[row + 1]:.6g} s follows {when[row]:.6g} s; sort them"
        )
    return np.clip(when, t[0], t[-1])


def _table(stored: Readable) -> Readable:
    """Return the stored columns of a table."""
    return stored.values if isinstance(stored, SelectedColumns) else stored


def _like(table: Readable, values: Vector) -> Vector:
    """Return values of the stored columns in the form of their table."""
    if isinstance(table, SelectedColumns):  # is read like an array
        return cast(Vector, SelectedColumns(values, table.places, table.n))
    return values
