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
    ErrorNotMetWarning,
    InputError,
    InstabilityError,
    LoadError,
    ModesError,
    OutputError,
    PenetrationWarning,
    PlanChangedWarning,
    PlanError,
    RedundantConstraintsWarning,
    StepError,
    UnresolvedSignalWarning,
    UnstableEquilibriumWarning,
)
from ancfsparse.integrators import HHT, EnergyMomentum, GeneralizedAlpha, Newmark
from ancfsparse.nonlinear import ModifiedNewton, Newton, QuasiNewton
from ancfsparse.on_demand import on_demand
from ancfsparse.plans.goal_oriented_run import simulate
from ancfsparse.results import Equilibrium, Trajectory
from ancfsparse.scene import (
    Circle,
    IBeam,
    Material,
    Polygon,
    Rectangle,
    Scene,
    Section,
    Taper,
    Tube,
)
from ancfsparse.system import State

if TYPE_CHECKING:
    from ancfsparse.embedding import fmu, gym, urdf
    from ancfsparse.integrators import CentralDifference, DormandPrince, RungeKuttaNystrom
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
    from ancfsparse.scene import Input, Pulse, Ramp, Sine, SpinUp, Table
    from ancfsparse.scene.bodies.rigid_shapes import Box, Cylinder, Rod, Sphere
    from ancfsparse.scene.force_elements.obstacles import (
        Ball,
        Block,
        Capsule,
        Drum,
        HalfSpace,
        HeightField,
        Torus,
        TriangleMesh,
    )
    from ancfsparse.scene.geometry.curves import Arc, Helix
    from ancfsparse.solve import (
        Simulation,
        assemble,
        buckling,
        complex_modes,
        load_path,
        modal_response,
        modes,
        quasi_static,
        resume,
        solve_static,
        stable_step,
    )
    from ancfsparse.sweeps import grid, latin_hypercube
    from ancfsparse.sweeps.sweep import sweep

    __version__: str

__all__ = [
    "HHT",
    "AccuracyError",
    "AncfError",
    "ApproximateModesWarning",
    "Arc",
    "AssemblyError",
    "Ball",
    "Block",
    "Box",
    "Capsule",
    "CentralDifference",
    "Circle",
    "ConvergenceError",
    "Cylinder",
    "DormandPrince",
    "Drum",
    "EnergyIncreaseError",
    "EnergyMomentum",
    "Equilibrium",
    "EquilibriumError",
    "ErrorNotMetWarning",
    "GeneralizedAlpha",
    "HalfSpace",
    "HeightField",
    "Helix",
    "IBeam",
    "Input",
    "InputError",
    "InstabilityError",
    "LoadError",
    "Material",
    "ModesError",
    "ModifiedNewton",
    "Newmark",
    "Newton",
    "OutputError",
    "PenetrationWarning",
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
    "Simulation",
    "Sine",
    "Sphere",
    "SpinUp",
    "State",
    "StepError",
    "Table",
    "Taper",
    "Torus",
    "Trajectory",
    "TriangleMesh",
    "Tube",
    "UnresolvedSignalWarning",
    "UnstableEquilibriumWarning",
    "assemble",
    "buckling",
    "complex_modes",
    "energy",
    "fmu",
    "frequency",
    "grid",
    "gym",
    "latin_hypercube",
    "load",
    "load_path",
    "modal_response",
    "modes",
    "plan",
    "position",
    "quasi_static",
    "reaction",
    "resume",
    "section_force",
    "simulate",
    "slope_angle",
    "solve_static",
    "stable_step",
    "static_deflection",
    "strain",
    "sweep",
    "urdf",
    "velocity",
]


_load = on_demand(
    __name__,
    {
        "embedding": "fmu gym urdf",
        "integrators": "CentralDifference DormandPrince RungeKuttaNystrom",
        "plans": "Plan energy frequency plan position reaction section_force slope_angle "
        "static_deflection strain velocity",
        "results.hdf5_reader": "load",
        "scene": "Input Pulse Ramp Sine SpinUp Table",
        "scene.bodies.rigid_shapes": "Box Cylinder Rod Sphere",
        "scene.force_elements.obstacles": "Ball Block Capsule Drum HalfSpace "
        "HeightField Torus TriangleMesh",
        "scene.geometry.curves": "Arc Helix",
        "solve": "Simulation assemble buckling complex_modes load_path modal_response modes "
        "quasi_static resume solve_static stable_step",
        "sweeps": "grid latin_hypercube sweep",
    },
)


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version  # takes longer to load than to set up a small scene

        return version(__name__)
    return _load(name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
