"""What runs to an accuracy leave behind, however they end."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import AccuracyError
from ancfsparse.problems import pendulum
from ancfsparse.results.hdf5_reader import load
from tests.solve.error_control.accuracy_problems import swinging_pendulum


def test_dt_is_the_time_between_saved_states_and_what_was_asked_is_kept():
    run = ancf.simulate(swinging_pendulum(), 0.2, 0.01, accuracy=1e-4, save_every=3)
    np.testing.assert_allclose(run.t, [0.0, 0.03, 0.06, 0.09, 0.12, 0.15, 0.18, 0.2], atol=1e-15)
    assert run.settings["accuracy"] == 1e-4
    again = ancf.simulate(swinging_pendulum(), 0.2, 0.01, accuracy=1e-4, save_every=3)
    np.testing.assert_array_equal(run.q, again.q)
    assert math.isnan(ancf.simulate(swinging_pendulum(), 0.01, 1e-3).stats.error)


def test_loads_are_not_asked_for_past_the_end():
    def until_the_end(t):
        assert t <= 0.2
        return (0.0, 1.0)

    scene, rod = pendulum("thin", 3)
    scene.point_force(rod.end, until_the_end)
    ancf.simulate(scene, 0.2, accuracy=1e-4)


def interrupted_in_run(number, scene, rod):
    """Let a load interrupt the run in which time begins anew for the given time."""
    seen = {"runs": -1, "last": 0.0}  # the first time is that of the look for breaks

    def force(t):
        if t < seen["last"] - 0.1:
            seen["runs"] += 1
        seen["last"] = t
        if seen["runs"] == number and t > 0.15:
            raise KeyboardInterrupt
        return (0.0, 1e-3)

    scene.point_force(rod.end, force)
    return scene


@pytest.mark.parametrize("to_file", [False, True])
def test_an_interrupted_run_carries_the_best_motion_so_far(tmp_path, to_file):
    output = {"output": tmp_path / "run.h5"} if to_file else {}
    scene, rod = pendulum("thin", 4)
    interrupted_in_run(2, scene, rod)
    with pytest.raises(KeyboardInterrupt) as caught:
        ancf.simulate(scene, 0.2, accuracy=1e-7, integrator=ancf.GeneralizedAlpha(0.9), **output)
    path = caught.value.trajectory
    assert path.t[-1] == pytest.approx(0.2)
    assert not path.finished
    assert 1e-7 < path.stats.error < 1e-2
    assert path.stats.runs == 3
    assert "accuracy is 1e-07 m, the error is about" in repr(path)
    assert "attribute `trajectory`" in caught.value.__notes__[0]
    exact = ancf.simulate(pendulum("thin", 4)[0], 0.2, 1e-4).q[-1]
    assert np.abs(path.q[-1] - exact).max() < 3e-3
    if to_file:
        stored = load(tmp_path / "run.h5", scene)
        np.testing.assert_array_equal(stored.q[:], path.q[:])
        assert not stored.finished


def test_what_there_is_of_the_first_motion_is_in_the_file_while_it_runs(tmp_path):
    path = tmp_path / "run.h5"
    scene, rod = pendulum("thin", 4)
    interrupted_in_run(0, scene, rod)
    with pytest.raises(KeyboardInterrupt) as caught:
        ancf.simulate(scene, 0.2, accuracy=1e-7, output=path, integrator=ancf.GeneralizedAlpha(0.9))
    stored = load(path, scene)
    assert 0.0 < stored.t[-1] <= 0.2
    assert not stored.finished
    assert stored.t[-1] == caught.value.trajectory.t[-1]


def test_a_run_that_fails_carries_the_best_motion_so_far(monkeypatch):
    scene, _ = pendulum("thin", 4)
    monkeypatch.setattr("ancfsparse.solve.error_control.select_solution.MAX_RUNS", 2)
    with pytest.raises(AccuracyError, match="attribute `trajectory`") as caught:
        ancf.simulate(scene, 0.2, accuracy=1e-8, integrator=ancf.GeneralizedAlpha(0.9))
    assert caught.value.trajectory.t[-1] == pytest.approx(0.2)
    assert caught.value.trajectory.stats.error == caught.value.error
