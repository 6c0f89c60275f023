"""Hairs that are combed over a ball come to rest on it, whatever the step is."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import hair
from ancfsparse.results.solutions.selected_states import select_states

G = 9.81
BALL, RADIUS, LENGTH = 0.1, 1.2e-3, 0.12  # [m]
COMB, HEIGHT = 0.01, 0.02  # [m]
WEIGHT = 1000.0 * math.pi * RADIUS**2 * LENGTH * G  # of a hair [N]
N = 10


@pytest.fixture(scope="module")
def made():
    return hair(N)


@pytest.fixture(scope="module")
def run(made):
    return simulate(made, 1e-3)


def simulate(made, dt, **more):
    return ancf.simulate(made.scene, 1.6, dt, integrator=ancf.GeneralizedAlpha(0.5), **more)


def points(run, hairs):
    """Points from 5 mm above the roots to the last one with a contact force, (k, n, 3) [m]."""
    places = np.linspace(5e-3, 0.985 * LENGTH, 40)
    return np.stack([run.position(hairs.at(e, s)) for e in range(N) for s in places], axis=1)


def test_they_come_to_rest_and_roots_and_ball_bear_their_weight(made, run):
    end = {name: values[0] for name, values in made.quantities(run, [-1]).items()}
    hairs, last = made.bodies["hairs"], select_states(run, np.array([-1]))
    of_roots = sum(last.reaction(hairs.node(k))[0, 2] for k in range(N))
    assert 0.01 * of_roots < end["force"] < of_roots
    assert end["force"] + of_roots == pytest.approx(N * WEIGHT, rel=2e-3)
    assert end["kinetic_energy"] < 1e-4 * run.energy.kinetic.max()


def test_the_comb_lifts_them_over_the_ball_and_leaves(made, run):
    """It turns by 200 degrees; its work exceeds the potential energy of a hair at the top."""
    middle = run.position(made.bodies["comb"].at(rod_axis(0.0)))
    angle = np.degrees(np.arctan2(middle[:, 0], middle[:, 2]))
    np.testing.assert_allclose(angle[[0, -1]], [-100.0, 100.0], atol=1e-3)
    assert run.energy.work[-1] > WEIGHT * LENGTH
    moment = np.abs(made.quantities(run, range(0, 1601, 100))["moment"])
    assert moment[-1] < 0.01 * moment.max()


def rod_axis(y):
    """A point of the axis of the rod at the start [m]."""
    angle = math.radians(100.0)
    return (BALL + HEIGHT) * np.array([-math.sin(angle), 0.0, math.cos(angle)]) + (0.0, y, 0.0)


def test_they_stay_outside_the_ball_and_the_rod(made, run):
    x = points(run, made.bodies["hairs"])
    above = np.linalg.norm(x, axis=2) - BALL
    assert above.min() > 0.95 * RADIUS  # between the points where forces act
    on_ball = run.contacts(run.t[-1])[0]
    assert 0.0 < on_ball.penetration < 0.01 * RADIUS
    begin, end = (run.position(made.bodies["comb"].at(rod_axis(y)))[:, None] for y in (-0.1, 0.1))
    pressed = made.scene.attachments[1].points
    x = np.stack([run.position(point) for point in pressed], axis=1)
    share = np.clip(np.sum((x - begin) * (end - begin), axis=2) / 0.04, 0.0, 1.0)
    away = np.linalg.norm(x - begin - share[:, :, None] * (end - begin), axis=2) - COMB
    assert 0.9 * RADIUS < away.min() < RADIUS  # the limit for impacts


def test_its_energy_is_accounted_for(run):
    assert run.energy.drift < 0.03
    assert not run.stats.events


@pytest.mark.slow
def test_half_the_step_changes_little(made, run):
    runs = run, simulate(made, 5e-4, save_every=2), simulate(made, 2.5e-4, save_every=4)
    combed = [made.watched["combed"](each) for each in runs]
    np.testing.assert_allclose(combed[0], combed[1], rtol=0.0, atol=0.03 * combed[1].max())
    assert combed[1][-1] == pytest.approx(combed[2][-1], rel=1e-3)


@pytest.mark.slow
def test_half_the_step_changes_the_mean_over_similar_steps_little(made):
    """A hair is nearly upright when the comb leaves it, so single runs vary by 4e-4 by chance."""
    numbers = range(1568, 1633, 8)
    ends = [
        [made.watched["combed"](simulate(made, 1.6 / (by * n)))[-1] for n in numbers]
        for by in (1, 2)
    ]
    assert np.mean(ends[0]) == pytest.approx(np.mean(ends[1]), rel=1e-3)
