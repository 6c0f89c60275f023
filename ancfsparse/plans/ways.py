"""Ways to a motion that do not march its equations: equilibria, and sums of modes."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ancfsparse.plans import small
from ancfsparse.plans.costs import BESIDE
from ancfsparse.plans.quantities import EnergyOf, Position, Quantity, Reaction, Velocity
from ancfsparse.plans.slow import haste, hurried, late, lowest
from ancfsparse.plans.wanted import Wanted
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.results.modes import Modes
from ancfsparse.scene import Scene
from ancfsparse.solve.balance import Balance
from ancfsparse.solve.modal_response import modal_response
from ancfsparse.solve.modes import modes
from ancfsparse.solve.quasi_static import quasi_static
from ancfsparse.solve.statics import solve_static
from ancfsparse.system import System

Array = NDArray[np.float64]

# Times at which loads and drives are looked at.
LOOKS = 65
# Equilibria are not tried where inertia makes up the error, or the whole motion; nor where a bound
# of the lowest frequency shows that it does so many times.
FAR_OFF, SURELY, FEW = 1.0, 3.0, 5
# Steps for each period of the lowest frequency in the run that verifies equilibria.
RESOLVED = 48
# What calls take beside the work on coordinates, in that of a residual of one coordinate: of a
# factor in statics, of a state of a sum of modes, and of finding a mode, as measured.
FACTOR_CALLS, STATE_CALLS, MODE_CALLS = 4e4, 1.2e3, 2e5
# Work of a mode in a state, for each coordinate: three sums beside some hundred operations.
SUM = 0.06
# Displacements up to this share of the scene may be small.
SMALL = 0.2
# Share of the error that modes may leave out; and how many there are at first.
LEFT_OUT, FIRST_MODES = 0.05, 8
# Intervals between the saved states of the first pilot, and for each period of a vibration.
FEWEST, SEEN = 16, 8.0
# Work for each mode that is found, and of an implicit step, for each coordinate.
SOLVES, STEP = 50.0, 5.0
# Implicit steps of order 2 may be so many times as many as the slowest vibration needs.
PESSIMISTIC = 4.0


class Way(ABC):
    """How a motion is found without steps of an integrator.

    Attributes
    ----------
    order : int
        Power of the time between saved states by which what is between them becomes known: 2 by
        straight lines, 4 by cubics.
    fewest : int
        Intervals between the saved states of the first pilot.
    options : frozenset of str
        Arguments of `simulate` that it takes too.
    """

    order: ClassVar[int]
    options: ClassVar[frozenset[str]] = frozenset()
    fewest: int

    @classmethod
    @abstractmethod
    def fit(
        cls, system: System, t_end: float, wanted: Sequence[Wanted], start: str | None = None
    ) -> Way | None:
        """Return it if it may do for a scene, by what can be seen without a run; else None."""

    @abstractmethod
    def march(self, scene: Scene, t_end: float, steps: int, **options: Any) -> Trajectory:
        """Return the motion with so many intervals between saved states."""

    @abstractmethod
    def calls(self, stats: RunStats, coordinates: int) -> float:
        """Return what a run took beside its residuals, solves and factors, see `costs`."""

    @abstractmethod
    def neglected(self, run: Trajectory, quantity: Quantity) -> dict[str, float]:
        """Estimate what it leaves out of a quantity, by effect [unit of the quantity]."""

    @abstractmethod
    def steps_to_verify(self, run: Trajectory, share: float) -> float:
        """Return how many steps of an integrator are exact to a share of the motion."""

    @property
    @abstractmethod
    def reason(self) -> str:
        """Why it was taken, a sentence for plans."""


@dataclass(frozen=True)
class Statics(Way):
    """A sequence of equilibria, see `quasi_static`.

    Parameters
    ----------
    fewest : int
        Intervals between the saved states of the first pilot.
    start : str or None
        ``"equilibrium"`` if the motion that they stand for begins at the first one.
    """

    fewest: int = field(default=FEWEST, compare=False)
    start: str | None = None
    order: ClassVar[int] = 2
    options: ClassVar[frozenset[str]] = frozenset({"progress", "tolerance", "seed"})

    @classmethod
    def fit(
        cls, system: System, t_end: float, wanted: Sequence[Wanted], start: str | None = None
    ) -> Way | None:
        """Return it where all begins at rest, loads or drives change, and no speed is asked for."""
        if any(_of_speed(each.quantity) for each in wanted):
            return None
        if system.v0.any():
            return None
        changes = _changing(system, t_end)
        most = min(1.0, FAR_OFF * max(each.error if each.relative else 1.0 for each in wanted))
        if not changes or _is_fast(system, t_end, haste(changes, t_end), SURELY * most):
            return None
        return None if hurried(system.scene, t_end, changes, most) else cls(start=start)

    def march(self, scene: Scene, t_end: float, steps: int, **options: Any) -> Trajectory:
        """Follow the equilibrium."""
        first = None if self.start is None else solve_static(scene)
        return quasi_static(scene, t_end, t_end / steps, start=first, **options)

    def calls(self, stats: RunStats, coordinates: int) -> float:
        """Return the work of calls."""
        return FACTOR_CALLS * stats.factorizations

    def neglected(self, run: Trajectory, quantity: Quantity) -> dict[str, float]:
        """Estimate what inertia and damping would change."""
        # Where an equilibrium ceases to exist, the motion to another is fast.
        return {"inertia": np.inf if run.stats.recoveries else late(run, quantity)}

    def steps_to_verify(self, run: Trajectory, share: float) -> float:
        """Return how many steps resolve the slowest vibration."""
        return RESOLVED * lowest(run) * float(run.t[-1] - run.t[0]) / (2.0 * np.pi)

    @property
    def reason(self) -> str:
        """Why it was taken."""
        return "loads and drives are slow against the lowest frequency, so equilibria are followed"

    def __repr__(self) -> str:
        """Name it."""
        return "statics at all times"


def _of_speed(quantity: Quantity) -> bool:
    moving = isinstance(quantity, EnergyOf) and quantity.part in ("kinetic", "total")
    return moving or isinstance(quantity, Velocity)


def _is_fast(system: System, t_end: float, rate: float, most: float) -> bool:
    """Whether loads change fast beside the frequency of what they displace about the start.

    By Rayleigh's quotient the lowest frequency is no higher, unless far displacements stiffen it.
    """
    balance = small.stiff(system)
    if balance is None:
        return False
    x = small.farthest(system, small.pulled(system, balance, np.linspace(0.0, t_end, FEW)))
    places = system.q0[system.positions].reshape(-1, system.dim)
    if not 0.0 < small.size(system, x) <= SMALL * float(np.ptp(places, axis=0).max()):
        return False
    return rate > most * small.frequency_of(system, balance, x) ** 2


def _changing(system: System, t_end: float) -> list[Array]:
    """Return tables over time of loads and drives that change, each (LOOKS, m)."""
    times = np.linspace(0.0, t_end, LOOKS)
    tables = [np.asarray(system.loads.amplitudes(times))]
    if system.prescribed:
        tables.append(np.asarray(system.prescribed.tabulate(times)[0]))
    return [table for table in tables if np.ptp(table, axis=0).any()]


@dataclass(frozen=True)
class ModalSum(Way):
    """A sum of the lowest modes about the start, see `modal_response`.

    Parameters
    ----------
    n : int
        Number of modes; of half of the coordinates if these are fewer.
    fewest : int
        Intervals between the saved states of the first pilot.
    """

    n: int
    fewest: int = field(default=FEWEST, compare=False)
    order: ClassVar[int] = 4

    @classmethod
    def fit(
        cls, system: System, t_end: float, wanted: Sequence[Wanted], start: str | None = None
    ) -> Way | None:
        """Return it where loads and velocities move a scene without drives by little."""
        if start is not None or system.prescribed or not system.conservative:
            return None
        if any(isinstance(each.quantity, Reaction) for each in wanted):
            return None
        balance = small.stiff(system)
        if balance is None:
            return None
        places = system.q0[system.positions].reshape(-1, system.dim)
        most = SMALL * float(np.ptp(places, axis=0).max())
        moved = small.pulled(system, balance, np.linspace(0.0, t_end, LOOKS))
        whole = small.farthest(system, moved)
        if small.size(system, whole) > most:
            return None
        if not system.v0.any() and not cls._pays(system, balance, t_end, 2.0 * whole, wanted):
            return None
        n = FIRST_MODES
        while True:
            own = _modes(system.scene, n)
            if (own.eigenvalues <= 0.0).any():
                return None
            swing = small.swing(own, system, whole)
            far = small.size(system, swing)
            if far > most or not cls._pays(system, balance, t_end, swing, wanted):
                return None
            share = min(_share(each, far) for each in wanted)
            if small.missing(own, system, moved) <= LEFT_OUT * share * far or len(own) < n:
                return cls(len(own), _fewest(small.frequency_of(system, balance, swing) * t_end))
            n *= 2

    @classmethod
    def _pays(
        cls, system: System, balance: Balance, t_end: float, x: Array, wanted: Sequence[Wanted]
    ) -> bool:
        """Whether forces are nearly linear up to a displacement, and steps would be many."""
        far = small.size(system, x)
        if far == 0.0:
            return False
        share = min(_share(each, far) for each in wanted)
        turns = small.frequency_of(system, balance, x) * t_end
        if small.bent_off(balance, system, x, 0.5 * turns) > share * far:
            return False
        steps = PESSIMISTIC * turns * math.sqrt(turns / (12.0 * share))
        marched = steps * STEP * (system.n_free + BESIDE)
        return _modal_work(FIRST_MODES, _fewest(turns), system.n_free) < marched

    def march(self, scene: Scene, t_end: float, steps: int, **options: Any) -> Trajectory:
        """Sum the modes."""
        return modal_response(_modes(scene, self.n), t_end, t_end / steps, **options)

    def calls(self, stats: RunStats, coordinates: int) -> float:
        """Return the work of calls, and of finding and summing modes."""
        return _modal_work(self.n, stats.steps, coordinates)

    def neglected(self, run: Trajectory, quantity: Quantity) -> dict[str, float]:
        """Estimate what is lost by linearity, and with other modes."""
        return small.neglected(_modes(run.system.scene, self.n), run, quantity)

    def steps_to_verify(self, run: Trajectory, share: float) -> float:
        """Return how many steps have phases exact to a tenth of the share."""
        turns = small.frequency(run) * float(run.t[-1] - run.t[0])
        return max(RESOLVED, turns * math.sqrt(max(turns, 1.0) / (1.2 * share)))

    @property
    def reason(self) -> str:
        """Why it was taken."""
        return "the motion is small, so its modes about the start are summed"

    def __repr__(self) -> str:
        """Name it."""
        return f"{self.n} modes"


def _modal_work(n: int, states: int, coordinates: int) -> float:
    """Return the work of finding n modes and summing them, beside residuals."""
    finding = MODE_CALLS + n * (MODE_CALLS + SOLVES * coordinates)
    return finding + states * (STATE_CALLS + SUM * n * coordinates)


def _fewest(turns: float) -> int:
    """Return the intervals between saved states that show vibrations of so many radians."""
    seen = max(1.0, SEEN * turns / (2.0 * np.pi * FEWEST))
    return FEWEST << math.ceil(math.log2(seen))


def _modes(scene: Scene, n: int) -> Modes:
    """Return the lowest modes about the start, as many as the mesh has well."""
    system = System(scene)
    most = (system.n_free - system.n_multipliers) // 2
    at = system.state(system.t0, system.q0, system.v0)
    return modes(scene, max(1, min(n, most)), at=at)


def _share(wanted: Wanted, far: float) -> float:
    """Return the error that is asked for as a share of the motion, if that is known."""
    if wanted.relative:
        return wanted.error
    return wanted.error / far if isinstance(wanted.quantity, Position) and far > 0.0 else 1e-3
