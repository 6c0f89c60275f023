"""Points of a section beside its centroid."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.checks import check_finite, check_reals
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.meshing.straight_beam import check_position
from ancfsparse.scene.sections.sections import Taper, principal_axes

if TYPE_CHECKING:
    from ancfsparse.scene.bodies.beam import Beam

Offsets = tuple[float, ...]

# Components of unit vectors that differ by no more are those of one direction.
EVEN = 1e-9


def offsets_of(beam: Beam, y: object, z: object) -> Offsets:
    """Return the coordinates of a point of a section along r_x, r_y (and r_z) of its beam [m].

    Parameters
    ----------
    beam : Beam
        The beam.
    y, z : float
        The point in the axes of the section, from its centroid [m].

    Returns
    -------
    tuple of float
        Empty for the centroid itself.

    Raises
    ------
    InputError
        If a coordinate is not finite, or the vectors of the section do not turn as a section does.
    """
    up = check_finite(f"y of a point of {beam.name}", y, "m")
    side = check_finite(f"z of a point of {beam.name}", z, "m")
    if side and beam.dim == 2:
        raise InputError(
            f"z of a point of {beam.name} has no meaning in a planar scene, got {side:.6g} m: "
            "leave it out"
        )
    if not (up or side):
        return ()
    check_sections(beam)
    check_position(f"a point of {beam.name} beside its axis", (up, side), 2)
    if beam.dim == 2:
        return 0.0, up
    angle = 0.0 if isinstance(beam.section, Taper) else principal_axes(beam.section)[0]
    c, s = math.cos(angle), math.sin(angle)
    return 0.0, c * up + s * side, c * side - s * up


def checked_offsets(beam: Beam, offsets: ArrayLike) -> Offsets:
    """Return the coordinates of such a point that are data, (0, y) or (0, y, z) [m]."""
    what = f"the offsets of a point of {beam.name}"
    along, *beside = check_position(what, offsets, beam.dim).tolist()
    if along:
        raise InputError(f"{what} are in its section and begin with 0, got {along:.6g} m")
    check_sections(beam)
    return 0.0, *beside


def beside_line(beam: Beam, offset: ArrayLike) -> Beam:
    """Move a straight beam so that its centroid is beside the line through its ends.

    Parameters
    ----------
    beam : Beam
        On the line.
    offset : float or array_like, shape (dim - 1,)
        From the line to the centroid in the axes of the section [m].

    Returns
    -------
    Beam
        The moved beam, whose nodes are points of the line.
    """
    what = f"offset of {beam.name}"
    needed = "a number of metres, y" if beam.dim == 2 else "two numbers of metres, (y, z)"
    place = np.atleast_1d(check_reals(what, offset, needed))
    if place.shape != (beam.dim - 1,):
        raise InputError(f"{what} must be {needed}, got {format_value(offset)}")
    if np.ptp(beam.frames, axis=0).max() > EVEN:
        raise InputError(
            f"{what} needs a straight beam, whose sections all point one way: give the curve of "
            f"its centroid, and attach to points such as rod.at(s, y={-float(place[0]):.6g})"
        )
    beside = offsets_of(beam, *place.tolist(), *(0.0,) * (3 - beam.dim))
    vectors = beam.vectors[0, : len(beside)]
    positions = beam.positions + np.array(beside) @ vectors if beside else beam.positions
    positions.flags.writeable = False
    return replace(beam, positions=positions, offset=beside)


def check_sections(beam: Beam) -> None:
    """Refuse beams without section vectors that alone turn with the section.

    With ``curvature="axis"`` a force beside the axis would turn r_y against r_x, by a shear of the
    last element that grows as elements become shorter.
    """
    if beam.automatic:
        raise InputError(
            f"{beam.name} has no points beside its axis before a plan has chosen its element and "
            "mesh: give both, element='thick' with curvature='section'"
        )
    if "r_y" not in beam.kind.section or "r_x" in beam.kind.section:
        own = beam.kind.is_cable or beam.kind.is_string
        what = "has no section vectors" if own else "turns its sections with the slope of the axis"
        raise InputError(
            f"{beam.name} has no points beside its axis, since its element {beam.element!r} "
            f"{what}: take element='thick' with curvature='section', or weld a rigid body to it"
        )
