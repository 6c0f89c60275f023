"""Initial velocities as functions of the reference position."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import call_function, check_reals, check_vector
from ancfsparse.errors import InputError
from ancfsparse.scene.bodies.body import VelocityField
from ancfsparse.scene.geometry.positions import place
from ancfsparse.scene.kinematics.rigid_motion import RigidMotion
from ancfsparse.scene.records.picklable_functions import picklable


@dataclass(frozen=True)
class CheckedVelocity:
    """Initial velocity by a function of the user, which may return one array again and again.

    Parameters
    ----------
    what : str
        Name in messages.
    function : callable
        Velocities (k, dim) [m/s] at reference positions (k, dim) [m].
    """

    what: str
    function: VelocityField

    def __call__(self, positions: Vector) -> Vector:
        """Return a checked copy of the velocities at positions."""
        at = f"for an array of {len(positions)} reference positions, one in each row"
        result = call_function(self.what, self.function, positions.copy(), at)
        values = check_reals(f"the result of {self.what}", result, "an array of numbers")
        if values.shape != positions.shape:
            raise InputError(
                f"{self.what} returned shape {values.shape} for positions of shape "
                f"{positions.shape}: one row of velocities per row of positions is needed"
            )
        return values

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling."""
        return self.__dict__ | {"function": picklable(self.__dict__["function"])}


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
    checked = velocity if isinstance(velocity, RigidMotion) else CheckedVelocity(what, velocity)
    values = checked(positions)
    is_invalid = ~np.isfinite(values).all(axis=1)
    if is_invalid.any():
        i = int(np.argmax(is_invalid))
        raise InputError(f"{what} must be finite, got {values[i]} at {place(positions[i])}")
    return checked
