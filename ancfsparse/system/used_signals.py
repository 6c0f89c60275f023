"""The signals that loads, eigenstrains and prescribed motions of a system follow."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.scene import Beam, Signal
from ancfsparse.scene.records.signal import Sum
from ancfsparse.system.loads.amplitudes import FunctionAmplitude
from ancfsparse.system.system import System


@dataclass(frozen=True)
class UsedSignal:
    """A signal of a load or of a prescribed motion.

    Attributes
    ----------
    what : str
        Name of the load or the prescribed motion in messages.
    signal : Signal
        The signal, or a sum of signals that are constant outside some times.
    is_motion : bool
        Whether it is a prescribed motion, whose rate moves the scene.
    """

    what: str
    signal: Signal
    is_motion: bool

    @property
    def impulse_of_one_change(self) -> float:
        """The largest value times the shortest time scale, or the largest change of a motion."""
        scale = self.signal.time_scale
        values = self.signal(np.array(scale.times))
        if self.is_motion:
            return float(np.max(np.ptp(values, axis=0)))
        return float(np.max(np.abs(values))) * scale.shortest

    def values(self, times: Vector) -> Vector:
        """Return the load, or the rate of the motion, at times (k,) as a table (k, n)."""
        values = self.signal.rate(times) if self.is_motion else self.signal(times)
        return values.reshape(len(times), math.prod(values.shape[1:]))


def signals_of(system: System) -> list[UsedSignal]:
    """Return the signals of a system: those that sums consist of, and sums of pulses or ramps."""
    followed: list[tuple[str, object, bool]] = [
        (source.load.what, source.load.value, False)
        for source in system.loads.sources
        if isinstance(source, FunctionAmplitude)
    ]
    followed += [(each.what, each.function_of_time, False) for each in system.attachments]
    for beam in system.scene.beams:
        if isinstance(beam, Beam):
            followed += [(f"eigenstrain of {beam.name}", x, False) for x in beam.changing or ()]
    for motion in system.prescribed.courses:
        value = motion.source.value
        followed.append((value.what, value.value, True))
    return [
        UsedSignal(what, part, is_motion)
        for what, signal, is_motion in followed
        if isinstance(signal, Signal)
        for part in _parts(signal)
    ]


def _parts(signal: Signal) -> list[Signal]:
    """Return the signals of a sum, and the sum of those that are constant outside some times.

    Two ramps may make a pulse.
    """
    parts = list(signal.summands)
    timed = tuple(part for part in parts if part.time_scale.times)
    return [*parts, Sum(timed)] if len(timed) > 1 else parts
