"""Plans: the cheapest model, mesh, step and method that give a quantity to an error."""

from ancfsparse.plans.planning import plan
from ancfsparse.plans.quantities import (
    energy,
    position,
    reaction,
    section_force,
    slope_angle,
    strain,
    velocity,
)
from ancfsparse.plans.record import Plan

__all__ = [
    "Plan",
    "energy",
    "plan",
    "position",
    "reaction",
    "section_force",
    "slope_angle",
    "strain",
    "velocity",
]
