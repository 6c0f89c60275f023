"""Random scenes of cables, beams and nets that fall on obstacles, lie on drums, and meet ropes."""

import math
from dataclasses import dataclass, field

import ancfsparse as ancf
from ancfsparse.system import System
from tests.soak import scenes
from tests.soak.contacts.draft import Draft
from tests.soak.contacts.layouts import PARTS

LAYOUTS = ("fall", "fall", "fall", "hang", "wrap", "pulley", "throw", "ropes", "ropes", "net")
MAX_EXPLICIT_STEPS = 4000
EXPLICIT_FRACTION = 0.2  # of the stable step: contacts stiffen a mesh after the start


@dataclass
class Touching(scenes.Drawn):
    """A scene with contacts, and what an explicit run of it needs."""

    contacts: list = field(default_factory=list)
    pulls: list = field(default_factory=list)  # points, and the signals of forces on them
    explicit: object = None  # integrator of an explicit run
    max_halvings: int = 0

    @property
    def is_explicit(self):
        return self.explicit is not None


def draw(rng):
    """Draw a scene with contacts."""
    layout = str(rng.choice(LAYOUTS))
    wants_explicit = rng.random() < 0.2
    draft = Draft(rng, layout, slips=wants_explicit)
    duration = PARTS[layout](draft)
    steps = int(rng.integers(20, 80))
    dt = duration / steps
    drawn = Touching(
        draft.scene, draft.beams, dt, steps, words=draft.words, bodies=draft.bodies,
        contacts=draft.contacts, pulls=draft.pulls, max_halvings=int(rng.choice([0, 6])),
    )  # fmt: skip
    if layout == "ropes":
        drawn.max_halvings = 6
    if wants_explicit:
        take_explicit_steps(drawn)
    drawn.words |= {
        "element": draft.element, **draft.options, "radius": draft.radius, "gap": draft.gap,
        "speed": draft.speed, "modulus": draft.modulus,
        "density": draft.density, "dt": drawn.dt, "steps": drawn.steps,
        "max_halvings": drawn.max_halvings,
    }  # fmt: skip
    return drawn


def take_explicit_steps(drawn):
    """Choose an explicit integrator and its steps, if a trial has time for them."""
    for integrator in (ancf.CentralDifference(), ancf.DormandPrince()):  # the other for friction
        try:
            limit = ancf.stable_step(drawn.scene, integrator)
            break
        except ancf.AncfError:
            continue
    else:
        return
    for each in System(drawn.scene).contributions:
        contact = getattr(each, "contact", None)
        if contact is not None:
            mass = contact.body.material.density * contact.body.section.area
            limit = min(limit, math.sqrt(mass / getattr(each, "stiffness", contact.stiffness)))
    steps = math.ceil(drawn.t_end / (EXPLICIT_FRACTION * limit))
    if steps <= MAX_EXPLICIT_STEPS:
        drawn.dt, drawn.steps, drawn.explicit = drawn.t_end / steps, steps, integrator
        drawn.max_halvings = 0
