"""The same scene in other units: the same motion, at the same cost.

Where a decision hangs on rounding, the scene differs from itself in units that are SI but for
rounding, too.  If only rounding decides, the other units are one more draw of the same kind: that
they differ most of all has a chance of one in twenty.
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
# Units that are SI within 1e-15.
NEARBY = [Units(*(1.0 + np.random.default_rng(k).integers(-4, 5, 3) * 2.0**-52)) for k in range(19)]
# Largest difference of positions over the length of the scene, and of counts over themselves.
SAME, AS_MANY = 1e-6, 0.05


@dataclass(frozen=True)
class Attempt:
    """How a run ended, the ends of its beams at every instant [m], and its iterations."""

    ended: str
    places: np.ndarray
    iterations: int

    def apart(self, other):
        """Give the largest difference of positions [m], and the difference of counts."""
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
    if rounding_decides(one, two, [attempt_in(nearby) for nearby in NEARBY]):
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
    """Say in sentences how a run in other units differs from that in SI."""
    if one.ended != two.ended:
        return [f"in SI it {one.ended}, in {name} it {two.ended}"]
    if one.ended != "finished":
        return []
    apart, more = one.apart(two)
    finds = []
    if not apart < SAME * size:
        finds.append(f"positions differ by {apart / size:.2g} of the length in {name}")
    if more > max(3, AS_MANY * one.iterations):
        finds.append(f"iterations are {one.iterations} in SI and {two.iterations} in {name}")
    return finds


def rounding_decides(one, two, nearby):
    """Whether runs in units that are nearly SI differ from that in SI as much as `two` does."""
    if one.ended != two.ended:
        return any(each.ended == two.ended for each in nearby)
    finished = [one.apart(each) for each in nearby if each.ended == "finished"]
    return bool(finished) and all(one.apart(two) <= np.max(finished, axis=0))
