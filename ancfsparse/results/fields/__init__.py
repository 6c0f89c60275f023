"""Energy balance, section forces, joint forces and rigid-body motion of solutions."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.results.fields.energy_balance import evaluate_energy
    from ancfsparse.results.fields.joint_forces import joint_force, tension
    from ancfsparse.results.fields.rigid_body_motion import evaluate_motion
    from ancfsparse.results.fields.section_forces import (
        axial_forces,
        curvature,
        section_force,
        strain,
    )

__all__ = [
    "axial_forces",
    "curvature",
    "evaluate_energy",
    "evaluate_motion",
    "joint_force",
    "section_force",
    "strain",
    "tension",
]

__getattr__ = on_demand(
    __name__,
    {
        "axial_forces": "section_forces",
        "curvature": "section_forces",
        "evaluate_energy": "energy_balance",
        "joint_force": "joint_forces",
        "evaluate_motion": "rigid_body_motion",
        "section_force": "section_forces",
        "strain": "section_forces",
        "tension": "joint_forces",
    },
)
