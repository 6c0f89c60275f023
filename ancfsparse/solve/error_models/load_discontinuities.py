"""Where loads jump or kink: times that a step must not reach across."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.system.loads.applied_loads import Loads

Vector = NDArray[np.float64]

# Intervals of the first look, and points around an interval that it is compared with.
LOOK, AROUND = 1024, 8
# A second difference so many times the median of those around it is worth a closer look.
OUTLIER = 10.0
# More suspects than these, and the load is rough everywhere: a table of many points, or noise.
MOST = 64
# Points of a closer look; each is narrower than the last by a quarter of these.
ZOOM = 17
# A second difference falls with the width to this power: 0 for a jump, 1 for a kink, 2 without.
JUMP, KINK = 0.5, 1.5


class LoadDiscontinuities:
    """Times at which the loads of a scene jump, or their rates do.

    Parameters
    ----------
    loads : Loads
        Of the scene.
    t_start, t_end : float
        Begin and end of the time that is looked at [s].

    Attributes
    ----------
    before, after : (k,) float
        The last time before each, and the first after it [s]; `t_start` and `t_end` are not among
        them.
    times : (n,) float
        Times of the first look, equally spaced from `t_start` to `t_end` [s].
    amplitudes : (n, n_amplitudes) float
        Loads then.
    """

    def __init__(self, loads: Loads, t_start: float, t_end: float) -> None:
        self.times = np.linspace(t_start, t_end, LOOK + 1)
        self.amplitudes = np.zeros((LOOK + 1, 0))
        found: list[tuple[float, float]] = []
        if loads.n_amplitudes:
            self.amplitudes = loads.amplitudes(self.times)
            found = _merged(
                _found(loads, self.times, self.amplitudes),
                4.0 * EPSILON * max(abs(t_start), abs(t_end)),
            )
        # What changes within rounding of an end has no step before or after it.
        near = 1e-9 * (t_end - t_start)
        inside = [pair for pair in found if t_start + near < pair[0] and pair[1] < t_end - near]
        self.before, self.after = np.array(inside).reshape(-1, 2).T

    @property
    def spans(self) -> list[tuple[float, float]]:
        """Begin and end of the times in which all loads are smooth [s]."""
        begins, ends = np.append(self.times[0], self.after), np.append(self.before, self.times[-1])
        return [(float(a), float(b)) for a, b in zip(begins, ends, strict=True)]


def _found(loads: Loads, times: Vector, values: Vector) -> list[tuple[float, float]]:
    """Return the last time before and the first time after each break."""
    bends = np.abs(values[2:] - 2.0 * values[1:-1] + values[:-2])
    size = np.max(np.abs(values), axis=0)
    rounding = 16.0 * EPSILON * size
    padded = np.pad(bends, ((AROUND, AROUND), (0, 0)), mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * AROUND + 1, axis=0)
    suspect = bends > OUTLIER * np.median(windows, axis=2) + rounding
    if np.max(np.count_nonzero(suspect, axis=0)) > 2 * MOST:
        return []
    found = []
    for column in np.flatnonzero(suspect.any(axis=0)):
        last = -1
        for i in np.flatnonzero(suspect[:, column]).tolist():
            # A jump shows in two second differences that overlap.
            if i > last:
                pair = _closer(loads, int(column), times[i], times[i + 2], rounding[column])
                if pair is not None:
                    found.append(pair)
                    last = i + 1
    return found


def _closer(
    loads: Loads, column: int, low: float, high: float, rounding: float
) -> tuple[float, float] | None:
    """Close in on a break; None if there is none."""
    first, first_width, power = 0.0, high - low, 2.0
    while True:
        times = np.linspace(low, high, ZOOM)
        values = loads.amplitudes(times)[:, column]
        bends = np.abs(values[2:] - 2.0 * values[1:-1] + values[:-2])
        most = int(np.argmax(bends))
        if not first:
            first = bends[most]
        elif bends[most] > rounding:
            power = np.log(first / bends[most]) / np.log(first_width / (high - low))
        narrow = high - low < 32.0 * EPSILON * max(abs(high), first_width)
        if bends[most] <= rounding or narrow:
            break
        low, high = times[max(most - 1, 0)], times[min(most + 3, ZOOM - 1)]
    if power > KINK:
        return None
    if power > JUMP:
        return (0.5 * (low + high),) * 2
    steps = np.abs(np.diff(values))
    jump = int(np.argmax(steps))
    return float(times[jump]), float(times[jump + 1])


def _merged(found: list[tuple[float, float]], near: float) -> list[tuple[float, float]]:
    """Join those that are one for several loads."""
    out: list[tuple[float, float]] = []
    for low, high in sorted(found):
        if out and low <= out[-1][1] + near:
            out[-1] = (out[-1][0], max(high, out[-1][1]))
        else:
            out.append((low, high))
    return out
