"""Time of the search for pairs of elements against their number."""

from __future__ import annotations

import time

import numpy as np

from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.scene import Circle, Material, Scene
from ancfsparse.scene.force_elements.obstacles import HalfSpace
from ancfsparse.solve import simulate
from benchmarks.common.timing import in_turn
from benchmarks.contact.references.comparison import Comparison, limit_above

ROWS = (5, 10, 20, 40)  # of cables, as many in each row
CABLE_ELEMENTS = 10
STEP_ELEMENTS = 640_000  # steps times elements of a run
SHORT_RUN = 2  # steps of another run, for the time of the set-up
DT = 1e-3  # [s]
ROUNDS = 3  # of all sizes in turn; the shortest time counts
RADIUS = 5e-3  # [m]
GAP = 1e-3  # between cables [m]
MAX_RATIO = 1.5  # of times per element; quadratic growth would be up to 64
MAX_ORDER = 1.15  # of the growth of time with the number of elements
SECTION = Circle(2.0 * RADIUS)
MATERIAL = Material(1e8, 1e3)


def compare_search_times() -> list[Comparison]:
    """Compare the time of a residual with the number of elements that it grows in proportion to."""
    times = [min(samples) for samples in in_turn(ROWS, _time_residual, ROUNDS)]
    sizes = [CABLE_ELEMENTS * n**2 for n in ROWS]
    first, *others = (t / size for size, t in zip(sizes, times, strict=True))
    rows = [
        limit_above(
            f"cables side by side: time per residual and element, {size} over {sizes[0]} elements",
            time_per_element / first,
            MAX_RATIO,
        )
        for size, time_per_element in zip(sizes[1:], others, strict=True)
    ]
    order = float(np.polyfit(np.log(sizes), np.log(times), 1)[0])
    name = "cables side by side: order of the time per residual in the number of elements"
    return [*rows, limit_above(name, order, MAX_ORDER)]


def _time_residual(n: int) -> float:
    """Return the processor time of steps per residual, with the search, without set-up [s]."""
    scene = Scene((0.0, 0.0, -9.81))
    for x in (0.5 * np.arange(n)).tolist():
        for y in ((2.0 * RADIUS + GAP) * np.arange(n)).tolist():
            ends = (x, y, 1.2 * RADIUS), (x + 0.4, y, 1.2 * RADIUS)
            scene.add_beam("thin", *ends, CABLE_ELEMENTS, SECTION, MATERIAL)
    floor = HalfSpace((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    scene.contact(scene.beams, floor, stiffness=1e6, friction=0.3)
    scene.contact(scene.beams, scene.beams, stiffness=1e6, friction=0.3)
    n_steps = STEP_ELEMENTS // (CABLE_ELEMENTS * n**2)
    _time_steps(scene, SHORT_RUN)  # imports modules
    set_up, fewer = _time_steps(scene, SHORT_RUN)
    seconds, more = _time_steps(scene, n_steps)
    return (seconds - set_up) / (more - fewer)


def _time_steps(scene: Scene, steps: int) -> tuple[float, int]:
    """Return processor time [s] and number of residuals of a run."""
    begin = time.process_time()
    run = simulate(scene, steps * DT, DT, integrator=GeneralizedAlpha(0.5), save_every=steps)
    return time.process_time() - begin, run.stats.residual_evaluations
