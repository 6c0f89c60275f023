"""Sections with straight edges: their moments, and their torsion by an own solution."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.checks import check_positive, check_reals, set_fields
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.sections.profiles import check_side
from ancfsparse.scene.sections.torsion import torsion_constant

Complex = NDArray[np.complex128]
Corners = tuple[tuple[float, float], ...]

# Corners that the solution of torsion takes in a second or two.
MOST_CORNERS = 100
# Share of the second moments by which axes may be off principal ones.
PRINCIPAL = 1e-9
# Share of the size by which an edge may meet another and not cross it.
MEETING = 1e-12


@dataclass(frozen=True)
class Polygon:
    """A section with straight edges, with or without holes.

    Its moments are about its centroid, through which the axis of a beam runs: where `centroid` is
    in the coordinates of the corners.  Where its `inertia_yz` is not zero, the frame of a beam is
    turned by `principal_angle` from y and z; the corners stay where they are.

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

    def __post_init__(self) -> None:
        """Check the corners and keep them as tuples."""
        outline = _corners("corners of the polygon", self.corners)
        if not isinstance(self.holes, list | tuple):
            raise InputError(
                f"holes of a polygon must be a list of corners, got {format_value(self.holes)}"
            )
        holes = [_corners(f"hole {k} of the polygon", each) for k, each in enumerate(self.holes)]
        set_fields(
            self,
            corners=_plain(outline),
            holes=tuple(map(_plain, holes)),
            shear_factor=check_positive("shear_factor of the polygon", self.shear_factor),
        )
        n = sum(map(len, (outline, *holes)))
        if n > MOST_CORNERS:
            raise InputError(
                f"the polygon has {n} corners, more than the {MOST_CORNERS} for which torsion is "
                "solved: take fewer, or a Section with its numbers"
            )
        check_side("extent of the polygon", float(np.ptp(outline, axis=0).max()))
        _check_edges([outline, *holes])
        if any(not _inside(hole, outline) for hole in holes):
            raise InputError("a hole of the polygon lies outside of it")

    @cached_property
    def _given(self) -> list[Complex]:
        """Corners y + i z: of the outline counterclockwise, of holes clockwise."""
        loops = [np.array(each) @ [1.0, 1j] for each in (self.corners, *self.holes)]
        turns = [(np.conj(loop) * np.roll(loop, -1)).imag.sum() > 0.0 for loop in loops]
        return [
            loop if turn == (k == 0) else loop[::-1]
            for k, (loop, turn) in enumerate(zip(loops, turns, strict=True))
        ]

    @cached_property
    def _moments(self) -> tuple[float, complex, complex, float]:
        """Area, centroid, and int w^2 dA and int |w|^2 dA of w = y + i z about it."""
        first = self._given[0][0]
        area, moment, square, size = 0.0, 0j, 0j, 0.0
        for loop in self._given:
            a, b = loop - first, np.roll(loop, -1) - first
            cross = (np.conj(a) * b).imag
            area += float(cross.sum()) / 2.0
            moment += complex((cross * (a + b)).sum()) / 6.0
            square += complex((cross * (a * a + a * b + b * b)).sum()) / 12.0
            product = np.abs(a) ** 2 + (np.conj(a) * b).real + np.abs(b) ** 2
            size += float((cross * product).sum()) / 12.0
        middle = moment / area
        square, size = square - area * middle**2, size - area * abs(middle) ** 2
        return area, first + middle, square, size

    @property
    def area(self) -> float:
        """Area [m2]."""
        return self._moments[0]

    @property
    def centroid(self) -> tuple[float, float]:
        """Centroid (y, z), through which the axis of a beam passes, like the corners [m]."""
        middle = self._moments[1]
        return middle.real, middle.imag

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
        """Whether y and z are principal axes, to rounding."""
        return abs(self.inertia_yz) <= PRINCIPAL * self._moments[3]

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

        It is turned back by `principal_angle`: with it, a beam that is to keep the section in its
        place turns by that angle about e_x, by `up` or `twist`.
        """
        turn = complex(math.cos(self.principal_angle), -math.sin(self.principal_angle))
        middle = self._moments[1]
        loops = [
            tuple((w.real, w.imag) for w in ((complex(y, z) - middle) * turn for y, z in each))
            for each in (self.corners, *self.holes)
        ]
        return Polygon(loops[0], tuple(loops[1:]), self.shear_factor)

    @cached_property
    def torsion_constant(self) -> float:
        """Saint-Venant's torsion constant J without restraint of warping [m4].

        Notes
        -----
        By a fit of rational functions with poles at the corners, refined until J changes by less
        than 1e-5 of it (`ancfsparse/scene/sections/torsion.py`).
        """
        return torsion_constant(self._given)[0]

    def shear_correction(self, poisson_ratio: float) -> float:
        """Shear correction factor k, as it was given.

        Parameters
        ----------
        poisson_ratio : float
            Poisson's ratio of the material; does not change the factor.

        Returns
        -------
        float
            The factor.
        """
        return self.shear_factor


def _corners(what: str, value: ArrayLike) -> NDArray[np.float64]:
    """Return at least three finite corners, (n, 2)."""
    needed = "at least three corners of two finite numbers, y and z"
    table = check_reals(what, value, needed)
    if table.ndim != 2 or table.shape[1] != 2 or len(table) < 3 or not np.isfinite(table).all():
        raise InputError(f"{what} must be {needed}, got {format_value(value)}")
    return table


def _plain(table: NDArray[np.float64]) -> Corners:
    return tuple((float(y), float(z)) for y, z in table)


def _inside(loop: NDArray[np.float64], outline: NDArray[np.float64]) -> bool:
    """Whether a loop that does not cross an outline is inside: it turns around its first corner."""
    to = (outline - loop[0]) @ [1.0, 1j]
    return bool(abs(np.angle(np.roll(to, -1) / to).sum()) > math.pi)


def _check_edges(loops: list[NDArray[np.float64]]) -> None:
    """Refuse edges that cross or meet others than their neighbours, and edges without length."""
    starts = np.concatenate(loops) @ [1.0, 1j]
    ends = np.concatenate([np.roll(loop, -1, axis=0) for loop in loops]) @ [1.0, 1j]
    along, size = ends - starts, np.abs(starts - starts.mean()).max()
    short = np.abs(along) <= MEETING * size
    if short.any():
        raise InputError(
            f"corner {int(np.argmax(short))} of the polygon and the next are one: leave one out"
        )
    for i in range(len(starts)):
        with np.errstate(divide="ignore", invalid="ignore"):
            cross = (np.conj(along[i]) * along).imag
            to = starts - starts[i]
            mine = (np.conj(to) * along).imag / cross
            other = (np.conj(to) * along[i]).imag / cross
        crossing = (mine >= 0.0) & (mine <= 1.0) & (other >= 0.0) & (other <= 1.0)
        crossing &= (starts != ends[i]) & (ends != starts[i])
        crossing[i] = False
        if crossing.any():
            j = int(np.argmax(crossing))
            raise InputError(
                f"edges {i} and {j} of the polygon meet, counted from its first corner on: give "
                "the corners in order around the section, and holes inside it"
            )
