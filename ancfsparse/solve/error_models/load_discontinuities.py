"""Locate discontinuities of the loads and of their rates, which time steps must not straddle."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.scene.records.prescribed_motion import MIN_SMOOTHNESS
from ancfsparse.scene.records.signals import TIME_ROUNDING
from ancfsparse.solve.error_models.signal_resolution import longest_step
from ancfsparse.system import System
from ancfsparse.system.loads.applied_loads import AppliedLoads
from ancfsparse.system.used_signals import UsedSignal, signals_of

N_INTERVALS = 1024  # intervals of the first sampling
N_NEIGHBOURS = 8  # intervals on each side with which one is compared
MIN_OUTLIER_RATIO = 10.0  # second difference over the median of its neighbours
MAX_DISCONTINUITIES = 64  # beyond it a load is irregular everywhere, as noise is
N_REFINED = 17  # points of a refined sampling; each is narrower than the last by a quarter of these


class LoadDiscontinuities:
    """Times at which the loads of a scene jump, or their rates do, and short signals begin or end.

    Signals state these times; functions of the user are sampled.

    Parameters
    ----------
    system : System
        The scene with its loads and prescribed motions.
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
    longest_step : float
        Longest step that aliases no signal [s].
    """

    def __init__(self, system: System, t_start: float, t_end: float) -> None:
        loads = system.loads
        self.times = np.linspace(t_start, t_end, N_INTERVALS + 1)
        self.amplitudes = np.zeros((N_INTERVALS + 1, 0))
        self.longest_step = t_end - t_start
        corners: list[float] = []
        self._ends: set[float] = set()
        for used in signals_of(system):
            times, longest = _limits(used, t_start, t_end)
            corners += times
            if len(used.signal.time_scale.times) <= MAX_DISCONTINUITIES:
                self._ends.update(used.signal.time_scale.times)
            self.longest_step = min(self.longest_step, longest)
        pairs: list[tuple[float, float]] = [
            (time - 2.0 * TIME_ROUNDING * abs(time), float(np.nextafter(time, np.inf)))
            for time in corners
        ]
        if loads.n_amplitudes:
            self.amplitudes = loads.amplitudes(self.times)
            sampled = _find(loads, self.times, self.amplitudes)
            pairs += [pair for pair in sampled if not _is_among(pair, corners, t_end - t_start)]
        pairs = _merge(pairs, 4.0 * EPSILON * max(abs(t_start), abs(t_end)))
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

    @property
    def analytic_spans(self) -> list[tuple[float, float]]:
        """The same intervals, divided where smooth signals have no higher derivatives.

        There the error of a step of high order is not what differences of two motions show.
        """
        tolerance, out = 1e-9 * (self.times[-1] - self.times[0]), []
        for begin, end in self.spans:
            inside = sorted(
                time for time in self._ends if begin + tolerance < time < end - tolerance
            )
            out += list(pairwise([begin, *inside, end]))
        return out


def _limits(used: UsedSignal, t_start: float, t_end: float) -> tuple[list[float], float]:
    """Return the times at which steps must end for a signal, and the longest step [s].

    Steps end at the times of a smooth signal only if the sampling cannot see it.
    """
    scale = used.signal.time_scale
    times = [time for time in scale.times if t_start < time < t_end]
    if scale.times and not times:  # constant, or in one smooth change
        return [], np.inf
    if not times or len(times) > MAX_DISCONTINUITIES:
        return [], longest_step(used, t_start, t_end)
    is_long = scale.shortest > N_NEIGHBOURS * (t_end - t_start) / N_INTERVALS
    if used.signal.smoothness >= MIN_SMOOTHNESS and is_long:
        return [], scale.shortest
    return times, np.inf


def _is_among(pair: tuple[float, float], corners: list[float], length: float) -> bool:
    """Return whether a sampled discontinuity is one of the given times."""
    return any(pair[0] - 1e-9 * length <= time <= pair[1] + 1e-9 * length for time in corners)


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
    # It decreases with the width to the power 0 at a jump, 1 at a kink, 2 otherwise.
    if round(power) >= 2:
        return None
    if round(power) == 1:
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
