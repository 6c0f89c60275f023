"""Large soft scenes start steps from an acceleration extrapolated from its last changes."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import chain, net
from ancfsparse.solve.stepping import implicit_setup
from ancfsparse.system import System

DT = 5e-4
DAMPED = ancf.GeneralizedAlpha(0.8)


def falling(n=300):
    return chain(n, "rest", "thin").scene


def both(monkeypatch, make, n_steps, dt=DT, **options):
    """Run a scene as it is, and with steps that start from the last acceleration."""
    options = {"integrator": DAMPED, "save_every": n_steps} | options
    runs = []
    for least in (implicit_setup.MIN_EXTRAPOLATED_UNKNOWNS, 10**9):
        monkeypatch.setattr(implicit_setup, "MIN_EXTRAPOLATED_UNKNOWNS", least)
        runs.append(ancf.simulate(make(), n_steps * dt, dt, **options))
    return runs


def test_a_chain_falling_from_rest_takes_fewer_corrections_and_as_many_factors(monkeypatch):
    # Measured: 1.2 for 2.0 with a factor in 67 steps each.
    extrapolated, plain = both(monkeypatch, falling, 400)
    assert plain.stats.iterations > 1.9 * plain.stats.steps
    assert extrapolated.stats.iterations < 1.4 * extrapolated.stats.steps
    assert extrapolated.stats.factorizations <= plain.stats.factorizations + 3
    assert extrapolated.stats.recoveries == 0


def test_a_net_takes_fewer_corrections(monkeypatch):
    # Measured: 2.0 for 3.4.
    extrapolated, plain = both(monkeypatch, lambda: net(20, "rest").scene, 150)
    assert extrapolated.stats.iterations < 0.75 * plain.stats.iterations


@pytest.mark.parametrize("integrator", [DAMPED, ancf.Newmark(), ancf.HHT(0.1)], ids=repr)
def test_its_solution_is_nearer_to_exact_steps(monkeypatch, integrator):
    # Measured: 0.006 to 0.1 of the distance, before chaos sets in after 3 s.
    options = {"integrator": integrator, "save_every": 400}
    extrapolated, plain = both(monkeypatch, falling, 2000, **options)
    exact = ancf.simulate(falling(), 2000 * DT, DT, tolerance=1e-9, **options)
    off, before = (np.abs(run.q - exact.q).max() for run in (extrapolated, plain))
    assert off < 0.5 * before
    gain, gain_before = (
        abs(run.energy.total[-1] - exact.energy.total[-1]) for run in (extrapolated, plain)
    )
    assert gain < gain_before + 1e-7 * exact.energy.kinetic.max()


@pytest.mark.parametrize(
    ("make", "options"),
    [
        (falling, {"dt": 1e-3}),  # inertia is no longer the larger part of the matrix
        (lambda: chain(200, "rest", "thin").scene, {}),  # 802 unknowns
        (falling, {"solver": ancf.Newton()}),
        (falling, {"tolerance": "paper"}),
        (falling, {"integrator": ancf.EnergyMomentum()}),
    ],
    ids=["stiff", "small", "Newton", "paper", "energy"],
)
def test_elsewhere_steps_are_what_they_were(monkeypatch, make, options):
    extrapolated, plain = both(monkeypatch, make, 40, **options)
    np.testing.assert_array_equal(extrapolated.q, plain.q)


def test_so_are_those_of_scenes_with_equations(monkeypatch):
    def held():
        scene = falling()
        scene.rod(scene.beams[0].end, (60.0, 1.0))
        return scene

    extrapolated, plain = both(monkeypatch, held, 40)
    np.testing.assert_array_equal(extrapolated.q, plain.q)


def test_the_number_of_threads_changes_only_rounding():
    one, two = (
        ancf.simulate(falling(), 100 * DT, DT, integrator=DAMPED, save_every=100, threads=n)
        for n in (1, 2)
    )
    assert one.stats.iterations == two.stats.iterations < 150
    np.testing.assert_allclose(two.q, one.q, rtol=0, atol=1e-11 * np.abs(one.q).max())


def test_a_sudden_load_is_not_extrapolated(monkeypatch):
    # The change that it makes says nothing about the next one.
    def pushed():
        scene = falling()
        scene.point_force(scene.beams[0].end, lambda t: (0.0, 500.0 if t > 0.05 else 0.0))
        return scene

    extrapolated, _ = both(monkeypatch, pushed, 300, save_every=1)
    exact = ancf.simulate(pushed(), 300 * DT, DT, integrator=DAMPED, tolerance=1e-9)
    off = np.abs(extrapolated.q - exact.q).max()
    way = np.abs(exact.q[-1] - exact.q[0]).max()
    assert off < 1e-5 * way
    assert extrapolated.stats.recoveries == 0


def test_the_prediction_is_that_of_least_squares():
    system, integrator = System(falling()), ancf.Newmark()
    made = implicit_setup.prepare_implicit(system, DT, integrator, "auto", "default", np.inf)
    march, n, loads = made.time_loop, system.n_free, np.empty((1, 0))
    room = [np.empty((2, width)) for width in (system.n_all,) * 3 + (0,)]
    states = []
    for _ in range(20):
        march.advance(made.iteration, 1, loads, 1, 0, *room)
        states.append(march.state)
    a = np.array([each[2] for each in states])
    before, last, new = np.diff(a[-4:], axis=0)
    weight = np.sqrt(system.mass_diagonal)
    columns = (weight * np.array([last[:n], before[:n]])).T
    x, y = np.round(1024.0 * np.linalg.lstsq(columns, weight * new[:n])[0]) / 1024.0
    q, v, a0, lam = states[-1]
    extrapolated = a0 + x * new + y * last
    scale = integrator.scale * DT**2
    place = q + DT * v + 0.5 * DT**2 * a0 + scale * (extrapolated - a0)
    r, _ = system.assembly.residual(place, v, extrapolated, lam, system.dead_load, np.zeros(0))
    plain, _ = system.assembly.residual(
        q + DT * v + 0.5 * DT**2 * a0, v, a0, lam, system.dead_load, np.zeros(0)
    )
    march.prepare(loads)  # the last step was extrapolated, and so is the next one
    off = np.linalg.norm(march.residual() - scale * r[:n])
    assert off < 1e-3 * scale * np.linalg.norm(r[:n])  # changes are kept in single precision
    assert np.linalg.norm(r[:n]) < 0.1 * np.linalg.norm(plain[:n])
