"""A cable around a turning drum: Euler and Eytelwein's T2 = T1 exp(mu phi)."""

import math
from itertools import pairwise

import numpy as np
import pytest

import ancfsparse as ancf

RADIUS, WIRE, TENSION, TAIL = 0.1, 1e-3, 10.0, 0.05
SQUARE = {"section": ancf.Rectangle(2e-3, 2e-3), "material": ancf.Material(2.5e10, 2.5e4)}


def wrapped(mu, angle, turning, dim=2):
    """A wire with straight ends, one of which is fixed and the other pulled; also a helix."""
    reach, pad = RADIUS + WIRE, (0.0,) * (dim - 2)

    def radial(phi):
        return np.array([-math.cos(phi), math.sin(phi), *pad])

    leaving = np.array([math.sin(angle), math.cos(angle), *pad])
    scene = ancf.Scene(np.zeros(dim))
    a, b = reach * radial(0.0), reach * radial(angle)
    up = np.array([0.0, 1.0, *pad])
    axis = {} if dim == 2 else {"axis": (0.0, 0.0, 1.0)}
    arc = ancf.Arc((0.0, 0.0, *pad), a, -angle, **axis)
    shape = {} if dim == 2 else {"rest": "straight"}
    parts = [
        scene.add_beam("thin", a - TAIL * up, a, 8, **SQUARE),
        scene.add_beam("thin", curve=arc, n_elements=int(16 * angle), **SQUARE, **shape),
        scene.add_beam("thin", b, b + TAIL * leaving, 8, **SQUARE),
    ]
    for one, other in pairwise(parts):
        scene.connect(one.end, other.start)
    scene.pin(parts[0].start)
    scene.point_force(parts[2].end, ancf.Ramp(TENSION * leaving, 0.05, smooth=True))
    drum = ancf.Drum((0.0, 0.0, *pad), RADIUS, angular_velocity=turning, **axis)
    # Of penetrations between 1 % of the radius of the wire and, where it is tightest, 10 %.
    stiffness = 1e7 * math.exp(max(-turning, 0.0) / 4.0 * mu * angle)
    contacts = [
        scene.contact(each, drum, stiffness=stiffness, radius=WIRE, friction=mu, slip_speed=1e-3)
        for each in parts
    ]
    return scene, parts, contacts


@pytest.mark.parametrize("turning", [2.0, -2.0])
@pytest.mark.parametrize("angle", [0.5 * math.pi, math.pi, 3.0 * math.pi])
@pytest.mark.parametrize("mu", [0.1, 0.3, 0.5])
def test_the_tension_grows_exponentially_along_the_arc(mu, angle, turning):
    scene, parts, contacts = wrapped(mu, angle, turning)
    solver = ancf.QuasiNewton("broyden", memory=20, max_iterations=60)  # 38 at the tightest
    run = ancf.simulate(scene, 0.3, 1e-3, integrator=ancf.GeneralizedAlpha(0.5), solver=solver)
    held = np.linalg.norm(run.reaction(parts[0].start)[-100:], axis=1).mean()
    assert held == pytest.approx(TENSION * math.exp(-turning / 2.0 * mu * angle), rel=1e-3)
    force = run.contact_force(contacts[1])
    assert np.allclose(
        np.linalg.norm(force.friction[-1], axis=1), mu * force.pressure[-1], rtol=2e-4
    )
    # The pressure is the tension over the radius of the axis; the wire is stretched by up to 1.1 %.
    middle = int(np.argmin(np.abs(force.s - 0.5 * force.s[-1])))
    there = TENSION * math.exp(-turning / 2.0 * mu * (angle - force.s[middle] / (RADIUS + WIRE)))
    assert force.pressure[-1, middle] == pytest.approx(there / (RADIUS + WIRE), rel=0.02)
