"""How the equations of a step are solved, by what earlier pilots took.

Long steps take many corrections and factors, of which two secant pairs save a fifth; more pairs
save no more.  A dense inverse, which `solver="auto"` takes on a few elements, is not renewed, and
takes up to three times the work on stiff rods.  Short steps take two or three corrections, of which
pairs save none.
"""

from __future__ import annotations

from collections.abc import Sequence

from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.nonlinear import Method, QuasiNewton
from ancfsparse.plans.trial_runs.cost_model import Counted
from ancfsparse.plans.trial_runs.solution_methods import Way
from ancfsparse.scene import ElasticBody, Mesh, Scene

# The pairs, and the work for each step and coordinate, in that of a residual, at which they pay.
PAIRS, BUSY = QuasiNewton("bfgs", memory=2), 16.0


def solver_of(
    scene: Scene, integrator: Implicit | Explicit | Way, bill: Sequence[Counted], steps: int
) -> Method | str:
    """Return how the steps of a scene are solved.

    Parameters
    ----------
    scene : Scene
        What is marched.
    integrator : Implicit, Explicit or Way
        By which it is.
    bill : sequence of Counted
        What runs have cost; of those with longer steps, the shortest steps tell what these take.
    steps : int
        Number of steps.
    """
    flexible = any(isinstance(body, ElasticBody) for body in scene.beams)
    if isinstance(integrator, Explicit | Way) or not flexible or _may_fill_in(scene):
        return "auto"
    longer = [each for each in bill if each.steps < steps]
    last = max(longer, key=lambda each: each.steps, default=None)
    return PAIRS if last is None or last.work >= BUSY else "auto"


def _may_fill_in(scene: Scene) -> bool:
    """Whether beams may form loops, for which incomplete seeds have pairs of their own."""
    joined = sum(bool(joint.joins) for joint in scene.joints)
    return joined >= len(scene.beams) or any(isinstance(body, Mesh) for body in scene.beams)
