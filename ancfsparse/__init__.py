"""Flexible multibody dynamics with ANCF cables and beams.

A `Scene` describes a model; `simulate` computes its motion, `solve_static` its equilibrium.
"""

from typing import TYPE_CHECKING

from ancfsparse.errors import (
    AccuracyError,
    AncfError,
    ApproximateModesWarning,
    AssemblyError,
    ConvergenceError,
    EnergyIncreaseError,
    EquilibriumError,
    InputError,
    InstabilityError,
    LoadError,
    ModesError,
    OutputError,
    PlanChangedWarning,
    PlanError,
    RedundantConstraintsWarning,
    StepError,
    UnstableEquilibriumWarning,
)
from ancfsparse.integrators import (
    HHT,
    CentralDifference,
    DormandPrince,
    EnergyMomentum,
    GeneralizedAlpha,
    Newmark,
    RungeKuttaNystrom,
)
from ancfsparse.nonlinear import ModifiedNewton, Newton, QuasiNewton
from ancfsparse.on_demand import on_demand
from ancfsparse.plans.goal_oriented_run import simulate
from ancfsparse.results import Equilibrium, Trajectory
from ancfsparse.scene import (
    Circle,
    IBeam,
    Material,
    Polygon,
    Pulse,
    Ramp,
    Rectangle,
    Scene,
    Section,
    Sine,
    Table,
    Taper,
    Tube,
)
from ancfsparse.solve import solve_static, stable_step
from ancfsparse.system import State

if TYPE_CHECKING:
    from ancfsparse.plans import (
        Plan,
        energy,
        frequency,
        plan,
        position,
        reaction,
        section_force,
        slope_angle,
        static_deflection,
        strain,
        velocity,
    )
    from ancfsparse.results.hdf5_reader import load
    from ancfsparse.scene.bodies.rigid_shapes import Box, Cylinder, Rod, Sphere
    from ancfsparse.scene.geometry.curves import Arc, Helix
    from ancfsparse.solve.equilibrium_paths.load_path import load_path
    from ancfsparse.solve.equilibrium_paths.quasi_static import quasi_static
    from ancfsparse.solve.statics.assemble import assemble
    from ancfsparse.solve.vibration.buckling import buckling
    from ancfsparse.solve.vibration.complex_modes import complex_modes
    from ancfsparse.solve.vibration.modal_response import modal_response
    from ancfsparse.solve.vibration.modes import modes
    from ancfsparse.sweeps import grid, latin_hypercube, sweep

__all__ = [
    "HHT",
    "AccuracyError",
    "AncfError",
    "ApproximateModesWarning",
    "Arc",
    "AssemblyError",
    "Box",
    "CentralDifference",
    "Circle",
    "ConvergenceError",
    "Cylinder",
    "DormandPrince",
    "EnergyIncreaseError",
    "EnergyMomentum",
    "Equilibrium",
    "EquilibriumError",
    "GeneralizedAlpha",
    "Helix",
    "IBeam",
    "InputError",
    "InstabilityError",
    "LoadError",
    "Material",
    "ModesError",
    "ModifiedNewton",
    "Newmark",
    "Newton",
    "OutputError",
    "Plan",
    "PlanChangedWarning",
    "PlanError",
    "Polygon",
    "Pulse",
    "QuasiNewton",
    "Ramp",
    "Rectangle",
    "RedundantConstraintsWarning",
    "Rod",
    "RungeKuttaNystrom",
    "Scene",
    "Section",
    "Sine",
    "Sphere",
    "State",
    "StepError",
    "Table",
    "Taper",
    "Trajectory",
    "Tube",
    "UnstableEquilibriumWarning",
    "assemble",
    "buckling",
    "complex_modes",
    "energy",
    "frequency",
    "grid",
    "latin_hypercube",
    "load",
    "load_path",
    "modal_response",
    "modes",
    "plan",
    "position",
    "quasi_static",
    "reaction",
    "section_force",
    "simulate",
    "slope_angle",
    "solve_static",
    "stable_step",
    "static_deflection",
    "strain",
    "sweep",
    "velocity",
]


_ON_DEMAND = {
    "Arc": "scene.geometry.curves",
    "Box": "scene.bodies.rigid_shapes",
    "Cylinder": "scene.bodies.rigid_shapes",
    "Helix": "scene.geometry.curves",
    "Plan": "plans",
    "Rod": "scene.bodies.rigid_shapes",
    "Sphere": "scene.bodies.rigid_shapes",
    "assemble": "solve.statics.assemble",
    "buckling": "solve.vibration.buckling",
    "complex_modes": "solve.vibration.complex_modes",
    "energy": "plans",
    "frequency": "plans",
    "grid": "sweeps",
    "latin_hypercube": "sweeps",
    "load": "results.hdf5_reader",
    "load_path": "solve.equilibrium_paths.load_path",
    "modal_response": "solve.vibration.modal_response",
    "modes": "solve.vibration.modes",
    "plan": "plans",
    "position": "plans",
    "quasi_static": "solve.equilibrium_paths.quasi_static",
    "reaction": "plans",
    "section_force": "plans",
    "slope_angle": "plans",
    "static_deflection": "plans",
    "strain": "plans",
    "sweep": "sweeps",
    "velocity": "plans",
}

__getattr__ = on_demand(__name__, _ON_DEMAND)
