"""The same scene in other units: the same motion, at the same cost."""

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
# Largest difference of positions over the length of the scene, and of counts over themselves.
SAME, AS_MANY = 1e-6, 0.05


def run(seed, index):
    rng = np.random.default_rng([seed, index])
    name, units = list(OTHERS.items())[rng.integers(len(OTHERS))]
    integrator, solver = draw_integrator(rng), draw_solver(rng)
    drawing = int(rng.integers(2**32))
    drawn = draw(np.random.default_rng(drawing), tame=True)
    other = draw(np.random.default_rng(drawing), units, tame=True)
    tried = f"{name}, {integrator!r}, {solver!r}, {drawn.words}"
    (ended, one), (there, two) = (attempt(each, integrator, solver) for each in (drawn, other))
    if ended != there:
        return Report("differ", [f"in SI it {ended}, in {name} it {there}"], tried)
    if ended != "finished":
        return Report(ended, [], tried)
    ends = [beam.end for beam in drawn.beams], [beam.end for beam in other.beams]
    size = sum(beam.length for beam in drawn.beams)
    apart = max(
        float(np.abs(one.position(a) / SI.metre - two.position(b) / units.metre).max() / size)
        for a, b in zip(*ends, strict=True)
    )
    finds = []
    if not apart < SAME:
        finds.append(f"positions differ by {apart:.2g} of the length in {name}")
    counts = [run.stats.iterations for run in (one, two)]
    if abs(counts[1] - counts[0]) > max(3, AS_MANY * counts[0]):
        finds.append(f"iterations are {counts[0]} in SI and {counts[1]} in {name}")
    return Report("differ" if finds else "same", finds, tried)


def attempt(drawn, integrator, solver):
    try:
        run = ancf.simulate(
            drawn.scene, drawn.t_end, drawn.dt, integrator=integrator, solver=solver
        )
    except ancf.AncfError as stop:
        return f"ended with {type(stop).__name__}", None
    return "finished", run
