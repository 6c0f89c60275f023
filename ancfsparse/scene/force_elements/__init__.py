"""Springs, ropes, masses, user forces, joint springs and contacts: methods of `Scene`."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.force_elements.beam_contacts import BeamContact, check_pairs
    from ancfsparse.scene.force_elements.contact_checks import (
        check_bodies,
        check_contact,
        check_law,
        check_on,
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
    "BeamContact",
    "check_bodies",
    "check_contact",
    "check_law",
    "check_on",
    "check_pairs",
    "describe_left_out",
    "fixed_points",
    "is_left_out",
    "joined_points",
    "near_elements",
    "radius_of",
]

__getattr__ = on_demand(
    __name__,
    {
        "beam_contacts": "BeamContact check_pairs",
        "contact_checks": "check_bodies check_contact check_law check_on radius_of",
        "fixed_ends": "describe_left_out fixed_points is_left_out joined_points near_elements",
    },
)
