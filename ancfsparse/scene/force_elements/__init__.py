"""Springs, ropes, masses, user forces, joint springs and contacts: methods of `Scene`."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.force_elements.beam_contacts import make_beam_contact
    from ancfsparse.scene.force_elements.contact_checks import (
        check_elements,
        check_on,
        check_penetration,
        check_reach,
        check_restitution,
        check_slip_speed,
        check_static_friction,
        radius_of,
    )
    from ancfsparse.scene.force_elements.fixed_ends import (
        describe_left_out,
        fixed_points,
        is_left_out,
        joined_points,
        near_elements,
    )

__all__ = [
    "check_elements",
    "check_on",
    "check_penetration",
    "check_reach",
    "check_restitution",
    "check_slip_speed",
    "check_static_friction",
    "describe_left_out",
    "fixed_points",
    "is_left_out",
    "joined_points",
    "make_beam_contact",
    "near_elements",
    "radius_of",
]

__getattr__ = on_demand(
    __name__,
    {
        "beam_contacts": "make_beam_contact",
        "contact_checks": "check_elements check_on check_penetration check_reach "
        "check_restitution check_slip_speed check_static_friction radius_of",
        "fixed_ends": "describe_left_out fixed_points is_left_out joined_points near_elements",
    },
)
