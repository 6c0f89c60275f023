"""From the arguments of a straight beam to a checked `Beam`."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.checks import check_count, check_positive, check_reals, check_vector
from ancfsparse.errors import InputError, MessageTemplate, Parameter
from ancfsparse.kernels.catalog import ElementKind
from ancfsparse.scene.bodies.beam import Beam
from ancfsparse.scene.bodies.body import VelocityField
from ancfsparse.scene.bodies.element_choice import check_make, chosen_element
from ancfsparse.scene.records.transferable_functions import Uniform
from ancfsparse.scene.sections.material import Material
from ancfsparse.scene.sections.sections import AnySection, Taper, principal_axes
from ancfsparse.system_memory import check_memory

Vector = NDArray[np.float64]

# Start and end closer than this share of their distance from the origin differ by rounding only.
NO_LENGTH = 1e-12
# Sine of the angle to the z axis below which a beam has e_y = +y.
UPRIGHT = 1e-8
# Farther away [m], squares of lengths leave the range of floating-point numbers.
FARTHEST = 1e150


def straight_beam(
    label: str,
    dim: int,
    element: str | ElementKind,
    start: ArrayLike | None,
    end: ArrayLike | None,
    n_elements: int | str,
    section: AnySection,
    material: Material,
    options: Mapping[str, str],
    up: ArrayLike | None,
    velocity: ArrayLike | VelocityField | None,
) -> Beam:
    """Check the arguments of a straight beam and make its handle.

    Parameters
    ----------
    label : str
        Its name.
    dim : int
        Dimension of its scene.
    element, start, end, n_elements, section, material, up, velocity
        As in `Scene.add_beam`.
    options : mapping of str to str
        A value for every option of every element.

    Returns
    -------
    Beam
        The handle, not yet part of a scene.
    """
    element, chosen, kind = chosen_element(label, element, dim, options)
    count = check_count(f"n_elements of {label}", n_elements)
    check_make(label, kind, section, material)
    fewer = MessageTemplate("a smaller {n_elements}", n_elements=Parameter("n_elements"))
    check_memory(f"{label}, {count} elements,", (16.0 * dim + 20.0) * count, fewer)
    tail, head = check_ends(label, start, end, dim)
    if up is not None and dim == 2:
        raise InputError(
            f"`up` of {label} has no meaning in a planar scene, where the height of the section "
            "lies in the plane: leave it out"
        )
    upwards = None if up is None else check_vector(f"`up` of {label}", up, 3)
    positions = np.linspace(tail, head, count + 1)
    axes = along_principal_axes(section_axes(head - tail, upwards, label), section)
    rows = np.arange(count + 1, dtype=np.int32)
    ends = np.stack([rows[:-1], rows[1:]], axis=1)
    length = float(np.linalg.norm(positions[-1] - positions[0]))
    arcs = rows / count * length
    for array in (positions, axes, rows, ends, arcs):
        array.flags.writeable = False
    field = None if velocity is None else velocity_field(label, velocity, positions)
    return Beam(
        name=label,
        element=element,
        options=chosen,
        kind=kind,
        section=section,
        material=material,
        positions=positions,
        n_each=count,
        lengths=np.broadcast_to(length / count, (count,)),
        row_nodes=rows,
        ends=ends,
        vectors=axes[None],
        velocity=field,
        arcs=arcs,
        frames=axes[None],
    )


def check_ends(
    label: str, start: ArrayLike | None, end: ArrayLike | None, dim: int
) -> tuple[Vector, Vector]:
    """Return the two ends of a beam, each (dim,) [m].

    Raises
    ------
    InputError
        If one is missing or no position, or both are one.
    """
    if start is None or end is None:
        missing = "start" if start is None else "end"
        raise InputError(f"{label} has no {missing}: give `start` and `end`, or a `curve`")
    tail = check_vector(f"start of {label}", start, dim, "m")
    head = check_vector(f"end of {label}", end, dim, "m")
    far = max(np.abs(tail).max(), np.abs(head).max())
    if far > FARTHEST:
        raise InputError(
            f"{label} has an end beyond {FARTHEST:g} m: it runs from {place(tail)} to "
            f"{place(head)}; give positions in metres"
        )
    if np.linalg.norm(head - tail) <= NO_LENGTH * far:
        raise InputError(
            f"{label} has zero length: start and end are both at {place(tail)}, move one of them"
        )
    return tail, head


def check_position(what: str, value: ArrayLike, dim: int) -> NDArray[np.float64]:
    """Return a point in space as `check_vector` does, whose distances do not overflow.

    Raises
    ------
    InputError
        If it is no such vector [m], or lies beyond `FARTHEST`.
    """
    point = check_vector(what, value, dim, "m")
    if np.max(np.abs(point)) > FARTHEST:
        raise InputError(
            f"{what} lies beyond {FARTHEST:g} m, at {place(point)}: give positions in metres"
        )
    return point


def place(position: Vector) -> str:
    """Write a position for a message.

    Parameters
    ----------
    position : ndarray, shape (dim,)
        Position [m].

    Returns
    -------
    str
        For example ``(0, 1.5) m``.
    """
    return "(" + ", ".join(f"{each:.6g}" for each in position) + ") m"


def section_axes(axis: Vector, up: Vector | None, where: str) -> Vector:
    """Set up the unit vectors of a section.

    Parameters
    ----------
    axis : ndarray, shape (dim,)
        From the start of the beam to its end [m], not zero.
    up : ndarray, shape (3,), or None
        Rough direction of e_y in a spatial scene; only its part normal to the beam counts.
        None: as in the plane, e_z is as near to +z as it can be, and e_y = e_z x e_x; a beam
        along z takes e_y = +y.
    where : str
        Name of the beam, for the message.

    Returns
    -------
    ndarray, shape (dim, dim)
        Rows e_x, e_y and, if spatial, e_z: right-handed and orthonormal.  In the plane e_y is e_x
        turned by +90 degrees.
    """
    e_x = axis / np.linalg.norm(axis)
    if len(axis) == 2:
        return np.array([e_x, [-e_x[1], e_x[0]]])
    if up is None:
        side = np.cross([0.0, 0.0, 1.0], e_x)
        if np.linalg.norm(side) < UPRIGHT:
            side = np.array([0.0, 1.0, 0.0])
    else:
        direction = up / check_positive(f"length of `up` of {where}", np.linalg.norm(up))
        side = direction - (direction @ e_x) * e_x
        if np.linalg.norm(side) < 1e-6:
            raise InputError(
                f"`up` of {where} is parallel to the beam and does not define where its section "
                "points: give a direction across the beam"
            )
    e_z = np.cross(e_x, side)
    e_z /= np.linalg.norm(e_z)
    return np.array([e_x, np.cross(e_z, e_x), e_z])


def section_frames(slopes: Vector) -> Vector:
    """Set up the unit vectors of sections as `section_axes` does without `up`, (n, dim, dim)."""
    if slopes.shape[1] == 2:
        return np.stack([slopes, np.stack([-slopes[:, 1], slopes[:, 0]], axis=1)], axis=1)
    side = np.cross([0.0, 0.0, 1.0], slopes)
    side[np.linalg.norm(side, axis=1) < UPRIGHT] = 0.0, 1.0, 0.0
    e_z = np.cross(slopes, side)
    e_z /= np.linalg.norm(e_z, axis=1)[:, None]
    return np.stack([slopes, np.cross(e_z, slopes), e_z], axis=1)


def along_principal_axes(frames: Vector, section: AnySection) -> Vector:
    """Turn frames (..., dim, dim) about e_x until e_y and e_z are principal axes of a section."""
    angle = 0.0 if isinstance(section, Taper) else principal_axes(section)[0]
    if not angle:
        return frames
    c, s = math.cos(angle), math.sin(angle)
    e_x, e_y, e_z = np.moveaxis(frames, -2, 0)
    return np.stack([e_x, c * e_y + s * e_z, c * e_z - s * e_y], axis=-2)


def velocity_field(
    label: str, velocity: ArrayLike | VelocityField, positions: Vector
) -> VelocityField:
    """Turn an initial velocity into a function of the reference position and try it out.

    Parameters
    ----------
    label : str
        Name of the beam, for messages.
    velocity : array_like, shape (dim,), or callable
        What was given [m/s].
    positions : ndarray, shape (n, dim)
        Where to try it [m].
    """
    what = f"velocity of {label}"
    if not callable(velocity):
        constant = check_vector(what, velocity, positions.shape[1], "m/s")
        return Uniform(constant)
    values = check_reals(f"what {what} returns", velocity(positions.copy()), "an array of numbers")
    if values.shape != positions.shape:
        raise InputError(
            f"{what} returned shape {values.shape} for positions of shape {positions.shape}: "
            "one row of velocities per row of positions is needed"
        )
    bad = ~np.isfinite(values).all(axis=1)
    if bad.any():
        i = int(np.argmax(bad))
        raise InputError(f"{what} must be finite, got {values[i]} at {place(positions[i])}")
    return velocity
