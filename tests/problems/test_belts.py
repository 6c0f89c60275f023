"""Belts over several pulleys, and without slip, against equilibria of moments and lengths."""

import cmath
import math

import numpy as np
import pytest
from scipy.optimize import root, root_scalar

import ancfsparse as ancf
from ancfsparse.problems import serpentine, timing_belt
from ancfsparse.problems.belts import ARM_MOMENT, ARM_STIFFNESS, LAYOUT, PIVOT

DAMPED = ancf.GeneralizedAlpha(0.5)


def tangents(circles):
    """Directions as complex numbers and lengths of the spans to each circle, and arcs around it.

    The belt has one circle (centre, radius, sense) to its left for the sense 1.  A span makes the
    angle with the line between centres whose sine is the difference of signed radii over distance.
    """
    directions, lengths = [], []
    for k, (centre, radius, sense) in enumerate(circles):
        before, other, its_sense = circles[k - 1]
        line = centre - before
        angle = math.asin((sense * radius - its_sense * other) / abs(line))
        directions.append(line / abs(line) * cmath.exp(-1j * angle))
        lengths.append(abs(line) * math.cos(angle))
    arcs = [
        sense * cmath.phase(directions[(k + 1) % len(circles)] / directions[k]) % (2.0 * math.pi)
        for k, (_, _, sense) in enumerate(circles)
    ]
    return directions, lengths, arcs


class Serpentine:
    """Steady motion of the belt: equilibrium of the arm, of moments, and the length without stress.

    The belt keeps the tension of its span on a pulley up to the arc before the exit on which it
    slides, where the tension is exponential.  It sinks into the pulleys by T / (k R).
    """

    ea, mass, strain, stiffness, mu = 5e4, 0.1, 3e-3, 5e8, 0.6

    def __init__(self, alternator, pump, omega):
        moments = {"alternator": alternator, "pump": pump}
        self.rises = [moments.get(name, 0.0) / LAYOUT[name][1] for name in LAYOUT][1:]
        self.rim = omega * LAYOUT["crank"][1]
        self.pivot = complex(*PIVOT)
        self.circles = [(complex(*c), r, s) for c, r, s in LAYOUT.values()]
        self.length = self.path(self.circles)[0] / (1.0 + self.strain)

    def path(self, circles):
        _, lengths, arcs = tangents(circles)
        pieces = [n + r * a for n, (_, r, _), a in zip(lengths, circles, arcs, strict=True)]
        return sum(pieces), pieces

    def tensions(self, slack):
        """Tensions of the spans from the crank on; the last one enters the crank."""
        return slack + np.concatenate([[0.0], np.cumsum(self.rises)])

    def state(self, unknowns):
        slack, turn = unknowns
        tensions = self.tensions(slack)
        feed = self.rim / (1.0 + tensions[-1] / self.ea)
        flow = self.mass * feed**2 * (1.0 + tensions / self.ea)
        entering = np.roll(tensions, 1)  # at the pulleys, beginning with the crank
        circles = list(self.circles)
        hub = self.pivot + (circles[1][0] - self.pivot) * cmath.exp(1j * turn)
        circles[1] = hub, *circles[1][1:]
        directions, _, _ = tangents(circles)
        force = (slack - flow[0]) * (directions[2] - directions[1])
        moment = ((hub - self.pivot).conjugate() * force).imag
        spring = -ARM_MOMENT - ARM_STIFFNESS * turn
        sunk = [
            (c, r - t / (self.stiffness * r), s)
            for (c, r, s), t in zip(circles, entering, strict=True)
        ]
        slides = np.abs(np.log((tensions - flow) / (entering - flow))) / self.mu
        # Integral of T less the entering tension over the arc on which it slides.
        grown = np.abs(tensions - entering) / self.mu + flow * slides
        excess = grown - entering * slides
        pieces = self.path(sunk)[1] / (1.0 + entering / self.ea)
        radii = np.array([r for _, r, _ in circles])
        length = sum(pieces - radii * excess / self.ea) - self.length
        return moment + spring, length, sunk

    def solve(self):
        """Tensions of the spans [N], rotation of the arm [rad], and speeds of pulleys [rad/s]."""

        def scaled(unknowns):
            moment, length, _ = self.state(unknowns)
            return moment, length * self.ea

        slack, turn = root(scaled, (150.0, 0.0), tol=1e-12).x
        tensions, sunk = self.tensions(slack), self.state((slack, turn))[2]
        entering = np.roll(tensions, 1)
        passing = (1.0 + entering / self.ea) / [r for _, r, _ in sunk]
        return tensions, turn, self.rim / LAYOUT["crank"][1] * passing / passing[0]

    def excess_of_slip_arc(self):
        """Arc on which the belt slides on the alternator less the one that it touches [rad]."""
        tensions, turn, _ = self.solve()
        flow = self.mass * self.rim**2
        ratio = (tensions[2] - flow) / (tensions[1] - flow)
        return math.log(ratio) / self.mu - tangents(self.state((tensions[0], turn))[2])[2][2]


@pytest.mark.slow
def test_a_serpentine_belt_with_a_tensioner():
    """Equilibria of pulleys, where each load raises the tension by moment over radius, and arm."""
    tensions, turn, speeds = Serpentine(2.0, 3.0, 60.0).solve()
    made = serpentine()
    run = ancf.simulate(made.scene, 0.3, 1e-4, integrator=DAMPED, save_every=10)
    found = {name: values[run.t > 0.25] for name, values in made.quantities(run).items()}
    spans = found["spans"].mean(axis=0)
    np.testing.assert_allclose(spans, tensions, rtol=3e-3)
    np.testing.assert_allclose(np.diff(spans), [0.0, 2.0 / 0.03, 3.0 / 0.06, 0.0], atol=1.0)
    assert found["arm"].mean() == pytest.approx(turn, rel=0.01)
    np.testing.assert_allclose(found["omegas"].mean(axis=0), speeds, rtol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "slips"), [(0.96, False), (1.04, True)])
def test_the_alternator_slips_at_the_moment_of_the_capstan(ratio, slips):
    """Where its tensions, less the centrifugal force, have the ratio exp(mu phi): 8.0 N m."""

    def excess(moment):
        return Serpentine(moment, 3.0, 60.0).excess_of_slip_arc()

    limit = root_scalar(excess, bracket=(5.0, 12.0)).root
    made = serpentine(alternator=ratio * limit)
    run = ancf.simulate(made.scene, 0.26, 1e-4, integrator=DAMPED, save_every=10)
    speeds = made.quantities(run)["omegas"][run.t > 0.2]
    assert (speeds[-1, 2] < 0.5 * speeds[0, 2]) == slips
    assert (speeds[-1, 2] > 0.98 * 60.0 * 0.08 / 0.03) != slips
    np.testing.assert_allclose(speeds[:, 3], 80.0, rtol=5e-3)  # the pump never slips


def test_a_timing_belt_keeps_the_ratio_of_radii():
    """Tensions by the moment and the length without stress, which sticks as it arrives."""
    ea, start, stiffness, load = 1e6, 400.0, 2e9, 20.0
    made = timing_belt(load=load, n_elements=120)
    run = ancf.simulate(made.scene, 0.2, 2e-4, integrator=DAMPED, save_every=5)
    found = {name: values[run.t > 0.15].mean() for name, values in made.quantities(run).items()}
    _, (tight_span, slack_span), arcs = tangents([(0.0, 0.05, -1.0), (0.3, 0.1, -1.0)])
    high, low = tight_span + 0.05 * arcs[0], slack_span + 0.1 * arcs[1]
    sinks = (
        arcs[0] / (0.05 * stiffness),
        arcs[1] / (0.1 * stiffness),
    )  # shorter lengths over tensions
    difference = load / 0.1
    # high T/EA + low S/EA + sinks T + sinks S = (high + low) start/EA, T = S + difference
    stretch = high / ea + sinks[0], low / ea + sinks[1]
    slack = ((high + low) * start / ea - stretch[0] * difference) / sum(stretch)
    assert found["tight"] - found["slack"] == pytest.approx(difference, rel=5e-3)
    assert found["slack"] == pytest.approx(slack, rel=0.02)
    assert found["ratio"] == pytest.approx(2.0, rel=1e-3)
    creep = difference / ea + (slack + difference) / (0.05**2 * stiffness)
    creep -= slack / (0.1**2 * stiffness)
    assert found["speed_loss"] == pytest.approx(creep, abs=2e-4)
    assert max(found["slip_arc_driver"], found["slip_arc_driven"]) < 2.0
