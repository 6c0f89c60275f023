"""Quantities of a whole scene: energies and natural frequencies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice, check_count
from ancfsparse.plans.quantities.quantity import Quantity
from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam
from ancfsparse.solve.vibration.modes import modes

ENERGIES = ("total", "kinetic", "elastic", "potential")


@dataclass(frozen=True, eq=False, repr=False)
class EnergyOf(Quantity):
    """Quantity returned by `energy`."""

    part: str = "total"
    unit: ClassVar[str] = "J"
    is_relative_to_start: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check the part."""
        super().__post_init__()
        check_choice("part of the energy", self.part, ENERGIES)

    @property
    def name(self) -> str:
        """Name in printed plans and messages."""
        return f"{self.part} energy"

    @property
    def depends_on_velocity(self) -> bool:  # type: ignore[override]
        """True if it contains the kinetic energy."""
        return self.part in ("kinetic", "total")

    def admits_rigid(self, beam: Beam) -> bool:
        """Return True for the kinetic energy, which rods have."""
        return self.part == "kinetic"

    def history(self, run: Trajectory) -> Vector:
        """Return energies (k, 1) [J]."""
        return np.asarray(getattr(run.energy, self.part))[:, None]

    def varies(self, run: Trajectory) -> bool:
        """Return True unless all its changes are errors of the time steps."""
        energy = run.energy
        return self.part != "total" or bool(energy.work.any() or energy.lost.any())


@dataclass(frozen=True, eq=False, repr=False)
class Frequency(Quantity):
    """Quantity returned by `frequency`."""

    number: int = 1
    unit: ClassVar[str] = "Hz"
    is_static: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check the number."""
        super().__post_init__()
        check_count("the number of a frequency", self.number)

    @property
    def name(self) -> str:
        """Name in printed plans and messages."""
        return f"natural frequency {self.number}"

    @property
    def mode_number(self) -> int:  # type: ignore[override]
        """Number of the mode whose frequency it is."""
        return self.number

    def history(self, run: Trajectory) -> Vector:
        """Return the frequency about the last state, (1, 1) [Hz]."""
        result = modes(run.system.scene, self.number, at=run.last)
        return np.array([[result.frequencies[self.number - 1]]])


def energy(part: str = "total", *, at: str = "saved") -> EnergyOf:
    """Return an energy of the scene as a quantity of interest [J].

    Relative errors refer to its largest change, which the total energy has where loads, prescribed
    motions or damping do work.

    Parameters
    ----------
    part : {"total", "kinetic", "elastic", "potential"}, optional
        See `Trajectory.energy`.
    at : {"saved", "end", "largest"}, optional
        As in `position`.
    """
    return EnergyOf(part, at=at)


def frequency(number: int = 1) -> Frequency:
    """Return a natural frequency about the static equilibrium, without damping [Hz].

    Parameters
    ----------
    number : int, optional
        Its number, from 1 in ascending order, see `modes`.
    """
    return Frequency(number, at="end")
