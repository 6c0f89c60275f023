"""Impacts of cables on each other that steps do not resolve: no energy is gained."""

import dataclasses
import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.results.fields import energy_balance
from tests.system.contributions.test_beam_contacts import control_points

RADIUS, SPEED = 0.005, 2.0
SECTION, MATERIAL = ancf.Circle(2.0 * RADIUS), ancf.Material(1e8, 5e3)
LINE_MASS = MATERIAL.density * SECTION.area
SCHEMES = [ancf.GeneralizedAlpha(0.9), ancf.HHT(0.1), ancf.Newmark(0.0)]


def level(stiffness, gap):
    """A cable that moves onto a parallel one that is held, and the distance of their surfaces."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 4, SECTION, MATERIAL)
    for k in range(5):
        scene.clamp(lower.node(k))
    ends = (-0.5, 0, 2.0 * RADIUS + gap), (0.5, 0, 2.0 * RADIUS + gap)
    upper = scene.add_beam("thin", *ends, 4, SECTION, MATERIAL, velocity=(0, 0, -SPEED))
    scene.contact(lower, upper, stiffness=stiffness)
    return scene, upper


def crossing(stiffness, gap, velocity=(0, 0, -SPEED)):
    """A cable that moves across another one; both are free."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 6, SECTION, MATERIAL)
    along = 0.5 * np.array([math.cos(1.0), math.sin(1.0), 0.0])
    middle = np.array([0.05, 0.02, 2.0 * RADIUS + gap])
    upper = scene.add_beam(
        "thin", middle - along, middle + along, 6, SECTION, MATERIAL, velocity=velocity
    )
    return scene, scene.contact(lower, upper, stiffness=stiffness)


@pytest.mark.parametrize("integrator", SCHEMES, ids=repr)
@pytest.mark.parametrize("stiffness", [1e5, 1e7, 1e9])
@pytest.mark.parametrize("dt", [1e-3, 5e-3])
def test_a_level_impact_gains_no_energy(integrator, stiffness, dt):
    """It takes from 6 steps to a hundredth of one; wherever the steps meet it."""
    for share in (0.05, 0.3, 0.55, 0.8):
        scene, _ = level(stiffness, (2.2 + share) * SPEED * dt)
        energy = ancf.simulate(scene, 20 * dt, dt, integrator=integrator).energy
        assert energy.total.max() <= energy.total[0] * (1.0 + 1e-9)
        assert energy.total[-1] < 0.9999 * energy.total[0]


@pytest.mark.parametrize("integrator", SCHEMES, ids=repr)
@pytest.mark.parametrize("stiffness", [1e6, 1e9])
def test_an_impact_in_the_first_steps_gains_no_energy(integrator, stiffness):
    """As on obstacles, such steps are repeated."""
    dt = 1e-3
    for share in (0.1, 0.4, 0.9, 1.3):
        scene, _ = level(stiffness, share * SPEED * dt)
        energy = ancf.simulate(scene, 20 * dt, dt, integrator=integrator, tolerance=1e-10).energy
        assert energy.total.max() <= energy.total[0] * (1.0 + 1e-4)


@pytest.mark.parametrize("integrator", SCHEMES, ids=repr)
@pytest.mark.parametrize(("stiffness", "dt"), [(1e7, 1e-4), (1e9, 1e-4), (1e7, 1e-3)])
def test_cables_that_cross_gain_no_energy(integrator, stiffness, dt):
    for share in (0.05, 0.55):
        scene, _ = crossing(stiffness, (2.2 + share) * SPEED * dt)
        energy = ancf.simulate(scene, max(20 * dt, 6e-3), dt, integrator=integrator).energy
        assert energy.total.max() <= energy.total[0] * (1.0 + 1e-6)
        assert 0.9 * energy.total[0] < energy.total[-1] < 0.999 * energy.total[0]
        assert energy.impact_damping[-1] > 0.5 * (energy.total[0] - energy.total[-1])


def test_the_pressure_is_that_of_penetration_and_approach():
    """k (e + theta (e - e0)), theta = (2 dt / t)^2, t = pi sqrt(m / 2k), and never below zero."""
    stiffness, dt = 1e5, 2e-4
    scene, upper = level(stiffness, 2.5 * SPEED * dt)
    run = ancf.simulate(scene, 0.03, dt, integrator=ancf.Newmark(0.0), tolerance=1e-12)
    depth = 2.0 * RADIUS - run.position(upper.at(0.5))[:, 2]
    index, weight = run.system.point(upper.at(0.5))
    acceleration = np.asarray(run.a)[:, index[2]] @ weight
    theta = (2.0 * dt / (math.pi * math.sqrt(0.5 * LINE_MASS / stiffness))) ** 2
    damped = depth[1:] + theta * np.diff(depth)
    expected = stiffness * np.maximum(damped, 0.0) / LINE_MASS
    # Where the end is round, the force is distributed otherwise.
    assert np.abs(acceleration[1:] - expected).max() < 0.02 * expected.max()
    first = int(np.argmax(expected > 0.0)) + 1
    assert depth[first] < 0.0 or depth[first - 1] < 0.0
    after = (depth[1:] > 0.0) & (damped < 0.0)
    assert np.abs(acceleration[1:][after]).max(initial=0.0) < 1e-9 * expected.max()


def test_an_impact_that_steps_resolve_keeps_its_energy():
    for share in (0.05, 0.55):
        scene, _ = level(1e5, (2.2 + share) * SPEED * 1e-4)
        energy = ancf.simulate(scene, 0.02, 1e-4).energy
        assert energy.total[-1] == pytest.approx(energy.total[0], rel=1e-3)


def test_the_balance_has_the_energy_that_the_damping_takes():
    """What it lacks decreases with the cube of the step, as the loss itself."""
    lacking = []
    for dt in (2e-4, 1e-4):
        scene, _ = crossing(1e6, 2.5 * SPEED * dt)
        energy = ancf.simulate(scene, 0.03, dt).energy
        loss = energy.total[0] - energy.total[-1]
        lacking.append(abs(loss - energy.impact_damping[-1]))
        assert lacking[-1] < 0.2 * loss
    assert lacking[1] < 0.4 * lacking[0]


@pytest.mark.parametrize("integrator", [*SCHEMES, ancf.EnergyMomentum()], ids=repr)
def test_a_run_in_two_parts_is_one_run_bit_for_bit(integrator):
    """The damping of an impact needs the coordinates of the last step: they are history."""
    options = {"integrator": integrator, "solver": ancf.Newton(), "max_halvings": 6}

    def meet():
        return crossing(1e7, 2e-3, velocity=(0.5, 0, -SPEED))[0]

    whole = ancf.simulate(meet(), 0.01, 2e-4, **options)
    scene = meet()
    first = ancf.simulate(scene, 0.0016, 2e-4, **options)  # in the impact
    assert first.contact_force(scene.attachments[0]).size[-1] > 0.0
    second = ancf.simulate(scene, 0.01, 2e-4, start=first.last, **options)
    assert np.array_equal(second.q[-1], whole.q[-1])


def test_losses_do_not_depend_on_the_memory_and_leave_the_history_as_it_is(monkeypatch):
    scene, _ = crossing(1e7, 2e-3)
    run = ancf.simulate(scene, 0.004, 2e-4)
    memory = run.system.assembly.memory
    energy = run.energy
    assert energy.impact_damping[-1] > 0.0
    assert np.array_equal(run.system.assembly.memory, memory)
    monkeypatch.setattr(energy_balance, "BLOCK_SIZE", 3 * run.q.shape[1])
    again = dataclasses.replace(run).energy
    np.testing.assert_allclose(again.impact_damping, energy.impact_damping, rtol=1e-13)


def test_explicit_runs_and_energy_momentum_are_not_damped():
    for integrator, dt in ((ancf.EnergyMomentum(), 2e-4), (ancf.CentralDifference(), 2e-6)):
        scene, _ = crossing(1e6, 2e-3)
        energy = ancf.simulate(scene, 0.01, dt, integrator=integrator).energy
        assert not energy.impact_damping.any()
        assert energy.total[-1] == pytest.approx(energy.total[0], rel=1e-5)


def cubics(run, k):
    """Control points of all elements in a state, by body, (2, n, 4, 3)."""
    system, q = run.system, run.q[k]
    points = control_points(system, q)
    return points.reshape(2, -1, 4, 3)


def on_curve(points, z):
    """Points of curves (n, 4, 3) at z (k,), and their first two derivatives, each (n, k, 3)."""
    y = 1.0 - z
    weights = (
        (y**3, 3 * y * y * z, 3 * y * z * z, z**3),
        (-3 * y * y, 3 * y * (y - 2 * z), 3 * z * (2 * y - z), 3 * z * z),
        (6 * y, 6 * (z - 2 * y), 6 * (y - 2 * z), 6 * z),
    )
    return [np.einsum("jk,njc->nkc", np.array(each), points) for each in weights]


def brute_force(one, other, before_one, before_other, theta, per_area):
    """Force of one body on the other one by half of the pressures, sampled along its axis, (3,)."""
    z = (np.arange(2000) + 0.5) / 2000
    force = np.zeros(3)
    for a, a0 in zip(one, before_one, strict=True):
        x, x0 = (on_curve(each[None], z)[0][0] for each in (a, a0))
        for b, b0 in zip(other, before_other, strict=True):
            gaps = np.maximum(a.min(axis=0) - b.max(axis=0), b.min(axis=0) - a.max(axis=0))
            if gaps.max() > 3.0 * RADIUS:
                continue
            u = np.full(len(z), 0.5)
            for _ in range(8):
                foot, slope, bend = (each[0] for each in on_curve(b[None], u))
                h = ((x - foot) * slope).sum(axis=1)
                u = u + h / ((slope**2).sum(axis=1) - ((x - foot) * bend).sum(axis=1))
            inside = (u > 0.0) & (u < 1.0)
            d = x - on_curve(b[None], u)[0][0]
            distance = np.linalg.norm(d, axis=1)
            n = d / distance[:, None]
            d0 = x0 - on_curve(b0[None], u)[0][0]
            e = 2.0 * RADIUS - distance + theta * (n * (d0 - d)).sum(axis=1)
            force += 0.5 * per_area * ((np.maximum(e, 0.0) * inside) @ n) / len(z)
    return force


def test_the_damped_force_is_the_sum_of_pressures_sampled_along_both_axes():
    """From the states of a run, whose accelerations are the force; its overlaps are not used."""
    stiffness, dt = 1e7, 1e-4
    scene, _ = crossing(stiffness, 2.5 * SPEED * dt)
    run = ancf.simulate(scene, 2e-3, dt, integrator=ancf.Newmark(0.0), tolerance=1e-13)
    system, length = run.system, 1.0 / 6.0
    theta = min(1.0, (2.0 * dt / (math.pi * math.sqrt(0.5 * LINE_MASS / stiffness))) ** 2)
    upper = np.zeros(system.n_all)
    upper[system.vectors("r")[1][:, 2]] = 1.0
    n_early = 0
    for k in range(1, len(run.t)):
        (low, up), (low0, up0) = cubics(run, k), cubics(run, k - 1)
        expected = brute_force(up, low, up0, low0, theta, stiffness * length)
        expected -= brute_force(low, up, low0, up0, theta, stiffness * length)
        found = upper @ system.assembly.inertia(run.a[k])
        assert found == pytest.approx(expected[2], rel=2e-3, abs=1e-4)
        n_early += expected[2] > 1.0
    assert n_early > 5
