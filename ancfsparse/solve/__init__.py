"""Solution procedures: each takes a scene and returns a trajectory, an equilibrium or modes."""

from ancfsparse.solve.simulate import simulate
from ancfsparse.solve.stability import stable_step
from ancfsparse.solve.statics import solve_static

__all__ = ["simulate", "solve_static", "stable_step"]
