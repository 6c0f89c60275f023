"""The work of drives in the energy balance of `EnergyMomentum`, whose forces are means."""

import numpy as np
import pytest

import ancfsparse as ancf
from tests.beams import build_beam

MEANS = ancf.EnergyMomentum()


def swung(as_constraint):
    scene, beam = build_beam(
        "thin", (0, 0), (2, 0), 6, ancf.Rectangle(0.01, 0.01), ancf.Material(1e6, 4000.0)
    )
    far = np.array([0.3, 0.2])
    scene.drive(
        beam.start,
        lambda t: far * np.sin(2 * t) ** 2,
        rate=lambda t: far * 2 * np.sin(4 * t),
        second_rate=lambda t: far * 8 * np.cos(4 * t),
        as_constraint=as_constraint,
    )
    return scene


def cranked(as_constraint=True):
    """A crank with a rod in the plane, turned by a prescribed angle."""
    scene = ancf.Scene((0.0, -9.81))
    crank = scene.add_body(ancf.Rod(0.5), mass=1.0, position=(0, 0))
    rod = scene.add_body(ancf.Rod(1.0), mass=2.0, position=(0.5, 0))
    pin = scene.pin(crank.origin)
    scene.connect(crank.end, rod.origin)
    scene.drive_joint(
        pin,
        lambda t: t**3,
        rate=lambda t: 3 * t**2,
        second_rate=lambda t: 6 * t,
        as_constraint=as_constraint,
    )
    return scene


@pytest.mark.parametrize(
    ("make", "drift"),
    [
        (lambda: swung(True), 1e-11),
        (lambda: swung(False), 1e-6),
        (cranked, 1e-11),
        (lambda: cranked(False), 1e-6),
    ],
    ids=["multipliers", "numbering", "angle", "angle by numbering"],
)
def test_it_is_that_of_each_step(make, drift):
    """2.7e-3 before, for a beam whose end is driven by multipliers."""
    run = ancf.simulate(make(), 1.0, 4e-3, integrator=MEANS, tolerance=1e-10)
    assert np.ptp(run.energy.work) > 0.5
    assert run.energy.work[-1] == pytest.approx(run.last.memory["watch"]["work"], rel=1e-10)
    assert run.energy.drift < drift


def test_of_fewer_states_it_is_no_longer_half_a_step_late():
    """Of every second state, 4 ms apart and more: half a step late is 0.03 J and more."""
    exact = ancf.simulate(cranked(), 1.0, 2.5e-4, integrator=MEANS).energy.work[-1]
    off = [
        ancf.simulate(cranked(), 1.0, dt, integrator=MEANS, save_every=2).energy.work[-1] - exact
        for dt in (4e-3, 2e-3)
    ]
    assert np.max(np.abs(off)) < 1e-4
