"""Two shafts that cross at an angle, joined by a universal joint."""

import numpy as np
import pytest

import ancfsparse as ancf

ANGLE, SPEED = 0.5, 2.0  # rad, rad/s
ACROSS = (-np.sin(ANGLE), np.cos(ANGLE), 0.0)
SHAFT = np.array([np.cos(ANGLE), np.sin(ANGLE), 0.0])


def shafts():
    """A heavy shaft along x that turns alike, and a light one that the joint drives."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    place = {"position": (0, 0, 0)}
    drive = scene.add_body(
        inertia=(1e6, 1e6, 1e6), mass=1e3, angular_velocity=(SPEED, 0, 0), **place
    )
    scene.revolute(drive.origin, axis=(1, 0, 0))
    driven = scene.add_body(
        inertia=(1e-3, 1e-3, 1e-3),
        mass=1.0,
        orientation=np.array([SHAFT, ACROSS, (0, 0, 1)]).T,
        angular_velocity=SPEED * np.cos(ANGLE) * SHAFT,
        **place,
    )
    scene.universal(drive.origin, driven.origin, axis_a=(0, 0, 1), axis_b=ACROSS)
    return scene, driven


def test_speeds_are_those_of_hookes_joint():
    """w2 = w1 cos(b) / (1 - sin(b)^2 sin(w1 t)^2), with w1 t from where the fork is across both."""
    scene, driven = shafts()
    scene.pin(driven.at((1.0, 0.0, 0.0)))
    with pytest.warns(
        ancf.RedundantConstraintsWarning, match="follows from the rigidity of body 1, u.u"
    ):
        run = ancf.simulate(scene, 1.5, 1e-3)
    turned = SPEED * run.t
    exact = SPEED * np.cos(ANGLE) / (1.0 - (np.sin(ANGLE) * np.sin(turned)) ** 2)
    assert np.max(np.abs(run.body(driven).angular_velocity @ SHAFT - exact)) < 3e-6


def test_a_bearing_that_holds_what_is_held_is_refused_with_what_to_take():
    scene, driven = shafts()
    scene.cylindrical(driven.at((1.0, 0.0, 0.0)), axis=SHAFT)
    with pytest.raises(ancf.AncfError, match="or use a joint with more freedom, such as pin"):
        ancf.simulate(scene, 0.1, 1e-3)
