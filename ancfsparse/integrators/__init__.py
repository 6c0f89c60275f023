"""In comes a system at rest or in motion, out go its states, step after step.

This room knows time and no elements.
"""

from ancfsparse.integrators.explicit import CentralDifference, RungeKuttaNystrom
from ancfsparse.integrators.newmark import Newmark

__all__ = ["CentralDifference", "Newmark", "RungeKuttaNystrom"]
