"""Selection of the nonlinear solver of the steps from the costs of earlier trial runs.

Long steps take many iterations and factorizations, of which two secant pairs save a fifth; more
pairs save no more.  A dense inverse, which `solver="auto"` takes on a few elements, is not renewed,
and takes up to three times the work on stiff rods.  Short steps take two or three iterations, of
which pairs save none.
"""

from __future__ import annotations

from collections.abc import Sequence

from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.nonlinear import Method, QuasiNewton
from ancfsparse.plans.trial_runs.cost_model import RunCost
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.scene import ElasticBody, Mesh, Scene

PAIRS = QuasiNewton("bfgs", memory=2)
MIN_PAIRS_WORK = 16.0  # residuals per step and coordinate at which pairs reduce the work


def select_solver(
    scene: Scene,
    integrator: Implicit | Explicit | SolutionMethod,
    run_costs: Sequence[RunCost],
    steps: int,
) -> Method | str:
    """Return the solver of the steps of a run.

    The cost of the earlier run with the shortest among longer steps decides.
    """
    flexible = any(isinstance(body, ElasticBody) for body in scene.beams)
    if isinstance(integrator, Explicit | SolutionMethod) or not flexible or _may_fill_in(scene):
        return "auto"
    longer = [each for each in run_costs if each.steps < steps]
    last = max(longer, key=lambda each: each.steps, default=None)
    return PAIRS if last is None or last.unit_work >= MIN_PAIRS_WORK else "auto"


def _may_fill_in(scene: Scene) -> bool:
    """Return True if beams may form loops, for which incomplete seeds have their own pairs."""
    joined = sum(bool(joint.joins) for joint in scene.joints)
    return joined >= len(scene.beams) or any(isinstance(body, Mesh) for body in scene.beams)
