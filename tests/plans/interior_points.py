"""Random lines with a force, a mass, a spring, a follower force or a support inside."""

from dataclasses import dataclass

import numpy as np

import ancfsparse as ancf
from ancfsparse.plans.models.model import Model, build_model
from ancfsparse.plans.selection.element_hierarchy import CABLE, STRING
from tests.plans.comparison import largest_distance

KINDS = ("taut", "slack", "stiff", "curved")
INSIDE = ("force", "mass", "spring", "follower", "support")
ELEMENTS = {None: (300, 450), "motion": (100, 150)}  # of the two references
STEPS = (4000, 2000)  # of the references of motions, with fewer and more elements


@dataclass
class InteriorScene:
    """A scene, the point of interest, the end time [s] or None, and what was drawn."""

    scene: ancf.Scene
    line: object
    point: object
    t_end: float | None
    words: str


def draw(rng, kind=None, inside=None, moving=None):
    """Draw a line, what acts inside, and whether it moves."""
    kind = kind or str(rng.choice(KINDS))
    inside = inside or str(rng.choice(INSIDE))
    moving = bool(rng.integers(2)) if moving is None else moving
    length, density = rng.uniform(1.0, 3.0), rng.uniform(1000.0, 8000.0)
    scene = ancf.Scene(gravity=(0.0, -9.81))
    if kind in ("taut", "slack"):
        diameter, youngs = 10.0 ** rng.uniform(-3.0, -2.0), 10.0 ** rng.uniform(9.0, 10.7)
    else:
        diameter, youngs = length * rng.uniform(0.01, 0.04), 10.0 ** rng.uniform(8.5, 11.0)
    area, inertia = np.pi * diameter**2 / 4.0, np.pi * diameter**4 / 64.0
    weight = density * area * 9.81 * length
    ends, options = ((0.0, 0.0), (length, 0.0)), {}
    if kind == "taut":
        pull = max(youngs * area * 10.0 ** rng.uniform(-4.0, -2.3), 2.0 * weight)
        options["tension"], sway = pull, pull
        period = 2.0 * length / np.sqrt(pull / (density * area))
    elif kind == "slack":
        slack = rng.uniform(1.005, 1.1)
        options["length"], sway = slack * length, weight / np.sqrt(slack - 1.0)
        period = 2.0 * np.sqrt(length / 9.81)
    else:
        sway = 48.0 * youngs * inertia / length**2
        period = 2.0 * length**2 / np.pi * np.sqrt(density * area / (youngs * inertia))
    if kind == "curved":
        radius = length * rng.uniform(0.6, 2.0)
        x = np.linspace(0.0, length, 41)
        y = np.sqrt(radius**2 - (x - length / 2.0) ** 2) - np.sqrt(radius**2 - length**2 / 4.0)
        ends, options["curve"] = (), np.column_stack([x, y])
    made = ancf.Circle(diameter), ancf.Material(youngs, density)
    if ends:
        line = scene.add_beam("auto", *ends, "auto", *made, **options)
    else:
        line = scene.add_beam("auto", n_elements="auto", section=made[0], material=made[1],
                              **options)  # fmt: skip
    scene.pin(line.start)
    scene.pin(line.end)
    place = line.at(line.length * rng.uniform(0.05, 0.95))
    size = sway * rng.uniform(0.01, 0.05)
    if inside == "force":
        scene.point_force(place, (0.0, -size))
    elif inside == "follower":
        scene.point_force(place, (0.0, -size), follow=True)
    elif inside == "mass":
        scene.add_mass(place, size / 9.81)
    elif inside == "spring":
        anchor = tuple(place.position + np.array([0.0, 0.5 * length]))
        scene.spring(place, anchor, stiffness=sway / length, length=0.4 * length)
    else:
        scene.pin(place)
        if kind in ("stiff", "curved"):
            scene.distributed_force(line, (0.0, -8.0 * size / length))
    point = place
    if inside == "support" or rng.random() < 0.3:
        point = line.at(line.length * rng.uniform(0.1, 0.9))
    words = f"{kind}, {inside} at {place.s / line.length:.3f}, seen at {point.s / line.length:.3f}"
    return InteriorScene(scene, line, point, period * rng.uniform(0.3, 1.0) if moving else None,
                         words + (", moving" if moving else ""))  # fmt: skip


def plan_of(drawn, error):
    """Return the plan of a drawn scene to a relative error."""
    quantity = ancf.static_deflection if drawn.t_end is None else ancf.position
    return ancf.plan(drawn.scene, drawn.t_end, quantity(drawn.point), f"{100 * error:g} %")


def missed(drawn, plan):
    """Return the error of a plan over its tolerance, and the same of its reference."""
    run = plan.run()
    counts = ELEMENTS[None if drawn.t_end is None else "motion"]
    dt = None if drawn.t_end is None else [plan.dt / max(1, round(n / plan.steps)) for n in STEPS]
    found, name = [], drawn.line.name
    element = CABLE if plan.model.elements[name] == STRING else plan.model.elements[name]
    for i, count in enumerate(counts):
        model = Model({name: element}, {name: count})
        scene = build_model(drawn.scene, model)
        if dt is None:
            found.append(ancf.solve_static(scene).position(drawn.point)[None])
        else:
            every = round(run.t[1] / dt[i])
            fine = ancf.simulate(scene, drawn.t_end, run.t[1] / every, save_every=every)
            found.append(fine.position(drawn.point))
    tolerance = plan.predictions[0].tolerance
    here = run.position(drawn.point)
    return (
        largest_distance(here[-len(found[1]) :], found[1]) / tolerance,
        largest_distance(*found) / tolerance,
    )
