"""A belt drive with friction of bristles: tensions, creep, and the moment at which it slips."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import belt_drive
from ancfsparse.problems.contacts import (
    BELT_MASS,
    BELT_RADIUS,
    BELT_STIFFNESS,
    BELT_STRAIN,
    CENTRE_DISTANCE,
)

OMEGA, MU = 100.0, 0.3


def theory(load):
    """Tight and slack tension [N], and loss of speed [1] by Euler and Eytelwein.

    A belt of the strain T/EA passes with c = c0 (1 + T/EA), where R omega is that of the tight side
    on the driver and of the slack side on the driven pulley; the free length is constant.
    """
    ea, r, d = BELT_STIFFNESS, BELT_RADIUS, CENTRE_DISTANCE

    def held(tension, c0):
        g = BELT_MASS * c0**2
        return tension * (1.0 - g / ea) - g

    def residuals(tight, slack):
        c0 = r * OMEGA / (1.0 + tight / ea)
        high, low = held(tight, c0), held(slack, c0)
        arc = math.log(high / low) / MU
        g = BELT_MASS * c0**2
        # Where it slides, the tension grows exponentially but for the centrifugal force.
        along = low * (high / low) ** np.linspace(0.0, 1.0, 201)
        sliding = np.trapezoid(1.0 / (1.0 + (along + g) / (ea - g)), dx=arc / 200)
        free = (d + r * (math.pi - arc)) * (1.0 / (1.0 + tight / ea) + 1.0 / (1.0 + slack / ea))
        free += 2.0 * r * sliding
        return r * (high - low) - load, free - (2 * d + 2 * math.pi * r) / (1.0 + BELT_STRAIN)

    tight, slack = 250.0, 150.0
    for _ in range(20):  # Newton's method with differences
        f = residuals(tight, slack)
        a, b = residuals(tight + 1e-4, slack), residuals(tight, slack + 1e-4)
        j = [[(a[i] - f[i]) / 1e-4, (b[i] - f[i]) / 1e-4] for i in (0, 1)]
        det = j[0][0] * j[1][1] - j[0][1] * j[1][0]
        tight -= (f[0] * j[1][1] - f[1] * j[0][1]) / det
        slack -= (f[1] * j[0][0] - f[0] * j[1][0]) / det
    return tight, slack, (tight - slack) / (ea + tight)


def test_the_theory_has_the_published_numbers():
    """An independent solution of the same equations: 251.2362 N, 151.1875 N, 4.94038e-3."""
    tight, slack, loss = theory(10.0)
    assert tight == pytest.approx(251.2362, rel=2e-5)
    assert slack == pytest.approx(151.1875, rel=2e-5)
    assert loss == pytest.approx(4.94038e-3, rel=1e-4)


def drive(load, n_elements, t_end):
    case = belt_drive(load=load, n_elements=n_elements)
    run = ancf.simulate(
        case.scene, t_end, 2e-4, integrator=ancf.GeneralizedAlpha(0.5), save_every=5
    )
    return run, case.quantities(run)


@pytest.mark.slow
def test_tensions_and_loss_of_speed_are_those_of_creep():
    tight, slack, loss = theory(10.0)
    run, found = drive(10.0, 120, 0.4)
    last = run.t > 0.3
    assert found["tight"][last].mean() == pytest.approx(tight, rel=5e-3)
    assert found["slack"][last].mean() == pytest.approx(slack, rel=5e-3)
    assert found["loss"][last].mean() == pytest.approx(loss, rel=2e-2)


@pytest.mark.slow
@pytest.mark.parametrize(("load", "slips"), [(16.9, False), (17.6, True)])
def test_it_slips_at_the_moment_where_the_arc_slides_as_a_whole(load, slips):
    """17.245 N m: Th_t / Th_s = exp(mu pi)."""
    run, found = drive(load, 60, 0.3)
    speed = found["omega_driven"]
    assert (speed[-1] < 0.9 * speed[run.t > 0.2][0]) == slips
    assert (found["loss"][-1] > 0.05) == slips
