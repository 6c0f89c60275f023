"""Constructors of the quantities of interest."""

from __future__ import annotations

from typing import Any

from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.plans.quantities.quantity import (
    EnergyOf,
    Frequency,
    Position,
    Quantity,
    Reaction,
    SectionForceAt,
    SlopeAngle,
    StaticDeflection,
    Strain,
    Velocity,
)
from ancfsparse.scene import Beam, Point, Scene, check_point


def _check_on_beam(what: str, point: object) -> Point:
    node = check_point(what, point)
    if not isinstance(node.beam, Beam):
        raise InputError(f"{what} needs a point of a beam, got {format_value(point)}")
    return node


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
    return SlopeAngle(_check_on_beam("a slope angle", point), at=at)


def reaction(point: Point, *, at: str = "saved") -> Reaction:
    """Return the force of joints at a node [N]; parameters and errors as in `position`."""
    return Reaction(check_point("a reaction", point), at=at)


def section_force(point: Point, part: str = "M", *, at: str = "saved") -> SectionForceAt:
    """Return a force or moment in a section as a quantity of interest [N, N m].

    Parameters
    ----------
    point : Point
        A point of a beam.
    part : {"N", "Q", "M", "T"}, optional
        Axial force, shear force, bending moment or torsional moment, see
        `Trajectory.section_force`.
    at : {"saved", "end", "largest"}, optional
        As in `position`.

    Returns
    -------
    Quantity
        For `plan` and `simulate`.

    Raises
    ------
    InputError
        If `point` is not a point of a beam, or the part is unknown.
    """
    return SectionForceAt(_check_on_beam("a section force", point), part, at=at)


def strain(point: Point, *, at: str = "saved") -> Strain:
    """Return the axial strain at a point [-]; parameters and errors as in `position`."""
    return Strain(_check_on_beam("a strain", point), at=at)


def energy(part: str = "total", *, at: str = "saved") -> EnergyOf:
    """Return an energy of the scene as a quantity of interest [J].

    Parameters
    ----------
    part : {"total", "kinetic", "elastic", "potential"}, optional
        See `Trajectory.energy`.
    at : {"saved", "end", "largest"}, optional
        As in `position`.

    Returns
    -------
    Quantity
        For `plan` and `simulate`; relative errors refer to its largest change, which the total
        energy has where loads, prescribed motions or damping do work.

    Raises
    ------
    InputError
        If the part is unknown.
    """
    return EnergyOf(part, at=at)


def static_deflection(point: Point) -> StaticDeflection:
    """Return the displacement of a point in the static equilibrium [m].

    Parameters
    ----------
    point : Point
        Any point, such as ``rod.end`` or ``rod.at(s)``.

    Returns
    -------
    Quantity
        For ``plan(scene, quantity=..., error=...)``; relative errors refer to its magnitude.

    Raises
    ------
    InputError
        If `point` is not a point.
    """
    return StaticDeflection(check_point("a static deflection", point), at="end")


def frequency(number: int = 1) -> Frequency:
    """Return a natural frequency about the static equilibrium, without damping [Hz].

    Parameters
    ----------
    number : int, optional
        Its number, from 1 in ascending order, see `modes`.

    Returns
    -------
    Quantity
        For ``plan(scene, quantity=..., error=...)``.

    Raises
    ------
    InputError
        If `number` is not a positive integer.
    """
    return Frequency(number, at="end")


def check_quantities(quantity: Any, scene: Scene) -> tuple[Quantity, ...]:
    """Return one quantity or several as a tuple of quantities of the scene.

    Raises
    ------
    InputError
        If one is not a `Quantity`, there is none, or the scene does not have it.
    """
    given = quantity if isinstance(quantity, list | tuple) else (quantity,)
    for each in given:
        if not isinstance(each, Quantity):
            raise InputError(
                "quantity must be a Quantity, such as ancf.position(rod.end), or a list of them, "
                f"got {format_value(each)}"
            )
        each.check(scene)
    if given and len({each.is_static for each in given}) > 1:
        raise InputError(
            "quantities of a motion and of the equilibrium were given together: make a plan for "
            "each kind"
        )
    if not given:
        raise InputError("quantity is empty: give at least one, such as ancf.position(rod.end)")
    return tuple(given)
