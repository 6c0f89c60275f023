"""A cable around a turning drum: Euler and Eytelwein's T2 = T1 exp(mu phi)."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems.contacts import DRUM_RADIUS, WIRE_RADIUS, capstan

TENSION = 10.0


@pytest.mark.parametrize("slip_speed", [0.0, 1e-3], ids=["sticks", "slips"])
@pytest.mark.parametrize("turning", [2.0, -2.0])
@pytest.mark.parametrize("angle", [90.0, 180.0, 540.0])
@pytest.mark.parametrize("mu", [0.1, 0.3, 0.5])
def test_the_tension_grows_exponentially_along_the_arc(mu, angle, turning, slip_speed):
    case = capstan(mu, angle, TENSION, turning, int(0.28 * angle), slip_speed)
    solver = ancf.QuasiNewton("broyden", memory=20, max_iterations=60)  # 38 at the tightest
    run = ancf.simulate(case.scene, 0.3, 1e-3, integrator=ancf.GeneralizedAlpha(0.5), solver=solver)
    exponent, phi = math.copysign(mu, turning), math.radians(angle)
    held = case.quantities(run)["held"][-100:].mean()
    assert held == pytest.approx(TENSION * math.exp(exponent * phi), rel=1e-3)
    force = run.contact_force(case.scene.attachments[1]).at(-1)
    friction = np.linalg.norm(force.friction, axis=1)
    ratio = friction[force.pressure > 0.0] / (mu * force.pressure[force.pressure > 0.0])
    assert ratio.max() <= 1.0 + 1e-12
    if slip_speed:
        assert np.allclose(friction, mu * force.pressure, rtol=2e-4)
    else:
        assert np.quantile(ratio, 0.1) > 1.0 - 2e-4  # single points may stick for a moment
    # The pressure is the tension over the radius of the axis; the wire is stretched by up to 1.1 %.
    reach = DRUM_RADIUS + WIRE_RADIUS
    middle = int(np.argmin(np.abs(force.s - 0.5 * force.s[-1])))
    tension = TENSION * math.exp(exponent * (phi - force.s[middle] / reach))
    assert force.pressure[middle] == pytest.approx(tension / reach, rel=0.02)
