"""Elastic ropes over points, which pull and never push."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_moderate, check_not_negative
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.loads.attachment import Attachment
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.picklable_functions import picklable
from ancfsparse.scene.records.prescribed_motion import PrescribedValue
from ancfsparse.scene.records.record import At, Record, text
from ancfsparse.scene.records.signal import Signal


@dataclass(frozen=True, eq=False)
class RopeSpec(Record):
    """The record of `Scene.rope`."""

    points: tuple[Any, ...]
    stiffness: float
    damping: float = 0.0
    length: Any = None
    slack: float = 0.0
    method = "rope"
    units: ClassVar = {"stiffness": "N", "damping": "N s", "length": "m"}

    def describe(self, at: At, made: Any) -> str:
        """Describe everything that its force follows from."""
        points = "; ".join(text(end, at) for end in self.points)
        values = f"{self.stiffness:.9g}, {self.damping:.9g}, {self.slack:.9g}"
        return f"rope ({points}), length {text(made.given, at)}: ({values})"


@dataclass(frozen=True)
class Change:
    """The change of a natural length since t = 0.

    Parameters
    ----------
    given : callable
        The natural length as a function of t [m].
    length : float
        Its value at t = 0 [m].
    """

    given: Callable[[Any], Any]
    length: float

    def __call__(self, t: Any) -> Any:
        """Return the change at a time, or at many [m]."""
        now = np.asarray(self.given(t), dtype=float)
        if now.size and not now.min() > 0.0:
            raise InputError(f"the length must be positive, got {now.min():.6g} m")
        return now - self.length

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling."""
        return self.__dict__ | {"given": picklable(self.__dict__["given"])}


@dataclass(frozen=True, eq=False)
class Rope(Attachment):
    """A massless elastic rope over points without friction, which goes slack.

    Attributes
    ----------
    points, stiffness, damping, slack
        As in `Scene.rope`.
    length : float
        Natural length at t = 0 [m].
    change : PrescribedValue, optional
        Change of the natural length over time [m].
    given : float, Signal or callable
        The argument `length`.
    """

    points: tuple[Point | Vector, ...]
    stiffness: float
    damping: float
    length: float
    slack: float
    change: PrescribedValue | None
    given: Any
    contribution = "force_elements.ropes"
    is_rope = True

    @property
    def what(self) -> str:
        """Name in messages."""
        ends = (repr(x) if isinstance(x, Point) else format_value(x.tolist()) for x in self.points)
        return f"the rope over {', '.join(ends)}"

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling."""
        return self.__dict__ | {"given": picklable(self.given)}

    @property
    def function_of_time(self) -> object:
        """The natural length over time [m]."""
        return self.given

    @property
    def links(self) -> tuple[tuple[Point | Vector, Point | Vector], ...]:
        """The lines between consecutive points."""
        return tuple(pairwise(self.points))

    def tension(self, path: Vector, rate: Vector, length: Vector | float) -> Vector:
        """Return the tension, (k,) [N].

        Parameters
        ----------
        path, rate : (k,) float
            Sum of the distances of the points [m], and its rate [m/s].
        length : float or (k,) float
            Natural length [m].
        """
        strain = (path - length) / length
        root = np.hypot(strain, self.slack)
        with np.errstate(invalid="ignore", divide="ignore"):
            low = 0.5 * self.slack**2 / (root - strain)
            positive = np.where(strain > 0.0, 0.5 * (strain + root), np.where(root > 0.0, low, 0.0))
            fraction = np.where(root > 0.0, positive / root, 0.0)
        elastic = self.stiffness * positive * fraction
        viscous = self.damping * fraction**2 * rate / length
        return np.asarray(elastic + np.maximum(viscous, -elastic))


class Ropes(SceneBase):
    """Elastic ropes of a scene."""

    def rope(
        self,
        points: Sequence[Point | ArrayLike],
        *,
        stiffness: float,
        damping: float = 0.0,
        length: float | Signal | Callable[[float], float] | None = None,
        slack: float = 0.0,
    ) -> Rope:
        """Lead a massless elastic rope over points; it pulls, goes slack, and never pushes.

        With the strain eps, the distances of the points together over the natural length minus 1,
        its tension is ``stiffness * eps + damping * d eps/dt`` where that is positive and eps is,
        the same in all parts; `Trajectory.tension` gives it.  Where its length is a function of
        time, the work of what winds it up counts in the energy balance.  A drum that turns freely
        lets it out by a `winch` between the drum and a small body that the rope begins at.

        Parameters
        ----------
        points : sequence of Point or array_like of shape (dim,)
            Two or more, such as ``[(0, 3), hook.origin]``; one is a point of a beam or a body.
        stiffness : float
            Tension over strain, Young's modulus times area [N].
        damping : float, optional
            Tension over the rate of the strain [N s], of a rope whose length does not change.
        length : float, Signal or callable, optional
            Natural length [m], or a function of t [s] that returns it: paid out as it grows, drawn
            in as it falls.  By default the distances of the points in the reference shape.
        slack : float, optional
            Strain about which it goes slack smoothly [-], as of strings: its tension at its natural
            length is stiffness slack / 4.  By default its tension has a kink there.

        Raises
        ------
        InputError
            If a point is invalid, two consecutive ones coincide, or a number is out of range.
        """
        ends, places, natural = self._points_of_rope("a rope", points)
        width = check_not_negative("slack of a rope", slack)
        if width > 1.0:
            raise InputError(f"slack of a rope is a strain from 0 to 1, got {width:.6g}")
        viscosity = check_not_negative("damping of a rope", damping, "N s")
        subject = "the length of a rope"
        change = None
        if callable(length):
            if viscosity:
                raise InputError(
                    "a rope whose length changes with time takes no damping: damp the body that it "
                    "holds, or give it a constant length"
                )
            start = PrescribedValue(subject, 0, length).at(0.0)[0]
            natural = check_moderate(f"{subject} at t = 0", start, "m")
            change = PrescribedValue(subject, 0, Change(length, natural))
        elif length is not None:
            natural = check_moderate(subject, length, "m")
        elasticity = check_moderate("stiffness of a rope", stiffness, "N")
        given = length if callable(length) or length is None else natural
        rope = Rope(ends, elasticity, viscosity, natural, width, change, given)
        record = RopeSpec(places, elasticity, viscosity, given, width)
        return self._attach(rope, record)
