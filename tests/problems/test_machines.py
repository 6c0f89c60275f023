"""Ropes, springs, arms and cranes beside formulas and beside programs that share nothing with them.

Each reference is computed here, with the tolerance that the mesh of the named scene leaves.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

import ancfsparse as ancf
from ancfsparse.problems import (
    bend,
    cable_car,
    catenary,
    crane,
    hanging_net,
    mooring,
    robot_arm,
    spring_antenna,
)
from ancfsparse.problems.named import MECHANISMS
from tests.grids import level_grid
from tests.problems.rods import G, carried, hung, shot, spatial


def value_of(name):
    """Return the number that a scene is known by."""
    return np.array(MECHANISMS[name].value)


def test_catenary():
    """Irvine's elastic catenary: every part carries its weight, and stretches by its tension."""
    length, area = 24.0, math.pi * 1e-4
    weight, axial = 1200.0 * area * G, 1e9 * area

    def place(pull, s):
        h, v = pull
        low, high = -v / h, (-v + weight * s) / h
        x = h * s / axial + h / weight * (np.arcsinh(high) - np.arcsinh(low))
        y = (-v * s + 0.5 * weight * s**2) / axial
        return np.array([x, y + h / weight * (np.hypot(1, high) - np.hypot(1, low))])

    pull = fsolve(lambda pull: place(pull, length) - (20.0, 5.0), (40.0, 40.0), xtol=1e-13)
    np.testing.assert_allclose(value_of("catenary"), pull * [-1, 1], rtol=1e-8)
    errors = []
    for n in (64, 128):
        scene = catenary(n)
        rest = ancf.solve_static(scene.scene)
        errors.append(rest.position(scene.bodies["rope"].at(12.0)) - place(pull, 12.0))
    assert np.abs(errors[1]).max() < 2e-4
    np.testing.assert_allclose(errors[0] / errors[1], 4.0, rtol=0.05)


def test_hanging_net():
    """Newton's method for the energy of a truss, whose bars take half their weight to each end."""
    n, axial, weight = 12, 2e6 * math.pi * 25e-6, 1100.0 * math.pi * 25e-6 * G
    side = 4.0 / n
    x, bars, number = level_grid(n + 1, 4.0)
    at = x[:, :2] / 4.0
    x[:, 2] = -1.5 * (1.0 - np.max(np.abs(2.0 * at - 1.0), axis=1) ** 2) - 0.5
    corners = number[[0, 0, -1, -1], [0, -1, 0, -1]]
    x[corners, 2] = 0.0
    free = np.setdiff1d(np.arange(3 * len(x)), (3 * corners[:, None] + np.arange(3)).ravel())
    pull = np.zeros_like(x)
    np.add.at(pull[:, 2], bars.ravel(), -0.5 * weight * side)
    for _ in range(200):
        force, matrix = pull.copy(), np.zeros((3 * len(x), 3 * len(x)))
        for a, b in bars:
            way = x[b] - x[a]
            length = np.linalg.norm(way)
            u, tension = way / length, axial * (length / side - 1.0)
            force[a] += tension * u
            force[b] -= tension * u
            along = np.outer(u, u)
            k = axial / side * along + max(tension, 0.0) / length * (np.eye(3) - along)
            for one, other, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
                matrix[3 * one : 3 * one + 3, 3 * other : 3 * other + 3] += sign * k
        step = np.linalg.solve(matrix[np.ix_(free, free)], force.ravel()[free])
        x.ravel()[free] += step * min(1.0, 0.3 / np.abs(step).max())
        if np.abs(step).max() < 1e-12:
            break
    np.testing.assert_allclose(value_of("hanging_net"), x[number[n // 2, n // 2]], atol=1e-8)
    scene = hanging_net()
    rest = ancf.solve_static(scene.scene)
    assert rest.stable
    np.testing.assert_allclose(
        [rest.position(scene.bodies["net"].node(k)) for k in range(len(x))], x, atol=1e-8
    )


def test_cable_car():
    """The carriage hangs where the load is at a right angle to the rope, bent there by it."""
    scene = cable_car()
    rope, carriage = scene.bodies["rope"], scene.bodies["carriage"]
    rest, freed = (ancf.solve_static(scene.scene, t=t) for t in (0.0, 1.0))
    for found, held in ((rest, 300.0), (freed, 0.0)):
        load = -held, -100.0 * G
        place, pull = carried(21.0, np.array([20.0, 1.0]), 1e6, 1000.0, 1.5 * G, load)
        np.testing.assert_allclose(found.position(carriage.origin), place, rtol=0.0, atol=2e-3)
        np.testing.assert_allclose(found.reaction(rope.start), pull, rtol=5e-4)
        if held:
            np.testing.assert_allclose(value_of("cable_car"), place, rtol=0.0, atol=1e-6)
    run = ancf.simulate(scene.scene, 2.0, 2e-3, start=rest)
    assert np.ptp(scene.quantities(run)["carriage"][:, 0]) > 2.0


def test_mooring():
    """At rest and displaced, the tension is that of a chain integrated from where it lifts off."""
    moored = mooring()
    platform, chain = moored.bodies["platform"], moored.bodies["chain 1"]
    length, weight, stiffness = 120.0, 614.0, 3e8

    def hang(pull, height):
        """Return the distance of the ends, and the tension at the upper one, for a level pull."""

        def slope(s, x):
            tension = np.hypot(pull, weight * s)
            return np.array([pull, weight * s]) * (1.0 / tension + 1.0 / stiffness)

        def reaches(s, x):
            return x[1] - height

        reaches.terminal = True
        path = solve_ivp(
            slope, (0.0, 4.0 * length), (0.0, 0.0), events=reaches, rtol=1e-10, atol=1e-10
        )
        (s,), (x,) = path.t_events[0], path.y_events[0]
        return x[0] + (length - s) * (1.0 + pull / stiffness), np.hypot(pull, weight * s)

    for t, way in ((0.0, 0.0), (2.5, 3.0)):
        rest = ancf.solve_static(moored.scene, t=t)
        centre = rest.position(platform.origin)
        np.testing.assert_allclose(centre[0], way, atol=1e-9)
        height = centre[2]
        distance = np.linalg.norm((rest.position(chain.end) - rest.position(chain.start))[:2])
        pull = brentq(lambda pull, z, x: hang(pull, z)[0] - x, 2e4, 1e5, (height, distance))
        np.testing.assert_allclose(np.linalg.norm(rest.reaction(chain.start)[:2]), pull, rtol=2e-3)
        if t == 0.0:
            assert value_of("mooring") == pytest.approx(hang(pull, height)[1], rel=1e-6)


def test_robot_arm():
    """The pull of the hose by a rod with hinges, then the moment that the shoulder needs."""
    scene = robot_arm()
    rest = ancf.solve_static(scene.scene)
    start, hand = np.array([-0.3, 0.0]), rest.position(scene.bodies["fore"].end)
    pull, middle = hung(2.6, start, hand, 2e4, 0.05, 0.3 * G, 1.0)
    np.testing.assert_allclose(value_of("robot_arm"), pull, atol=1e-8)
    hose = scene.bodies["hose"]
    np.testing.assert_allclose(rest.reaction(hose.start), pull, atol=1e-6)
    np.testing.assert_allclose(rest.position(hose.at(1.3)), middle, atol=1e-6)
    at_hand = pull - (0.0, 0.3 * 2.6 * G)  # what the hose does to the hand
    weights = 8.0 * 0.25 + 5.0 * (0.5 + 0.4 * math.cos(math.radians(30.0)))
    needed = G * weights - (hand[0] * at_hand[1] - hand[1] * at_hand[0])
    run = ancf.simulate(scene.scene, 2.0, 2e-3, start=rest)
    found = scene.quantities(run)
    assert found["shoulder"][0] == pytest.approx(needed, rel=1e-6)
    u = np.radians([60.0 + 45.0, -30.0 + 45.0 + 75.0])
    expected = (math.cos(u[0]) + 0.8 * math.cos(u[1]), math.sin(u[0]) + 0.8 * math.sin(u[1]))
    np.testing.assert_allclose(found["hand"][-1], expected, atol=1e-6)


def test_bend():
    """Shear and stretch included: a force at the tip of an arc that is clamped."""
    stiffness = 1e7, 5.0 / 6.0 * 5e6, 5e6 / 6.0, 1e7 / 12.0
    radius, angle, force = 100.0, 0.25 * math.pi, np.array([0.0, 0.0, 600.0])

    def end(moment, share):
        curvature = np.array([0.0, 0.0, 1.0 / radius])
        load = share * force
        return spatial(np.eye(3), curvature, radius * angle, stiffness, load, moment)

    moment = shot(lambda m, share: end(m, share)[2], np.zeros(3), np.linspace(0.1, 1.0, 10))
    place = end(moment, 1.0)[0]
    tip = place - (radius * math.sin(angle), radius * (1.0 - math.cos(angle)), 0.0)
    np.testing.assert_allclose(value_of("bend"), tip, rtol=0.0, atol=1e-5)
    scene = bend()
    rest = ancf.solve_static(scene.scene)
    assert rest.stable
    np.testing.assert_allclose(
        rest.displacement(scene.bodies["bend"].end), tip, rtol=0.0, atol=5e-3
    )


@pytest.mark.slow
def test_spring_antenna():
    """A helix between a clamp and a plate that moves along its axis alone, under 6 N."""
    radius, rise, turns, d = 0.05, 0.03 / (2.0 * math.pi), 6.0, 0.003
    young, shear = 1.2e11, 1.2e11 / 2.66
    area, inertia = math.pi * d**2 / 4.0, math.pi * d**4 / 64.0
    share_of_shear = 6.0 * 1.33 / (7.0 + 6.0 * 0.33)  # Cowper's of a circle
    stiffness = young * area, share_of_shear * shear * area, 2.0 * shear * inertia, young * inertia
    slant = math.hypot(radius, rise)
    tangent = np.array([0.0, radius, rise]) / slant
    inward = np.array([-1.0, 0.0, 0.0])
    frame = np.stack([tangent, inward, np.cross(tangent, inward)], axis=1)
    curvature = np.array([rise, 0.0, radius]) / slant**2

    def end(unknowns, share):
        load = np.array([*unknowns[3:], -6.0 * share])
        length = 2.0 * math.pi * turns * slant
        return spatial(frame, curvature, length, stiffness, load, unknowns[:3])

    begin = end(np.zeros(5), 0.0)[1]

    def turned(unknowns, share):
        place, turn, _ = end(unknowns, share)
        w = turn @ begin.T
        spin = np.array([w[2, 1] - w[1, 2], w[0, 2] - w[2, 0], w[1, 0] - w[0, 1]])
        return np.concatenate([spin, place[:2] / radius])

    height = end(shot(turned, np.zeros(5), (0.3, 0.65, 1.0)), 1.0)[0][2]
    assert value_of("spring_antenna") == pytest.approx(height, abs=2e-7)
    scene = spring_antenna()
    plate = scene.bodies["plate"]
    rest = ancf.solve_static(scene.scene)
    assert rest.position(plate.origin)[2] == pytest.approx(height, abs=2e-4)
    run = ancf.simulate(scene.scene, 0.12, 1e-3, start=rest)
    # It jumps almost as far beyond its free height as it was below it.
    jump = scene.quantities(run)["height"].max() - 0.18
    assert 0.85 < jump / (0.18 - height) < 1.0


def test_crane():
    """A pendulum whose length and support change: l a + 2 l' w + g sin + x'' cos = 0."""
    travel, length = ancf.Ramp(5.0, 4.0, smooth=True), ancf.Ramp(-2.0, 5.0, 1.0, smooth=True) + 6.0

    def slopes(t, y):
        angle, rate = y
        pushed = 2.0 * length.rate(t) * rate + travel.rate(t, 2) * math.cos(angle)
        return rate, -(pushed + G * math.sin(angle)) / length(t)

    def moved(end):
        """Return angle, rate, and place of the load."""
        options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13, "max_step": 0.02}
        angle, rate = solve_ivp(slopes, (0.0, end), (0.0, 0.0), **options).y[:, -1]
        x, y = length(end) * math.sin(angle), -length(end) * math.cos(angle)
        return angle, rate, (travel(end) + x, 10.0 + y)

    np.testing.assert_allclose(value_of("crane"), moved(8.0)[2], rtol=0.0, atol=1e-7)
    scene, end = crane(), 2.0  # while trolley and winch accelerate
    angle, rate, place = moved(end)
    pushed = travel.rate(end, 2) * math.sin(angle) + length.rate(end, 2)
    tension = 500.0 * (G * math.cos(angle) + length(end) * rate**2 - pushed)
    run = ancf.simulate(scene.scene, end, 1e-3)
    np.testing.assert_allclose(scene.quantities(run)["load"][-1], place, rtol=0.0, atol=2e-5)
    assert scene.quantities(run)["tension"][-1] == pytest.approx(tension, rel=1e-3)
