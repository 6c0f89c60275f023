"""Plans of lines with a force, a mass, a spring or a support inside, compared with fine meshes."""

import numpy as np

import ancfsparse as ancf
from tests.plans.interior_points import draw, missed, plan_of
from tests.soak.report import Report
from tests.soak.trials.plans import MAX_PLANNED_SECONDS

ERRORS = (0.03, 0.01)  # relative ones that are requested
MAX_ERROR_RATIO = 1.5  # of the error to the tolerance
MAX_UNCERTAINTY = 0.3  # of the reference, over the tolerance


def run(seed, index):
    """Plan a random scene, and compare the planned run with a fine one."""
    rng = np.random.default_rng([seed, index])
    error = float(rng.choice(ERRORS))
    drawn = draw(rng)
    tried = f"{drawn.words}, to {error}"
    try:
        plan = plan_of(drawn, error)
        if not plan.is_met:  # and might take any time
            return Report("not met", [], tried)
        if plan.seconds > MAX_PLANNED_SECONDS:
            return Report("expensive", [], tried)
        ratio, uncertain = missed(drawn, plan)
    except ancf.AncfError as refused:
        return Report(f"refused ({type(refused).__name__})", [], tried)
    if uncertain > MAX_UNCERTAINTY:
        return Report("not judged", [], tried)
    finds = []
    if ratio > MAX_ERROR_RATIO:
        finds.append(f"its error is {ratio:.3g} times the tolerance: {plan.choice}")
    return Report("met" if ratio <= 1.0 else "missed", finds, tried)
