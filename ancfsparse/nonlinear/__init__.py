"""Solution of the nonlinear equations of each step, given their residual and a seed.

This package works on vectors and ``solve(r)`` and is independent of mechanics.
"""

from ancfsparse.nonlinear.methods import Method, ModifiedNewton, Newton, QuasiNewton
from ancfsparse.nonlinear.outcome import Attempt, Outcome

__all__ = ["Attempt", "Method", "ModifiedNewton", "Newton", "Outcome", "QuasiNewton"]
