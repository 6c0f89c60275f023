"""Beams whose centroid is offset from the line through their ends."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.checks import check_reals
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.bodies.section_offsets import offsets_of

if TYPE_CHECKING:
    from ancfsparse.scene.bodies.beam import Beam

MAX_DIRECTION_CHANGE = 1e-9  # of the components of unit vectors along a straight beam


def offset_from_line(beam: Beam, offset: ArrayLike) -> Beam:
    """Move a straight beam by an offset of its centroid from the line through its ends.

    The offset (dim - 1,) is the vector from the line to the centroid in the axes of the section
    [m].  The nodes of the moved beam are points of the line.
    """
    what = f"offset of {beam.name}"
    needed = "a number of metres, y" if beam.dim == 2 else "two numbers of metres, (y, z)"
    vector = np.atleast_1d(check_reals(what, offset, needed))
    if vector.shape != (beam.dim - 1,):
        raise InputError(f"{what} must be {needed}, got {format_value(offset)}")
    if np.ptp(beam.frames, axis=0).max() > MAX_DIRECTION_CHANGE:
        raise InputError(
            f"{what} needs a straight beam, whose sections are parallel: give the curve of "
            f"its centroid, and attach to points such as rod.at(s, y={-float(vector[0]):.6g})"
        )
    offsets = offsets_of(beam, *vector.tolist(), *(0.0,) * (3 - beam.dim))
    vectors = beam.vectors[0, : len(offsets)]
    positions = beam.positions + np.array(offsets) @ vectors if offsets else beam.positions
    return replace(beam, positions=positions, offset=offsets)
