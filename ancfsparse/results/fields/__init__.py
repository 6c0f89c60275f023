"""Energies, forces of sections, joints and contacts, rigid-body motion, states at any times."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.results.fields.consistent_forces import recover_forces
    from ancfsparse.results.fields.contact_forces import contact_force
    from ancfsparse.results.fields.contact_table import contact_table
    from ancfsparse.results.fields.energy_balance import evaluate_energy
    from ancfsparse.results.fields.joint_forces import joint_force, tension
    from ancfsparse.results.fields.quantities import evaluate_history, evaluate_range
    from ancfsparse.results.fields.resampling import resample
    from ancfsparse.results.fields.rigid_body_motion import evaluate_motion
    from ancfsparse.results.fields.section_forces import (
        curvature,
        section_force,
        strain,
    )

__all__ = [
    "contact_force",
    "contact_table",
    "curvature",
    "evaluate_energy",
    "evaluate_history",
    "evaluate_motion",
    "evaluate_range",
    "joint_force",
    "recover_forces",
    "resample",
    "section_force",
    "strain",
    "tension",
]

__getattr__ = on_demand(
    __name__,
    {
        "consistent_forces": "recover_forces",
        "contact_forces": "contact_force",
        "contact_table": "contact_table",
        "energy_balance": "evaluate_energy",
        "joint_forces": "joint_force tension",
        "quantities": "evaluate_history evaluate_range",
        "resampling": "resample",
        "rigid_body_motion": "evaluate_motion",
        "section_forces": "curvature section_force strain",
    },
)
