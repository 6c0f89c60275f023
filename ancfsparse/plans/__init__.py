"""Plans: the cheapest model, mesh, step and method that give a quantity to an error."""

from ancfsparse.plans.execution.plan_data import Plan
from ancfsparse.plans.plan import plan
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
