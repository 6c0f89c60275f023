"""Beams: their records, and their handles for joints, loads and results."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_finite, check_vector
from ancfsparse.errors import InputError
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.kernels.hermite import position_weights
from ancfsparse.messages import format_numbers
from ancfsparse.scene import bodies
from ancfsparse.scene.bodies.body import Point, VelocityField
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.bodies.element_choice import left_out
from ancfsparse.scene.records.record import PointRef, Record, as_data
from ancfsparse.scene.sections.cross_section import AnySection
from ancfsparse.scene.sections.material import Material

if TYPE_CHECKING:
    from ancfsparse.scene.geometry.curves import Angle, Direction
    from ancfsparse.scene.geometry.splines import AnyCurve
    from ancfsparse.scene.records.plane import Plane
    from ancfsparse.scene.records.signal import Signal

NODE_TOLERANCE = 1e-9  # distance of a point that is a node, over the length of an element


@dataclass(frozen=True, eq=False, kw_only=True)
class BeamSpec(Record):
    """The record of `Scene.add_beam`."""

    element: str | ElementKind
    start: ArrayLike | None = None
    end: ArrayLike | None = None
    n_elements: int | str | None
    section: AnySection
    material: Material
    strain: str | None = None
    curvature: str | None = None
    section_strain: str | None = None
    curve: AnyCurve | None = None
    rest: str = "curved"
    nodes: ArrayLike | None = None
    length: float | None = None
    tension: float | None = None
    slack: float | None = None
    up: Direction = None
    twist: Angle = None
    offset: Any = None
    eigenstrain: Any = None
    eigencurvature: Any = None
    velocity: ArrayLike | VelocityField | None = None
    name: Any = None
    method = "add_beam"
    units: ClassVar = {
        "start": "m",
        "end": "m",
        "velocity": "m/s",
        "length": "m",
        "tension": "N",
        "twist": "rad",
        "offset": "m",
        "eigencurvature": "1/m",
    }

    def __post_init__(self) -> None:
        """Keep the arguments as they are: they are checked when the beam is built."""

    def project(self, handle: Beam, plane: Plane) -> BeamSpec:
        """Return the record of a straight beam, or of one through points, for a planar scene."""
        has_points = self.curve is None or isinstance(self.curve, np.ndarray | tuple)
        others = self.eigenstrain, self.eigencurvature, self.twist
        is_plain = has_points and not callable(self.up) and all(each is None for each in others)
        if not is_plain or handle.section.frame_angle:
            plane.refuse()
        is_upright = handle.kind.section[1:] and not plane.is_normal(handle.frames[:, 2])
        if is_upright:
            plane.across(handle.frames[:, 1])
        return replace(
            self,
            **handle.planar_arguments(self, plane),
            start=plane.project(self.start, "put"),
            end=plane.project(self.end, "put"),
            curve=None if self.curve is None else plane.put(np.asarray(self.curve)),
            section=handle.section.rotate() if is_upright else handle.section,
            up=None,
        )

    def checked(self, beam: Beam) -> BeamSpec:
        """Return the record as plain data, with the checked values of the beam built from it."""
        ends: dict[str, Any] = {
            name: None if value is None else tuple(check_vector(name, value, beam.dim).tolist())
            for name, value in (("start", self.start), ("end", self.end))
        }
        arguments = (
            "curve", "length", "tension", "slack", "up", "twist", "offset", "eigenstrain",
            "eigencurvature", "velocity",
        )  # fmt: skip
        return replace(
            self,
            n_elements="auto" if "n_elements" in beam.automatic else beam.n_elements,
            nodes=beam.nodes,
            **ends,
            **left_out(self),
            **{name: as_data(getattr(self, name)) for name in arguments},
        )


def relocate(index: int, xi: float, n: int, n_new: int) -> tuple[int, float]:
    """Return the element of a point, and xi in it, on a mesh with another number of elements.

    Parameters
    ----------
    index : int
        Number of its element, or of its node if `xi` is 0.
    xi : float
        Fraction of the length of the element.
    n, n_new : int
        Integers of elements, before and after.

    Returns
    -------
    index : int
        Number of the new element or node.
    xi : float
        Fraction in the new element, exact if every element is divided.
    """
    common = math.gcd(n, n_new)
    n, n_new = n // common, n_new // common
    quotient, remainder = divmod(index * n_new, n)
    position = (remainder + xi * n_new) / n
    nearest = round(position)
    if abs(position - nearest) <= NODE_TOLERANCE:
        return quotient + nearest, 0.0
    return quotient + int(position), position - int(position)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Beam(ElasticBody):
    """A beam in a scene, as `Scene.add_beam` returns it.

    Attributes
    ----------
    name, element, options, kind, section, material, positions, lengths, velocity
        As in `ElasticBody`.
    arcs : ndarray, shape (n_nodes,)
        Arc coordinates of the nodes, measured without stress from the start [m], read-only.
    frames : ndarray, shape (n_nodes or 1, dim, dim)
        Rows are the unit vectors e_x (along the beam), e_y and, in a spatial scene, e_z of the
        section at every node in the reference shape, or one for all, read-only.
    nodes : tuple of float, or None
        Positions of the nodes as fractions of the length, if specified.
    offset : tuple of float
        Offset of the centroid from the line through the ends, along the vectors of its sections
        [m]; empty if it is on the line.
    eigen : ndarray, shape (n_elements, 2 or 3), or None
        Eigenstrain [-] and eigencurvature [1/m] of every element, read-only.
    changing : tuple of (Signal or None, Signal or None), or None
        Signals added to both, the same in all elements.
    """

    arcs: Vector
    frames: Vector
    nodes: tuple[float, ...] | None = None
    offset: tuple[float, ...] = ()
    eigen: Vector | None = None
    changing: tuple[Signal | None, Signal | None] | None = None

    def __repr__(self) -> str:
        """Identify the beam."""
        count = "auto" if "n_elements" in self.automatic else str(self.n_elements)
        element = "auto" if "element" in self.automatic else self.element
        return (
            f"{self.name}: {count} {element} elements, {self.length:.6g} m, "
            f"{'planar' if self.dim == 2 else 'spatial'}"
        )

    @property
    def length(self) -> float:
        """Length without stress [m]."""
        return float(self.arcs[-1])

    @property
    def _is_uniform(self) -> bool:
        """True if it is straight, with elements of one length."""
        return len(self.frames) == 1

    @property
    def axes(self) -> Vector:
        """Unit vectors of the section at the start, shape (dim, dim)."""
        return np.asarray(self.frames[0])

    def describe(self) -> dict[str, str]:
        """Return element, section, material, mesh, length and eigenstrains, for the digest."""
        parts = super().describe()
        if self.kind.is_curved and not self.kind.package:
            parts["element"] += " curved"
        if not self._is_uniform:
            parts["mesh"] += f", {self.length:.9g} m"
        if self.eigen is not None:
            parts["eigenstrain"] = format_numbers(self.eigen.ravel())
        if self.changing is not None:
            signals = ("none" if x is None else x.describe() for x in self.changing)
            parts["eigenstrain"] += f" + {', '.join(signals)}"
        return parts

    def free_of_stress(self, ends: Vector) -> Vector:
        """Return the stress-free coordinates of both nodes of every element, (n, 2, n_c)."""
        if self.eigen is None:
            return ends
        return bodies.strained_ends(self.kind, ends, self.lengths, self.eigen)

    def free_of_stress_at(self, ends: Vector, elements: NDArray[np.intp], times: Vector) -> Vector:
        """Return the same for some elements at many times of a time-dependent eigenstrain."""
        assert self.eigen is not None
        eigen = self.eigen[elements] + self.eigen_changes(times)[:, None]
        all_ends = np.tile(ends[elements], (len(times), 1, 1))
        lengths = np.tile(self.lengths[elements], len(times))
        return bodies.strained_ends(self.kind, all_ends, lengths, eigen.reshape(len(lengths), -1))

    @property
    def strains_change(self) -> bool:
        """True if its stress-free shape changes with time."""
        return self.changing is not None

    def eigen_changes(self, times: Vector) -> Vector:
        """Return the time-dependent eigenstrain and eigencurvature, (k, width) [-, 1/m]."""
        assert self.changing is not None
        out = np.zeros((len(times), 2 if self.dim == 2 else 3))
        strain, curvature = self.changing
        if strain is not None:
            out[:, 0] = strain(times)
        if curvature is not None:
            out[:, 1:] = curvature(times).reshape(len(times), -1)
        return out

    @property
    def size(self) -> float:
        """Its length [m]."""
        return self.length

    def among(self, n_each: int, point: Point) -> PointRef:
        """Return a reference to the same point of a beam with another number of elements."""
        if n_each % self.n_elements and np.ptp(self.lengths) > NODE_TOLERANCE * self.shortest:
            raise InputError(
                f"{point!r} cannot be moved to {n_each} elements, since {self.name} has specified "
                f"nodes: take a multiple of {self.n_elements}"
            )
        index, xi = relocate(point.index, point.xi, self.n_elements, n_each)
        return PointRef(self.name, index, xi, point.offsets)

    def finer(self, times: int) -> dict[str, Any]:
        """Return the arguments that change if every element is divided."""
        changes = super().finer(times)
        if self.nodes is not None:
            inner = np.arange(times * self.n_elements + 1) / times
            nodes = np.interp(inner, np.arange(len(self.nodes)), self.nodes)
            changes["nodes"] = tuple(nodes.tolist())
        return changes

    @property
    def profile(self) -> Any:
        """Section, or its means over elements if it changes."""
        return self.section.average_over(self.arcs / self.length)

    def arc(self, point: Point) -> float:
        """Return the distance of a point from the start along the undeformed axis [m]."""
        if self._is_uniform:
            return (point.index + point.xi) / self.n_elements * self.length
        inside = point.xi * self.lengths[point.index] if point.xi else 0.0
        return float(self.arcs[point.index] + inside)

    def inside(self, element: int, xi: float) -> Vector:
        """Return the position of a point inside an element in the reference shape, (dim,) [m]."""
        if len(self.vectors) == 1 or self.kind.is_string:
            return super().inside(element, xi)
        tail, head = self.ends[element]
        r, slopes = self.positions, self.vectors[:, 0]
        weights = position_weights(xi, self.lengths[element])
        return np.asarray(weights @ [r[tail], slopes[tail], r[head], slopes[head]])

    def axes_of(self, row: int) -> Vector:
        """Return the unit vectors of the section at a node, shape (dim, dim)."""
        return np.asarray(self.frames[min(row, len(self.frames) - 1)])

    def say(self, point: Point) -> str:
        """Return the location of a point, for messages."""
        pairs = zip("yz", point.offsets[1:], strict=False)
        offset = "".join(f", {name} = {value:.6g} m" for name, value in pairs)
        return f"{self.name} at s = {self.arc(point):.6g} m{offset}"

    def hint(self, point: Point) -> str:
        """Return a hint which node to use instead of a point inside an element."""
        return (
            f"the nodes are {self.length / self.n_elements:.6g} m apart, take "
            f"rod.node({round(point.index + point.xi)}) or choose n_elements so that a node falls "
            "there"
        )

    @property
    def start(self) -> Point:
        """The first node."""
        return self.node(0)

    @property
    def end(self) -> Point:
        """The last node."""
        return self.node(self.n_elements)

    @property
    def default_point(self) -> Point:
        """Its end."""
        return self.end

    def node(self, i: int) -> Point:
        """Return a node; for a beam with an `offset`, the point of its line at the node.

        Parameters
        ----------
        i : int
            Number of the node, from 0.
        """
        return replace(super().node(i), offsets=self.line)

    @property
    def line(self) -> tuple[float, ...]:
        """Offset of the line through the ends from the centroid, along the section vectors [m]."""
        return tuple(0.0 - x for x in self.offset)

    def at(self, s: float, *, y: float | None = None, z: float | None = None) -> Point:
        """Return a point of the section at an arc coordinate of the reference shape.

        Parameters
        ----------
        s : float
            Distance from the start along the undeformed axis [m], 0 to ``length``.
        y, z : float, optional
            Position in the section, from its centroid along its height and width [m].  The default
            is a point of the axis, or for a beam with an `offset` of the line through its ends.  A
            force acts on the section together with its moment about the centroid.  Requires
            ``"thick"`` with ``curvature="section"``.

        Returns
        -------
        Point
            A node if `s` is that of a node (to rounding), else a point inside an element.
        """
        point = self._at(s)
        if y is None and z is None:
            return point
        return replace(
            point, offsets=bodies.offsets_of(self, 0.0 if y is None else y, 0.0 if z is None else z)
        )

    def point(self, reference: PointRef) -> Point:
        """Return the handle of a point from its reference."""
        point = super().point(replace(reference, offsets=()))
        if not reference.offsets:
            return replace(point, offsets=())
        return replace(point, offsets=bodies.checked_offsets(self, reference.offsets))

    def _at(self, s: float) -> Point:
        distance = check_finite(f"arc coordinate s on {self.name}", s, "m")
        position = distance / self.length * self.n_elements
        if not self._is_uniform:
            i = int(np.clip(np.searchsorted(self.arcs, distance) - 1, 0, self.n_elements - 1))
            position = i + (distance - float(self.arcs[i])) / float(self.lengths[i])
        if not -NODE_TOLERANCE <= position <= self.n_elements + NODE_TOLERANCE:
            raise InputError(
                f"arc coordinate s = {distance:.6g} m lies outside {self.name}: "
                f"it runs from 0 to {self.length:.6g} m"
            )
        nearest = round(position)
        if abs(position - nearest) <= NODE_TOLERANCE:
            return Point(self, nearest, 0.0, self.line)
        return Point(self, int(position), position - int(position), self.line)

    def corresponding_point(self, handle: Point) -> Point:
        """Return the point at the same fraction of the length."""
        last = handle.index == handle.beam.n_elements
        return self.end if last else self.at(handle.s * (self.length / handle.beam.size))

    def parameters(self) -> dict[str, float]:
        """Return the parameters of the kernels, the same for every element of the beam.

        Returns
        -------
        dict of str to float
            ``length`` of one element [m], and what `stiffnesses` gives.
        """
        return {"length": self.length / self.n_elements, **self.stiffnesses()}
