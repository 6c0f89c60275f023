"""The discrete system of a scene: flat arrays, one numbering, one sparsity pattern.

The system evaluates residual, matrix and energy in compiled code; it does not integrate in time.

    coordinates    numbering of the coordinates, lowering of joints, constraints, states
    loads          load amplitudes and generalized forces
    contributions  terms of the equations of motion: elements, masses, loads, joints, springs
    assembly       sparsity pattern and compiled assembly
    system         the System: coordinates, contributions and their assembly
    recovery       reactions and joint forces of a solution
    rigid_motion   rigid parts and corotated frames of a system
"""

from ancfsparse.system.coordinates.state import State
from ancfsparse.system.system import System

__all__ = ["State", "System"]
