"""Force and moment of joints, tension of ropes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene import Joint
from ancfsparse.scene.force_elements.ropes import Rope
from ancfsparse.scene.mechanisms.winch import Winch
from ancfsparse.system.coordinates.coordinates import foreign_handle
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.recovery import joint_forces
from ancfsparse.system.system import System


@dataclass(frozen=True, eq=False)
class JointForce:
    """Force and moment of a joint on its first side; those on the second side are opposite.

    Attributes
    ----------
    force : ndarray, shape (k, dim)
        Force [N].
    moment : ndarray, shape (k, 3), or (k,) in the plane
        Moment about the point of the first side [N m].
    """

    force: Vector
    moment: Vector

    def at(self, k: int) -> JointForce:
        """Return force (dim,) and moment (3,) or () of one state."""
        return JointForce(self.force[k], self.moment[k])


def joint_force(system: System, joint: object, states: StateHistory, frame: str) -> JointForce:
    """Return force and moment of a joint, see `Trajectory.joint_force`."""
    check_choice("frame of joint_force", frame, ("space", "joint"))
    if not isinstance(joint, Joint):
        raise InputError(
            "joint_force needs a joint that a method of the scene returned, such as "
            f"scene.revolute(...), got {format_value(joint)}"
        )
    force, moment, axes = joint_forces.joint_force(system, joint, states)
    if frame == "space":
        return JointForce(force, moment)
    if np.isnan(axes).any():
        raise InputError(
            f"the {joint.label} has no axes, because its second side is a cable or a "
            "thin rod in space: take frame='space', or exchange its sides"
        )
    rotated = moment if moment.ndim == 1 else np.einsum("kij,kj->ki", axes, moment)
    return JointForce(np.einsum("kij,kj->ki", axes, force), rotated)


def tension(system: System, rope: object, states: StateHistory) -> Vector:
    """Return the tension of a rope or of the rope of a winch, (k,) [N]."""
    if isinstance(rope, Rope):
        return joint_forces.rope_tension(system, rope, states)
    if not isinstance(rope, Winch):
        raise InputError(
            "tension needs what scene.rope(...) or scene.winch(...) returned, got "
            f"{format_value(rope)}: take joint_force for other joints"
        )
    rows = system.rows_of(rope)
    if not rows:
        raise foreign_handle("the winch", "joints[0]")
    return states.lam[:, rows[0]]
