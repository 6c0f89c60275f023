"""Springs, ropes, masses, user forces, joint springs and contacts: methods of `Scene`."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.force_elements.beam_contacts import (
        BeamContact as BeamContact,
        check_pairs as check_pairs,
    )
    from ancfsparse.scene.force_elements.contact_checks import (
        check_bodies as check_bodies,
        check_contact as check_contact,
        check_law as check_law,
        check_on as check_on,
        radius_of as radius_of,
    )
    from ancfsparse.scene.force_elements.contact_points import (
        distribute_points as distribute_points,
    )
    from ancfsparse.scene.force_elements.fixed_ends import (
        describe_left_out as describe_left_out,
        fixed_points as fixed_points,
        is_left_out as is_left_out,
        joined_points as joined_points,
        near_elements as near_elements,
    )

__getattr__ = on_demand(
    __name__,
    {
        "beam_contacts": "BeamContact check_pairs",
        "contact_checks": "check_bodies check_contact check_law check_on radius_of",
        "contact_points": "distribute_points",
        "fixed_ends": "describe_left_out fixed_points is_left_out joined_points near_elements",
    },
)
