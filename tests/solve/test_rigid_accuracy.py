"""Motions of rigid bodies to an accuracy, against a pendulum's equation of one angle."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ancfsparse as ancf
from ancfsparse.solve.implicit_runs import ITERATIONS_SHARE

G, ANGLE, LENGTH = 9.81, 0.3, 1.6555


def rod():
    """A thin rod of 1 m, pinned where its origin is, so that nothing but its vector moves."""
    return ancf.Rod(1.0), (0.0, 0.0), lambda body: (body.origin, body.end), 1.5 * G


def box():
    """A box of 1 x 0.2 m about its origin, pinned beside it, by equations."""
    where = (0.5 * np.sin(ANGLE), -0.5 * np.cos(ANGLE))
    stiffness = G * 0.5 / (1.04 / 12.0 + 0.25)
    ends = lambda body: (body.at((-0.5, 0.0)), body.at((0.5, 0.0)))  # noqa: E731
    return ancf.Box(1.0, 0.2, 0.1), where, ends, stiffness


@pytest.mark.parametrize("body", [rod, box])
@pytest.mark.parametrize("accuracy", [1e-4, 1e-6])
def test_a_pendulum_is_as_accurate_as_asked_for(body, accuracy):
    """The vectors of a body count, and what iterations leave in all steps does not add up."""
    shape, where, ends, stiffness = body()
    scene = ancf.Scene((0.0, -G))
    made = scene.add_body(shape, mass=2.0, position=where, orientation=ANGLE - np.pi / 2)
    held, end = ends(made)
    scene.pin(held)
    run = ancf.simulate(scene, LENGTH, accuracy=accuracy)

    def rates(_, y):
        return y[1], -stiffness * np.sin(y[0])

    options = {"t_eval": run.t, "method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    angle = solve_ivp(rates, (0.0, LENGTH), (ANGLE, 0.0), **options).y[0]
    exact = np.stack([np.sin(angle), -np.cos(angle)], axis=1)
    off = np.max(np.linalg.norm(run.position(end) - exact, axis=1))
    assert run.finished
    assert off < accuracy
    assert off < 2.0 * run.stats.error + ITERATIONS_SHARE * accuracy
