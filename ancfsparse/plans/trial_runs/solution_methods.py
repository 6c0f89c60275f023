"""Ways to a motion that do not march its equations: equilibria, and sums of modes."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ancfsparse.plans.model_error import modal_truncation_error
from ancfsparse.plans.model_error.quasi_static_error import haste, hurried, late, lowest
from ancfsparse.plans.quantities.quantity import EnergyOf, Position, Quantity, Reaction, Velocity
from ancfsparse.plans.quantities.tolerances import Wanted
from ancfsparse.plans.trial_runs.cost_model import BESIDE
from ancfsparse.plans.trial_runs.load_resolution import courses, paced
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.results.solutions.modes import Modes
from ancfsparse.scene import Scene
from ancfsparse.solve.equilibrium_paths.quasi_static import quasi_static
from ancfsparse.solve.motion.arguments import at_equilibrium
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations
from ancfsparse.solve.statics.static_equilibrium import solve_static
from ancfsparse.solve.vibration.modal_response import modal_response
from ancfsparse.solve.vibration.modes import modes
from ancfsparse.system import State, System

Array = NDArray[np.float64]

# Times at which loads and drives are looked at, at least, and where each takes a solution at most.
LOOKS, MOST_LOOKS = 65, 513
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
# Share of the error that modes may leave out; how many there are at first, and at most about.
LEFT_OUT, FIRST_MODES, MOST_MODES = 0.05, 8, 128
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

    def richer(self) -> Way | None:
        """Return a way that leaves less out; None if there is none."""
        return None

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
    options: ClassVar[frozenset[str]] = frozenset({"progress", "tolerance", "factorization"})

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
        if hurried(system.scene, t_end, changes, most):
            return None
        return cls(paced(system, t_end, FEWEST), start=start)

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
    about = system.state(system.t0, system.q0, system.v0)
    equations = modal_truncation_error.stiff(system, about)
    if equations is None:
        return False
    x = modal_truncation_error.farthest(
        system,
        modal_truncation_error.pulled(system, about, equations, np.linspace(0.0, t_end, FEW)),
    )
    places = system.q0[system.positions].reshape(-1, system.dim)
    if (
        not 0.0
        < modal_truncation_error.size(system, x)
        <= SMALL * float(np.ptp(places, axis=0).max())
    ):
        return False
    return rate > most * modal_truncation_error.frequency_of(system, about, equations, x) ** 2


def _changing(system: System, t_end: float) -> list[Array]:
    """Return tables over time of loads and drives that change, each (k, m)."""
    times = np.linspace(0.0, t_end, paced(system, t_end, LOOKS - 1) + 1)
    return [table for table in courses(system, times) if np.ptp(table, axis=0).any()]


@dataclass(frozen=True)
class ModalSum(Way):
    """A sum of the lowest modes about the start, stress-free or at rest; see `modal_response`.

    Parameters
    ----------
    n : int
        Number of modes; of half of the coordinates if these are fewer.
    fewest : int
        Intervals between the saved states of the first pilot.
    start : str or None
        ``"equilibrium"`` if the motion begins there.
    """

    n: int
    fewest: int = field(default=FEWEST, compare=False)
    start: str | None = None
    order: ClassVar[int] = 4

    @classmethod
    def fit(
        cls, system: System, t_end: float, wanted: Sequence[Wanted], start: str | None = None
    ) -> Way | None:
        """Return it where loads and velocities move a scene without drives by little."""
        if system.prescribed or not system.conservative:
            return None
        if any(isinstance(each.quantity, Reaction) for each in wanted):
            return None
        about = _state(system.scene, start)
        equations = modal_truncation_error.stiff(system, about)
        if equations is None:
            return None
        places = about.q[system.positions].reshape(-1, system.dim)
        most = SMALL * float(np.ptp(places, axis=0).max())
        seen = paced(system, t_end, FEWEST)
        times = np.linspace(0.0, t_end, min(max(LOOKS, seen + 1), MOST_LOOKS))
        moved = modal_truncation_error.pulled(system, about, equations, times)
        whole = modal_truncation_error.farthest(system, moved)
        if modal_truncation_error.size(system, whole) > most:
            return None
        args = system, about, equations, t_end
        if not about.v.any() and not cls._pays(*args, 2.0 * whole, wanted):
            return None
        n = FIRST_MODES
        while True:
            own = _modes(system.scene, n, about)
            if (own.eigenvalues <= 0.0).any():
                return None
            swing = modal_truncation_error.swing(own, system, whole)
            far = modal_truncation_error.size(system, swing)
            if far > most or not cls._pays(*args, swing, wanted):
                return None
            share = min(_share(each, far) for each in wanted)
            if (
                modal_truncation_error.missing(own, system, moved) <= LEFT_OUT * share * far
                or len(own) < n
            ):
                turns = modal_truncation_error.frequency_of(system, about, equations, swing) * t_end
                # A coarse mesh that has no more does not show what those of finer ones leave out.
                most = 2 * n if len(own) < n else n
                return cls(most, max(seen, _fewest(turns)), start)
            n *= 2

    @classmethod
    def _pays(
        cls,
        system: System,
        about: State,
        equations: EquilibriumEquations,
        t_end: float,
        x: Array,
        wanted: Sequence[Wanted],
    ) -> bool:
        """Whether forces are nearly linear up to a displacement, and steps would be many."""
        far = modal_truncation_error.size(system, x)
        if far == 0.0:
            return False
        share = min(_share(each, far) for each in wanted)
        turns = modal_truncation_error.frequency_of(system, about, equations, x) * t_end
        if modal_truncation_error.bent_off(equations, system, about, x, 0.5 * turns) > share * far:
            return False
        steps = PESSIMISTIC * turns * math.sqrt(turns / (12.0 * share))
        marched = steps * STEP * (system.n_free + BESIDE)
        return _modal_work(FIRST_MODES, _fewest(turns), system.n_free) < marched

    def richer(self) -> Way | None:
        """Return a sum of four times as many modes: points that are pushed need many."""
        return replace(self, n=4 * self.n) if self.n < MOST_MODES else None

    def march(self, scene: Scene, t_end: float, steps: int, **options: Any) -> Trajectory:
        """Sum the modes."""
        own = _modes(scene, self.n, _state(scene, self.start))
        return modal_response(own, t_end, t_end / steps, **options)

    def calls(self, stats: RunStats, coordinates: int) -> float:
        """Return the work of calls, and of finding and summing modes."""
        return _modal_work(self.n, stats.steps, coordinates)

    def neglected(self, run: Trajectory, quantity: Quantity) -> dict[str, float]:
        """Estimate what is lost by linearity, and with other modes."""
        scene = run.system.scene
        own = _modes(scene, self.n, _state(scene, self.start))
        return modal_truncation_error.neglected(own, run, quantity)

    def steps_to_verify(self, run: Trajectory, share: float) -> float:
        """Return how many steps have phases exact to a tenth of the share."""
        turns = modal_truncation_error.frequency(run) * float(run.t[-1] - run.t[0])
        return max(RESOLVED, turns * math.sqrt(max(turns, 1.0) / (1.2 * share)))

    @property
    def reason(self) -> str:
        """Why it was taken."""
        where = "start" if self.start is None else "equilibrium that it starts at"
        return f"the motion is small, so its modes about the {where} are summed"

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


def _state(scene: Scene, start: str | None) -> State:
    """Return the state in which a motion starts."""
    if start is not None:
        return at_equilibrium(scene, start).state
    system = System(scene)
    return system.state(system.t0, system.q0, system.v0)


def _modes(scene: Scene, n: int, at: State) -> Modes:
    """Return the lowest modes about a state, as many as the mesh has well."""
    system = System(scene)
    most = (system.n_free - system.n_multipliers) // 2
    return modes(scene, max(1, min(n, most)), at=at)


def _share(wanted: Wanted, far: float) -> float:
    """Return the error that is asked for as a share of the motion, if that is known."""
    if wanted.relative:
        return wanted.error
    return wanted.error / far if isinstance(wanted.quantity, Position) and far > 0.0 else 1e-3
