"""Ways to a motion that do not march its equations: equilibria where loads are slow."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np

from ancfsparse.plans.quantities import EnergyOf, Quantity, Velocity
from ancfsparse.plans.slow import late, lowest
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene
from ancfsparse.solve.quasi_static import quasi_static
from ancfsparse.system import System

# Times at which loads and drives are looked at.
LOOKS = 65
# Steps for each period of the lowest frequency in the run that verifies equilibria.
RESOLVED = 48


class Way(ABC):
    """How a motion is found without steps of an integrator: exact in time at the saved states."""

    @abstractmethod
    def march(self, scene: Scene, t_end: float, steps: int, **options: Any) -> Trajectory:
        """Return the motion with so many intervals between saved states."""

    @abstractmethod
    def neglected(self, run: Trajectory, quantity: Quantity) -> dict[str, float]:
        """Estimate what it leaves out of a quantity, by effect [unit of the quantity]."""

    @abstractmethod
    def suits(self, scene: Scene, t_end: float, quantities: list[Quantity]) -> bool:
        """Whether it may do for a scene, by what can be seen without a run."""

    @abstractmethod
    def steps_to_verify(self, run: Trajectory, steps: int) -> int:
        """Return how many steps of an integrator verify it, for each interval between states."""

    @property
    @abstractmethod
    def reason(self) -> str:
        """Why it was taken, a sentence for plans."""

    @abstractmethod
    def refused(self, excess: float) -> str:
        """Why it was not taken: its error is so many times the one asked for."""


@dataclass(frozen=True)
class Statics(Way):
    """A sequence of equilibria, see `quasi_static`."""

    def march(self, scene: Scene, t_end: float, steps: int, **options: Any) -> Trajectory:
        """Follow the equilibrium."""
        return quasi_static(scene, t_end, t_end / steps, **options)

    def neglected(self, run: Trajectory, quantity: Quantity) -> dict[str, float]:
        """Estimate what inertia and damping would change."""
        return {"inertia": late(run, quantity)}

    def suits(self, scene: Scene, t_end: float, quantities: list[Quantity]) -> bool:
        """Whether all begins at rest, loads or drives change, and no velocity is asked for."""
        if any(isinstance(each, Velocity) or _moving_energy(each) for each in quantities):
            return False
        system = System(scene)
        return not system.v0.any() and _changes(system, t_end)

    def steps_to_verify(self, run: Trajectory, steps: int) -> int:
        """Return how many steps of an integrator verify it, for each interval between states."""
        turns = lowest(run) * float(run.t[-1] - run.t[0]) / (2.0 * np.pi)
        return max(1, math.ceil(RESOLVED * turns / steps))

    @property
    def reason(self) -> str:
        """Why it was taken."""
        return "loads and drives are slow against the lowest frequency, so equilibria are followed"

    def refused(self, excess: float) -> str:
        """Why it was not taken."""
        return f"equilibria would miss the error by {excess:.2g} times, mostly by inertia"

    def __repr__(self) -> str:
        """Name it."""
        return "statics at all times"


def _moving_energy(quantity: Quantity) -> bool:
    return isinstance(quantity, EnergyOf) and quantity.part in ("kinetic", "total")


def _changes(system: System, t_end: float) -> bool:
    """Whether loads or drives change over time."""
    times = np.linspace(0.0, t_end, LOOKS)
    if np.ptp(np.asarray(system.loads.amplitudes(times)), axis=0).any():
        return True
    if not system.prescribed:
        return False
    table, _ = system.prescribed.tabulate(times)
    return bool(np.ptp(table, axis=0).any())
