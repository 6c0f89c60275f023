"""Belt drives with friction of bristles: tensions, creep, slip arcs, and the moment at slip."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import root

import ancfsparse as ancf
from ancfsparse.problems import belt_drive, belt_drive_pechstein

DAMPED = ancf.GeneralizedAlpha(0.5)
GRIP = 0.1  # stiffness of the bristles over the one of the contact


@dataclass(frozen=True)
class Theory:
    """A belt around two equal pulleys by Euler and Eytelwein, with centrifugal force.

    A belt of the strain T/EA passes with c = c0 (1 + T/EA), where R omega is c of the tight side on
    the driver and of the slack side on the driven pulley; the length without stress is constant.
    `moment` is a function of the angular velocity of the driven pulley [N m].
    """

    moment: object
    omega: float = 100.0
    mu: float = 0.3
    ea: float = 2e4
    mass: float = 0.1
    strain: float = 0.01
    r: float = 0.1
    d: float = 0.4

    def pressing(self, tension, feed):
        """The part of the tension that presses on the pulley: T - mass c^2 (1 + T/EA)."""
        return tension - self.mass * feed**2 * (1.0 + tension / self.ea)

    def residuals(self, unknowns):
        tight, slack = unknowns
        feed = self.r * self.omega / (1.0 + tight / self.ea)
        high, low = self.pressing(tight, feed), self.pressing(slack, feed)
        arc = math.log(high / low) / self.mu
        g = self.mass * feed**2
        # Where it slides, the tension grows exponentially but for the centrifugal force.
        along = low * (high / low) ** np.linspace(0.0, 1.0, 201)
        sliding = np.trapezoid(1.0 / (1.0 + (along + g) / (self.ea - g)), dx=arc / 200)
        sticking = self.d + self.r * (math.pi - arc)
        free = sticking * (1.0 / (1.0 + tight / self.ea) + 1.0 / (1.0 + slack / self.ea))
        length = (2.0 * self.d + 2.0 * math.pi * self.r) / (1.0 + self.strain)
        omega = feed * (1.0 + slack / self.ea) / self.r
        return (
            self.r * (high - low) - self.moment(omega),
            self.ea * (free + 2.0 * self.r * sliding - length),
        )

    def solve(self):
        """Tight and slack tension [N], speed of the driven pulley [rad/s], slip arc [degrees]."""
        mean = self.ea * self.strain
        tight, slack = root(self.residuals, (1.3 * mean, 0.7 * mean), tol=1e-12).x
        feed = self.r * self.omega / (1.0 + tight / self.ea)
        arc = math.log(self.pressing(tight, feed) / self.pressing(slack, feed)) / self.mu
        return tight, slack, feed * (1.0 + slack / self.ea) / self.r, math.degrees(arc)

    def bristle_arcs(self, stiffness):
        """Slip arcs of driver and driven pulley if the belt holds on by bristles [degrees].

        They deflect by the difference of its strain from the one with which it arrives, so where it
        sticks friction grows as exp(x / l) with l^2 = EA / k_t, up to the limit where it slides.
        """
        tight, slack, _, arc = self.solve()
        ratio = self.mu / self.r * math.sqrt(self.ea / (GRIP * stiffness))
        at_driver = math.log(1.0 + ratio * (1.0 + tight / self.ea))
        at_driven = -math.log(1.0 - ratio * (1.0 + slack / self.ea))
        return [arc - math.degrees(each / self.mu) for each in (at_driver, at_driven)]


PUBLISHED = Theory(
    lambda omega: 2.0 * omega + 25.0, omega=12.0, mu=0.5, ea=0.95 * 8000.0, mass=0.8288 / 0.95,
    strain=1.0 / 0.95 - 1.0, d=0.1 * math.pi,
)  # fmt: skip


def test_the_theory_has_the_published_numbers():
    """An independent solution: 251.2362 N, 151.1875 N, 99.505962 rad/s, 102.1734 degrees."""
    tight, slack, omega, arc = Theory(lambda omega: 10.0).solve()
    assert tight == pytest.approx(251.2362, rel=2e-5)
    assert slack == pytest.approx(151.1875, rel=2e-5)
    assert omega == pytest.approx(99.505962, rel=1e-6)
    assert arc == pytest.approx(102.1734, rel=1e-4)


def test_the_theory_has_the_numbers_of_pechsteins_drive():
    """Independent: 663.2 N, 186.9 N, 11.308 rad/s, 145.6 degrees."""
    found = PUBLISHED.solve()
    np.testing.assert_allclose(found, (663.2, 186.9, 11.308, 145.6), rtol=4e-4)


def drive(load, n_elements, t_end, dt=1e-4):
    case = belt_drive(load=load, n_elements=n_elements)
    every = round(1e-3 / dt)
    run = ancf.simulate(case.scene, t_end, dt, integrator=DAMPED, save_every=every)
    return run, case.quantities(run)


@pytest.mark.slow
@pytest.mark.parametrize("load", [5.0, 10.0])
def test_tensions_loss_of_speed_and_slip_arcs_are_those_of_creep(load):
    """The arcs are shorter than those of Coulomb by the length in which bristles deflect."""
    theory = Theory(lambda omega: load)
    tight, slack, omega, slip = theory.solve()
    run, found = drive(load, 160, 0.3)
    last = run.t > 0.2
    assert found["tight"][last].mean() == pytest.approx(tight, rel=1e-3)
    assert found["slack"][last].mean() == pytest.approx(slack, rel=1e-3)
    assert found["speed_loss"][last].mean() == pytest.approx(1.0 - omega / 100.0, rel=1e-2)
    for name, bristles in zip(
        ("slip_arc_driver", "slip_arc_driven"), theory.bristle_arcs(2e9), strict=True
    ):
        arc = found[name][last].mean()
        assert arc == pytest.approx(slip, abs=10.0)
        assert arc == pytest.approx(bristles, abs=4.0)


@pytest.mark.slow
@pytest.mark.parametrize(("load", "slips"), [(16.9, False), (17.58, True)])
def test_it_slips_at_the_moment_where_the_arc_slides_as_a_whole(load, slips):
    """17.245 N m: Th_t / Th_s = exp(mu pi)."""
    run, found = drive(load, 60, 0.3)
    speed = found["w2"]
    assert (speed[-1] < 0.9 * speed[run.t > 0.2][0]) == slips
    assert (found["speed_loss"][-1] > 0.05) == slips


@pytest.mark.slow
def test_the_drive_of_pechstein_and_gerstmayr():
    """Steps of 1 ms against theory, and in the last 50 ms against steps of 0.05 ms."""
    tight, slack, omega, slip = PUBLISHED.solve()
    case = belt_drive_pechstein(n_elements=60)
    coarse = ancf.simulate(case.scene, 2.4, 1e-3, integrator=DAMPED)
    end = {
        dt: case.quantities(
            ancf.simulate(case.scene, 2.45, dt, integrator=DAMPED, start=coarse.last)
        )
        for dt in (1e-3, 5e-5)
    }
    for found in end.values():
        assert found["tight"].mean() == pytest.approx(tight, rel=2e-3)
        assert found["slack"].mean() == pytest.approx(slack, rel=2e-3)
        assert found["w2"].mean() == pytest.approx(omega, rel=1e-3)
        for name, bristles in zip(
            ("slip_arc_driver", "slip_arc_driven"), PUBLISHED.bristle_arcs(3.2e8), strict=True
        ):
            assert found[name].mean() == pytest.approx(bristles, abs=5.0)
            assert found[name].mean() == pytest.approx(slip, abs=15.0)
    one, other = (end[dt]["tension"][-1] for dt in (1e-3, 5e-5))
    np.testing.assert_allclose(one, other, rtol=0.02)
