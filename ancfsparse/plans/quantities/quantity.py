"""Quantity of interest: a function of a solution, with the properties that plans depend on."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.plans.models.model import find_counterpart
from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam, Point, Scene, check_point

TIMES = {"saved": "at all saved times", "end": "at the end", "largest": "at its largest"}
# A free beam of 1.2 m at rest moves by 2e-14 m in 1 s, turns by 1e-12 rad, has strains of 4e-13.
ROUNDING_RATIO = 3e-12  # of coordinates, slopes and strains, below which they are rounding


def check_beam_point(what: str, point: object) -> Point:
    """Return a point if it is one of a beam."""
    node = check_point(what, point)
    if not isinstance(node.beam, Beam):
        raise InputError(f"{what} needs a point of a beam, got {format_value(point)}")
    return node


def largest_norm(vectors: Vector) -> float:
    """Return the largest norm of the rows of (k, m); zero of none."""
    return float(np.linalg.norm(vectors, axis=1).max(initial=0.0))


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
    point : Point or None
        Its point, if it has one.
    mode_number : int or None
        Number of the mode whose frequency it is, if it is one.
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
    is_displacement : bool
        Whether it changes by the displacement of its point [m].
    is_axial_strain : bool
        Whether it is the axial strain at its point, which elements define differently.
    has_limit_at_start : bool
        Whether it is finite at t = 0 on ever finer meshes; forces after a shock may not be.
    needs_equations : bool
        Whether it is evaluated by the equations of motion, which sums of modes do not satisfy.
    depends_on_velocity : bool
        Whether equilibria, which are at rest, lack it.
    """

    at: str = field(default="saved", kw_only=True)
    unit: ClassVar[str] = "m"
    point: ClassVar[Point | None] = None
    mode_number: ClassVar[int | None] = None
    is_static: ClassVar[bool] = False
    is_expensive: ClassVar[bool] = False
    is_relative_to_start: ClassVar[bool] = False
    is_like_rates: ClassVar[bool] = False
    is_displacement: ClassVar[bool] = False
    is_axial_strain: ClassVar[bool] = False
    has_limit_at_start: ClassVar[bool] = True
    needs_equations: ClassVar[bool] = False
    depends_on_velocity: ClassVar[bool] = False

    def __post_init__(self) -> None:
        """Check the times."""
        check_choice("at of a quantity", self.at, TIMES)

    @property
    @abstractmethod
    def name(self) -> str:
        """Name in printed plans and messages."""

    @abstractmethod
    def history(self, run: Trajectory) -> Vector:
        """Return its components at all saved times, shape (k, m) [unit]."""

    def check(self, scene: Scene) -> None:  # noqa: B027
        """Refuse a scene that does not have the quantity.

        Raises
        ------
        InputError
            If the scene does not have it.
        """

    def order(self, position_order: int) -> int:
        """Return its order of convergence from that of positions in the same elements."""
        return position_order

    def __repr__(self) -> str:
        """Return its name and times."""
        return f"{self.name}, {TIMES[self.at]}"

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

    def response_size(self, history: Vector) -> float:
        """Return the size that changes of stiffness and mass change in proportion [unit]."""
        return self.size(history)

    def change_by_vibration(self, amplitude: float, omega: float) -> float:
        """Return its change by a vibration of its point [m, 1/s], beyond that of lengths [unit]."""
        return 0.0

    def admits_rigid(self, beam: Beam) -> bool:
        """Return True if it has the same meaning where a beam is a rigid rod."""
        return self.point is None or self.point.beam is not beam

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

    point: Point  # type: ignore[misc]
    label: ClassVar[str]

    @property
    def name(self) -> str:
        """Name in printed plans and messages."""
        return f"{self.label} {self.point!r}"

    @property
    def beam(self) -> Beam:
        """Beam with the point."""
        assert isinstance(self.point.beam, Beam)
        return self.point.beam

    def in_scene(self, scene: Scene) -> Quantity:
        """Return the same quantity of a scene that was built from its own."""
        return replace(self, point=find_counterpart(scene, self.point))

    def check(self, scene: Scene) -> None:
        """Refuse a point of another scene."""
        if self.point.beam not in scene.bodies:
            raise InputError(
                f"the scene does not have the {self.name}: {self.point.beam.name} belongs to "
                "another scene; use a handle that a method of this scene returned"
            )


def position_rounding(quantity: Quantity, run: Trajectory) -> float:
    """Return the size up to which changes of positions are rounding errors [m]."""
    system = run.system
    return ROUNDING_RATIO * float(np.max(np.abs(system.q_ref[system.positions])))


def relative_rounding(quantity: Quantity, run: Trajectory) -> float:
    """Return the size up to which slopes and strains are rounding errors [-]."""
    return ROUNDING_RATIO
