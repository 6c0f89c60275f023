"""The same scene in other units: the same motion, at the same cost.

Where motions enlarge rounding errors, a run in other units differs from that in SI.  Powers of
four change no rounding, neither of sums and products nor of square roots.  So if the run in the
powers of four nearest to the units is that in SI, the scene is scaled correctly, and rounding alone
decides.
"""

import math
from dataclasses import astuple, dataclass

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
    if not compare(one, attempt_in(nearest_powers_of_four(units)), size, name):
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
    if more > max(3, MAX_COUNT_DIFFERENCE * one.iterations):
        finds.append(f"iterations are {one.iterations} in SI and {two.iterations} in {name}")
    return finds


def nearest_powers_of_four(units):
    """Return units in which every number of a scene in SI is rounded as in SI."""
    return Units(*(4.0 ** round(math.log(each, 4.0)) for each in astuple(units)))
