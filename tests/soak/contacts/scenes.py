"""Random scenes of cables, beams and nets that fall on obstacles, lie on drums, and meet ropes."""

import math
from dataclasses import dataclass, field

import numpy as np

import ancfsparse as ancf
from ancfsparse.scene.force_elements.beam_contacts import BeamContact
from ancfsparse.system import System
from tests.soak import scenes
from tests.soak.contacts.draft import MAX_STEPS, RESOLVED, Draft
from tests.soak.contacts.layouts import PARTS

LAYOUTS = ("fall", "fall", "fall", "hang", "wrap", "pulley", "throw", "ropes", "ropes", "net")
RESOLVED_SHARE = 0.999  # of the longest step that resolves impacts
SPRING_STEPS = 10  # times as many steps for ropes that spring back
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


def draw(rng, laws=None, layout=None):
    """Draw a scene with contacts; those with restitution or static friction need a generator."""
    layout = layout or str(rng.choice(LAYOUTS))
    wants_explicit = rng.random() < 0.2
    draft = Draft(rng, layout, slips=wants_explicit, laws=laws)
    duration = PARTS[layout](draft)
    steps = int(rng.integers(20, 80))
    dt = duration / steps
    drawn = Touching(
        draft.scene, draft.beams, dt, steps, words=draft.words, bodies=draft.bodies,
        contacts=draft.contacts, pulls=draft.pulls, max_halvings=int(rng.choice([0, 6])),
    )  # fmt: skip
    if layout in ("ropes", "bend"):
        drawn.max_halvings = 6
    if layout == "bend":  # which springs back
        drawn.dt, drawn.steps = drawn.dt / SPRING_STEPS, drawn.steps * SPRING_STEPS
    longest = RESOLVED_SHARE * longest_step(drawn.scene)
    if drawn.dt > longest:
        drawn.steps = math.ceil(duration / longest)
        drawn.dt = duration / drawn.steps
    if wants_explicit:
        take_explicit_steps(drawn)
    drawn.words |= {
        "element": draft.element, **draft.options, "radius": draft.radius, "gap": draft.gap,
        "speed": draft.speed, "modulus": draft.modulus,
        "density": draft.density, "dt": drawn.dt, "steps": drawn.steps,
        "max_halvings": drawn.max_halvings,
    }  # fmt: skip
    return drawn


def contacts_of(scene):
    """Yield the contacts, the masses per length [kg/m], and the stiffnesses [N/m2]."""
    for each in System(scene).contributions:
        contact = getattr(each, "contact", None)
        if contact is not None:
            mass = contact.bodies[0].material.density * contact.bodies[0].section.area
            yield contact, mass, np.max(getattr(each, "stiffness", contact.stiffness))


def longest_step(scene):
    """Return the longest step that resolves impacts with a restitution [s], of equal ropes too."""
    return min(
        (
            contact.restitution / RESOLVED * math.pi
            * math.sqrt(mass / stiffness / (1 + isinstance(contact, BeamContact)))
            for contact, mass, stiffness in contacts_of(scene)
            if contact.restitution
        ),
        default=math.inf,
    )  # fmt: skip


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
    for _, mass, stiffness in contacts_of(drawn.scene):
        limit = min(limit, math.sqrt(mass / stiffness))
    limit = min(EXPLICIT_FRACTION * limit, RESOLVED_SHARE * longest_step(drawn.scene))
    steps = math.ceil(drawn.t_end / limit)
    if steps <= MAX_STEPS:
        drawn.dt, drawn.steps, drawn.explicit = drawn.t_end / steps, steps, integrator
        drawn.max_halvings = 0
