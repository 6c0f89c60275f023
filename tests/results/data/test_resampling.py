"""States between saved ones: order of the interpolation, and runs of all kinds."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.problems import pendulum
from ancfsparse.results import RunStats, Trajectory


def interpolation_errors(run, every):
    """Return the largest errors of q, v and a in states that a coarser selection leaves out."""
    coarse = Trajectory(
        run.system, *(x[::every] for x in (run.t, run.q, run.v, run.a, run.lam)), RunStats()
    )
    fine = coarse.resample(run.t)
    return [np.abs(getattr(fine, x) - getattr(run, x)).max() for x in "qva"]


def test_errors_have_the_stated_order():
    # A smooth motion known in closed form: each coordinate is a sine of its own.
    scene, _ = pendulum(n_elements=1)
    system = ancf.simulate(scene, 1e-3, 1e-3).system
    t, rates = np.linspace(0.0, 1.0, 1025)[:, None], np.linspace(1.0, 6.0, system.n_all)
    q, v, a = np.sin(rates * t), rates * np.cos(rates * t), -(rates**2) * np.sin(rates * t)
    run = Trajectory(system, t[:, 0], q, v, a, np.empty((1025, 0)), RunStats())
    errors = np.array([interpolation_errors(run, every) for every in (64, 32, 16)])
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(
        np.array([[4.0, 4.0, 2.0]] * 2), abs=0.1
    )
    h = 16 / 1024
    assert errors[-1, 0] == pytest.approx(h**4 / 384 * 6.0**4, rel=0.05)
    assert errors[-1, 1] == pytest.approx(h**4 / 384 * 6.0**5, rel=0.05)


def test_a_run_is_resampled_as_precisely_as_it_is_computed():
    scene, rod = pendulum(n_elements=4)
    options = {"t_end": 0.4, "dt": 2e-4}
    every = ancf.simulate(scene, **options)
    rare = ancf.simulate(scene, **options, save_every=5)
    again = rare.resample(every.t)
    assert np.array_equal(again.q[::5], rare.q)
    assert np.array_equal(again.v[::5], rare.v)
    assert again.finished
    assert np.array_equal(again.last.q, rare.last.q)
    path = every.position(rod.end)
    assert np.abs(again.position(rod.end) - path).max() < 1e-6 * np.ptp(path)


def test_velocities_between_mean_accelerations_are_linear():
    scene, _ = pendulum(n_elements=4)
    run = ancf.simulate(scene, 0.1, 1e-3, integrator=ancf.EnergyMomentum())
    middle = run.resample(0.5 * (run.t[:-1] + run.t[1:]))
    assert middle.v == pytest.approx(0.5 * (run.v[:-1] + run.v[1:]), rel=1e-14, abs=1e-14)
    # The method itself: q1 - q0 is the step times the mean of both velocities.
    quarter = run.q[:-1] + 0.5e-3 * (0.75 * run.v[:-1] + 0.25 * run.v[1:])
    assert middle.q == pytest.approx(quarter, abs=1e-9)


def test_equilibria_are_interpolated_linearly():
    scene = ancf.Scene((0, 0))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 2, ancf.Circle(0.01), ancf.Material(1e8, 1e3))
    scene.clamp(rod.start)
    scene.point_force(rod.end, lambda t: (0.0, -0.1 * t))
    run = ancf.quasi_static(scene, 1.0, 0.5)
    assert run.resample([0.25]).q[0] == pytest.approx(0.5 * (run.q[0] + run.q[1]), rel=1e-14)


def test_stored_states_and_selected_points(tmp_path):
    scene, rod = pendulum(n_elements=4)
    times = [0.0, 0.0123, 0.05]
    full = ancf.simulate(scene, 0.1, 1e-3)
    stored = ancf.simulate(scene, 0.1, 1e-3, output=tmp_path / "run.h5")
    few = ancf.simulate(scene, 0.1, 1e-3, save_nodes=[rod.end])
    expected = full.resample(times)
    assert np.array_equal(stored.resample(times).q, expected.q)
    resampled = few.resample(times)
    assert resampled.velocity(rod.end) == pytest.approx(expected.velocity(rod.end), rel=1e-13)
    assert resampled.settings["t_end"] == 0.05
    assert resampled.finished


@pytest.mark.parametrize(
    ("times", "message"),
    [
        ([0.2], "there is no state at t = 0.2 s: the run goes from 0 s to 0.01 s"),
        ([0.002, 0.001], "times must increase: 0.001 s follows 0.002 s; sort them"),
        ([[0.0]], "times must be a list such as"),
        ([np.nan], "there is no state at t = nan s"),
        (["a"], "times must be a list of times in s"),
    ],
)
def test_invalid_times_are_refused(times, message):
    run = ancf.simulate(pendulum(n_elements=2).scene, 0.01, 1e-3)
    with pytest.raises(InputError, match=message):
        run.resample(times)
