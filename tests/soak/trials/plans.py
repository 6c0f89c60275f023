"""Plans of random scenes: the measured error of a met plan, from a converged reference."""

import re
import time
import warnings
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

import ancfsparse as ancf
from ancfsparse.plans.trial_runs.trial_runs import as_trajectory
from tests.soak.report import Report

MAX_ERROR_RATIO = 1.5  # of the measured error to the requested one, of a met plan
MAX_UNCERTAINTY = 0.2  # of a reference, over the requested error
MAX_WORK = 6e6  # nodes times steps of the finest reference
MAX_PLANNED_SECONDS = 4.0  # of the run of a plan
GRID_ELEMENTS = 2, 4, 8, 16, 32, 64
GRID_STEPS = 1, 2, 4, 8, 16  # from one saved time to the next
RICHEST = {"curvature": "section", "section_strain": "nodal"}
GRAVITY = 9.81


@dataclass
class Drawn:
    """Numbers of one scene, from which it is built with any mesh."""

    kind: str
    element: str
    length: float
    section: ancf.Circle
    material: ancf.Material
    inside: float
    probe: float
    signal: object
    quantity: str
    at: str
    error: float
    t_end: float | None
    words: dict = field(default_factory=dict)

    def build(self, element, n_elements, **options):
        """Return the scene and the quantity."""
        scene = ancf.Scene(gravity=(0, -GRAVITY))
        ends = (0, 0), (self.length, 0)
        if n_elements != "auto":
            options["nodes"] = self.nodes(n_elements)
            n_elements = len(options["nodes"]) - 1
        rod = scene.add_beam(element, *ends, n_elements, self.section, self.material, **options)
        (scene.clamp if self.kind == "cantilever" else scene.pin)(rod.start)
        if self.kind == "span":
            scene.pin(rod.end)
        scene.point_force(rod.at(self.inside), self.signal)
        point = rod.at(self.probe)
        make = {
            "energy": lambda: ancf.energy("kinetic", at=self.at),
            "static": lambda: ancf.static_deflection(point),
            "moment": lambda: ancf.section_force(point, "M", at=self.at),
            "reaction": lambda: ancf.reaction(rod.start, at=self.at),
        }
        if self.quantity in make:
            return scene, make[self.quantity]()
        return scene, getattr(ancf, self.quantity)(point, at=self.at)

    def nodes(self, n_elements):
        """Return fractions of the length, with the load and the probe among them."""
        corners = np.unique([0.0, self.inside / self.length, self.probe / self.length, 1.0])
        parts = [
            np.linspace(one, other, max(1, round(n_elements * (other - one))), endpoint=False)
            for one, other in pairwise(corners)
        ]
        return [float(each) for each in (*np.concatenate(parts), 1.0)]


def draw(seed, index):
    """Draw a beam, its load and support, a quantity at a place, and its error."""
    rng = np.random.default_rng([seed, index])
    kind = str(rng.choice(["cantilever", "pendulum", "span"]))
    length = float(10 ** rng.uniform(-0.5, 1.0))
    section = ancf.Circle(length * 10 ** rng.uniform(-2.7, -1.5))
    density = float(10 ** rng.uniform(3.0, 3.9))
    weight = GRAVITY * density * section.area
    droop = 10 ** rng.uniform(-2, 1)  # weight times length cubed over bending stiffness [-]
    young = weight * length**3 / (droop * section.inertia_z)
    damping = float(rng.choice([0.0, 1e-3, 1e-2]))
    material = ancf.Material(young, density, bending_damping=damping, axial_damping=damping)
    slow = 2 * np.pi * np.sqrt(length / GRAVITY) * min(1.0, np.sqrt(droop) / 3.5)
    t_end = float(slow * rng.uniform(0.5, 2.0))
    force = np.array([0.0, float(weight * length * rng.uniform(-0.5, 1.0))])
    rise = t_end * float(10 ** rng.uniform(-1.3, -0.2))
    signals = {
        "jump": lambda: force,
        "ramp": lambda: ancf.Ramp(force, rise),
        "smooth": lambda: ancf.Ramp(force, rise, smooth=True),
        "sine": lambda: ancf.Sine(force, 1.0 / rise),
        "pulse": lambda: ancf.Pulse(force, 0.2 * t_end, 0.2 * t_end + rise),
        "table": lambda: ancf.Table(
            np.linspace(0.0, t_end, 5), np.outer(rng.uniform(-1, 1, 5), force)
        ),
    }
    name = str(rng.choice(list(signals)))
    quantity = str(
        rng.choice(
            "position position velocity slope_angle strain moment reaction energy static".split()
        )
    )
    is_static = quantity == "static" and kind != "pendulum"
    if quantity == "static" and not is_static:
        quantity = "position"
    inside, probe = (float(each) for each in length * rng.uniform(0.15, 0.95, 2))
    error = float(10 ** rng.uniform(-2.5, -1.0))
    drawn = Drawn(
        kind,
        str(rng.choice(["auto", "thin"])),
        length,
        section,
        material,
        inside,
        length if kind != "span" and rng.random() < 0.4 and quantity != "moment" else probe,
        force if is_static else signals[name](),
        quantity,
        str(rng.choice(["saved", "end", "largest"])),
        error,
        None if is_static else t_end,
    )
    drawn.words = {"kind": kind, "element": drawn.element, "signal": name, "droop": round(droop, 3)}
    drawn.words |= {"quantity": quantity, "at": drawn.at, "error": error, "t_end": drawn.t_end}
    return drawn


def run(seed, index):
    """Plan a random scene, and compare its run with a reference if the plan is met."""
    drawn = draw(seed, index)
    tried = str(drawn.words)
    scene, quantity = drawn.build(drawn.element, "auto")
    start = time.process_time()
    try:
        plan = ancf.plan(scene, drawn.t_end, quantity, f"{100 * drawn.error!r} %")
    except ancf.AncfError as refused:
        reason = re.sub(r"[\d.]+(e[+-]?\d+)?", "#", str(refused).split(":")[0])
        return Report(f"refused ({type(refused).__name__}: {reason[:60]})", [], tried)
    if plan.seconds > MAX_PLANNED_SECONDS:
        return Report("expensive" if plan.is_met else "not met", [], tried)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = plan.run()
    seconds = time.process_time() - start
    has_warned = any(issubclass(each.category, ancf.ErrorNotMetWarning) for each in caught)
    finds = []
    if has_warned == result.finished:
        finds.append(f"finished is {result.finished}, and warned is {has_warned}")
    if not result.finished:
        return Report("not met", finds, tried)
    prediction = result.plan.predictions[0]
    exact, uncertainty = reference(drawn, result, prediction.goal.quantity)
    if not uncertainty <= MAX_UNCERTAINTY * prediction.tolerance:
        return Report("not compared", finds, tried)
    error = difference(prediction.goal.quantity, result, exact) / prediction.tolerance
    tried += f", error {error:.3g}, predicted {prediction.error / prediction.tolerance:.3g}"
    if error > MAX_ERROR_RATIO:
        finds.append(f"the error is {error:.3g} times the requested one, by {result.plan.choice}")
    ratios = {"error over the requested one": error}
    if (least := cheapest(drawn, result, prediction, exact)) < np.inf:
        ratios["processor time over the best of a grid"] = seconds / least
    return Report("met" if error <= 1.0 else "exceeded", finds, tried, ratios)


def reference(drawn, result, quantity):
    """Return a run on a fine mesh with short steps, and its difference from a coarser one."""
    element, options = ("thick", RICHEST) if drawn.element == "auto" else ("thin", {})
    n = max(24, 2 * max(result.plan.model.counts.values(), default=0))
    runs = []
    for level in range(4):
        count, every = round(n * 1.5**level), 2 ** (level + 1)
        scene, _ = drawn.build(element, count, **options)
        try:
            if drawn.t_end is None:
                runs.append(ancf.solve_static(scene))
            else:
                intervals = len(result.t) - 1
                every *= -(-result.plan.steps // intervals)
                if count * every * intervals > MAX_WORK:
                    break
                dt = drawn.t_end / (intervals * every)
                runs.append(ancf.simulate(scene, drawn.t_end, dt, save_every=every))
        except ancf.AncfError:
            break
        if len(runs) > 1:
            change = difference(quantity, *runs[-2:])
            if change <= MAX_UNCERTAINTY * result.plan.predictions[0].tolerance:
                return runs[-1], change
    return None, np.inf


def cheapest(drawn, result, prediction, exact):
    """Return the least processor time of equal elements and steps within the tolerance [s]."""
    least, quantity = np.inf, prediction.goal.quantity
    for n in GRID_ELEMENTS:
        for every in GRID_STEPS if drawn.t_end else GRID_STEPS[:1]:
            start = time.process_time()
            scene, _ = drawn.build("thin", n)
            try:
                if drawn.t_end is None:
                    found = ancf.solve_static(scene)
                else:
                    dt = drawn.t_end / ((len(result.t) - 1) * every)
                    found = ancf.simulate(scene, drawn.t_end, dt, save_every=every)
            except ancf.AncfError:
                continue
            seconds = time.process_time() - start
            if difference(quantity, found, exact) <= prediction.tolerance:
                least = min(least, seconds)
                break
            if seconds > least:
                break
    return least


def difference(quantity, one, other):
    """Return the largest difference of a quantity of two runs at the requested times."""
    one, other = (
        quantity.select(quantity.in_scene(each.system.scene).history(as_run(each)))
        for each in (one, other)
    )
    return quantity.largest_difference(one, other)


def as_run(result):
    """Return an equilibrium as a trajectory of one state, and a trajectory unchanged."""
    if isinstance(result, ancf.Trajectory):
        return result
    return as_trajectory(result)
