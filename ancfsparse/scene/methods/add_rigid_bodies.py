"""The method of a scene that adds rigid bodies."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import (
    check_moderate,
    check_positive,
    check_vector,
)
from ancfsparse.errors import InputError
from ancfsparse.kernels.element_kind import RIGID, rigid_kind
from ancfsparse.messages import format_value
from ancfsparse.scene import bodies
from ancfsparse.scene.geometry.positions import check_position
from ancfsparse.scene.kinematics.rigid_motion import (
    ROUNDING_RATIO,
    RigidMotion,
    check_inertia,
    orientation_axes,
    second_moments,
    spin_matrix,
)
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.record import as_data, record_type


class RigidBodies(SceneBase):
    """Rigid bodies of a scene."""

    def add_body(
        self,
        shape: bodies.RigidShape | None = None,
        *,
        position: ArrayLike,
        mass: float | None = None,
        density: float | None = None,
        centre: ArrayLike | None = None,
        inertia: ArrayLike | None = None,
        orientation: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        angular_velocity: ArrayLike | None = None,
        name: str | None = None,
    ) -> bodies.RigidBody:
        """Add a rigid body.

        The origin of its frame is arbitrary.  A joint at the origin fixes coordinates, a joint at
        another point of the body adds equations.

        Parameters
        ----------
        shape : Box, Cylinder, Sphere or Rod, optional
            Its shape, of uniform density, or else `inertia`.  A rod begins at the origin, all other
            shapes have their centre there.
        position : array_like, shape (dim,)
            Position of the origin of its frame at the start [m].
        mass : float, optional
            Its mass [kg], positive.
        density : float, optional
            Density of a shape, instead of the mass [kg/m3].
        centre : array_like, shape (dim,), optional
            Its centre of mass in its frame [m], by default the centre of the shape or the origin.
            Pictures show a shape around it, but a rod from the origin.
        inertia : float, array_like of shape (3,) or (3, 3), optional
            Moments of inertia about its centre of mass [kg m2]: in a planar scene one number; in
            space the principal moments about the axes of its frame, or the whole tensor in it, with
            minus the products of inertia off the diagonal.
        orientation : float or array_like of shape (4,) or (3, 3), optional
            Rotation of its frame at the start: in a planar scene an angle [rad]; in space a unit
            quaternion (real part first) or a matrix with the axes of the frame as columns.
        velocity : array_like, shape (dim,), optional
            Initial velocity of the origin of its frame [m/s].
        angular_velocity : float or array_like of shape (3,), optional
            Initial angular velocity along the axes of space [rad/s]; in the plane counterclockwise.
        name : str, optional
            Its name in messages; by default ``"body 0"`` for the first in the scene, and so on.

        Returns
        -------
        RigidBody
            The handle for joints, loads and results.

        Raises
        ------
        InputError
            If an argument is invalid, such as an inertia that violates the triangle inequality.
        """
        label = self._label(name, "body")
        dim = self.dim
        if shape is not None and not isinstance(shape, bodies.RigidShape):
            raise InputError(
                f"the shape of {label} must be a Box, Cylinder, Sphere or Rod, got "
                f"{format_value(shape)}"
            )
        body_mass = _mass(label, shape, mass, density)
        centre_of_mass = np.zeros(dim) if shape is None else shape.centre[:dim]
        if centre is not None:
            centre_of_mass = check_position(f"centre of {label}", centre, dim)
        second = _second_moments(label, dim, shape, body_mass, inertia)
        n_vectors = 1 if shape is not None and shape.is_line else dim
        if centre_of_mass[n_vectors:].any():
            raise InputError(
                f"centre of {label} is off the line of its rod, at "
                f"{format_value(tuple(centre_of_mass))}: give the body an inertia instead of the "
                "shape Rod"
            )
        spread = np.zeros((n_vectors + 1, n_vectors + 1))
        arm = np.append(1.0, centre_of_mass[:n_vectors])
        spread[1:, 1:] = second[:n_vectors, :n_vectors]
        spread += body_mass * np.outer(arm, arm)
        axes = orientation_axes(f"orientation of {label}", dim, orientation)
        origin = check_position(f"position of {label}", position, dim)[None].copy()
        spin = np.zeros((dim, dim))
        if angular_velocity is not None:
            spin = spin_matrix(f"angular velocity of {label}", angular_velocity, dim)
        initial_velocity = np.zeros(dim)
        if velocity is not None:
            initial_velocity = check_vector(f"velocity of {label}", velocity, dim, "m/s")
        if n_vectors < dim and dim == 3:
            spin = _across(spin, axes[0])
        body = bodies.RigidBody(
            name=label,
            element=RIGID,
            options={"vectors": str(n_vectors)},
            kind=rigid_kind(dim, n_vectors),
            positions=origin,
            n_each=0,
            lengths=np.empty(0),
            row_nodes=np.zeros(1, dtype=np.int32),
            ends=np.empty((0, 2), dtype=np.int32),
            vectors=axes[None, :n_vectors].copy(),
            velocity=RigidMotion(origin[0], initial_velocity, spin),
            mass=body_mass,
            spread=spread,
            shape=shape,
        )
        record = BodySpec(
            shape,
            position=as_data(position),
            mass=as_data(mass),
            density=as_data(density),
            centre=as_data(centre),
            inertia=as_data(inertia),
            orientation=as_data(orientation),
            velocity=as_data(velocity),
            angular_velocity=as_data(angular_velocity),
            name=label,
        )
        return self._take(body, record)


def _mass(
    label: str, shape: bodies.RigidShape | None, mass: float | None, density: float | None
) -> float:
    if (mass is None) == (density is None):
        given = "neither" if mass is None else "both"
        raise InputError(f"{label} needs its mass or its density, got {given}")
    if density is None:
        return check_moderate(f"mass of {label}", mass, "kg")
    if shape is None or shape.volume == 0.0:
        raise InputError(
            f"{label} has a density and no volume: give its mass"
            + (", or a Box, Cylinder or Sphere as its shape" if shape is None else "")
        )
    value = check_positive(f"density of {label}", density, "kg/m3") * shape.volume
    return check_moderate(f"mass of {label}", value, "kg")


def _second_moments(
    label: str, dim: int, shape: bodies.RigidShape | None, mass: float, inertia: ArrayLike | None
) -> Vector:
    """Return the integral of x x^T over the mass about the centre, (dim, dim) [kg m2]."""
    what = f"inertia of {label}"
    if (shape is None) == (inertia is None):
        given = "neither" if shape is None else "both"
        raise InputError(f"{label} needs a shape or its inertia about its centre, got {given}")
    if shape is not None:
        return np.asarray(mass * shape.spread[:dim, :dim])
    if dim == 2:
        # In the plane any division of the moment between the two vectors is the same rotation.
        return 0.5 * check_moderate(what, inertia, "kg m2") * np.eye(2)
    tensor = check_inertia(what, inertia, "tensor", ROUNDING_RATIO)
    check_moderate(f"largest moment of the {what}", np.abs(tensor).max(), "kg m2")
    principal = np.linalg.eigvalsh(tensor)
    if principal[0] <= ROUNDING_RATIO * principal[2]:
        raise InputError(
            f"{what} has the principal moments {_listed(principal)} kg m2, and all three must be "
            "positive; a thin rod, which has none about its axis, is the shape Rod(length)"
        )
    if principal[0] + principal[1] < (1.0 - ROUNDING_RATIO) * principal[2]:
        raise InputError(
            f"{what} violates the triangle inequality: the largest principal moment is at most the "
            f"sum of the other two, got {_listed(principal)} kg m2"
        )
    return second_moments(0.5 * (tensor + tensor.T))


def _listed(values: Iterable[float]) -> str:
    return ", ".join(f"{value:.6g}" for value in values)


def _across(spin: Vector, axis: Vector) -> Vector:
    """Remove the angular velocity of a rod about its axis, which its coordinates exclude."""
    rate = spin @ axis
    return np.asarray(np.outer(rate, axis) - np.outer(axis, rate))


UNITS = {
    "position": "m",
    "mass": "kg",
    "density": "kg/m3",
    "centre": "m",
    "inertia": "kg m2",
    "velocity": "m/s",
    "angular_velocity": "rad/s",
}
BodySpec = record_type("BodySpec", RigidBodies.add_body, units=UNITS)
