"""Initial velocities as functions of the reference position."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_reals, check_vector
from ancfsparse.errors import InputError
from ancfsparse.scene.bodies.body import VelocityField
from ancfsparse.scene.geometry.positions import place
from ancfsparse.scene.kinematics.rigid_motion import RigidMotion


def velocity_field(
    label: str, velocity: ArrayLike | VelocityField | None, positions: Vector
) -> VelocityField | None:
    """Return an initial velocity [m/s] as a function, checked at reference positions (n, dim)."""
    if velocity is None:
        return None
    what = f"velocity of {label}"
    if not callable(velocity):
        dim = positions.shape[1]
        constant = check_vector(what, velocity, dim, "m/s")
        return RigidMotion(np.zeros(dim), constant, np.zeros((dim, dim)))
    try:
        result = velocity(positions.copy())
    except Exception as error:  # a user function may raise anything
        reason = f"{type(error).__name__}: {error}".rstrip(": ")
        raise InputError(
            f"{what} failed for an array of {len(positions)} reference positions, one in each row: "
            f"{reason}"
        ) from error
    values = check_reals(f"the result of {what}", result, "an array of numbers")
    if values.shape != positions.shape:
        raise InputError(
            f"{what} returned shape {values.shape} for positions of shape {positions.shape}: "
            "one row of velocities per row of positions is needed"
        )
    is_invalid = ~np.isfinite(values).all(axis=1)
    if is_invalid.any():
        i = int(np.argmax(is_invalid))
        raise InputError(f"{what} must be finite, got {values[i]} at {place(positions[i])}")
    return velocity
