"""Solution procedures: each takes a scene and returns a trajectory, an equilibrium or modes."""

from ancfsparse.solve.linearization.matrices import stable_step
from ancfsparse.solve.motion.simulate import simulate
from ancfsparse.solve.statics.solve_static import solve_static

__all__ = ["simulate", "solve_static", "stable_step"]
