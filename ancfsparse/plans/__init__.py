"""Plans: the cheapest model, mesh, step and method that give a quantity to an error."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.plans.planning import Plan, plan
    from ancfsparse.plans.quantities.point_motions import (
        position,
        slope_angle,
        static_deflection,
        velocity,
    )
    from ancfsparse.plans.quantities.scene_values import energy, frequency
    from ancfsparse.plans.quantities.section_forces import reaction, section_force, strain

__all__ = [
    "Plan",
    "energy",
    "frequency",
    "plan",
    "position",
    "reaction",
    "section_force",
    "slope_angle",
    "static_deflection",
    "strain",
    "velocity",
]

__getattr__ = on_demand(
    __name__,
    {
        "planning": "Plan plan",
        "quantities.point_motions": "position slope_angle static_deflection velocity",
        "quantities.scene_values": "energy frequency",
        "quantities.section_forces": "reaction section_force strain",
    },
)
