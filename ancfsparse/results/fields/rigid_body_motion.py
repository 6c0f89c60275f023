"""Motion of a rigid body: position, orientation, velocities, momenta and energy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.results.data.selected_columns import Readable
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.system.system import System


@dataclass(frozen=True, eq=False, repr=False)
class BodyMotion:
    """The motion of a rigid body, at k times.

    Attributes
    ----------
    body : RigidBody
        The rigid body.
    vectors, rates : ndarray, shape (k, n_vectors + 1, dim)
        Origin [m] and unit vectors, and their velocities [m/s, 1/s].
    """

    body: RigidBody
    vectors: Vector
    rates: Vector

    def __repr__(self) -> str:
        """Return the name of the body and the number of states."""
        return f"motion of {self.body.name}, {len(self.vectors)} states"

    @property
    def origin(self) -> Vector:
        """Position of its origin, (k, dim) [m]."""
        return self.vectors[:, 0]

    @property
    def centre(self) -> Vector:
        """Position of its centre of mass, (k, dim) [m]."""
        return self._at_centre(self.vectors)

    @property
    def velocity(self) -> Vector:
        """Velocity of its centre of mass, (k, dim) [m/s]."""
        return self._at_centre(self.rates)

    @property
    def axes(self) -> Vector:
        """Its unit vectors in rows, (k, n_vectors, dim); a thin rod has one."""
        return self.vectors[:, 1:]

    @property
    def rotation(self) -> Vector:
        """Rotation matrices with its unit vectors as columns, (k, dim, dim).

        Raises
        ------
        InputError
            For a thin rod in space, whose rotation about its axis is undefined.
        """
        axes = self.axes
        if axes.shape[1] == axes.shape[2]:
            return np.asarray(np.swapaxes(axes, 1, 2))
        if axes.shape[2] == 3:
            raise InputError(
                f"{self.body.name} is a thin rod, whose rotation about its axis is undefined: use "
                "its axes, or give the body an inertia"
            )
        u = axes[:, 0]
        return np.stack([u, np.stack([-u[:, 1], u[:, 0]], axis=1)], axis=2)

    @property
    def quaternion(self) -> Vector:
        """Unit quaternions of the rotation, real part first, without jumps of sign, (k, 4).

        In the plane the rotation is about z.
        """
        rotation = self.rotation
        if rotation.shape[1] == 2:
            half = 0.5 * self.angles
            zero = np.zeros_like(half)
            return np.stack([np.cos(half), zero, zero, np.sin(half)], axis=1)
        return _quaternions(rotation)

    @property
    def angles(self) -> Vector:
        """Angles of the rotation [rad], without jumps of full turns.

        In the plane one angle, (k,).  In space (k, 3): yaw, pitch and roll, about z, the rotated y
        and the twice rotated x; the pitch is between -pi/2 and pi/2.
        """
        rotation = self.rotation
        if rotation.shape[1] == 2:
            return np.unwrap(np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0]))
        yaw = np.unwrap(np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0]))
        pitch = np.arcsin(np.clip(-rotation[:, 2, 0], -1.0, 1.0))
        roll = np.unwrap(np.arctan2(rotation[:, 2, 1], rotation[:, 2, 2]))
        return np.stack([yaw, pitch, roll], axis=1)

    @property
    def angular_velocity(self) -> Vector:
        """Angular velocity along the axes of space, (k, 3), in the plane (k,) [rad/s]."""
        turns = _cross(self.vectors[:, 1:], self.rates[:, 1:]).sum(axis=1)
        return np.asarray(turns / min(self.body.n_vectors, 2))

    @property
    def angular_velocity_in_body(self) -> Vector:
        """Angular velocity along the axes of the body, (k, 3); in the plane the same, (k,)."""
        velocity = self.angular_velocity
        if velocity.ndim == 1:
            return velocity
        return np.asarray(np.einsum("kij,ki->kj", self.rotation, velocity))

    @property
    def momentum(self) -> Vector:
        """Momentum, (k, dim) [kg m/s]."""
        return self.body.mass * self.velocity

    @property
    def angular_momentum(self) -> Vector:
        """Angular momentum about the origin of space, (k, 3), in the plane (k,) [kg m2/s]."""
        moved = np.einsum("ij,kjd->kid", self.body.masses, self.rates)
        return np.asarray(_cross(self.vectors, moved).sum(axis=1))

    @property
    def kinetic_energy(self) -> Vector:
        """Kinetic energy, (k,) [J]."""
        rates = self.rates
        return np.asarray(0.5 * np.einsum("kid,ij,kjd->k", rates, self.body.masses, rates))

    def _at_centre(self, vectors: Vector) -> Vector:
        weights = self.body.masses[0] / self.body.mass
        return np.asarray(np.einsum("i,kid->kd", weights, vectors))


def evaluate_motion(system: System, q: Readable, v: Readable, body: RigidBody) -> BodyMotion:
    """Return the motion of a rigid body from coordinates and velocities (k, n).

    Raises
    ------
    InputError
        If `body` is not a rigid body of the scene.
    """
    if not isinstance(body, RigidBody):
        raise InputError(
            f"a motion of a body needs a rigid body of the scene, got {format_value(body)}"
        )
    indices = system.rows(body.origin)[0]
    vectors, rates = (
        np.asarray(x[..., indices]).reshape(-1, body.n_vectors + 1, body.dim) for x in (q, v)
    )
    return BodyMotion(body, vectors, rates)


def _cross(a: Vector, b: Vector) -> Vector:
    """Return a x b over the last axis: a vector in space, a number in the plane."""
    if a.shape[-1] == 3:
        return np.asarray(np.cross(a, b))
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _quaternions(rotation: Vector) -> Vector:
    """Return unit quaternions of rotation matrices, computed from their largest component."""
    r = rotation
    trace = np.trace(r, axis1=1, axis2=2)
    # Four times the products of all pairs of components.
    products = np.empty((len(r), 4, 4))
    products[:, 0, 0] = 1.0 + trace
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        products[:, i + 1, i + 1] = 1.0 + 2.0 * r[:, i, i] - trace
        products[:, 0, i + 1] = products[:, i + 1, 0] = r[:, k, j] - r[:, j, k]
        products[:, i + 1, j + 1] = products[:, j + 1, i + 1] = r[:, i, j] + r[:, j, i]
    largest = np.argmax(np.einsum("kii->ki", products), axis=1)
    found = products[np.arange(len(r)), largest]
    found /= np.linalg.norm(found, axis=1, keepdims=True)
    if found[0, 0] < 0.0:
        found[0] *= -1.0
    signs = np.sign(np.sum(found[1:] * found[:-1], axis=1))
    found[1:] *= np.cumprod(np.where(signs == 0.0, 1.0, signs))[:, None]
    return np.asarray(found)
