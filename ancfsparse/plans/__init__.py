"""Plans: the cheapest model, mesh, step and method that give a quantity to an error."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.plans.planning import Plan, plan
    from ancfsparse.plans.quantities.functions import (
        energy,
        frequency,
        position,
        reaction,
        section_force,
        slope_angle,
        static_deflection,
        strain,
        velocity,
    )

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
        "quantities.functions": "energy frequency position reaction section_force slope_angle "
        "static_deflection strain velocity",
    },
)
