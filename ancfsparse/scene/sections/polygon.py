"""Polygonal sections: moments of area and torsion."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.array_types import Complex
from ancfsparse.checks import check_positive, check_reals, set_fields
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.sections.cross_section import (
    MAX_PRODUCT_MOMENT,
    CrossSection,
    check_side,
)
from ancfsparse.scene.sections.torsion import torsion_constant

Corners = tuple[tuple[float, float], ...]

MAX_CORNERS = 100  # for which torsion is solved in a second or two
MIN_EDGE = 1e-12  # over the size of the section


@dataclass(frozen=True)
class Polygon(CrossSection):
    """A section with straight edges, with or without holes.

    Its moments are about its centroid, through which the axis of a beam passes.  If its
    `inertia_yz` is not zero, the frame of a beam is rotated by `principal_angle` from y and z; the
    corners keep their positions.

    Parameters
    ----------
    corners : array_like, shape (n, 2)
        Corners of the outline in order [m], y (the height) and z of each.
    holes : sequence of array_like, optional
        Corners of every hole likewise.
    shear_factor : float, optional
        Shear correction factor k, the same for y and z.  The default 5/6 is the value of a
        rectangle at Poisson's ratio 0.

    Examples
    --------
    >>> angle = ancf.Polygon([(0, 0), (0.1, 0), (0.1, 0.01), (0.01, 0.01), (0.01, 0.1), (0, 0.1)])
    >>> section = angle.principal()
    """

    corners: Corners
    holes: tuple[Corners, ...] = ()
    shear_factor: float = 5.0 / 6.0
    can_taper = False

    def __post_init__(self) -> None:
        """Check the corners and store them as tuples."""
        outline = _corners("corners of the polygon", self.corners)
        if not isinstance(self.holes, list | tuple):
            raise InputError(
                f"holes of a polygon must be a list of corners, got {format_value(self.holes)}"
            )
        holes = [_corners(f"hole {k} of the polygon", hole) for k, hole in enumerate(self.holes)]
        set_fields(
            self,
            corners=_as_tuples(outline),
            holes=tuple(map(_as_tuples, holes)),
            shear_factor=check_positive("shear_factor of the polygon", self.shear_factor),
        )
        n = sum(map(len, (outline, *holes)))
        if n > MAX_CORNERS:
            raise InputError(
                f"the polygon has {n} corners, more than the {MAX_CORNERS} for which torsion is "
                "solved: take fewer, or a Section with its numbers"
            )
        check_side("extent of the polygon", float(np.ptp(outline, axis=0).max()))
        _check_edges([outline, *holes])
        if any(not _inside(hole, outline) for hole in holes):
            raise InputError("a hole of the polygon lies outside of it")

    @cached_property
    def _loops(self) -> list[Complex]:
        """Corners y + i z: of the outline counterclockwise, of holes clockwise."""
        loops = [np.array(corners) @ [1.0, 1j] for corners in (self.corners, *self.holes)]
        areas = [(np.conj(loop) * np.roll(loop, -1)).imag.sum() for loop in loops]
        return [
            loop if (area > 0.0) == (k == 0) else loop[::-1]
            for k, (loop, area) in enumerate(zip(loops, areas, strict=True))
        ]

    @cached_property
    def _moments(self) -> tuple[float, complex, complex, float]:
        """Area, centroid, and int w^2 dA and int |w|^2 dA of w = y + i z about it."""
        origin = self._loops[0][0]
        area, moment, square, polar = 0.0, 0j, 0j, 0.0
        for loop in self._loops:
            a, b = loop - origin, np.roll(loop, -1) - origin
            cross = (np.conj(a) * b).imag
            area += float(cross.sum()) / 2.0
            moment += complex((cross * (a + b)).sum()) / 6.0
            square += complex((cross * (a * a + a * b + b * b)).sum()) / 12.0
            product = np.abs(a) ** 2 + (np.conj(a) * b).real + np.abs(b) ** 2
            polar += float((cross * product).sum()) / 12.0
        centroid = moment / area
        square, polar = square - area * centroid**2, polar - area * abs(centroid) ** 2
        return area, origin + centroid, square, polar

    @property
    def area(self) -> float:
        """Area [m2]."""
        return self._moments[0]

    @property
    def centroid(self) -> tuple[float, float]:
        """Centroid (y, z), through which the axis of a beam passes, like the corners [m]."""
        centroid = self._moments[1]
        return centroid.real, centroid.imag

    @property
    def inertia_y(self) -> float:
        """Second moment of area int z^2 dA about the centroid, for bending about y [m4]."""
        return 0.5 * (self._moments[3] - self._moments[2].real)

    @property
    def inertia_z(self) -> float:
        """Second moment of area int y^2 dA about the centroid, for bending about z [m4]."""
        return 0.5 * (self._moments[3] + self._moments[2].real)

    @property
    def inertia_yz(self) -> float:
        """Product moment of area int y z dA about the centroid [m4]."""
        return 0.5 * self._moments[2].imag

    @property
    def is_principal(self) -> bool:
        """True if y and z are principal axes, to rounding."""
        return abs(self.inertia_yz) <= MAX_PRODUCT_MOMENT * self._moments[3]

    @property
    def principal_angle(self) -> float:
        """Angle from y, towards z, to the principal axis nearest to it [rad], -pi/4 to pi/4."""
        square = self._moments[2]
        if self.is_principal:
            return 0.0
        angle = 0.5 * math.atan2(square.imag, square.real)
        return (
            angle if abs(angle) <= 0.25 * math.pi else angle - math.copysign(0.5 * math.pi, angle)
        )

    def principal(self) -> Polygon:
        """Return the section with its principal axes along y and z, about its centroid.

        It is rotated by minus `principal_angle`; a beam keeps the section in its place if it is
        rotated by `principal_angle` about e_x, by `up` or `twist`.
        """
        rotation = complex(math.cos(self.principal_angle), -math.sin(self.principal_angle))
        centroid = self._moments[1]
        loops = [
            tuple(
                (w.real, w.imag)
                for w in ((complex(y, z) - centroid) * rotation for y, z in corners)
            )
            for corners in (self.corners, *self.holes)
        ]
        return Polygon(loops[0], tuple(loops[1:]), self.shear_factor)

    @cached_property
    def torsion_constant(self) -> float:
        """Saint-Venant's torsion constant J without restraint of warping [m4].

        Notes
        -----
        Rational functions with poles at the corners are fitted and refined until J changes by less
        than 1e-5 of its value (`ancfsparse/scene/sections/torsion.py`).
        """
        return torsion_constant(self._loops)[0]


def _corners(what: str, value: ArrayLike) -> NDArray[np.float64]:
    """Return at least three finite corners, (n, 2)."""
    needed = "at least three corners of two finite numbers, y and z"
    table = check_reals(what, value, needed)
    if table.ndim != 2 or table.shape[1] != 2 or len(table) < 3 or not np.isfinite(table).all():
        raise InputError(f"{what} must be {needed}, got {format_value(value)}")
    return table


def _as_tuples(table: NDArray[np.float64]) -> Corners:
    return tuple((float(y), float(z)) for y, z in table)


def _inside(loop: NDArray[np.float64], outline: NDArray[np.float64]) -> bool:
    """Return True if a loop that does not cross an outline is inside, by the winding number."""
    to_outline = (outline - loop[0]) @ [1.0, 1j]
    return bool(abs(np.angle(np.roll(to_outline, -1) / to_outline).sum()) > math.pi)


def _check_edges(loops: list[NDArray[np.float64]]) -> None:
    """Refuse edges that meet others than their neighbours, and edges of zero length."""
    starts = np.concatenate(loops) @ [1.0, 1j]
    ends = np.concatenate([np.roll(loop, -1, axis=0) for loop in loops]) @ [1.0, 1j]
    along, size = ends - starts, np.abs(starts - starts.mean()).max()
    short = np.abs(along) <= MIN_EDGE * size
    if short.any():
        raise InputError(
            f"corner {int(np.argmax(short))} of the polygon and the next are one: leave one out"
        )
    for i in range(len(starts)):
        with np.errstate(divide="ignore", invalid="ignore"):
            cross = (np.conj(along[i]) * along).imag
            offset = starts - starts[i]
            on_first = (np.conj(offset) * along).imag / cross
            on_second = (np.conj(offset) * along[i]).imag / cross
        crossing = (on_first >= 0.0) & (on_first <= 1.0) & (on_second >= 0.0) & (on_second <= 1.0)
        crossing &= (starts != ends[i]) & (ends != starts[i])
        crossing[i] = False
        if crossing.any():
            j = int(np.argmax(crossing))
            raise InputError(
                f"edges {i} and {j} of the polygon meet, counted from its first corner on: give "
                "the corners in order around the section, and holes inside it"
            )
