"""Scenes of the tests of simulations."""

import numpy as np

import ancfsparse as ancf

STEEL = ancf.Material(1e7, 1e3)


def pendulum(load=(0.0, 0.0), element="thin"):
    """Return a hanging cable with a force at its end, and the cable."""
    scene = ancf.Scene((0, -9.81))
    rod = scene.add_beam(element, (0, 0), (1, 0), 8, ancf.Circle(0.01), STEEL)
    scene.pin(rod.start)
    scene.point_force(rod.end, load)
    return scene, rod


def crossing_cables():
    """Return two cables that touch, separate and touch again."""
    scene = ancf.Scene((0, 0, -9.81))
    rope, wire = ancf.Circle(0.01), ancf.Material(1e8, 5e3)
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 6, rope, wire)
    scene.pin(lower.start)
    scene.pin(lower.end)
    upper = scene.add_beam("thin", (0, -0.5, 0.0101), (0, 0.5, 0.0101), 6, rope, wire)
    scene.contact(lower, upper, stiffness=1e7, friction=0.3)
    return scene


def cable_on_drum():
    """Return a cable that falls onto a turning drum after 10 ms."""
    scene = ancf.Scene((0, -9.81))
    rope, y = ancf.Circle(0.004), 0.1025
    cable = scene.add_beam("thin", (-0.5, y), (0.5, y), 20, rope, ancf.Material(1e8, 2e3))
    scene.contact(cable, ancf.Drum((0, 0), radius=0.1, angular_velocity=5.0), friction=0.3)
    return scene


def hanging_body():
    """Return a body on a pin with a cable, so constraints by multipliers."""
    scene = ancf.Scene((0, 0, -9.81))
    box = scene.add_body(ancf.Box(length=0.2, width=0.1, height=0.1), position=(0, 0, 0), mass=1.0)
    scene.pin(box.at((-0.1, 0, 0)))
    rod = scene.add_beam("thin", (0.1, 0, 0), (1.1, 0, 0), 6, ancf.Circle(0.01), STEEL)
    scene.connect(box.at((0.1, 0, 0)), rod.start)
    return scene


SCENES = {
    "pendulum": (lambda: pendulum(ancf.Sine((0.0, 1.0), 3.0))[0], 1e-3),
    "drum": (cable_on_drum, 5e-4),
    "cables": (crossing_cables, 1e-3),
    "body": (hanging_body, 1e-3),
}
INTEGRATORS = (
    ancf.GeneralizedAlpha(0.9),
    ancf.Newmark(0),
    ancf.EnergyMomentum(),
    ancf.HHT(0.1),
)
SOLVERS = (
    "auto",
    ancf.Newton(),
    ancf.ModifiedNewton(),
    ancf.QuasiNewton("broyden"),
    ancf.QuasiNewton("bfgs", memory=5),
    ancf.QuasiNewton("dfp", memory=5, carry=True),
    ancf.QuasiNewton("davidon"),
)


def same(one, other):
    """Return whether two states are equal to the last bit."""
    return all(np.array_equal(getattr(one, k), getattr(other, k)) for k in ("q", "v", "a", "lam"))
