"""Loads: constant, or functions of time that return the load at time t [s]."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.checks import check_finite, check_reals, check_vector, shown
from ancfsparse.errors import InputError
from ancfsparse.scene.bodies import Body, Node
from ancfsparse.scene.functions import sendable

Vector = NDArray[np.float64]
Value = ArrayLike | Callable[[float], ArrayLike]


class Sendable:
    """A load that can be sent to another process, if need be without its function of time."""

    def __getstate__(self) -> dict[str, Any]:
        """Give what is pickled."""
        return self.__dict__ | {"value": sendable(self.__dict__["value"])}


@dataclass(frozen=True, eq=False)
class PointForce(Sendable):
    """A force at a point of a beam, fixed in space.

    Attributes
    ----------
    node : Node
        Where it acts; any point of a beam.
    value : ndarray, shape (dim,), or callable
        The force [N], or a function of t [s] that returns it.
    """

    node: Node
    value: Value

    def __post_init__(self) -> None:
        """Try the load out, and keep a constant one as a checked vector."""
        now = self.at(0.0)
        if not callable(self.value):
            object.__setattr__(self, "value", now)

    def at(self, t: float) -> Vector:
        """Give the force at time `t` [s], shape (dim,) [N]."""
        return vector_at(f"the force on {self.node!r}", self.value, t, self.node.beam.dim, "N")


@dataclass(frozen=True, eq=False)
class PointMoment(Sendable):
    """A moment at a node of a beam, fixed in space.

    Attributes
    ----------
    node : Node
        Where it acts.
    value : float, ndarray of shape (3,), or callable
        The moment [N m], or a function of t [s] that returns it: a number about +z in a planar
        scene, three components in a spatial one.
    """

    node: Node
    value: Value

    def __post_init__(self) -> None:
        """Try the load out, and keep a constant one as a checked number or vector."""
        now = self.at(0.0)
        if not callable(self.value):
            object.__setattr__(self, "value", now if self.node.beam.dim == 3 else float(now[0]))

    def at(self, t: float) -> Vector:
        """Give the moment at time `t` [s], shape (1,) in a planar scene, else (3,) [N m]."""
        what = f"the moment on {self.node!r}"
        if self.node.beam.dim == 3:
            return vector_at(what, self.value, t, 3, "N m")
        value = self.value(t) if callable(self.value) else self.value
        name = _at_time(what, self.value, t)
        needed = "one number about +z because the scene is planar"
        if check_reals(name, value, needed).ndim:
            raise InputError(f"{name} must be {needed}, got {shown(value)}")
        return np.array([check_finite(name, value, "N m")])


@dataclass(frozen=True, eq=False)
class DistributedForce(Sendable):
    """A force per reference length along a whole beam or mesh, fixed in space.

    Attributes
    ----------
    beam : Beam or Mesh
        Where it acts.
    value : ndarray, shape (dim,), or callable
        The force per length [N/m], or a function of t [s] that returns it.
    """

    beam: Body
    value: Value

    def __post_init__(self) -> None:
        """Try the load out, and keep a constant one as a checked vector."""
        now = self.at(0.0)
        if not callable(self.value):
            object.__setattr__(self, "value", now)

    def at(self, t: float) -> Vector:
        """Give the force per length at time `t` [s], shape (dim,) [N/m]."""
        what = f"the distributed force on {self.beam.name}"
        return vector_at(what, self.value, t, self.beam.dim, "N/m")


Load = PointForce | PointMoment | DistributedForce


def vector_at(what: str, value: Value, t: float, dim: int, unit: str) -> Vector:
    """Evaluate a vector load and check what comes out.

    Parameters
    ----------
    what : str
        Name of the load in the message.
    value : ndarray or callable
        The load or a function of time.
    t : float
        Time [s].
    dim : int
        Number of components it must have.
    unit : str
        Its unit in the message.

    Returns
    -------
    ndarray, shape (dim,)
        The load at that time.
    """
    now = value(t) if callable(value) else value
    return check_vector(_at_time(what, value, t), now, dim, unit)


def _at_time(what: str, value: Value, t: float) -> str:
    return f"{what}, a function of time, at t = {t:.6g} s," if callable(value) else what
