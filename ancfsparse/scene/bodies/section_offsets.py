"""Points of a section at an offset from its centroid."""

from __future__ import annotations

import math

from numpy.typing import ArrayLike

from ancfsparse.checks import check_finite
from ancfsparse.errors import InputError
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.geometry.positions import check_position

Offsets = tuple[float, ...]


def offsets_of(beam: ElasticBody, y: object, z: object) -> Offsets:
    """Return the coordinates of a point of a section along r_x, r_y (and r_z) of its beam [m].

    The point is given in the axes of the section, from its centroid [m], for which they are empty.

    Raises
    ------
    InputError
        If a coordinate is not finite, or the element has no vectors that rotate with the section.
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
    check_position(f"a point of {beam.name} off its axis", (up, side), 2)
    if beam.dim == 2:
        return 0.0, up
    angle = beam.section.frame_angle
    c, s = math.cos(angle), math.sin(angle)
    return 0.0, c * up + s * side, c * side - s * up


def checked_offsets(beam: ElasticBody, offsets: ArrayLike) -> Offsets:
    """Check the offsets of a point from a record, (0, y) or (0, y, z) [m]."""
    what = f"the offsets of a point of {beam.name}"
    axial, *offset = check_position(what, offsets, beam.dim).tolist()
    if axial:
        raise InputError(f"{what} are in its section and begin with 0, got {axial:.6g} m")
    check_sections(beam)
    return 0.0, *offset


def check_sections(beam: ElasticBody) -> None:
    """Refuse beams without section vectors that rotate independently of the slope.

    With ``curvature="axis"`` a force off the axis would rotate r_y relative to r_x, by a shear
    strain of the last element that grows as elements become shorter.
    """
    if beam.automatic:
        raise InputError(
            f"{beam.name} has no points off its axis before a plan has chosen its element and "
            "mesh: give both, element='thick' with curvature='section'"
        )
    if "r_y" not in beam.kind.section or "r_x" in beam.kind.section:
        has_none = beam.kind.is_cable or beam.kind.is_string
        what = (
            "has no section vectors"
            if has_none
            else "rotates its sections with the slope of the axis"
        )
        raise InputError(
            f"{beam.name} has no points off its axis, since its element {beam.element!r} "
            f"{what}: take element='thick' with curvature='section', or weld a rigid body to it"
        )
