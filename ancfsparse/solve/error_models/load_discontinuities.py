"""Locate discontinuities of the loads and of their rates, which time steps must not straddle."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.system.loads.applied_loads import AppliedLoads

N_INTERVALS = 1024  # intervals of the first sampling
N_NEIGHBOURS = 8  # intervals on each side with which one is compared
MIN_OUTLIER_RATIO = 10.0  # second difference over the median of its neighbours
MAX_DISCONTINUITIES = 64  # beyond it a load is irregular everywhere, as noise is
N_REFINED = 17  # points of a refined sampling; each is narrower than the last by a quarter of these
# A second difference decreases with the width to the power 0 at a jump, 1 at a kink, 2 otherwise.
MAX_JUMP_POWER = 0.5  # largest power of a jump
MAX_KINK_POWER = 1.5  # largest power of a kink


class LoadDiscontinuities:
    """Times at which the loads of a scene jump, or their rates do.

    Parameters
    ----------
    loads : Loads
        Loads of the scene.
    t_start, t_end : float
        Begin and end of the sampled time [s].

    Attributes
    ----------
    before, after : (k,) float
        The last time before each discontinuity, and the first after it [s], without the ends.
    times : (n,) float
        Times of the first sampling, equally spaced from `t_start` to `t_end` [s].
    amplitudes : (n, n_amplitudes) float
        Amplitudes of the loads at these times.
    """

    def __init__(self, loads: AppliedLoads, t_start: float, t_end: float) -> None:
        self.times = np.linspace(t_start, t_end, N_INTERVALS + 1)
        self.amplitudes = np.zeros((N_INTERVALS + 1, 0))
        pairs: list[tuple[float, float]] = []
        if loads.n_amplitudes:
            self.amplitudes = loads.amplitudes(self.times)
            pairs = _merge(
                _find(loads, self.times, self.amplitudes),
                4.0 * EPSILON * max(abs(t_start), abs(t_end)),
            )
        # A discontinuity at an end has no step before or after it.
        tolerance = 1e-9 * (t_end - t_start)
        inside = [
            pair for pair in pairs if t_start + tolerance < pair[0] and pair[1] < t_end - tolerance
        ]
        self.before, self.after = np.array(inside).reshape(-1, 2).T

    @property
    def spans(self) -> list[tuple[float, float]]:
        """Begin and end of the intervals in which all loads are smooth [s]."""
        begins, ends = np.append(self.times[0], self.after), np.append(self.before, self.times[-1])
        return [(float(a), float(b)) for a, b in zip(begins, ends, strict=True)]


def _find(loads: AppliedLoads, times: Vector, values: Vector) -> list[tuple[float, float]]:
    """Return the last time before and the first time after each discontinuity."""
    bends = np.abs(values[2:] - 2.0 * values[1:-1] + values[:-2])
    size = np.max(np.abs(values), axis=0)
    rounding = 16.0 * EPSILON * size
    padded = np.pad(bends, ((N_NEIGHBOURS, N_NEIGHBOURS), (0, 0)), mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * N_NEIGHBOURS + 1, axis=0)
    suspect = bends > MIN_OUTLIER_RATIO * np.median(windows, axis=2) + rounding
    if np.max(np.count_nonzero(suspect, axis=0)) > 2 * MAX_DISCONTINUITIES:
        return []
    pairs = []
    for column in np.flatnonzero(suspect.any(axis=0)):
        last = -1
        for i in np.flatnonzero(suspect[:, column]).tolist():
            # A jump is in two second differences that overlap.
            if i > last:
                pair = _locate(loads, int(column), times[i], times[i + 2], rounding[column])
                if pair is not None:
                    pairs.append(pair)
                    last = i + 1
    return pairs


def _locate(
    loads: AppliedLoads, column: int, low: float, high: float, rounding: float
) -> tuple[float, float] | None:
    """Refine the interval of a discontinuity; return None if there is none."""
    first, first_width, power = 0.0, high - low, 2.0
    while True:
        times = np.linspace(low, high, N_REFINED)
        values = loads.amplitudes(times)[:, column]
        bends = np.abs(values[2:] - 2.0 * values[1:-1] + values[:-2])
        largest = int(np.argmax(bends))
        if not first:
            first = bends[largest]
        elif bends[largest] > rounding:
            power = np.log(first / bends[largest]) / np.log(first_width / (high - low))
        narrow = high - low < 32.0 * EPSILON * max(abs(high), first_width)
        if bends[largest] <= rounding or narrow:
            break
        low, high = times[max(largest - 1, 0)], times[min(largest + 3, N_REFINED - 1)]
    if power > MAX_KINK_POWER:
        return None
    if power > MAX_JUMP_POWER:
        return (0.5 * (low + high),) * 2
    steps = np.abs(np.diff(values))
    jump = int(np.argmax(steps))
    return float(times[jump]), float(times[jump + 1])


def _merge(pairs: list[tuple[float, float]], tolerance: float) -> list[tuple[float, float]]:
    """Merge discontinuities of several loads at one time."""
    out: list[tuple[float, float]] = []
    for low, high in sorted(pairs):
        if out and low <= out[-1][1] + tolerance:
            out[-1] = (out[-1][0], max(high, out[-1][1]))
        else:
            out.append((low, high))
    return out
