"""The coordinates that joints leave free: an angle, or a displacement."""

from __future__ import annotations

from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.scene.joints.joint import Joint

# Units of joint coordinates, and of the forces along them.
COORDINATE_UNITS = {"angle": "rad", "displacement": "m"}
FORCE_UNITS = {"angle": "N m", "displacement": "N"}


def select_coordinate(what: str, joint: Joint, of: str | None) -> str:
    """Return the freedom of a joint that is named, or its only one."""
    if of is not None:
        check_choice(f"of of {what}", of, ("angle", "displacement"))
    free = joint.coordinate_names
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
