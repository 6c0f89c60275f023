"""Quantities of interest, as functions of a solution."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice, check_count
from ancfsparse.errors import InputError
from ancfsparse.plans.models.model import find_counterpart
from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam, Point, Scene
from ancfsparse.solve.vibration.modes import modes

TIMES = ("saved", "end", "largest")
ENERGIES = ("total", "kinetic", "elastic", "potential")
PARTS = ("N", "Q", "M", "T")
# A free beam of 1.2 m at rest moves by 2e-14 m in 1 s, turns by 1e-12 rad, has strains of 4e-13.
ROUNDING_RATIO = 3e-12  # of coordinates, slopes and strains, below which they are rounding
FORCE_ROUNDING_RATIO = 1e-13  # the same of forces, over stiffness times coordinates; it has 4e-14


def largest_norm(vectors: Vector) -> float:
    """Return the largest norm of the rows of (k, m); zero of none."""
    return float(np.linalg.norm(vectors, axis=1).max(initial=0.0))


def position_rounding(run: Trajectory) -> float:
    """Return the size up to which changes of positions are rounding errors [m]."""
    system = run.system
    return ROUNDING_RATIO * float(np.max(np.abs(system.q_ref[system.positions])))


def force_rounding(run: Trajectory, moment: bool = False) -> float:
    """Return the size up to which forces, or moments, are rounding errors [N, N m]."""
    system = run.system
    is_position = np.isin(np.arange(system.n_free), system.positions)
    stiffness = np.abs(system.stiffness_diagonal(system.q_ref))[is_position != moment]
    arm = 1.0 if moment else position_rounding(run) / ROUNDING_RATIO
    return FORCE_ROUNDING_RATIO * arm * float(np.max(stiffness, initial=0.0))


@dataclass(frozen=True, eq=False)
class Quantity(ABC):
    """Quantity of interest of a motion or an equilibrium.

    Parameters
    ----------
    at : {"saved", "end", "largest"}
        All saved times, whose largest error counts; the last one; or the largest magnitude
        over time, a number.

    Attributes
    ----------
    unit : str
        Unit of its values and of its absolute errors.
    is_static : bool
        Whether it belongs to the equilibrium, not to a motion.
    is_expensive : bool
        Whether its evaluation in one state takes about as long as a step, so that trial runs
        evaluate it in fewer states, unless its largest value is sought, which these may miss.
    is_relative_to_start : bool
        Whether relative errors refer to its largest change since the start.
    is_like_rates : bool
        Whether its parts at higher frequencies are larger than in a position, about in
        proportion to the frequency, as for velocities and bending moments.
    """

    at: str = field(default="saved", kw_only=True)
    unit: ClassVar[str] = "m"
    is_expensive: ClassVar[bool] = False
    is_static: ClassVar[bool] = False
    is_relative_to_start: ClassVar[bool] = False
    is_like_rates: ClassVar[bool] = False

    def __post_init__(self) -> None:
        """Check the times."""
        check_choice("at of a quantity", self.at, TIMES)

    @abstractmethod
    def history(self, run: Trajectory) -> Vector:
        """Return its components at all saved times, shape (k, m) [unit]."""

    @abstractmethod
    def check(self, scene: Scene) -> None:
        """Refuse a scene that does not have the quantity.

        Raises
        ------
        InputError
            If the scene does not have it.
        """

    @property
    @abstractmethod
    def name(self) -> str:
        """Name in printed plans and messages."""

    def order(self, position_order: int) -> int:
        """Return its order of convergence from that of positions in the same elements."""
        return position_order

    def __repr__(self) -> str:
        """Return its name and times."""
        when = {"saved": "at all saved times", "end": "at the end", "largest": "at its largest"}
        return f"{self.name}, {when[self.at]}"

    def in_scene(self, scene: Scene) -> Quantity:
        """Return the same quantity of a scene that was built from its own."""
        return self

    def value(self, run: Trajectory) -> Vector:
        """Return the values at the requested times.

        Returns
        -------
        ndarray, shape (k, m), or (1, m) at the end, or (1, 1) for the largest [unit]
        """
        return self.select(self.history(run))

    def select(self, history: Vector) -> Vector:
        """Return the values at the requested times from all, shapes as in `value`."""
        if self.at == "end":
            return history[-1:]
        if self.at == "largest":
            return np.array([[largest_norm(history)]])
        return history

    def size(self, history: Vector) -> float:
        """Return the size that relative errors refer to: the largest magnitude over time [unit]."""
        return largest_norm(history - history[0] if self.is_relative_to_start else history)

    def varies(self, run: Trajectory) -> bool:
        """Return True unless all its changes are errors of the time steps."""
        return True

    def rounding(self, run: Trajectory) -> float:
        """Return the size up to which it consists of rounding errors [unit]."""
        return 0.0

    def difference(self, one: Vector, other: Vector) -> Vector:
        """Return the difference of values, of the shape of both [unit]."""
        return one - other

    def largest_difference(self, one: Vector, other: Vector) -> float:
        """Return the largest magnitude of the difference of values [unit]."""
        return largest_norm(self.difference(one, other))


@dataclass(frozen=True, eq=False, repr=False)
class AtPoint(Quantity):
    """Quantity of one point."""

    point: Point
    label: ClassVar[str]

    @property
    def name(self) -> str:
        """Name in printed plans and messages."""
        return f"{self.label} {self.point!r}"

    def in_scene(self, scene: Scene) -> Quantity:
        """Return the same quantity of a scene that was built from its own."""
        return replace(self, point=find_counterpart(scene, self.point))

    @property
    def beam(self) -> Beam:
        """Beam with the point."""
        assert isinstance(self.point.beam, Beam)
        return self.point.beam

    def check(self, scene: Scene) -> None:
        """Refuse a point of another scene."""
        if self.point.beam not in scene.bodies:
            raise InputError(
                f"the scene does not have the {self.name}: {self.point.beam.name} belongs to "
                "another scene; use a handle that a method of this scene returned"
            )


class Position(AtPoint):
    """Quantity returned by `position`."""

    is_relative_to_start: ClassVar[bool] = True
    label: ClassVar[str] = "position of"

    def history(self, run: Trajectory) -> Vector:
        """Return positions (k, dim) [m]."""
        return run.position(self.point)

    def rounding(self, run: Trajectory) -> float:
        """Return the size up to which it consists of rounding errors [unit]."""
        return position_rounding(run)


class Velocity(AtPoint):
    """Quantity returned by `velocity`."""

    is_like_rates: ClassVar[bool] = True
    label: ClassVar[str] = "velocity of"
    unit: ClassVar[str] = "m/s"

    def history(self, run: Trajectory) -> Vector:
        """Return velocities (k, dim) [m/s]."""
        return run.velocity(self.point)

    def rounding(self, run: Trajectory) -> float:
        """Return the size up to which it consists of rounding errors [unit]."""
        return position_rounding(run) * run.stats.steps / float(run.t[-1] - run.t[0])


class SlopeAngle(AtPoint):
    """Quantity returned by `slope_angle`."""

    is_relative_to_start: ClassVar[bool] = True
    label: ClassVar[str] = "slope angle at"
    unit: ClassVar[str] = "rad"

    def history(self, run: Trajectory) -> Vector:
        """Return angles (k, 1) [rad]."""
        slopes = run.slope(self.point)
        if slopes.shape[1] == 2:
            angles = np.unwrap(np.arctan2(slopes[:, 1], slopes[:, 0]))
        else:
            across = np.linalg.norm(np.cross(slopes[0], slopes), axis=1)
            angles = np.arctan2(across, slopes @ slopes[0])
        return np.asarray(angles).reshape(-1, 1)

    def rounding(self, run: Trajectory) -> float:
        """Return the size up to which it consists of rounding errors [unit]."""
        return ROUNDING_RATIO

    def difference(self, one: Vector, other: Vector) -> Vector:
        """Return the difference modulo 2 pi, since saved times may not resolve whole turns."""
        return np.asarray((one - other + np.pi) % (2.0 * np.pi) - np.pi)


class Reaction(AtPoint):
    """Quantity returned by `reaction`."""

    is_like_rates: ClassVar[bool] = True
    label: ClassVar[str] = "reaction at"
    unit: ClassVar[str] = "N"
    is_expensive: ClassVar[bool] = True

    def check(self, scene: Scene) -> None:
        """Refuse a point without a joint."""
        super().check(scene)
        if not any(self.point in joint.nodes for joint in scene.joints):
            raise InputError(
                f"the scene does not have the {self.name}: no joint holds that point; take a "
                "point with a pin, a clamp or a rod"
            )

    def history(self, run: Trajectory) -> Vector:
        """Return forces (k, dim) [N]."""
        return run.reaction(self.point)

    def rounding(self, run: Trajectory) -> float:
        """Return the size up to which it consists of rounding errors [unit]."""
        return force_rounding(run)


@dataclass(frozen=True, eq=False, repr=False)
class SectionForceAt(AtPoint):
    """Quantity returned by `section_force`."""

    is_like_rates: ClassVar[bool] = True
    part: str = "M"

    def __post_init__(self) -> None:
        """Check the part."""
        super().__post_init__()
        check_choice("part of a section force", self.part, PARTS)

    @property
    def unit(self) -> str:  # type: ignore[override]
        """Unit: N, or N m for moments."""
        return "N m" if self.part in "MT" else "N"

    @property
    def label(self) -> str:  # type: ignore[override]
        """Name without the point."""
        return f"section force {self.part} at"

    def order(self, position_order: int) -> int:
        """Return the order: moments need two derivatives, shear three; tension is constant."""
        return min(position_order, 2 if self.part in "MT" else 1)

    def history(self, run: Trajectory) -> Vector:
        """Return components (k, m) [N, N m]."""
        values = getattr(run.section_force(self.beam, [self.point]), self.part)
        if values is None:
            raise InputError(
                f"{self.point.beam.name} has an element without torsion: take N, Q or M, or "
                "element='thick'"
            )
        return np.asarray(values).reshape(len(run.t), -1)

    def rounding(self, run: Trajectory) -> float:
        """Return the size up to which it consists of rounding errors [unit]."""
        return force_rounding(run, self.part in "MT")


class Strain(AtPoint):
    """Quantity returned by `strain`."""

    is_like_rates: ClassVar[bool] = True
    label: ClassVar[str] = "strain at"
    unit: ClassVar[str] = ""

    def order(self, position_order: int) -> int:
        """Return the order: axial strains are mean values over an element."""
        return min(position_order, 2)

    def history(self, run: Trajectory) -> Vector:
        """Return strains (k, 1) [-]."""
        return run.strain(self.beam, [self.point])

    def rounding(self, run: Trajectory) -> float:
        """Return the size up to which it consists of rounding errors [unit]."""
        return ROUNDING_RATIO


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

    def check(self, scene: Scene) -> None:
        """Do nothing: every scene has energies."""

    def history(self, run: Trajectory) -> Vector:
        """Return energies (k, 1) [J]."""
        return np.asarray(getattr(run.energy, self.part))[:, None]

    def varies(self, run: Trajectory) -> bool:
        """Return True unless all its changes are errors of the time steps."""
        energy = run.energy
        return self.part != "total" or bool(energy.work.any() or energy.lost.any())


class StaticDeflection(AtPoint):
    """Quantity returned by `static_deflection`."""

    label: ClassVar[str] = "static deflection of"
    is_static: ClassVar[bool] = True

    def history(self, run: Trajectory) -> Vector:
        """Return displacements from the reference shape (k, dim) [m]."""
        return run.position(self.point) - self.point.position

    def rounding(self, run: Trajectory) -> float:
        """Return the size up to which it consists of rounding errors [unit]."""
        return position_rounding(run)


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

    def check(self, scene: Scene) -> None:
        """Do nothing: every scene has frequencies; `modes` refuses a mesh with too few."""

    def history(self, run: Trajectory) -> Vector:
        """Return the frequency about the last state, (1, 1) [Hz]."""
        result = modes(run.system.scene, self.number, at=run.last)
        return np.array([[result.frequencies[self.number - 1]]])
