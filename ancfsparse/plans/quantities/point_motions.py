"""Quantities of the motion of a point: position, velocity, slope, deflection at rest."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.plans.quantities.quantity import (
    AtPoint,
    check_beam_point,
    largest_norm,
    position_rounding,
    relative_rounding,
)
from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam, Point, check_point


class Position(AtPoint):
    """Quantity returned by `position`."""

    label: ClassVar[str] = "position of"
    is_relative_to_start: ClassVar[bool] = True
    is_displacement: ClassVar[bool] = True
    rounding = position_rounding

    def history(self, run: Trajectory) -> Vector:
        """Return positions (k, dim) [m]."""
        return run.position(self.point)

    def response_size(self, history: Vector) -> float:
        """Return the larger of its displacements from the start and the stress-free shape [m]."""
        return max(self.size(history), largest_norm(history - self.point.position))

    def change_by_vibration(self, amplitude: float, omega: float) -> float:
        """Return the amplitude [m]."""
        return amplitude

    def admits_rigid(self, beam: Beam) -> bool:
        """Return True: points of rods have positions."""
        return True


class Velocity(AtPoint):
    """Quantity returned by `velocity`."""

    label: ClassVar[str] = "velocity of"
    unit: ClassVar[str] = "m/s"
    is_like_rates: ClassVar[bool] = True
    depends_on_velocity: ClassVar[bool] = True

    def history(self, run: Trajectory) -> Vector:
        """Return velocities (k, dim) [m/s]."""
        return run.velocity(self.point)

    def rounding(self, run: Trajectory) -> float:
        """Return the size up to which it consists of rounding errors [m/s]."""
        return position_rounding(self, run) * run.stats.steps / float(run.t[-1] - run.t[0])

    def change_by_vibration(self, amplitude: float, omega: float) -> float:
        """Return the amplitude of the velocity [m/s]."""
        return omega * amplitude

    def admits_rigid(self, beam: Beam) -> bool:
        """Return True: points of rods have velocities."""
        return True


class SlopeAngle(AtPoint):
    """Quantity returned by `slope_angle`."""

    label: ClassVar[str] = "slope angle at"
    unit: ClassVar[str] = "rad"
    is_relative_to_start: ClassVar[bool] = True
    rounding = relative_rounding

    def history(self, run: Trajectory) -> Vector:
        """Return angles (k, 1) [rad]."""
        slopes = run.slope(self.point)
        if slopes.shape[1] == 2:
            angles = np.unwrap(np.arctan2(slopes[:, 1], slopes[:, 0]))
        else:
            across = np.linalg.norm(np.cross(slopes[0], slopes), axis=1)
            angles = np.arctan2(across, slopes @ slopes[0])
        return np.asarray(angles).reshape(-1, 1)

    def difference(self, one: Vector, other: Vector) -> Vector:
        """Return the difference modulo 2 pi, since saved times may not resolve whole turns."""
        return np.asarray((one - other + np.pi) % (2.0 * np.pi) - np.pi)


class StaticDeflection(AtPoint):
    """Quantity returned by `static_deflection`."""

    label: ClassVar[str] = "static deflection of"
    is_static: ClassVar[bool] = True
    is_displacement: ClassVar[bool] = True
    rounding = position_rounding

    def history(self, run: Trajectory) -> Vector:
        """Return displacements from the reference shape (k, dim) [m]."""
        return run.position(self.point) - self.point.position


def position(point: Point, *, at: str = "saved") -> Position:
    """Return the position of a point as a quantity of interest [m].

    Parameters
    ----------
    point : Point
        Any point, such as ``rod.end`` or ``rod.at(s)``.
    at : {"saved", "end", "largest"}, optional
        All saved times, whose largest error counts; the last one; or the largest distance
        from the origin over time.

    Returns
    -------
    Quantity
        For `plan` and `simulate`; relative errors refer to the largest displacement.

    Raises
    ------
    InputError
        If `point` is not a point.
    """
    return Position(check_point("a position", point), at=at)


def velocity(point: Point, *, at: str = "saved") -> Velocity:
    """Return the velocity of a point [m/s]; parameters and errors as in `position`."""
    return Velocity(check_point("a velocity", point), at=at)


def slope_angle(point: Point, *, at: str = "saved") -> SlopeAngle:
    """Return the angle of the slope r' at a point [rad]; parameters and errors as in `position`.

    In the plane counterclockwise from the x axis; in space from its direction at the start.
    """
    return SlopeAngle(check_beam_point("a slope angle", point), at=at)


def static_deflection(point: Point) -> StaticDeflection:
    """Return the displacement of a point in the static equilibrium [m].

    For ``plan(scene, quantity=..., error=...)``; relative errors refer to its magnitude, and the
    parameter is as in `position`.
    """
    return StaticDeflection(check_point("a static deflection", point), at="end")
