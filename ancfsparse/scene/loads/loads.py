"""Loads: constant, or functions of time that return the load at time t [s]."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.checks import check_finite, check_reals, check_vector, set_fields
from ancfsparse.errors import InputError, LoadError, trial_call
from ancfsparse.messages import format_value
from ancfsparse.scene.bodies.body import Body, ElasticBody, Point
from ancfsparse.scene.records.record import At, BodyRef, PointRef, Spec, text
from ancfsparse.scene.records.transferable_functions import sendable

Vector = NDArray[np.float64]
# How a single number is read in the force that follows a cable in space.
ALONG = "one number along the axis, the only axis that a cable has in space"
Value = ArrayLike | Callable[[float], ArrayLike]


class Applied(ABC):
    """What all loads have in common.

    It can be sent to another process, if need be without its function of time.

    Attributes
    ----------
    value : number, ndarray or callable
        The load, or a function of t [s] that returns it.
    """

    value: Value
    unit: ClassVar[str]
    number: ClassVar[str] = "one number about +z because the scene is planar"

    def __post_init__(self) -> None:
        """Try the load out, and keep a constant one as a checked number or vector."""
        with trial_call():
            now = self.at(0.0)
        if not callable(self.value):
            set_fields(self, value=now if self.shape else float(now[0]))

    def __getstate__(self) -> dict[str, Any]:
        """Give what is pickled."""
        return self.__dict__ | {"value": sendable(self.__dict__["value"])}

    @property
    @abstractmethod
    def what(self) -> str:
        """Name of the load in messages."""

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Shape of a value: ``(dim,)``, or ``()`` for a number."""

    def at(self, t: float) -> Vector:
        """Give the load at time `t` [s], shape (dim,) or (1,) [`unit`].

        Raises
        ------
        InputError
            If a constant load is invalid; a `LoadError` if it is a function.
        """
        if not callable(self.value):
            return self._checked(self.what, self.value)
        try:
            now = self.value(t)
        except Exception as error:  # a function of the caller's may raise anything
            raise self.failure(t, error) from error
        return self.checked(t, now)

    def checked(self, t: float, now: ArrayLike) -> Vector:
        """Return what a function of time has returned, shape (dim,) or (1,), if it is a load.

        Raises
        ------
        LoadError
            If it is invalid.
        """
        try:
            return self._checked(f"{self.what}, a function of time, at t = {t:.6g} s,", now)
        except InputError as wrong:
            raise LoadError(str(wrong), t) from None

    def failure(self, t: float, error: Exception) -> LoadError:
        """Return the error for a function that raised one."""
        kind = "" if isinstance(error, InputError) else f"{type(error).__name__}: "
        reason = f"{kind}{error}".rstrip(": ")
        return LoadError(f"{self.what}, a function of time, failed at t = {t:.6g} s: {reason}", t)

    def _checked(self, name: str, value: ArrayLike) -> Vector:
        if self.shape:
            return check_vector(name, value, self.shape[0], self.unit)
        if check_reals(name, value, self.number).ndim:
            raise InputError(f"{name} must be {self.number}, got {format_value(value)}")
        return np.array([check_finite(name, value, self.unit)])


@dataclass(frozen=True, eq=False)
class LoadSpec(Spec):
    """What the records of all loads have in common."""

    def describe(self, at: At, made: Any) -> str:
        """Describe its position and its value."""
        where, value, *more = self.given.values()
        words = "".join(
            f", {name} {text(each, at)}"
            for name, each in zip([*self.given][2:], more, strict=True)
            if each is not None and each is not False
        )
        return f"{type(made).__name__} ({at(where)}): {text(value, at)}{words}"


@dataclass(frozen=True, eq=False)
class PointForceSpec(LoadSpec):
    """The record of `Scene.point_force`."""

    node: PointRef
    value: Any
    follow: bool = False
    method = "point_force"
    units: ClassVar = {"value": "N"}


@dataclass(frozen=True, eq=False)
class PointMomentSpec(LoadSpec):
    """The record of `Scene.point_moment`."""

    node: PointRef
    value: Any
    follow: bool = False
    method = "point_moment"
    units: ClassVar = {"value": "N m"}


@dataclass(frozen=True, eq=False)
class DistributedForceSpec(LoadSpec):
    """The record of `Scene.distributed_force`."""

    beam: BodyRef
    value: Any
    shape: Any = None
    follow: bool = False
    method = "distributed_force"
    units: ClassVar = {"value": "N/m"}


@dataclass(frozen=True, eq=False)
class ChangingGravitySpec(Spec):
    """The record of `Scene.changing_gravity`."""

    value: Any
    method = "changing_gravity"
    units: ClassVar = {"value": "m/s2"}


@dataclass(frozen=True, eq=False)
class PointForce(Applied):
    """A force at a point, fixed in space or along the axes of the section.

    Attributes
    ----------
    node : Point
        Where it acts; any point of a beam or of a rigid body.
    value : number, ndarray of shape (dim,), or callable
        The force [N], or a function of t [s] that returns it; see `Scene.point_force`.
    follow : bool
        Whether it follows the section.
    """

    node: Point
    value: Value
    follow: bool = False
    unit = "N"
    number = ALONG

    @property
    def what(self) -> str:
        """Name of the load in messages."""
        return f"the force on {self.node!r}"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a value: (dim,), or () along the axis of a cable in space."""
        return _components(self.node.beam, self.follow)


@dataclass(frozen=True, eq=False)
class PointMoment(Applied):
    """A moment at a node, about axes of space or of the section.

    Attributes
    ----------
    node : Point
        Where it acts.
    value : float, ndarray of shape (3,), or callable
        The moment [N m], or a function of t [s] that returns it: a number about +z in a planar
        scene, three components in a spatial one.
    follow : bool
        Whether its axes follow the section.
    """

    node: Point
    value: Value
    follow: bool = False
    unit = "N m"

    @property
    def what(self) -> str:
        """Name of the load in messages."""
        return f"the moment on {self.node!r}"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a value: () in a planar scene, else (3,)."""
        return () if self.node.beam.dim == 2 else (3,)


@dataclass(frozen=True, eq=False)
class DistributedForce(Applied):
    """A force per reference length along a whole beam or mesh.

    Attributes
    ----------
    beam : Beam or Mesh
        Where it acts.
    value : number, ndarray of shape (dim,), or callable
        The force per length [N/m], or a function of t [s] that returns it.
    along : callable or None
        Factor of the force as a function of the arc coordinate s [m].
    follow : bool
        Whether it follows the sections.
    """

    beam: ElasticBody
    value: Value
    along: Callable[[float], float] | None = None
    follow: bool = False
    unit = "N/m"
    number = ALONG

    def __getstate__(self) -> dict[str, Any]:
        """Give what is pickled."""
        return super().__getstate__() | {"along": sendable(self.along)}

    @property
    def what(self) -> str:
        """Name of the load in messages."""
        return f"the distributed force on {self.beam.name}"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a value: (dim,), or () along the axis of a cable in space."""
        return _components(self.beam, self.follow)

    def factors(self, arcs: Vector) -> Vector:
        """Return the factor at arc coordinates [m], of any shape [-].

        Raises
        ------
        InputError
            If the function fails, or returns no finite number.
        """
        if self.along is None:
            return np.ones_like(arcs)
        out = np.empty_like(arcs)
        for k, s in enumerate(arcs.ravel().tolist()):
            name = f"the shape of {self.what} at s = {s:.6g} m"
            try:
                value = self.along(s)
            except Exception as error:  # a function of the caller's may raise anything
                raise InputError(f"{name} failed: {type(error).__name__}: {error}") from error
            out.flat[k] = check_finite(name, value)
        return out


@dataclass(frozen=True, eq=False)
class ChangingGravity(Applied):
    """A uniform acceleration of all masses, in addition to that of gravity.

    Attributes
    ----------
    dim : int
        Of the scene.
    value : ndarray, shape (dim,), or callable
        The acceleration [m/s2], or a function of t [s] that returns it.
    """

    dim: int
    value: Value
    unit = "m/s2"

    @property
    def what(self) -> str:
        """Name of the load in messages."""
        return "the changing gravity"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a value, (dim,)."""
        return (self.dim,)


def _components(body: Body, follow: bool) -> tuple[int, ...]:
    """Return the shape of a force: a cable in space has one axis alone."""
    return () if follow and body.dim == 3 and len(body.kind.vectors) <= 2 else (body.dim,)


Load = PointForce | PointMoment | DistributedForce | ChangingGravity
