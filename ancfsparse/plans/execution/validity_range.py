"""The range that pilots have met, beyond which a prediction is not known to hold."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ancfsparse.results import Trajectory
from ancfsparse.scene import ElasticBody
from ancfsparse.system import System

Array = NDArray[np.float64]

# What a run meets may be so many times what pilots met.
BEYOND = 1.5
# A push of a stop, a rope or a function so many times as large as in the pilots is one that begins:
# peaks of short ones that the pilots have met depend on which states are saved.
BEGINS = 10.0
# Below these, strains and turns [-, rad] are rounding.
NOTHING = 1e-9
# Saved states, and times of loads, that are looked at.
MOST_STATES, MOST_TIMES = 200, 20000
# The same for pushes, which may be short.
MOST_TOUCHED = 2000


@dataclass(frozen=True)
class Span:
    """Extremes of a motion.

    Attributes
    ----------
    strain : float
        Largest strain of an axis [-].
    turn : float
        Largest turn of a slope in a step [rad].
    loads : tuple of float
        Largest amplitude of every load over the steps.
    touches : tuple of (str, float)
        The largest push of what begins to push on the way, such as stops and ropes, by its name.
    """

    strain: float
    turn: float
    loads: tuple[float, ...]
    touches: tuple[tuple[str, float], ...] = ()

    def left_by(self, other: Span) -> str:
        """Explain by what another motion leaves the range of this one; empty if it does not."""
        for what, mine, its in (
            ("strains come to", self.strain, other.strain),
            ("turns in a step come to", self.turn, other.turn),
        ):
            if its > BEYOND * mine + NOTHING:
                return f"{what} {its:.3g}, and to {mine:.3g} in the pilots"
        if len(self.loads) == len(other.loads):
            for mine, its in zip(self.loads, other.loads, strict=True):
                if its > BEYOND * mine:
                    return (
                        f"a load comes to {its:.3g} times its unit, and to {mine:.3g} in the pilots"
                    )
        if len(self.touches) == len(other.touches):
            for (_, mine), (what, its) in zip(self.touches, other.touches, strict=True):
                if its > BEGINS * mine:
                    return f"{what} comes to {its:.3g}, and to {mine:.3g} in the pilots"
        return ""


def span_of(run: Trajectory, steps: int) -> Span:
    """Return the extremes of a motion that was marched in so many steps."""
    system = run.system
    assert isinstance(system, System)
    some = np.unique(np.linspace(0, len(run.t) - 1, MOST_STATES).astype(int))
    strain = 0.0
    few = _few(run, some)
    for body in system.scene.beams:
        if isinstance(body, ElasticBody):
            strain = max(strain, float(np.abs(few.strain(body)).max()))
    dt = float(run.t[-1] - run.t[0]) / steps
    slopes = np.setdiff1d(np.arange(system.n_all), system.positions)
    v = np.asarray(run.v)[some][:, slopes]
    turn = dt * float(np.abs(v).max(initial=0.0))
    times = np.linspace(run.t[0], run.t[-1], min(steps, MOST_TIMES) + 1)
    loads = np.abs(np.asarray(system.loads.amplitudes(times))).max(axis=0, initial=0.0)
    return Span(strain, turn, tuple(loads.tolist()), _touches(run))


def _touches(run: Trajectory) -> tuple[tuple[str, float], ...]:
    """Return the largest pushes of what begins to push on the way, by name."""
    system = run.system
    assert isinstance(system, System)
    some = np.unique(np.linspace(0, len(run.t) - 1, MOST_TOUCHED).astype(int))
    q, v = (np.asarray(each)[some] for each in (run.q, run.v))
    amplitudes = system.loads.amplitudes(np.asarray(run.t)[some])
    return tuple(
        (name, float(np.abs(values).max()))
        for each in system.contributions
        for name, values in each.touches(q, v, amplitudes)
    )


def _few(run: Trajectory, rows: Array) -> Trajectory:
    """Return a motion with some of its states."""
    t, q, v, a, lam = (np.asarray(x)[rows] for x in (run.t, run.q, run.v, run.a, run.lam))
    return replace(run, t=t, q=q, v=v, a=a, lam=lam)
