"""Flexible multibody dynamics with ANCF cables and beams.

A `Scene` says what there is, `simulate` and `solve_static` answer how it moves and rests.
"""

from ancfsparse.errors import AncfError, EquilibriumFailure, InputError, StepFailure
from ancfsparse.integrators import Newmark
from ancfsparse.nonlinear import ModifiedNewton, Newton, QuasiNewton
from ancfsparse.results import Equilibrium, Trajectory
from ancfsparse.scene import Circle, Material, Rectangle, Scene, Section
from ancfsparse.solve import simulate, solve_static

__all__ = [
    "AncfError",
    "Circle",
    "Equilibrium",
    "EquilibriumFailure",
    "InputError",
    "Material",
    "ModifiedNewton",
    "Newmark",
    "Newton",
    "QuasiNewton",
    "Rectangle",
    "Scene",
    "Section",
    "StepFailure",
    "Trajectory",
    "simulate",
    "solve_static",
]
