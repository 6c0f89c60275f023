"""Motions of rigid bodies to an accuracy, against a pendulum's equation of one angle."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ancfsparse as ancf
from ancfsparse.solve.error_control.implicit_candidate import ITERATIONS_RATIO

G, ANGLE, LENGTH = 9.81, 0.3, 1.6555


def rod():
    """A thin rod of 1 m, pinned where its origin is, so that nothing but its vector moves."""
    return ancf.Rod(1.0), (0.0, 0.0), lambda body: (body.origin, body.end), 1.5 * G


def box():
    """A box of 1 x 0.2 m about its origin, pinned beside it, by equations."""
    where = (0.5 * np.sin(ANGLE), -0.5 * np.cos(ANGLE))
    stiffness = G * 0.5 / (1.04 / 12.0 + 0.25)
    ends = lambda body: (body.at((-0.5, 0.0)), body.at((0.5, 0.0)))  # noqa: E731
    return ancf.Box(length=1.0, width=0.1, height=0.2), where, ends, stiffness


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
    assert off < 2.0 * run.stats.error + ITERATIONS_RATIO * accuracy


@pytest.mark.parametrize("omega", [(1e-3, 5.0, 0.0), (1.0, 2.0, 3.0)])
@pytest.mark.parametrize(("accuracy", "steps"), [(1e-3, 1500), (1e-6, 8000)])
def test_a_body_that_spins_takes_no_more_steps_than_it_needs(omega, accuracy, steps):
    """Each step needs a factor, as the body turns; shorter ones do too, so they do not pay."""
    moments, t_end = np.array([2.0, 3.0, 4.0]), 2.0
    scene = ancf.Scene((0.0, 0.0, 0.0))
    body = scene.add_body(inertia=moments, mass=6.0, position=(0, 0, 0), angular_velocity=omega)
    run = ancf.simulate(scene, t_end, accuracy=accuracy)

    def rates(_, y):
        w, turned = y[:3], y[3:].reshape(3, 3)
        spin = np.cross(np.eye(3), w)
        return np.concatenate([-np.cross(w, moments * w) / moments, (turned @ spin).ravel()])

    options = {"t_eval": run.t, "method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    exact = solve_ivp(rates, (0.0, t_end), np.concatenate([omega, np.eye(3).ravel()]), **options).y
    # Columns of a rotation are unit vectors, so points 1 m from the centre.
    off = np.linalg.norm(run.body(body).rotation - exact[3:].T.reshape(-1, 3, 3), axis=1).max()
    assert off < accuracy
    assert off < 2.0 * run.stats.error + ITERATIONS_RATIO * accuracy
    assert run.stats.steps < steps


@pytest.mark.parametrize("as_constraint", [False, True])
@pytest.mark.parametrize("driven", [False, True])
def test_forces_are_as_accurate_as_positions(as_constraint, driven):
    """States lie between steps of half a radian, where lines between their ends miss forces."""
    size, rate, mass = (0.1 if driven else 0.0), 7.0, 2.0

    def place(t):
        return 0.0 * t, size * np.cos(rate * t)

    def second(t):
        return 0.0 * t, -size * rate**2 * np.cos(rate * t)

    scene = ancf.Scene((0.0, -G))
    rod = scene.add_body(ancf.Rod(1.0), mass=mass, position=place(0.0), orientation=0.0)
    if driven:
        rates = {"rate": lambda t: (0.0 * t, -size * rate * np.sin(rate * t))}
        scene.drive(rod.origin, place, **rates, second_rate=second, as_constraint=as_constraint)
    else:
        scene.pin(rod.origin, as_constraint=as_constraint)
    run = ancf.simulate(scene, 4.0, accuracy=1e-6)

    def turn(t, y):
        return y[1], -1.5 * (G + second(t)[1]) * np.cos(y[0])

    options = {"t_eval": run.t, "method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    angle, speed = solve_ivp(turn, (0.0, 4.0), (0.0, 0.0), **options).y
    along = np.stack([np.cos(angle), np.sin(angle)])
    across = np.stack([-np.sin(angle), np.cos(angle)])
    support = np.array([np.zeros_like(run.t), G + second(run.t)[1]])
    twice = turn(run.t, (angle, speed))[1]
    exact = mass * (support + 0.5 * (twice * across - speed**2 * along))
    off = np.abs(run.reaction(rod.origin) - exact.T).max() / np.abs(exact).max()
    assert off < 1e-5
