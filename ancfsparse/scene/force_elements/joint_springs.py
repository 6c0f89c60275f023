"""Springs, dampers, stops and friction in joints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ancfsparse.checks import check_finite
from ancfsparse.errors import InputError
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.joints.joint_coordinate import (
    COORDINATE_UNITS,
    FORCE_UNITS,
    select_coordinate,
)
from ancfsparse.scene.loads.attachment import Attachment, check_coefficient
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.record import JointRef, Record, record_type

# Force laws, in the order of ``Law`` in _joint_springs.pyx.
LAWS = SPRING, STOP, FRICTION, RUBBING = range(4)


@dataclass(frozen=True, eq=False)
class JointFrictionSpec(Record):
    """The record of `Scene.joint_friction`."""

    joint: JointRef
    size: float | None = None
    slip: float = 0.0  # always given
    of: str | None = None
    coefficient: float | None = None
    radius: float | None = None
    method = "joint_friction"

    @property
    def given(self) -> dict[str, Any]:
        """All fields by name, without the arguments of the other kind of friction."""
        items = super().given.items()
        return {name: value for name, value in items if value is not None or name == "of"}


@dataclass(frozen=True, eq=False)
class JointSpring(Attachment):
    """A force element along a coordinate of a joint, an angle [rad] or a displacement [m].

    Attributes
    ----------
    joint : Joint
        The joint.
    of : str
        ``"angle"`` or ``"displacement"``.
    law : int
        One of `LAWS`.
    low, high : float
        Interval without force [rad or m].
    stiffness : float
        Stiffness [N m/rad or N/m].
    damping : float
        Damping of a spring [N m s/rad or N s/m]; relative growth of the force of a stop with the
        rate [s/rad or s/m]; magnitude of friction [N m or N], or magnitude over the joint force
        [m or 1].
    slip : float
        Rate at which friction has 0.71 of its magnitude [rad/s or m/s].
    """

    joint: Joint
    of: str
    law: int
    low: float = 0.0
    high: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    slip: float = 1.0
    contribution = "force_elements.joint_springs"

    @property
    def what(self) -> str:
        """Name in messages."""
        kind = ("spring", "stop", "friction", "friction")[self.law]
        return f"the {kind} at the {self.of} of the {self.joint.label}"


class JointSprings(SceneBase):
    """Springs, stops and friction in the joints of a scene."""

    def joint_spring(
        self,
        joint: Joint,
        *,
        stiffness: float = 0.0,
        damping: float = 0.0,
        rest: float = 0.0,
        of: str | None = None,
    ) -> JointSpring:
        """Add a spring and a damper to a joint: about a hinge, or along a slide.

        Parameters
        ----------
        joint : Joint
            As `drive_joint` takes it.
        stiffness : float, optional
            Moment over angle [N m/rad], or force over displacement [N/m].
        damping : float, optional
            Moment over angular velocity [N m s/rad], or force over velocity [N s/m].
        rest : float, optional
            The angle [rad] or displacement [m] without force, as `drive_joint` counts them.  A
            spring about a hinge counts at most half a turn to either side of it.
        of : str, optional
            ``"angle"`` or ``"displacement"``, where the joint has both.

        Raises
        ------
        InputError
            If a number is negative or not finite, or the joint has no such coordinate.
        """
        reference, coordinate, units = self._coordinate("a spring", joint, of)
        what = f"of the spring at the {coordinate} of the {joint.label}"
        k = check_coefficient(f"stiffness {what}", stiffness, f"{units[0]}/{units[1]}")
        c = check_coefficient(f"damping {what}", damping, f"{units[0]} s/{units[1]}")
        at = check_finite(f"rest {what}", rest, units[1])
        if k == 0.0 and c == 0.0:
            raise InputError(
                f"the spring at the {coordinate} of the {joint.label} does nothing: give it a "
                "stiffness or a damping"
            )
        element = JointSpring(joint, coordinate, SPRING, at, at, k, c)
        return self._attach(
            element, JointSpringSpec(reference, stiffness=k, damping=c, rest=at, of=of)
        )

    def joint_stop(
        self,
        joint: Joint,
        low: float,
        high: float,
        *,
        stiffness: float,
        damping: float = 0.0,
        of: str | None = None,
    ) -> JointSpring:
        """Stop a joint softly at both ends of a range.

        Outside the range by e, its restoring force is ``stiffness * (e + damping * |e| * rate)``.

        Parameters
        ----------
        joint, of
            As in `joint_spring`.
        low, high : float
            The ends of the range [rad or m]; of angles less than a turn apart.
        stiffness : float
            [N m/rad or N/m].
        damping : float, optional
            Relative growth of the stiffness with the rate [s/rad or s/m].

        Raises
        ------
        InputError
            If a number is out of range, or the joint has no such coordinate.
        """
        reference, coordinate, units = self._coordinate("a stop", joint, of)
        what = f"of the stop at the {coordinate} of the {joint.label}"
        low_end = check_finite(f"low {what}", low, units[1])
        high_end = check_finite(f"high {what}", high, units[1])
        is_turn = coordinate == "angle" and high_end - low_end >= 2.0 * math.pi
        if is_turn or not low_end < high_end:
            turn = ", less than a turn apart" if coordinate == "angle" else ""
            raise InputError(
                f"the range {what} must have low below high{turn}, got {low_end:.6g} and "
                f"{high_end:.6g} {units[1]}"
            )
        k = check_coefficient(f"stiffness {what}", stiffness, f"{units[0]}/{units[1]}")
        c = check_coefficient(f"damping {what}", damping, f"s/{units[1]}")
        if k == 0.0:
            raise InputError(f"stiffness {what} must be positive, got 0: it would stop nothing")
        element = JointSpring(joint, coordinate, STOP, low_end, high_end, k, c)
        record = JointStopSpec(reference, low_end, high_end, stiffness=k, damping=c, of=of)
        return self._attach(element, record)

    def joint_friction(
        self,
        joint: Joint,
        size: float | None = None,
        *,
        slip: float,
        of: str | None = None,
        coefficient: float | None = None,
        radius: float | None = None,
    ) -> JointSpring:
        """Add Coulomb's friction to a joint, smoothed about rest.

        It acts against the rate with ``size * rate / sqrt(rate^2 + slip^2)``, so below the rate
        `slip` it lets the joint creep instead of holding it.  The size is given, or proportional to
        the force F of the joint at the same time, with the order of the integrator: ``coefficient
        * |F|`` along a slide, ``coefficient * |F| * radius`` about a hinge.  F is the whole force
        of a pin or a hinge, a thrust along its axis included, and the force across a slide; moments
        that a joint transmits do not rub.

        Parameters
        ----------
        joint : Joint
            As `drive_joint` takes it; with a coefficient one by multipliers.
        size : float, optional
            Moment [N m] or force [N] of a joint that slips.
        slip : float
            The rate at which it has 0.71 of that [rad/s or m/s], small compared with those of the
            motion.
        of : str, optional
            ``"angle"`` or ``"displacement"``, where the joint has both.
        coefficient : float, optional
            Coefficient of friction [1], instead of a size.
        radius : float, optional
            Of the bearing [m], for angles with a coefficient.

        Raises
        ------
        InputError
            If a number is not positive, or the joint has no such coordinate.
        """
        reference, coordinate, units = self._coordinate("friction", joint, of)
        what = f"of the friction at the {coordinate} of the {joint.label}"
        if (size is None) == (coefficient is None):
            raise InputError(f"give either a size or a coefficient {what}")
        if (radius is not None) != (coefficient is not None and coordinate == "angle"):
            raise InputError(
                f"the radius {what} goes with a coefficient for an angle: "
                f"{'leave it out' if radius is not None else 'give the radius of the bearing [m]'}"
            )
        numbers = {
            name: _positive(f"{name} {what}", value, unit)
            for name, value, unit in (
                ("size", size, units[0]),
                ("coefficient", coefficient, "1"),
                ("radius", radius, "m"),
                ("slip", slip, f"{units[1]}/s"),
            )
            if value is not None or name == "slip"
        }
        law = FRICTION if coefficient is None else RUBBING
        magnitude = numbers.get("size") or numbers["coefficient"] * numbers.get("radius", 1.0)
        element = JointSpring(joint, coordinate, law, damping=magnitude, slip=numbers["slip"])
        return self._attach(element, JointFrictionSpec(reference, of=of, **numbers))

    def _coordinate(
        self, what: str, joint: Joint, of: str | None
    ) -> tuple[JointRef, str, tuple[str, str]]:
        """Return the reference and the coordinate of a joint, and the units of force and value."""
        reference = self._joint(what, joint)
        coordinate = select_coordinate(what, joint, of)
        return reference, coordinate, (FORCE_UNITS[coordinate], COORDINATE_UNITS[coordinate])


def _positive(what: str, value: object, unit: str) -> float:
    number = check_coefficient(what, value, unit)
    if number == 0.0:
        raise InputError(f"{what} must be positive, got 0")
    return number


JointSpringSpec = record_type("JointSpringSpec", JointSprings.joint_spring)
JointStopSpec = record_type("JointStopSpec", JointSprings.joint_stop)
