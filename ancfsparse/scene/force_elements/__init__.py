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

__all__ = [
    "check_elements",
    "check_on",
    "check_penetration",
    "check_reach",
    "check_restitution",
    "check_slip_speed",
    "check_static_friction",
    "make_beam_contact",
    "radius_of",
]

__getattr__ = on_demand(
    __name__,
    {
        "beam_contacts": "make_beam_contact",
        "contact_checks": "check_elements check_on check_penetration check_reach "
        "check_restitution check_slip_speed check_static_friction radius_of",
    },
)
