"""Scenes of cables on obstacles, compared with formulas and with programs that share no code."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

import ancfsparse as ancf
from ancfsparse.problems import (
    cable_drop,
    cantilever_on_cylinders,
    chain_over_pulley,
    net_on_sphere,
    pile,
    sliding_block,
)
from ancfsparse.problems.named import MECHANISMS

G = 9.81
LINE_MASS, LAYER = 0.4, 5e-6  # [kg/m], [m]


def test_the_cable_rebounds_like_a_mass_on_its_contact():
    """The motion of one point on p(e) from the touch to the end of the impact, then a flight."""
    stiffness, end = 1e5, 0.5

    def pressure(e):
        inside = e**3 / LAYER**2 - e**4 / (2.0 * LAYER**3) if e < LAYER else e - 0.5 * LAYER
        return stiffness * inside if e > 0.0 else 0.0

    def leaves(t, y):
        return y[0] if t > 1e-4 else 1.0

    leaves.terminal = True
    touch, speed = math.sqrt(2.0 * 0.5 / G), math.sqrt(2.0 * G * 0.5)
    impact = solve_ivp(
        lambda _, y: (y[1], G - pressure(y[0]) / LINE_MASS), (0.0, 0.02), (0.0, speed),
        method="DOP853", rtol=1e-11, atol=1e-14, max_step=5e-6, events=leaves,
    )  # fmt: skip
    flight = end - touch - impact.t_events[0][0]
    height = -impact.y_events[0][0][1] * flight - 0.5 * G * flight**2
    assert MECHANISMS["cable_drop"].value == pytest.approx((height,), abs=1e-7)
    scene = cable_drop()
    run = ancf.simulate(scene.scene, end, 2.5e-4, integrator=ancf.EnergyMomentum(), tolerance=1e-12)
    found = scene.quantities(run)
    assert found["height"][-1] == pytest.approx(height, abs=2e-5)
    assert found["height"].min() == pytest.approx(-impact.y[0].max(), rel=1e-3)
    assert np.abs(found["energy_lost"]).max() < 1e-6 * LINE_MASS * 2.0 * G * 0.5


def test_a_damped_cable_comes_to_rest_where_the_floor_bears_its_weight():
    """It loses the potential energy of the fall and half of that of the penetration w/k."""
    scene, weight = cable_drop(), LINE_MASS * G
    run = ancf.simulate(scene.scene, 1.0, 5e-3, integrator=ancf.GeneralizedAlpha(0.5))
    found, depth = scene.quantities(run), weight / 1e5
    assert found["height"][-1] == pytest.approx(-(depth + 0.5 * LAYER), rel=1e-6)
    lost = 2.0 * weight * (0.5 + 0.5 * depth)
    assert found["energy_lost"][-1] == pytest.approx(lost, abs=2.0 * weight * LAYER)


@pytest.mark.parametrize("slip_speed", [1e-1, 1e-2])
def test_the_block_stops_where_friction_has_used_its_energy(slip_speed):
    """Further than v^2 / (2 mu g), because friction is smaller at small velocities."""
    v, mu = 3.0, 0.3
    coulomb = v**2 / (2.0 * mu * G)
    path = v * math.hypot(v, slip_speed) + slip_speed**2 * math.asinh(v / slip_speed)
    scene = sliding_block(mu, v, slip_speed)
    run = ancf.simulate(scene.scene, 1.5, 5e-3, integrator=ancf.EnergyMomentum())
    found = scene.quantities(run)
    assert found["distance"][-1] == pytest.approx(path / (2.0 * mu * G), abs=3e-6)
    assert found["distance"][-1] - coulomb > 0.9 * (path / (2.0 * mu * G) - coulomb)
    assert found["speed"][100] == pytest.approx(v - mu * G * 0.5, abs=slip_speed**2)
    if slip_speed == 1e-2:
        known = MECHANISMS["sliding_block"].value
        assert known == pytest.approx((path / (2.0 * mu * G),), abs=1e-7)


def test_the_cantilever_touches_both_cylinders_at_one_point():
    """Reissner's rod by shooting: forces at the clamp, place and force of each contact."""
    axial, bending, load = 2.07e5, 2.07e11 * 1e-12 / 12.0, 80.0 * 7800.0 * 1e-6 * 0.25
    cylinders = (np.array([0.5, -0.15]), 0.1), (np.array([1.5, -0.5]), 0.2)

    def slopes(_, y):
        c, s = np.cos(y[2]), np.sin(y[2])
        stretch = 1.0 + (y[4] * c + y[5] * s) / axial
        moment = stretch * (y[4] * s - y[5] * c)
        return [stretch * c, stretch * s, y[3] / bending, moment, 0.0, 0.0]

    def shoot(unknowns):
        moment, h, v, first, first_force, second, second_force = unknowns
        y, gaps, begin = np.array([0.0, 0.0, 0.0, moment, h, v]), [], 0.0
        events = [(0.25 * i, load * (0.5 if i == 8 else 1.0), None) for i in range(1, 9)]
        events += [(first, first_force, cylinders[0]), (second, second_force, cylinders[1])]
        for end, force, cylinder in sorted(events, key=lambda event: event[0]):
            y = solve_ivp(slopes, (begin, end), y, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
            begin = end
            if cylinder is None:
                y[5] += force
                continue
            way = y[:2] - cylinder[0]
            distance = np.linalg.norm(way)
            gaps += [distance - cylinder[1], way @ (np.cos(y[2]), np.sin(y[2]))]
            y[4:6] -= force * way / distance
        return y[:2], np.array([*gaps, 100.0 * y[3], y[4], y[5]])

    start = [-0.0117, 0.289, -0.067, 0.5385, 0.583, 1.597, 0.5615]
    found = root(lambda unknowns: shoot(unknowns)[1], start, tol=1e-11)
    assert np.abs(found.fun).max() < 1e-9
    tip, forces = shoot(found.x)[0], found.x[[4, 6]]
    np.testing.assert_allclose(MECHANISMS["cantilever_on_cylinders"].value, tip, atol=1e-7)
    # Contact is evaluated at Gauss points, whose distance the place of the force is uncertain by.
    for n, tolerance in ((128, 6e-4), (256, 2e-4)):
        scene = cantilever_on_cylinders(n)
        rest = ancf.solve_static(scene.scene)
        np.testing.assert_allclose(scene.quantities(rest)["tip"], tip, rtol=0.0, atol=tolerance)
    np.testing.assert_allclose(scene.quantities(rest)["forces"], forces, rtol=0.01)


def test_the_force_of_the_chain_falls_until_it_lifts_off():
    """The momentum of all parts gives the force; half of the radius halves that at the lift-off."""
    rho, speed_up, middle = 0.1, 2.0 * G, 0.03
    lift_off = math.sqrt(2.0 * speed_up / (G * 4.0 * G))
    assert lift_off == pytest.approx(0.319, abs=5e-4)

    def force(t, radius):
        side = 1.0 - 0.5 * G * t**2
        return 2.0 * rho * (side * speed_up - (G * t) ** 2) + math.pi * rho * radius * speed_up

    assert MECHANISMS["chain_over_pulley"].value == pytest.approx((force(0.2, 0.1),), abs=1e-7)
    for radius in (0.2, 0.1):
        assert force(lift_off, radius) == pytest.approx(math.pi * rho * radius * speed_up)
        scene = chain_over_pulley(radius=radius)
        run = ancf.simulate(
            scene.scene, 0.349, 1e-3, integrator=ancf.GeneralizedAlpha(0.5),
            start=ancf.solve_static(scene.scene),
        )  # fmt: skip
        found = scene.quantities(run)
        # Within 1 % of the force at the start: the chain bends from node to node.
        for step in (130, 180, 230, 280, 349):
            expected = force(run.t[step] - middle, radius)
            assert found["force"][step] == pytest.approx(expected, abs=0.01 * force(0.0, radius))
        assert found["speed"][-1] == pytest.approx(G * lift_off, rel=1e-3)


@pytest.mark.parametrize(
    ("acceleration", "free_length", "radius"),
    [(G, 1.0, 0.2), (G, 1.0, 0.1), (0.5 * G, 1.0, 0.1), (2.0 * G, 1.0, 0.1), (G, 0.5, 0.1)],
)
def test_the_chain_lifts_off_when_the_tension_is_the_flow_of_momentum(
    acceleration, free_length, radius
):
    """After Brun et al.: T = rho v^2 where the chain arrives; a radius changes it by 1 ms."""
    lift_off = math.sqrt(
        2.0 * free_length * (G + acceleration) / (acceleration * (3.0 * acceleration + G))
    )
    scene = chain_over_pulley(acceleration, free_length, radius)
    run = ancf.simulate(
        scene.scene, round(lift_off + 0.06, 3), 1e-3, integrator=ancf.GeneralizedAlpha(0.5),
        start=ancf.solve_static(scene.scene), save_every=2,
    )  # fmt: skip
    found = scene.quantities(run)
    time = found["lift_off_time"]
    assert time[-1] == pytest.approx(lift_off, rel=0.01)
    assert found["speed_at_lift_off"][-1] == pytest.approx(acceleration * lift_off, rel=0.01)
    hangs = run.t - 0.03 < time[-1]
    assert np.all(time[hangs] == 0.0)
    assert np.all(time[~hangs] == time[-1])


def test_the_net_comes_to_rest_and_the_ball_bears_its_weight():
    scene, n = net_on_sphere(6), 6
    run = ancf.simulate(scene.scene, 2.0, 4e-3, integrator=ancf.GeneralizedAlpha(0.5))
    found = scene.quantities(run)
    weight = 1000.0 * math.pi * 4e-6 * 1.6 * 2 * (n + 1) * G
    assert found["force"][-1] == pytest.approx(weight, rel=1e-3)
    assert found["kinetic_energy"][-1] < 1e-3 * found["kinetic_energy"].max()
    known = MECHANISMS["net_on_sphere"].value[0]
    assert known * (n + 1) / 13 == pytest.approx(weight, rel=1e-6)


def test_a_pile_comes_to_rest_with_little_penetration_and_no_failed_step():
    scene = pile(10, 0.24)
    run = ancf.simulate(scene.scene, 0.3, 2e-3, integrator=ancf.GeneralizedAlpha(0.5))
    found = scene.quantities(run)
    weight = 1000.0 * math.pi * 25e-6 * scene.bodies["cables"].lengths.sum() * G
    assert found["force"][-1] == pytest.approx(weight, rel=1e-4)
    assert found["kinetic_energy"][-1] < 1e-6 * found["kinetic_energy"].max()
    assert 1e-3 < found["largest_penetration"].max() < 1e-2
    assert not run.stats.events
    assert run.stats.iterations < 6 * run.stats.steps
    known = MECHANISMS["pile"].value[0]
    lengths = pile().scene.bodies[0].lengths.sum()
    assert known == pytest.approx(1000.0 * math.pi * 25e-6 * lengths * G, rel=1e-6)


def test_a_wide_pile_with_a_friction_of_one_comes_to_rest_and_every_step_converges():
    """As the one of 100 cables in docs/limits.md, with five cables in each of four layers."""
    scene = pile(20, 0.64, 1.0, stiffness=3e7, cables_in_layer=5, width=0.56)
    run = ancf.simulate(scene.scene, 0.4, 2e-3, integrator=ancf.GeneralizedAlpha(0.5), save_every=5)
    assert run.finished
    found, cables = scene.quantities(run), scene.bodies["cables"]
    weight = 1000.0 * math.pi * 25e-6 * cables.lengths.sum() * G
    assert found["force"][-1] == pytest.approx(weight, rel=1e-4)
    fall = run.energy.potential[0] - run.energy.potential[-1]
    # Each layer has fallen by the gaps below it but for penetrations and bending.
    assert fall == pytest.approx(weight * 2e-3 * 2.5, rel=0.05)
    assert found["kinetic_energy"][-1] < 1e-6 * fall
    assert found["speed"].max() > 0.2
    assert found["speed"][-1] < 1e-3
    assert 1e-3 < found["largest_penetration"][-1] < 1e-2
    assert not run.stats.short_steps
    assert len(run.stats.events) <= 1
    # At rest the factor of one step serves all others, which take two or three corrections.
    run = ancf.simulate(
        scene.scene, 0.5, 2e-3, integrator=ancf.GeneralizedAlpha(0.5), start=run.last
    )
    assert run.stats.iterations < 4 * run.stats.steps
    assert run.stats.factorizations < 5
    assert scene.quantities(run)["speed"].max() < 1e-3


def test_a_stiffer_pile_sinks_in_by_less_than_a_percent_at_all_times_and_is_converged_in_the_step():
    """Penetrations in impacts too; halved steps end at the same height within 1e-4 radii."""
    heights = {}
    for dt in (1e-3, 5e-4):
        scene = pile(9, 0.4, 1.0, stiffness=1e8, cables_in_layer=3, width=0.3)
        run = ancf.simulate(
            scene.scene, 0.3, dt, integrator=ancf.GeneralizedAlpha(0.5), solver=ancf.Newton()
        )
        found = scene.quantities(run)
        assert 1e-3 < found["largest_penetration"].max() < 1e-2
        assert found["speed"][-1] < 1e-3
        assert not run.stats.short_steps
        assert run.stats.iterations < 4 * run.stats.steps
        heights[dt] = run.position(scene.bodies["cables"].node(0))[-1, 2]
    assert heights[1e-3] == pytest.approx(heights[5e-4], abs=1e-4 * 5e-3)
