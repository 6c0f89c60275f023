"""Quantities: what a plan is asked for, as functions of a solution."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_choice, check_count
from ancfsparse.errors import InputError
from ancfsparse.plans.models.model import counterpart
from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam, Point, Scene
from ancfsparse.solve.vibration.modes import modes

Array = NDArray[np.float64]

TIMES = ("saved", "end", "largest")
ENERGIES = ("total", "kinetic", "elastic", "potential")
PARTS = ("N", "Q", "M", "T")


@dataclass(frozen=True, eq=False)
class Quantity(ABC):
    """What a person wants to know about a motion.

    Parameters
    ----------
    at : {"saved", "end", "largest"}
        All saved times, of whose errors the largest counts; the last of them; or the largest
        magnitude over them, a number.

    Attributes
    ----------
    unit : str
        Unit of its values and of its absolute errors.
    static : bool
        Whether it is one of the equilibrium, and so of a scene without a motion.
    slow : bool
        Whether each state takes about as long as a step, so that pilots look at fewer.
    """

    at: str = field(default="saved", kw_only=True)
    unit: ClassVar[str] = "m"
    slow: ClassVar[bool] = False
    static: ClassVar[bool] = False

    def __post_init__(self) -> None:
        """Check the times."""
        check_choice("at of a quantity", self.at, TIMES)

    @abstractmethod
    def history(self, run: Trajectory) -> Array:
        """Return its components at all saved times, shape (k, m) [unit]."""

    @abstractmethod
    def check(self, scene: Scene) -> None:
        """Refuse a scene that does not have it.

        Raises
        ------
        InputError
            With what is missing.
        """

    @property
    @abstractmethod
    def name(self) -> str:
        """What plans call it."""

    def order(self, of_positions: int) -> int:
        """Return the order in which it converges, by that of positions in the same elements."""
        return of_positions

    def __repr__(self) -> str:
        """Describe what it is, and when."""
        when = {"saved": "at all saved times", "end": "at the end", "largest": "at its largest"}
        return f"{self.name}, {when[self.at]}"

    def on(self, scene: Scene) -> Quantity:
        """Return the same quantity of a scene that was built from the one it is of."""
        return self

    def value(self, run: Trajectory) -> Array:
        """Return the values that are asked for.

        Returns
        -------
        ndarray, shape (k, m), or (1, m) at the end, or (1, 1) for the largest [unit]
        """
        return self.chosen(self.history(run))

    def chosen(self, history: Array) -> Array:
        """Return the values that are asked for out of all, shapes as in `value`."""
        if self.at == "end":
            return history[-1:]
        if self.at == "largest":
            return np.array([[np.linalg.norm(history, axis=1).max()]])
        return history

    def size(self, history: Array) -> float:
        """Return what relative errors refer to: the largest magnitude over time [unit]."""
        return float(np.linalg.norm(history, axis=1).max())

    def varies(self, run: Trajectory) -> bool:
        """Whether it is more than an error of the steps that changes it."""
        return True

    def difference(self, one: Array, other: Array) -> Array:
        """Return by how much values differ, of the shape of both [unit]."""
        return one - other


@dataclass(frozen=True, eq=False, repr=False)
class AtPoint(Quantity):
    """A quantity of one point."""

    point: Point

    def on(self, scene: Scene) -> Quantity:
        """Return the same quantity of a scene that was built from the one it is of."""
        return replace(self, point=counterpart(scene, self.point))

    @property
    def beam(self) -> Beam:
        """The beam that the point is on."""
        assert isinstance(self.point.beam, Beam)
        return self.point.beam

    def check(self, scene: Scene) -> None:
        """Refuse a point of another scene."""
        if self.point.beam not in scene.bodies:
            raise InputError(
                f"the scene does not have the {self.name}: {self.point.beam.name} is of another "
                "scene; use a handle that a method of this scene returned"
            )


class Position(AtPoint):
    """See `position`."""

    @property
    def name(self) -> str:
        """What plans call it."""
        return f"position of {self.point!r}"

    def history(self, run: Trajectory) -> Array:
        """Return positions (k, dim) [m]."""
        return run.position(self.point)

    def size(self, history: Array) -> float:
        """Return the largest displacement since the start [m]."""
        return float(np.linalg.norm(history - history[0], axis=1).max())


class Velocity(AtPoint):
    """See `velocity`."""

    unit: ClassVar[str] = "m/s"

    @property
    def name(self) -> str:
        """What plans call it."""
        return f"velocity of {self.point!r}"

    def history(self, run: Trajectory) -> Array:
        """Return velocities (k, dim) [m/s]."""
        return run.velocity(self.point)


class SlopeAngle(AtPoint):
    """See `slope_angle`."""

    unit: ClassVar[str] = "rad"

    @property
    def name(self) -> str:
        """What plans call it."""
        return f"slope angle at {self.point!r}"

    def history(self, run: Trajectory) -> Array:
        """Return angles (k, 1) [rad]."""
        slopes = run.slope(self.point)
        if slopes.shape[1] == 2:
            angles = np.unwrap(np.arctan2(slopes[:, 1], slopes[:, 0]))
        else:
            across = np.linalg.norm(np.cross(slopes[0], slopes), axis=1)
            angles = np.arctan2(across, slopes @ slopes[0])
        return np.asarray(angles).reshape(-1, 1)

    def size(self, history: Array) -> float:
        """Return the largest turn since the start [rad]."""
        return float(np.abs(history - history[0]).max())

    def difference(self, one: Array, other: Array) -> Array:
        """Return the difference without whole turns, which saved times may not resolve."""
        return np.asarray((one - other + np.pi) % (2.0 * np.pi) - np.pi)


class Reaction(AtPoint):
    """See `reaction`."""

    unit: ClassVar[str] = "N"
    slow: ClassVar[bool] = True

    @property
    def name(self) -> str:
        """What plans call it."""
        return f"reaction at {self.point!r}"

    def check(self, scene: Scene) -> None:
        """Refuse a point that no joint holds."""
        super().check(scene)
        if not any(self.point in joint.nodes for joint in scene.joints):
            raise InputError(
                f"the scene does not have the {self.name}: no joint holds that point; ask for it "
                "at a pin, a clamp or a rod"
            )

    def history(self, run: Trajectory) -> Array:
        """Return forces (k, dim) [N]."""
        return run.reaction(self.point)


@dataclass(frozen=True, eq=False, repr=False)
class SectionForceAt(AtPoint):
    """See `section_force`."""

    part: str = "M"

    def __post_init__(self) -> None:
        """Check the part."""
        super().__post_init__()
        check_choice("part of a section force", self.part, PARTS)

    @property
    def unit(self) -> str:  # type: ignore[override]
        """N, or N m of a moment."""
        return "N m" if self.part in "MT" else "N"

    @property
    def name(self) -> str:
        """What plans call it."""
        return f"section force {self.part} at {self.point!r}"

    def order(self, of_positions: int) -> int:
        """Moments need two derivatives, shear forces three; tension is even in an element."""
        return min(of_positions, 2 if self.part in "MT" else 1)

    def history(self, run: Trajectory) -> Array:
        """Return components (k, m) [N, N m]."""
        values = getattr(run.section_force(self.beam, [self.point]), self.part)
        if values is None:
            raise InputError(
                f"{self.point.beam.name} is made of an element without torsion: ask for N, Q or M, "
                "or take element='thick'"
            )
        return np.asarray(values).reshape(len(run.t), -1)


class Strain(AtPoint):
    """See `strain`."""

    unit: ClassVar[str] = ""

    @property
    def name(self) -> str:
        """What plans call it."""
        return f"strain at {self.point!r}"

    def order(self, of_positions: int) -> int:
        """Strains of the axis are averages of what they are in an element."""
        return min(of_positions, 2)

    def history(self, run: Trajectory) -> Array:
        """Return strains (k, 1) [-]."""
        return run.strain(self.beam, [self.point])


@dataclass(frozen=True, eq=False, repr=False)
class EnergyOf(Quantity):
    """See `energy`."""

    part: str = "total"
    unit: ClassVar[str] = "J"

    def __post_init__(self) -> None:
        """Check the part."""
        super().__post_init__()
        check_choice("part of the energy", self.part, ENERGIES)

    @property
    def name(self) -> str:
        """What plans call it."""
        return f"{self.part} energy"

    def check(self, scene: Scene) -> None:
        """Every scene has energies."""

    def history(self, run: Trajectory) -> Array:
        """Return energies (k, 1) [J]."""
        return np.asarray(getattr(run.energy, self.part))[:, None]

    def varies(self, run: Trajectory) -> bool:
        """Whether it is more than an error of the steps that changes it."""
        energy = run.energy
        return self.part != "total" or bool(energy.work.any() or energy.dissipated.any())

    def size(self, history: Array) -> float:
        """Return the largest change since the start [J]."""
        return float(np.abs(history - history[0]).max())


class StaticDeflection(AtPoint):
    """See `static_deflection`."""

    static: ClassVar[bool] = True

    @property
    def name(self) -> str:
        """What plans call it."""
        return f"static deflection of {self.point!r}"

    def history(self, run: Trajectory) -> Array:
        """Return displacements from the reference shape (k, dim) [m]."""
        return run.position(self.point) - self.point.position


@dataclass(frozen=True, eq=False, repr=False)
class Frequency(Quantity):
    """See `frequency`."""

    number: int = 1
    unit: ClassVar[str] = "Hz"
    static: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check the number."""
        super().__post_init__()
        check_count("the number of a frequency", self.number)

    @property
    def name(self) -> str:
        """What plans call it."""
        return f"natural frequency {self.number}"

    def check(self, scene: Scene) -> None:
        """Every scene has frequencies; a mesh with too few is refused by `modes`."""

    def history(self, run: Trajectory) -> Array:
        """Return the frequency about the last state, (1, 1) [Hz]."""
        found = modes(run.system.scene, self.number, at=run.last)
        return np.array([[found.frequencies[self.number - 1]]])
