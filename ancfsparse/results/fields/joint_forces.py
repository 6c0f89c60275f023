"""Force and moment of joints, tension of ropes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene import Joint
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


def tension(system: System, rope: Any, states: StateHistory) -> Vector:
    """Return the tension of a rope or of the rope of a winch, (k,) [N]."""
    if not getattr(rope, "is_rope", False):
        raise InputError(
            "tension needs what scene.rope(...) or scene.winch(...) returned, got "
            f"{format_value(rope)}: take joint_force for other joints"
        )
    if rows := system.rows_of(rope):
        return states.lam[:, rows[0]]
    amplitudes = system.loads.amplitudes(states.t)
    for part in system.contributions:
        tension = part.tension(rope, states.q, states.v, amplitudes)
        if tension is not None:
            return tension
    raise foreign_handle("the rope or winch", "attachments[0] or .joints[0]")
