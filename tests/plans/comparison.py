"""Trial runs for one quantity, and distances of planned motions from finer ones."""

import numpy as np

import ancfsparse as ancf
from ancfsparse.plans.quantities.tolerances import check_goals, check_quantities
from ancfsparse.plans.trial_runs.trial_runs import TrialRuns

DAMPED = ancf.GeneralizedAlpha(0.9)


def build_trials(scene, t_end, quantity, error, **options):
    """Return the trial runs of a scene for one quantity."""
    goals = check_goals(check_quantities(quantity, scene), error)
    return TrialRuns(scene, t_end, goals, DAMPED, **options)


def largest_distance(one, other):
    """Return the largest distance between places over time [m]."""
    return np.linalg.norm(one - other, axis=1).max()


def distance_from_shorter_steps(run, point, scene, its, division, **options):
    """Return how far a point is from its motion in `scene`, in `division` steps for each [m]."""
    dt = run.t[-1] / (division * (len(run.t) - 1))
    motion = ancf.simulate(scene, run.t[-1], dt, save_every=division, **options)
    return largest_distance(run.position(point), motion.position(its))
