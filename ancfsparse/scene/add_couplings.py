"""The methods of a scene that prescribe or couple what joints leave free."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError, SingularSceneError
from ancfsparse.scene.course import course_of
from ancfsparse.scene.joints import Joint
from ancfsparse.scene.records import Records
from ancfsparse.scene.spec import At, OfJoint, Spec, text

if TYPE_CHECKING:
    from ancfsparse.scene.joints.driven import Driven
    from ancfsparse.scene.signal import Signal


@dataclass(frozen=True, eq=False)
class DrivenSpec(Spec):
    """The record of `Scene.drive_joint`."""

    joint: OfJoint
    value: Any
    rate: Callable[[float], float] | None = None
    second_rate: Callable[[float], float] | None = None
    of: str | None = None
    method = "drive_joint"

    def describe(self, at: At, made: Any) -> str:
        """Describe everything that its equation follows from."""
        return f"drive of {made.of} ({at(self.joint)}) along {text(self.value, at)}"


class Couplings(Records):
    """Joints of a scene that act on the freedoms of others."""

    def drive_joint(
        self,
        joint: Joint,
        value: float | Signal | Callable[[float], float],
        *,
        rate: Callable[[float], float] | None = None,
        second_rate: Callable[[float], float] | None = None,
        of: str | None = None,
    ) -> Driven:
        """Move a joint as prescribed: a hinge by its angle, a sliding joint by its displacement.

        The moment or force that takes is a multiplier, see `Trajectory.joint_force`; its work
        counts in the energy balance.

        Parameters
        ----------
        joint : Joint
            A revolute, cylindrical or prismatic joint; in a planar scene also a pin or a connection
            of nodes, of beams too, whose slopes then turn.
        value : float, Signal or callable
            The angle [rad] by which the first side of the joint is turned against the second one,
            or the ground, right-handed about the axis, counterclockwise in the plane; it is 0 in
            the reference shape and may count many turns.  Or the displacement of the first point
            from the second one along the axis [m].  A signal such as
            ``Ramp(math.pi, 0.5, smooth=True)`` or a function of t [s], whose second derivative must
            be continuous.  `simulate` starts with that of the start.
        rate, second_rate : callable, optional
            Its derivatives, as `drive` takes them.
        of : str, optional
            ``"angle"`` or ``"displacement"``, where a joint has both.

        Returns
        -------
        Driven
            The drive.

        Raises
        ------
        InputError
            If the joint leaves nothing free that is one number, or the motion is not smooth.
        SingularSceneError
            If it is driven already.
        """
        from ancfsparse.scene.joints.driven import Driven
        from ancfsparse.scene.joints.freedoms import UNITS

        reference = self._joint("a drive", joint)
        freedom = freedom_of("a drive", joint, of)
        for other in self.joints:
            if isinstance(other, Driven) and other.joint is joint and other.of == freedom:
                raise SingularSceneError(
                    f"the {freedom} of the {joint.label} is driven already: leave one drive out"
                )
        subject = f"the {freedom} of the {joint.label}"
        course = course_of(subject, 0, value, rate, second_rate, UNITS[freedom])
        record = DrivenSpec(reference, value, rate, second_rate, of)
        return self._add_partial(Driven(joint, freedom, course), record)


def freedom_of(what: str, joint: Joint, of: str | None) -> str:
    """Return the freedom of a joint that is meant: its only one, or the one that is named."""
    if of is not None:
        check_choice(f"of of {what}", of, ("angle", "displacement"))
    free = joint.freedoms
    if not free or (of is not None and of not in free):
        needed = {None: "an angle or a displacement", "angle": "an angle"}.get(of, "a displacement")
        raise InputError(
            f"{what} needs a joint with {needed}, and the {joint.label} has none: take a "
            "revolute, cylindrical or prismatic joint, or in the plane a pin or a connection"
        )
    if of is None and len(free) > 1:
        raise InputError(
            f"{what} of the {joint.label}, which has an angle and a displacement, needs of='angle' "
            "or of='displacement'"
        )
    return of or free[0]
