"""Elastic ropes over points: they pull, go slack, and are paid out and drawn in."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ancfsparse as ancf
from ancfsparse.system import System
from tests.matrices import stiffness
from tests.solve.refusals import assert_refused

G = 9.81
STIFF = 2.0e3


MASS = 2.0  # kg


def hanging(length=None, **options):
    """A weight on a rope from (0, 0), guided along the vertical."""
    scene = ancf.Scene((0.0, -G))
    load = scene.add_body(mass=MASS, inertia=0.1, position=(0, -1))
    scene.prismatic(load.origin, axis=(0.0, 1.0))
    rope = scene.rope([(0.0, 0.0), load.origin], stiffness=STIFF, length=length, **options)
    return scene, load, rope


def positive(strain, slack=0.0):
    return 0.5 * (strain + np.hypot(strain, slack))


def path_of(length, t_end, *, slack=0.0, viscosity=0.0):
    """The height of that weight by an integrator of order 8, whose steps end at each change."""

    def rate(t, y):
        natural = length(t)
        strain = -y[0] / natural - 1.0
        root = math.hypot(strain, slack)
        s = positive(strain, slack)
        share = s / root if root else 0.0
        elastic = STIFF * s * share
        viscous = viscosity * share**2 * -y[1] / natural
        return [y[1], (elastic + max(viscous, -elastic)) / MASS - G]

    return solve_ivp(rate, (0.0, t_end), [-1.0, 0.0], method="DOP853", rtol=1e-11, atol=1e-12,
                     max_step=1e-3, dense_output=True)  # fmt: skip


def test_a_rope_hoists_by_its_length_and_balances_its_energy():
    # From equilibrium, so that it stays taut.
    haul = ancf.Ramp(-0.4, 0.5, smooth=True) + 1.0 / (1.0 + 2.0 * G / STIFF)
    scene, load, rope = hanging(haul)
    exact = path_of(haul, 1.0)
    errors, drifts = [], []
    for dt in (0.002, 0.001):
        run = ancf.simulate(scene, 1.0, dt, integrator=ancf.Newmark(0.0), tolerance=1e-12)
        errors.append(np.abs(run.position(load.origin)[:, 1] - exact.sol(run.t)[0]).max())
        drifts.append(run.energy.drift)
    assert errors[1] < 1e-4
    assert 3.5 < errors[0] / errors[1] < 4.5
    # What the winch has done became energy of the weight and of the rope.
    assert run.energy.work[-1] > 2.0 * G * 0.35
    assert drifts[1] < 2e-3
    assert 3.5 < drifts[0] / drifts[1] < 4.5  # of the trapezoidal rule for the work
    strain = -exact.sol(run.t)[0] / haul(run.t) - 1.0
    np.testing.assert_allclose(run.tension(rope), STIFF * np.maximum(strain, 0.0), atol=0.2)


@pytest.mark.parametrize("slack", [0.0, 1e-3])
def test_a_rope_paid_out_faster_than_the_weight_falls_goes_slack_and_catches_it(slack):
    pay = ancf.Ramp(0.5, 0.2, smooth=True) + 1.0
    scene, load, rope = hanging(pay, slack=slack)
    exact = path_of(pay, 0.8, slack=slack)
    run = ancf.simulate(scene, 0.8, 2.5e-4, integrator=ancf.Newmark(0.0), tolerance=1e-12)
    assert run.tension(rope).min() >= 0.0
    assert (run.tension(rope) < 1e-2).mean() > 0.2  # slack for a good part of the time
    assert run.tension(rope).max() > 5.0 * 2.0 * G  # caught with a jerk
    np.testing.assert_allclose(run.position(load.origin)[:, 1], exact.sol(run.t)[0], atol=2e-4)
    assert run.energy.drift < 2e-4


@pytest.mark.parametrize("solver", [ancf.Newton(), ancf.QuasiNewton("davidon"), "auto"], ids=repr)
def test_every_solver_passes_slack_and_taut_phases(solver):
    scene, load, rope = hanging(1.1)  # falls a tenth of a metre before it is caught
    run = ancf.simulate(scene, 2.0, 0.002, solver=solver)
    exact = path_of(lambda t: 1.1, 2.0)
    np.testing.assert_allclose(run.position(load.origin)[:, 1], exact.sol(run.t)[0], atol=1e-2)
    assert run.tension(rope).min() == 0.0


def test_a_slack_rope_keeps_the_energy_under_energy_momentum():
    scene = ancf.Scene((0.0, -G))
    load = scene.add_body(mass=1.0, inertia=0.02, position=(0.3, 0.0), angular_velocity=3.0)
    scene.rope([(-0.5, 0.5), load.at((0.1, 0.0)), (0.8, 0.2)], stiffness=500.0, length=1.5)
    run = ancf.simulate(
        scene, 4.0, 0.01, integrator=ancf.EnergyMomentum(), solver=ancf.Newton(), tolerance=1e-13
    )
    total = run.energy.total
    np.testing.assert_allclose(total, total[0], atol=1e-9 * np.ptp(run.energy.kinetic))
    assert run.energy.elastic.min() == 0.0 < run.energy.elastic.max()


def test_viscosity_takes_energy_and_never_pushes():
    scene, load, rope = hanging(1.1, damping=40.0, slack=1e-3)
    exact = path_of(lambda t: 1.1, 1.5, slack=1e-3, viscosity=40.0)
    run = ancf.simulate(scene, 1.5, 5e-4, integrator=ancf.Newmark(0.0), tolerance=1e-12)
    np.testing.assert_allclose(run.position(load.origin)[:, 1], exact.sol(run.t)[0], atol=1e-4)
    assert run.tension(rope).min() >= 0.0
    assert run.energy.drift < 1e-3
    assert (np.diff(run.energy.dissipated) >= 0.0).all()
    assert run.energy.dissipated[-1] > 1.0


def test_a_load_hangs_on_a_rope_over_two_points_with_one_tension():
    # Over (0, 0) and (1, 0) to a weight: its middle stands below, both parts carry T.
    scene = ancf.Scene((0.0, -G))
    load = scene.add_body(mass=2.0, inertia=0.1, position=(0.5, -0.5))
    rope = scene.rope([(0.0, 0.0), load.origin, (1.0, 0.0)], stiffness=STIFF, length=1.6)
    rest = ancf.solve_static(scene)
    x, y = rest.position(load.origin)
    half = math.hypot(0.5, y)
    tension = STIFF * (2.0 * half / 1.6 - 1.0)
    assert x == pytest.approx(0.5, abs=1e-6)
    assert rest.tension(rope) == pytest.approx(tension, rel=1e-9)
    assert 2.0 * tension * -y / half == pytest.approx(2.0 * G, rel=1e-6)
    assert rest.elastic_energy == pytest.approx(tension**2 * 1.6 / (2.0 * STIFF), rel=1e-9)


DRUM, RADIUS, LOAD, HOOK = 0.5, 0.2, 3.0, 0.05  # kg m2, m, kg, kg
REDUCED = DRUM / RADIUS**2 + HOOK  # of drum and hook, as a mass that moves with the rope [kg]


def on_a_drum(speed=0.0):
    """A weight on an elastic rope, whose upper end a free drum lets out by a hook."""
    scene = ancf.Scene((0.0, -G))
    drum = scene.add_body(mass=1.0, inertia=DRUM, position=(0, 3))
    hook = scene.add_body(mass=HOOK, inertia=1e-5, position=(RADIUS, 2.5))
    load = scene.add_body(mass=LOAD, inertia=0.1, position=(RADIUS, 1.5), velocity=(0, speed))
    for body in (hook, load):
        scene.prismatic(body.origin, axis=(0, 1))
    scene.winch([(RADIUS, 3.0), hook.origin], drum=scene.pin(drum.origin), radius=RADIUS)
    rope = scene.rope([hook.origin, load.origin], stiffness=STIFF, length=1.0)
    return scene, drum, load, rope


def test_a_weight_on_an_elastic_rope_unwinds_a_free_drum():
    # Two masses on a spring that let go: their centre falls evenly, the rope oscillates about its
    # stretch; without stretch and hook the acceleration is m g r^2 / (J + m r^2).
    both = REDUCED + LOAD
    along = (LOAD + HOOK) * G / both
    assert along == pytest.approx(LOAD * G * RADIUS**2 / (DRUM + LOAD * RADIUS**2), rel=2e-2)
    scene, drum, load, rope = on_a_drum()
    errors = []
    for dt in (0.004, 0.002):
        run = ancf.simulate(scene, 2.0, dt, integrator=ancf.Newmark(0.0), tolerance=1e-12)
        omega = math.sqrt(STIFF * both / (LOAD * REDUCED))
        stretch = LOAD * (G - along) / STIFF * (1.0 - np.cos(omega * run.t))
        fallen = 0.5 * along * run.t**2 + stretch * REDUCED / both
        errors.append(np.abs(1.5 - run.position(load.origin)[:, 1] - fallen).max())
        turned = np.unwrap(run.body(drum).angles)
        np.testing.assert_allclose(-RADIUS * turned, fallen - stretch, atol=2.0 * errors[-1])
    assert turned[-1] < -6.0 * np.pi  # three times round
    assert errors[1] < 1e-3
    assert 3.5 < errors[0] / errors[1] < 4.5
    np.testing.assert_allclose(run.tension(rope), STIFF * stretch, atol=0.5)


def test_a_weight_thrown_up_on_a_drum_falls_into_its_slack_rope_and_keeps_the_energy():
    scene, drum, _, rope = on_a_drum(speed=3.0)
    run = ancf.simulate(scene, 2.0, 0.002, integrator=ancf.EnergyMomentum(), tolerance=1e-13)
    total = run.energy.total
    np.testing.assert_allclose(total, total[0], atol=1e-11 * np.ptp(run.energy.kinetic))
    assert (run.tension(rope) == 0.0).mean() > 0.5
    assert run.tension(rope).max() > 5.0 * LOAD * G
    assert np.unwrap(run.body(drum).angles)[-1] < -2.0 * np.pi


@pytest.mark.parametrize("slack", [0.0, 0.05])
@pytest.mark.parametrize("length", [1.2, 4.0], ids=["taut", "slack"])
def test_force_and_stiffness_are_derivatives_of_the_energy(rng_state, slack, length):
    scene = ancf.Scene((0.0, 0.0, -G))
    box = scene.add_body(
        ancf.Box(length=0.2, width=0.4, height=0.3), mass=1.0, position=(1.0, 0.0, 0.0)
    )
    rod = scene.add_beam(
        "thin", (0, 1, 0), (1, 1, 0), 2, ancf.Circle(0.02), ancf.Material(1e7, 1e3)
    )
    over = [rod.at(0.5), box.at((0.1, 0.1, 0.0)), (0.0, 0.0, 1.0), box.origin]
    scene.rope(over, stiffness=70.0, length=length, slack=slack)
    with_rope = System(scene)
    bare = ancf.Scene((0.0, 0.0, -G))
    for record in scene.records[:-1]:
        record.build(bare)
    system = System(bare)
    q = with_rope.q_ref + rng_state.uniform(-0.02, 0.02, with_rope.n_all)

    def energy(x):
        return with_rope.assembly.strain_energy(x) - system.assembly.strain_energy(x)

    def force(x):
        return with_rope.assembly.force(x) - system.assembly.force(x)

    way = rng_state.uniform(-1.0, 1.0, with_rope.n_all)
    way[with_rope.n_free :] = 0.0
    step = 1e-5
    slope = (energy(q + step * way) - energy(q - step * way)) / (2 * step)
    assert force(q) @ way == pytest.approx(slope, rel=1e-5, abs=1e-7)
    bend = (force(q + step * way) - force(q - step * way)) / (2 * step)
    n = with_rope.n_free
    whole = (stiffness(with_rope, q) - stiffness(system, q)).toarray()[:n, :n]
    np.testing.assert_allclose(whole @ way[:n], bend[:n], rtol=1e-4, atol=1e-3)


@pytest.fixture
def rng_state():
    return np.random.default_rng(5)


@pytest.mark.parametrize("method", [ancf.CentralDifference(), ancf.DormandPrince()], ids=repr)
def test_explicit_integrators_wind_ropes_too(method):
    haul = ancf.Ramp(-0.4, 0.5, smooth=True) + 1.0
    scene, load, _ = hanging(haul)
    run = ancf.simulate(scene, 1.0, 1e-3, integrator=method)
    exact = path_of(haul, 1.0)
    np.testing.assert_allclose(run.position(load.origin)[:, 1], exact.sol(run.t)[0], atol=2e-5)
    assert run.energy.drift < 5e-3


def test_a_run_in_two_parts_winds_on():
    haul = ancf.Ramp(-0.4, 0.5, smooth=True) + 1.0
    scene, load, _ = hanging(haul)
    whole = ancf.simulate(scene, 0.4, 0.002, solver=ancf.Newton())
    first = ancf.simulate(scene, 0.2, 0.002, solver=ancf.Newton())
    rest = ancf.simulate(scene, 0.4, 0.002, solver=ancf.Newton(), start=first.last)
    np.testing.assert_array_equal(rest.position(load.origin)[-1], whole.position(load.origin)[-1])


def test_bad_arguments_of_ropes():
    scene, load, rope = hanging()
    good = [(0.0, 0.0), load.origin]
    cases = [
        (lambda: scene.rope([load.origin], stiffness=1.0), "list of two points or more"),
        (lambda: scene.rope([(0, 0), (1, 1)], stiffness=1.0), "needs a point of a beam or a body"),
        (lambda: scene.rope([(0, -1), load.origin], stiffness=1.0), "0 and 1 of a rope coincide"),
        (lambda: scene.rope(good, stiffness=0.0), "stiffness of a rope must be positive"),
        (lambda: scene.rope(good, stiffness=1.0, damping=-1.0), "must not be negative"),
        (lambda: scene.rope(good, stiffness=1.0, slack=2.0), "strain from 0 to 1"),
        (lambda: scene.rope(good, stiffness=1.0, length=0.0), "length of a rope must be positive"),
        (lambda: scene.rope(good, stiffness=1.0, length=lambda t: -t), "at t = 0 must be pos"),
        (lambda: scene.rope(good, stiffness=1.0, length=lambda t: 1, damping=2), "no damping"),
    ]  # fmt: skip
    for call, words in cases:
        assert_refused(words, call)
    assert [each.method for each in scene.records].count("rope") == 1
    other, _, _ = hanging()
    assert_refused("not part of this scene: take", ancf.simulate(other, 0.01, 0.01).tension, rope)


def test_a_length_that_runs_out_ends_the_run_and_keeps_what_was_before():
    scene, *_ = hanging(lambda t: 1.0 - 4.0 * t)
    with pytest.raises(ancf.LoadError, match="length must be positive, got 0") as found:
        ancf.simulate(scene, 0.5, 0.01)
    assert found.value.trajectory.t[-1] == pytest.approx(0.24)
