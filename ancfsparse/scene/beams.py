"""Straight beams, as handles that joints, loads and results are asked with."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ancfsparse.checks import check_finite
from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import ElementKind
from ancfsparse.scene.bodies import ElasticBody, Node, Numbers, Vector, VelocityField
from ancfsparse.scene.material import Material
from ancfsparse.scene.sections import AnySection
from ancfsparse.scene.spec import Point, Spec

# A point closer to a node than this share of an element is that node: rounding, not a place.
NODE_SNAP = 1e-9


@dataclass(frozen=True, eq=False)
class BeamSpec(Spec):
    """The record of `Scene.add_beam`."""

    element: str | ElementKind
    start: tuple[float, ...]
    end: tuple[float, ...]
    n_elements: int
    section: AnySection
    material: Material
    strain: str = "green"
    curvature: str = "axis"
    section_strain: str = "consistent"
    up: tuple[float, ...] | None = None
    velocity: tuple[float, ...] | VelocityField | None = None
    name: str | None = None
    method = "add_beam"
    units: ClassVar = {"start": "m", "end": "m", "velocity": "m/s"}


def resettled(index: int, xi: float, n: int, to: int) -> tuple[int, float]:
    """Return the element that a point is in, and where in it, when n elements become others.

    Parameters
    ----------
    index : int
        Number of its element, or of its node if `xi` is 0.
    xi : float
        Share of the element's length.
    n, to : int
        Numbers of elements on one length, before and after.

    Returns
    -------
    index : int
        As before, among the new elements.
    xi : float
        Likewise; exact where every element is divided.
    """
    common = math.gcd(n, to)
    n, to = n // common, to // common
    whole, left = divmod(index * to, n)
    share = (left + xi * to) / n
    nearest = round(share)
    if abs(share - nearest) <= NODE_SNAP:
        return whole + nearest, 0.0
    return whole + int(share), share - int(share)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Beam(ElasticBody):
    """A straight beam in a scene, as `Scene.add_beam` returns it.

    Attributes
    ----------
    name, element, options, kind, section, material, positions, lengths, velocity
        As in `ElasticBody`; all elements are of one length.
    axes : ndarray, shape (dim, dim)
        Rows are the unit vectors e_x (along the beam), e_y and, in a spatial scene, e_z of the
        section in the reference shape, read-only.
    """

    axes: Vector

    def __repr__(self) -> str:
        """Say which beam this is."""
        return (
            f"{self.name}: {self.n_elements} {self.element} elements, {self.length:.6g} m, "
            f"{'planar' if self.dim == 2 else 'spatial'}"
        )

    @cached_property
    def length(self) -> float:
        """Length in the reference shape [m]."""
        return float(np.linalg.norm(self.positions[-1] - self.positions[0]))

    @property
    def size(self) -> float:
        """Its length [m]."""
        return self.length

    @property
    def parts(self) -> Numbers:
        """Zero for every row: a beam is one piece."""
        return np.zeros(self.n_nodes, dtype=np.int32)

    def among(self, n_each: int, point: Node) -> Point:
        """Return a point as data of a beam with another number of elements."""
        return Point(self.name, *resettled(point.index, point.xi, self.n_elements, n_each))

    def arc(self, point: Node) -> float:
        """Return the distance of a point from the start along the undeformed axis [m]."""
        return (point.index + point.xi) / self.n_elements * self.length

    def axes_of(self, row: int) -> Vector:
        """Return the unit vectors of the section, shape (dim, dim)."""
        return self.axes

    def say(self, point: Node) -> str:
        """Say where a point is."""
        return f"{self.name} at s = {self.arc(point):.6g} m"

    def hint(self, point: Node) -> str:
        """Say which node to take instead of a point inside an element."""
        return (
            f"the nodes are {self.length / self.n_elements:.6g} m apart, take "
            f"rod.node({round(point.index + point.xi)}) or choose n_elements so that a node falls "
            "there"
        )

    @property
    def start(self) -> Node:
        """The first node."""
        return Node(self, 0)

    @property
    def end(self) -> Node:
        """The last node."""
        return Node(self, self.n_elements)

    def at(self, s: float) -> Node:
        """Return the point at an arc coordinate of the reference shape.

        Parameters
        ----------
        s : float
            Distance from the start along the undeformed axis [m], 0 to ``length``.

        Returns
        -------
        Node
            A node where `s` falls on one (to rounding), else a point inside an element.
        """
        distance = check_finite(f"arc coordinate s on {self.name}", s, "m")
        share = distance / self.length * self.n_elements
        if not -NODE_SNAP <= share <= self.n_elements + NODE_SNAP:
            raise InputError(
                f"arc coordinate s = {distance:.6g} m lies outside {self.name}: "
                f"it runs from 0 to {self.length:.6g} m"
            )
        nearest = round(share)
        if abs(share - nearest) <= NODE_SNAP:
            return Node(self, nearest)
        return Node(self, int(share), share - int(share))

    def parameters(self) -> dict[str, float]:
        """Give the base parameters of the kernels, the same for every element of the beam.

        Returns
        -------
        dict of str to float
            ``length`` of one element [m], and what `stiffnesses` gives.
        """
        return {"length": self.length / self.n_elements, **self.stiffnesses()}
