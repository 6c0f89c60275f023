"""Plans: the cheapest model, mesh, step and method that give a quantity to an error."""

from ancfsparse.plans.asking import (
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
from ancfsparse.plans.planning import plan
from ancfsparse.plans.record import Plan

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
