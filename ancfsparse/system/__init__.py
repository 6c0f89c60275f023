"""The discrete system of a scene: flat arrays, one numbering, one sparsity pattern.

The system evaluates residual, matrix and energy in compiled code; it does not integrate in time.
"""

from ancfsparse.system.coordinates.state import State
from ancfsparse.system.system import System

__all__ = ["State", "System"]
