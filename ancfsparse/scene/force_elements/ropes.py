"""Elastic ropes over points, which pull and never push."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_finite, check_moderate
from ancfsparse.errors import InputError, format_quantity
from ancfsparse.messages import format_value
from ancfsparse.scene.bodies.body import Body, Point
from ancfsparse.scene.joints.rod import SAME_PLACE
from ancfsparse.scene.loads.attachment import Attached
from ancfsparse.scene.meshing.straight_beam import check_position
from ancfsparse.scene.methods.scene_base import Records
from ancfsparse.scene.records.prescribed_motion import Places
from ancfsparse.scene.records.transferable_functions import sendable

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Change:
    """By how much a natural length differs from that at t = 0.

    Parameters
    ----------
    given : callable
        The natural length as a function of t [m].
    length : float
        That at t = 0 [m].
    """

    given: Callable[[Any], Any]
    length: float

    def __call__(self, t: Any) -> Any:
        """Return it at a time, or at many [m]."""
        now = np.asarray(self.given(t), dtype=float)
        if now.size and not now.min() > 0.0:
            raise InputError(f"the length must be positive, got {now.min():.6g} m")
        return now - self.length

    def __getstate__(self) -> dict[str, Any]:
        """Give what is pickled."""
        return self.__dict__ | {"given": sendable(self.__dict__["given"])}


@dataclass(frozen=True, eq=False)
class Rope(Attached):
    """A massless elastic rope over points without friction, which goes slack.

    Attributes
    ----------
    points : tuple of Point or (dim,) ndarray
        Points of bodies and beams, or fixed in space [m].
    stiffness : float
        Tension over strain, E A [N].
    damping : float
        Tension over the rate of the strain [N s].
    length : float
        Natural length at t = 0 [m].
    slack : float
        Strain about which it goes slack [-].
    change : Places, optional
        By how much the natural length differs from that over time [m].
    given : float, Signal or callable
        The length as it was given.
    """

    points: tuple[Point | Vector, ...]
    stiffness: float
    damping: float
    length: float
    slack: float
    change: Places | None
    given: Any
    contribution = "force_elements.ropes"

    @property
    def what(self) -> str:
        """Name in messages."""
        ends = (repr(x) if isinstance(x, Point) else format_value(x.tolist()) for x in self.points)
        return f"the rope over {', '.join(ends)}"

    def __getstate__(self) -> dict[str, Any]:
        """Give what is pickled."""
        return self.__dict__ | {"given": sendable(self.given)}

    @property
    def links(self) -> tuple[tuple[Point | Vector, Point | Vector], ...]:
        """The lines from point to point."""
        return tuple(pairwise(self.points))

    def tension(self, path: Vector, rate: Vector, length: Vector | float) -> Vector:
        """Return the tension, (k,) [N].

        Parameters
        ----------
        path, rate : (k,) float
            The distances of the points, added up [m], and their rate [m/s].
        length : float or (k,) float
            Natural length [m].
        """
        strain = (path - length) / length
        root = np.hypot(strain, self.slack)
        with np.errstate(invalid="ignore", divide="ignore"):
            low = 0.5 * self.slack**2 / (root - strain)
            positive = np.where(strain > 0.0, 0.5 * (strain + root), np.where(root > 0.0, low, 0.0))
            share = np.where(root > 0.0, positive / root, 0.0)
        elastic = self.stiffness * positive * share
        viscous = self.damping * share**2 * rate / length
        return np.asarray(elastic + np.maximum(viscous, -elastic))


def rope_over(
    scene: Records,
    points: object,
    stiffness: object,
    damping: object,
    length: Any,
    slack: object,
) -> Rope:
    """Check the arguments of `Scene.rope`; return the rope."""
    ends, apart = points_of_rope(scene, "a rope", points)
    values = check_moderate("stiffness of a rope", stiffness, "N")
    viscosity = _not_negative("damping of a rope", damping, "N s")
    width = _not_negative("slack of a rope", slack, "")
    if width > 1.0:
        raise InputError(f"slack of a rope is a strain from 0 to 1, got {width:.6g}")
    change, natural, name = None, sum(apart), "the length of a rope"
    if callable(length):
        if viscosity:
            raise InputError(
                "a rope whose length changes with time takes no damping: damp the body that it "
                "holds, or give it a length that stays"
            )
        natural = check_moderate(f"{name} at t = 0", Places(name, 0, length).at(0.0)[0], "m")
        change = Places(name, 0, Change(length, natural))
    elif length is not None:
        natural = check_moderate(name, length, "m")
    return Rope(ends, values, viscosity, natural, width, change, length)


def points_of_rope(
    scene: Records, what: str, points: object
) -> tuple[tuple[Point | Vector, ...], list[float]]:
    """Return the points that a rope leads over, and the distances of consecutive ones [m].

    Raises
    ------
    InputError
        If a point is invalid, two consecutive ones coincide, or all are fixed in space.
    """
    if not isinstance(points, list | tuple) or len(points) < 2:
        raise InputError(f"{what} needs a list of two points or more, got {format_value(points)}")
    ends: list[Point | Vector] = []
    for k, each in enumerate(points):
        if isinstance(each, Point):
            ends.append(scene._mine(what, each))
        elif isinstance(each, Body):
            raise InputError(
                f"point {k} of {what} must be a single point, got {each.name}: give one of its "
                "points, such as hook.origin or hook.at(...) of a rigid body, rod.end of a beam"
            )
        else:
            ends.append(check_position(f"point {k} of {what}", each, scene.dim))
    nodes = [each for each in ends if isinstance(each, Point)]
    if not nodes:
        raise InputError(f"{what} needs a point of a beam or a body among its points")
    places = np.array([each.position if isinstance(each, Point) else each for each in ends])
    apart = np.linalg.norm(np.diff(places, axis=0), axis=1)
    k = int(np.argmin(apart))
    if apart[k] <= SAME_PLACE * max(each.beam.size for each in nodes):
        raise InputError(
            f"points {k} and {k + 1} of {what} coincide, so its rope has no direction there: "
            "leave one of them out"
        )
    return tuple(ends), apart.tolist()


def _not_negative(what: str, value: object, unit: str) -> float:
    number = check_finite(what, value, unit)
    if number < 0.0:
        raise InputError(f"{what} must not be negative, got {format_quantity(number, unit)}")
    return number
