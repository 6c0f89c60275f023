"""Runs to an accuracy: the error that was achieved, against much finer fixed steps."""

import numpy as np

import ancfsparse as ancf
from tests.soak.report import Report
from tests.soak.scenes import draw

SAVED = 20  # times at which motions are compared, the start not counted
MAX_ERROR_RATIO = 2.0  # of the error to the accuracy
MAX_UNCERTAINTY = 0.3  # of a reference, over the accuracy
MAX_FORCES = 400_000  # evaluations of a reference
STABLE_FRACTIONS = (0.45, 0.15)  # of the stable step, in its two runs
IMPLICIT_STEPS = (4000, 8000)  # of its two runs where no step is stable
CONSERVING_FRACTION = 0.1  # of the trials by the energy-momentum method
REPEATED_STEPS = 1.3  # steps of a second reference over those of the first
MIN_STEPS = 12  # steps from one time to the next of the coarser one


def trial(seed, index):
    """Draw a scene, an accuracy and an integrator."""
    rng = np.random.default_rng([seed, index])
    drawn = draw(rng, tame=True)
    accuracy = float(drawn.words["length"] * 10 ** rng.uniform(-7, -3))
    integrator = ["auto", "auto", "auto", ancf.GeneralizedAlpha(0.9), ancf.HHT(0.05)][
        rng.integers(5)
    ]
    if np.random.default_rng([seed, index, 4]).random() < CONSERVING_FRACTION:
        integrator = ancf.EnergyMomentum()
    return drawn, accuracy, integrator


def solve(drawn, accuracy, integrator):
    """Run a scene to an accuracy."""
    every = drawn.t_end / SAVED
    return ancf.simulate(drawn.scene, drawn.t_end, every, accuracy=accuracy, integrator=integrator)


def run(seed, index):
    """Run a random scene to a random accuracy by a random way."""
    drawn, accuracy, integrator = trial(seed, index)
    tried = f"accuracy={accuracy:.3g}, {integrator!r}, {drawn.words}"
    try:
        found = solve(drawn, accuracy, integrator)
    except ancf.AncfError as refused:
        return Report(f"refused ({type(refused).__name__})", [], tried)
    finds = []
    if not found.stats.error <= accuracy:
        finds.append(f"its estimate is {found.stats.error / accuracy:.2g} times the accuracy")
    exact, uncertain = reference(drawn)
    if not uncertain <= MAX_UNCERTAINTY * accuracy:
        return Report("not judged", finds, tried)
    error = apart(positions(found), exact) / accuracy
    # A motion that amplifies rounding has as many references as lengths of step: two of them agreed
    # by chance where others differed by 0.8 times the accuracy, and by 2.2.
    if error > MAX_ERROR_RATIO and not is_repeated(drawn, exact, MAX_UNCERTAINTY * accuracy):
        return Report("not judged", finds, tried)
    if error > MAX_ERROR_RATIO:
        finds.append(
            f"its error is {error:.3g} times the accuracy, its estimate "
            f"{found.stats.error / accuracy:.2g}, by {found.stats.solver}"
        )
    ratios = {"error over the accuracy": error}
    return Report("met" if error <= 1.0 else "missed", finds, tried, ratios)


def is_repeated(drawn, exact, limit):
    """Return whether a reference with other steps agrees with the first up to a limit [m]."""
    again, uncertain = reference(drawn, REPEATED_STEPS)
    return uncertain <= limit and apart(again, exact) <= limit


def reference(drawn, factor=1.0):
    """Return positions by fixed steps, and their difference for two lengths of step [m].

    A factor multiplies the numbers of steps.
    """
    options = {"max_energy_gain": np.inf}
    for method in (ancf.RungeKuttaNystrom(8), ancf.DormandPrince()):
        try:
            limit = ancf.stable_step(drawn.scene, method)
        except ancf.InputError:
            continue
        coarse = factor * max(drawn.t_end / (STABLE_FRACTIONS[0] * limit), MIN_STEPS * SAVED)
        steps = [coarse, coarse * STABLE_FRACTIONS[0] / STABLE_FRACTIONS[1]]
        if steps[1] * method.tableau.forces <= factor * MAX_FORCES:
            options["integrator"] = method
            break
    else:
        steps = [factor * n for n in IMPLICIT_STEPS]
        options |= {"integrator": ancf.GeneralizedAlpha(0.9), "tolerance": 1e-6}
    try:
        runs = [positions(fixed(drawn, n, options)) for n in steps]
    except ancf.AncfError:
        return None, np.inf
    if isinstance(options["integrator"], ancf.GeneralizedAlpha):  # of second order
        runs = [runs[1], (4.0 * runs[1] - runs[0]) / 3.0]
    return runs[1], apart(*runs)


def fixed(drawn, steps, options):
    every = int(np.ceil(steps / SAVED))
    dt = drawn.t_end / (SAVED * every)
    return ancf.simulate(drawn.scene, drawn.t_end, dt, save_every=every, **options)


def positions(path):
    """All nodes at all saved times, (k, n, dim) [m]."""
    dim = path.system.dim
    return np.concatenate([path.q[:, places[:, :dim]] for places in path.system.places], axis=1)


def apart(one, other):
    return float(np.linalg.norm(one - other, axis=2).max())
