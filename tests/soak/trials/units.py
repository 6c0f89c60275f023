"""The same scene in other units: the same motion, at the same cost.

Where a decision depends on rounding, the scene differs from itself in units that are SI but for
rounding, too: within 1e-14.  If only rounding decides, the run in other units is one more sample of
the same kind, and no further from those than they are from each other.

Powers of two change no rounding, so every unit is one with a factor from 1 to 2.  The size of a
number relative to the power of two below it matters to rounding.  So where units within 1e-14 of SI
show that a motion enlarges it, runs with such factors count, too.
"""

from dataclasses import dataclass

import numpy as np

import ancfsparse as ancf
from tests.soak.report import Report
from tests.soak.scenes import SI, Units, draw, draw_integrator, draw_solver

OTHERS = {
    "t, mm, s": Units(1e3, 1e-3, 1.0),
    "g, um, ms": Units(1e6, 1e3, 1e3),
    "1000 km, 1000 t, h": Units(1e-6, 1e-6, 1 / 3600),
    "powers of two": Units(2.0**10, 2.0**-7, 2.0**5),
}
NEARBY = [
    Units(*(1.0 + np.random.default_rng(k).integers(-50, 51, 3) * 2.0**-52)) for k in range(19)
]
FACTORS = [Units(*np.random.default_rng(k).uniform(1.0, 2.0, 3)) for k in range(19)]
MAX_DIFFERENCE = 1e-6  # of positions, over the length of the scene
MAX_COUNT_DIFFERENCE = 0.05  # of iterations, relative


@dataclass(frozen=True)
class Attempt:
    """End of a run, ends of its beams at all times [m], and iterations."""

    ended: str
    places: np.ndarray
    iterations: int

    def apart(self, other):
        """Return the largest difference of positions [m], and the difference of counts."""
        return np.abs(self.places - other.places).max(), abs(self.iterations - other.iterations)


def run(seed, index):
    rng = np.random.default_rng([seed, index])
    name, units = list(OTHERS.items())[rng.integers(len(OTHERS))]
    integrator, solver = draw_integrator(rng), draw_solver(rng)
    drawing = int(rng.integers(2**32))
    drawn = draw(np.random.default_rng(drawing), tame=True)
    tried = f"{name}, {integrator!r}, {solver!r}, {drawn.words}"

    def attempt_in(units):
        return attempt(np.random.default_rng(drawing), units, integrator, solver)

    size = sum(beam.length for beam in drawn.beams)
    one, two = attempt_in(SI), attempt_in(units)
    finds = compare(one, two, size, name)
    if not finds:
        return Report("same" if one.ended == "finished" else one.ended, [], tried)
    alike = [one, *(attempt_in(nearby) for nearby in NEARBY)]
    if rounding_matters(alike, size) and not rounding_decides(alike, two, size):
        alike += [attempt_in(factors) for factors in FACTORS]
    if rounding_decides(alike, two, size):
        return Report("rounding decides", [], tried)
    return Report("differ", finds, tried)


def attempt(rng, units, integrator, solver):
    drawn = draw(rng, units, tame=True)
    try:
        run = ancf.simulate(
            drawn.scene, drawn.t_end, drawn.dt, integrator=integrator, solver=solver
        )
    except ancf.AncfError as stop:
        return Attempt(f"ended with {type(stop).__name__}", np.zeros(0), 0)
    places = [run.position(beam.end) / units.metre for beam in drawn.beams]
    return Attempt("finished", np.stack(places), run.stats.iterations)


def compare(one, two, size, name):
    """Return the differences of a run in other units from that in SI, as sentences."""
    if one.ended != two.ended:
        return [f"in SI it {one.ended}, in {name} it {two.ended}"]
    if one.ended != "finished":
        return []
    apart, more = one.apart(two)
    finds = []
    if not apart < MAX_DIFFERENCE * size:
        finds.append(f"positions differ by {apart / size:.2g} of the length in {name}")
    if more > allowed(one):
        finds.append(f"iterations are {one.iterations} in SI and {two.iterations} in {name}")
    return finds


def allowed(run):
    """Return the difference of counts that is tolerated."""
    return max(3, MAX_COUNT_DIFFERENCE * run.iterations)


def rounding_matters(alike, size):
    """Return True if runs that differ by rounding alone have different results."""
    return any(compare(alike[0], other, size, "") for other in alike[1:])


def rounding_decides(alike, two, size):
    """Return True if a run is as near to runs that differ by rounding as they are."""
    near = [each for each in alike if each.ended == two.ended]
    if two.ended != "finished" or not near:
        return bool(near)
    spread = np.max([one.apart(other) for one in near for other in near], axis=0)
    apart = np.min([one.apart(two) for one in near], axis=0)
    return bool(np.all(apart <= np.maximum(spread, [MAX_DIFFERENCE * size, allowed(two)])))
